"""Rig tests of the local bus: broker, client port, python-can plug-in, log."""
