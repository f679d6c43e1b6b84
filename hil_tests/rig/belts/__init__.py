"""Belts of a whole running cell."""
