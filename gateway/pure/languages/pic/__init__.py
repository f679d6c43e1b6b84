"""The PIC250 and SoftPIC of a rho 3: its program, its symbols, its scan.  Pure."""
