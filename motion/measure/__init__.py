"""Measuring while axes move: probe and high-speed inputs, MOVE UNTIL, flying measurement, fast start-off, latch, machine position."""
