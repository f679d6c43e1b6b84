"""The old control's signal interface: behaviour of its inputs and outputs on the process image.  Source: rho 3 release manual (rho3 3)."""
