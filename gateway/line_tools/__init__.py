"""Tools at the line: probe, diagnose, send, fetch, monitor, learn.  They run wherever Python does: nothing Linux-only is imported."""
