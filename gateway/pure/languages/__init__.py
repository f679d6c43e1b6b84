"""Languages of the old controls: programs are read, checked and run here; the process around them owns clock, rings and files."""
