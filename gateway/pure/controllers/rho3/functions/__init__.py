"""What the rho 3 did for its PLC beside moving: coded errors and texts, status display, external selection, panel, process table."""
