"""numpy in the tests works as it does in axisgate's own processes: with one thread (AX-434)."""

import importlib
import os

VARIABLE = "OPENBLAS_NUM_THREADS"


def one_thread() -> None:
    """Loads numpy with one thread for its sums.  With one for each core, those wait for each other, by spinning: where two test
    processes and two guests share two cores, a law took five times as long.  What a test starts sees nothing of it."""
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = "1"
    importlib.import_module("numpy")
    if before is None:
        del os.environ[VARIABLE]
    else:
        os.environ[VARIABLE] = before
