"""Makes many objects without the search for cycles between them."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def uncollected() -> Iterator[None]:
    """Inside, the collector does not look for cycles.  Reading a program makes many objects that have none, and up to half of the time
    would go into looking through them.  Afterwards it is as before, where it was off, too.  What was made counts as old then: the next
    collection would otherwise look through all of it at once."""
    searched = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if searched:
            gc.freeze()
            gc.unfreeze()
            gc.enable()
