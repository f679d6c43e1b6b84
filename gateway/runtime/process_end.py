"""Whether another process has ended, at once and without its help: a process that is killed cannot report it."""

import contextlib
import os
import select


class ProcessEnd:
    """Watches one process at a time by its pid.  Without pidfds, or where they are forbidden, no end is seen."""

    def __init__(self) -> None:
        self._pid, self._fd, self._ended = 0, -1, False
        self._poll = select.poll()

    def of(self, pid: int) -> bool:
        """Whether the process has ended; 0 is none, and has not.  A zombie has ended.  Cheap enough for each cycle."""
        if pid != self._pid:
            self._watch(pid)
        if self._fd >= 0 and self._poll.poll(0):
            self._ended = True
            self.close()
        return self._ended

    def _watch(self, pid: int) -> None:
        self.close()
        self._pid, self._ended = pid, False
        try:
            self._fd = os.pidfd_open(pid) if pid else -1
        except ProcessLookupError:
            self._ended = True
        except OSError:
            return
        if self._fd >= 0:
            self._poll.register(self._fd, select.POLLIN)

    def close(self) -> None:
        """Close the descriptor that watches the present process."""
        if self._fd >= 0:
            self._poll.unregister(self._fd)
            with contextlib.suppress(OSError):
                os.close(self._fd)
            self._fd = -1
