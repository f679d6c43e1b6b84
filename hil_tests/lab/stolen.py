"""Did the machine run at all?  A witness of the highest priority that only sleeps: where it overslept, nobody had the processor.

python -m hil_tests.lab.stolen FILE      until SIGTERM; one line `FROM TO` (s, wall clock) for each time stolen
"""

import contextlib
import os
import pathlib
import signal
import subprocess
import sys
import time
from collections.abc import Iterator

PRIORITY = 90  # above everything of ours
NAP_S = 0.005
STOLEN_S = 0.010


def main() -> int:
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(0))
    with open(sys.argv[1], "w", encoding="utf-8", buffering=1) as file:
        before = time.time()
        while True:
            time.sleep(NAP_S)
            now = time.time()
            if now - before > NAP_S + STOLEN_S:
                print(f"{before:.6f} {now:.6f}", file=file)
            before = now


@contextlib.contextmanager
def witness(file: pathlib.Path) -> Iterator[None]:
    process = subprocess.Popen([sys.executable, "-m", "hil_tests.lab.stolen", str(file)])
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def stolen(file: pathlib.Path) -> list[tuple[float, float]]:
    """From, to (s, wall clock)."""
    return [(float(line.split()[0]), float(line.split()[1])) for line in file.read_text().splitlines()]


def left_alone(since: float, to: float, times: list[tuple[float, float]]) -> bool:
    """Whether none of the stolen times touches this one (s, wall clock)."""
    return all(end < since or begin > to for begin, end in times)


if __name__ == "__main__":
    sys.exit(main())
