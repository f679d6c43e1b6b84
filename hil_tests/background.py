"""What stands behind the cells that are played beside it: the pure tests and the guests of a whole run."""

import contextlib
import os
import pathlib

BEHIND = 5  # nice: a third of what a cell gets that wants the same processor


def behind(pid: int) -> None:
    """This process, the first of its session, and all that it starts: they get what others leave of the processors, at least a third."""
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, pid, min(os.getpriority(os.PRIO_PROCESS, pid) + BEHIND, 19))
    with contextlib.suppress(OSError):
        pathlib.Path(f"/proc/{pid}/autogroup").write_text(str(BEHIND))  # where the host groups by session, nice alone counts within it
