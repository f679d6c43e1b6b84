"""An append-only file of limited size on a disk that may be full: neither limit ends or stops its writer.

Beyond `limit` it becomes NAME.1 (replacing the previous one) and a new one begins with `head`: both together stay within 2 x limit, and the
newest is kept.  Lines that a full disk refuses are counted; when it accepts writes again, `remark` reports how many are missing.
"""

import contextlib
import errno
import os
import pathlib
from collections.abc import Callable

LIMIT = 1 << 30


class BoundedFile:
    """Raises OSError only when it is opened."""

    def __init__(self, path: str | pathlib.Path, head: bytes, remark: Callable[[int, str], bytes], limit: int = LIMIT) -> None:
        """`remark`: returns a line for so many lost ones and the reason."""
        self._path, self._head, self._remark, self._limit = pathlib.Path(path), head, remark, limit
        self._fd = self._open()
        self._size = os.fstat(self._fd).st_size
        self._torn = False
        self._reason = ""
        self.lost = 0  # lines, since one was accepted
        self.write(head)

    def write(self, octets: bytes, lines: int = 1) -> None:
        """Complete lines."""
        try:
            if self._size + len(octets) > self._limit and self._size > len(self._head):
                self._turn_over()
            if self.lost:
                self._put((b"\n" if self._torn else b"") + self._remark(self.lost, self._reason))
                self._torn, self.lost = False, 0
            self._put(octets)
        except OSError as error:
            self.lost += lines
            self._reason = error.strerror or str(error)

    def close(self) -> None:
        os.close(self._fd)

    def _open(self) -> int:
        return os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)

    def _turn_over(self) -> None:
        self._path.replace(self._path.with_name(self._path.name + ".1"))
        with contextlib.suppress(OSError):
            os.close(self._fd)
        self._fd, self._size = self._open(), 0
        self._put(self._head)

    def _put(self, octets: bytes) -> None:
        while octets:
            taken = os.write(self._fd, octets)
            if not taken:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            self._size += taken
            octets, self._torn = octets[taken:], True
        self._torn = False
