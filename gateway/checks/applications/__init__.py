"""Checks that read the application of an old controller: loaded where a cell has one."""
