"""Checks that read the application of an old control: loaded where a cell has one."""
