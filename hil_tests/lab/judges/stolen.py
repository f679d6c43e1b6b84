"""Did the machine run at all?  A witness of the highest priority that only sleeps: where it overslept, nobody had its processor.  A host
takes them away one by one, so each has a witness of its own.

An ordinary witness has no priority: where it overslept by much, other processes without priority were not served either.

python -m hil_tests.lab.judges.stolen FILE [--ordinary | CPU]     until SIGTERM; one line `FROM TO` (s, wall clock) for each time stolen
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
NOT_SERVED_S = 0.040  # for an ordinary witness: ten turns of a scheduler with 4 ms


def main() -> int:
    ordinary = "--ordinary" in sys.argv
    if not ordinary:
        os.sched_setaffinity(0, {int(cpu) for cpu in sys.argv[2:]} or os.sched_getaffinity(0))
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    limit = NAP_S + (NOT_SERVED_S if ordinary else STOLEN_S)
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(0))
    with open(sys.argv[1], "w", encoding="utf-8", buffering=1) as file:
        before = time.time()
        while True:
            time.sleep(NAP_S)
            now = time.time()
            if now - before > limit:
                print(f"{before:.6f} {now:.6f}", file=file)
            before = now


def everywhere(file: pathlib.Path) -> dict[pathlib.Path, str]:
    """A file for the witness of each processor, and its option."""
    return {file.with_name(f"{file.name}-{cpu}"): str(cpu) for cpu in sorted(os.sched_getaffinity(0))}


@contextlib.contextmanager
def witness(file: pathlib.Path, *options: str) -> Iterator[None]:
    process = subprocess.Popen([sys.executable, "-m", "hil_tests.lab.judges.stolen", str(file), *options])
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
