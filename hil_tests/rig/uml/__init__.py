"""The user-mode-linux guest: a real vcan0 (and a real tty driver) on machines whose kernel has no CAN."""
