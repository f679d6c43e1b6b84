"""The one monotonic clock of all processes, and the wall clock for logs."""

import datetime
import time


def now_ns() -> int:
    """Nanoseconds of CLOCK_MONOTONIC: the same in every process of this machine."""
    return time.monotonic_ns()


def wall() -> str:
    """Local wall-clock time for logs only, ISO 8601 with milliseconds."""
    return datetime.datetime.now().astimezone().isoformat(timespec="milliseconds")
