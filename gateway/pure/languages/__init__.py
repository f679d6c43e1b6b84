"""Languages of the old controllers: programs are read, checked and run here; the process around them owns clock, rings and files."""
