"""The first minutes with a machine: a cell file out of five answers, and whether axisgate can take the old controller's place."""
