"""The house rules: what may be imported where, what pure code may not do, how many exceptions there are."""
