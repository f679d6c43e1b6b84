"""The first minutes with a machine: a cell file from five answers, and whether axisgate can replace the old controller."""
