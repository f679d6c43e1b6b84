"""The servo emulator: model, boosters, bus time."""
