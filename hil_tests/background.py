"""Lower priority for the pure tests and the guests of a complete run: the cells that run at the same time go first."""

import contextlib
import os
import pathlib

BACKGROUND = 5  # nice: a third of the processor time of a cell that wants the same processor


def to_background(pid: int) -> None:
    """Lower the priority of this session leader and of all that it starts: at least a third of the time remains."""
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, pid, min(os.getpriority(os.PRIO_PROCESS, pid) + BACKGROUND, 19))
    with contextlib.suppress(OSError):
        pathlib.Path(f"/proc/{pid}/autogroup").write_text(str(BACKGROUND))  # where the host groups by session, nice alone counts within it
