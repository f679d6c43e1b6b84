"""A piece of work in a copy of this process: its modules and memory end with the copy, its result is returned (AX-1740)."""

import contextlib
import os
import pickle
import sys
from collections.abc import Callable
from typing import NoReturn, TypeVar

T = TypeVar("T")


def apart(work: Callable[[], T]) -> T:
    """The result of `work`, which must be picklable; its output is printed.

    If no copy can be made, or the copy ends without a result, the work is done here: it then fails in the same way.
    """
    _flush()
    read, write = os.pipe()
    try:
        child = os.fork()
    except OSError:  # no memory or no process left
        os.close(read)
        os.close(write)
        return work()
    if child == 0:
        _work(work, write)
    os.close(write)
    with open(read, "rb") as pipe:
        result = pipe.read()
    os.waitpid(child, 0)
    return pickle.loads(result) if result else work()


def _work(work: Callable[[], object], write: int) -> NoReturn:
    """In the copy; never returns."""
    with contextlib.suppress(BaseException):  # also Ctrl-C, which its parent gets as well
        result = pickle.dumps(work())
        _flush()
        with open(write, "wb") as pipe:
            pipe.write(result)
        os._exit(0)
    os._exit(1)


def _flush() -> None:
    """Write the buffered output, so that the copy does not write it again.  A process may have no standard streams, or no reader."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
