"""Belts of a cell: joined to the core and the planner."""
