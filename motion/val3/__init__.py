"""Motion as VAL 3 means it: descriptors, the motion stack, move ids.  What an interpreter of the language calls."""
