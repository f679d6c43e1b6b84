"""Processes of a run are killed or stopped: what the drives do by themselves, who starts again, and that nothing moves by itself."""
