"""Measurements of `axisgate doctor`: echo of adapters, and lateness of this computer."""
