"""What moves a path from outside while it runs: belts of the rho 3 (types 1, 2, 3), the alteration of VAL 3, and their way into the
samples of the stepper."""
