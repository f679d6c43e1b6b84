"""The running cell in a terminal: axes, signals, lines, errors, and the pendant."""
