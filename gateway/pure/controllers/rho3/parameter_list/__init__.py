"""The printed machine-parameter list of a rho 3, as a cell file.  Pure."""
