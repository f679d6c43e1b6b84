"""The house rules that need real processes: the command finder, the matrix, the mutants, the cycle's modules."""
