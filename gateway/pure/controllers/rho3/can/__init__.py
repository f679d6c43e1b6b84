"""The CAN side of a rho 3: limits and rules of its buses, digital I/O blocks, coupling of controls, download of drive parameters.  Pure."""
