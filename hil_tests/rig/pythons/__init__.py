"""The other Pythons of this machine: a short part of the tests, and a recording of a run."""
