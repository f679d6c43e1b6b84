"""Run numpy with one thread in the tests, as axisgate's own processes do (AX-434)."""

import importlib
import os

VARIABLE = "OPENBLAS_NUM_THREADS"


def one_thread() -> None:
    """Load numpy with one thread.  The threads of several cores wait for each other by spinning: where two test processes and two
    guests share two cores, planning took five times as long.  The environment of what a test starts is unchanged."""
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = "1"
    importlib.import_module("numpy")
    if before is None:
        del os.environ[VARIABLE]
    else:
        os.environ[VARIABLE] = before
