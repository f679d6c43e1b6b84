"""The old controller's signal interface: its inputs and outputs on the process image.  Source: rho 3 release manual (rho3 3)."""
