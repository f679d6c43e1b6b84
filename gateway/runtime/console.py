"""Standard output of a run: lines for the operator, which never block the process and never end it.

A reader that went away (EPIPE), a terminal that hung up (EIO) or was stopped (Ctrl-S), a full disk behind `> file`: lines are dropped and
counted.  The begin and the end are reported once each; the caller writes these sentences to the journal.
"""

import contextlib
import errno
import os
import select
import stat
import sys

STOPPED = "it is stopped"


class Console:
    """One file descriptor a person reads."""

    def __init__(self, fd: int = 1) -> None:
        with contextlib.suppress(OSError, ValueError):
            if sys.stdout is not None:
                sys.stdout.flush()  # earlier output goes first
        self._fd = _own(fd)
        self._poll = select.poll()
        if self._fd >= 0:
            self._poll.register(self._fd, select.POLLOUT)
        self._rest = b""  # of a line that was only partly accepted
        self._reason = ""
        self._news: list[str] = []
        self.lost = 0  # lines left out since it last took one
        self.lost_in_all = 0

    def say(self, line: str) -> None:
        """Write one line if that can be done at once."""
        whole = line.encode(errors="replace") + b"\n"
        try:
            self._push(self._rest, begun=True)
            if self._reason:
                self._push(f"({self.lost} lines were not shown: {self._reason})\n".encode())
                self._over()
            self._push(whole)
        except OSError as error:
            if not (self._rest and whole.endswith(self._rest)):  # of this line nothing was accepted
                self._lose(error)

    def take_news(self) -> list[str]:
        """Sentences for the journal: lines are lost from now on, or no longer."""
        news, self._news = self._news, []
        return news

    def close(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def _push(self, octets: bytes, *, begun: bool = False) -> None:
        """BlockingIOError: nothing more is accepted now; another OSError: the reader is gone.  begun: a part of it is out already."""
        left, self._rest = octets, b""
        try:
            while left:
                if self._fd < 0:
                    raise OSError(errno.EBADF, "it is closed")
                if not self._poll.poll(0):
                    raise BlockingIOError(errno.EAGAIN, STOPPED)
                left = left[os.write(self._fd, left[:512]) :]  # a pipe that accepts anything accepts 512 bytes at once (POSIX)
        except BlockingIOError:
            self._rest = left if begun or len(left) < len(octets) else b""
            raise

    def _lose(self, error: OSError) -> None:
        self.lost += 1
        self.lost_in_all += 1
        if not self._reason:
            self._reason = STOPPED if isinstance(error, BlockingIOError) else error.strerror or str(error)
            self._news.append(f"standard output accepts no more lines ({self._reason}); the run continues, the journal is complete")

    def _over(self) -> None:
        self._news.append(f"standard output accepts lines again; {self.lost} lines were not shown ({self._reason})")
        self._reason, self.lost = "", 0


def _own(fd: int) -> int:
    """An open file of our own, so that O_NONBLOCK is not set for the shell and others that share it; -1: there is none."""
    try:
        mode = os.fstat(fd).st_mode
        if stat.S_ISFIFO(mode) or stat.S_ISCHR(mode):
            with contextlib.suppress(OSError):  # another user's terminal: then check before every write whether it is writable
                return os.open(f"/proc/self/fd/{fd}", os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
        return os.dup(fd)
    except OSError:
        return -1


def fill_standard() -> None:
    """A standard stream that was closed (`>&-`) becomes /dev/null: else the next region would get its number, and prints would go there."""
    for fd in range(3):
        try:
            os.fstat(fd)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest free number


def say_at_start(line: str) -> None:
    """A line before the run has its console; nothing depends on it."""
    with contextlib.suppress(OSError, ValueError):
        print(line, flush=True)
