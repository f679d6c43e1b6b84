"""Keep the processors of a virtual machine busy while a cell runs on them in real time (AX-591).

A virtual processor with nothing to do is given to others by its host and comes back late: on one such machine a process of the highest
priority that sleeps 1 ms overslept by more than 5 ms five times a second, and fifteen to thirty times less often while something, however
unimportant, always wanted the processor.

python -m hil_tests.lab.running.awake CPU     wants that processor at the lowest priority until its parent dies or SIGTERM
"""

import contextlib
import os
import pathlib
import subprocess
import sys
from collections.abc import Iterator

from gateway.runtime.realtime import die_with_parent

CPUINFO = pathlib.Path("/proc/cpuinfo")
LAST = "19"  # nice value


def main() -> None:
    die_with_parent()
    os.sched_setaffinity(0, {int(sys.argv[1])})
    with contextlib.suppress(OSError):  # where the kernel groups by session, nothing else counts between sessions
        pathlib.Path("/proc/self/autogroup").write_text(LAST)
    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    while True:
        pass


@contextlib.contextmanager
def awake(cpuinfo: pathlib.Path = CPUINFO) -> Iterator[list["subprocess.Popen[bytes]"]]:
    """Within it no processor of a virtual machine sleeps; on others, and in a user-mode-linux guest, nothing is done."""
    processors = sorted(os.sched_getaffinity(0)) if virtual(cpuinfo) else []
    keepers = [
        subprocess.Popen([sys.executable, "-m", "hil_tests.lab.running.awake", str(each)], start_new_session=True) for each in processors
    ]
    try:
        yield keepers
    finally:
        for keeper in keepers:
            keeper.terminate()
            keeper.wait()


def virtual(cpuinfo: pathlib.Path = CPUINFO) -> bool:
    """Return whether the processors are virtual.  A guest of user-mode-linux does not count: its clock may be stopped."""
    text = cpuinfo.read_text(encoding="utf-8", errors="replace") if cpuinfo.exists() else ""
    flags = next((line.split() for line in text.splitlines() if line.startswith("flags")), [])
    return "hypervisor" in flags and "User Mode Linux" not in text


if __name__ == "__main__":
    main()
