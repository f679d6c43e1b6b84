"""Rig tests of the process image: regions and rings between real processes."""
