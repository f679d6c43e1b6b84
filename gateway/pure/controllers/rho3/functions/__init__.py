"""PLC functions of the rho 3 other than motion: coded errors and texts, status display, external selection, panel, process table."""
