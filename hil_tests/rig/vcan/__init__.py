"""Tests on a real vcan0.  Marker vcan: they run inside the user-mode-linux guest."""
