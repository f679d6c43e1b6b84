"""Set points out of files: the binary BNR files of the rho 3 and MOVE_FILE."""
