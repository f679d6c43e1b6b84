"""The emulator as a process on a broker."""
