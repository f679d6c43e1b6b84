"""The journal: one JSON object per line, appended by every process of a run (complete lines, so writers never mix).

It never stops its writer: lines that a full disk refuses are counted, and reported once it accepts writes again.  It rotates during the
run: beyond LIMIT the file becomes NAME.1 (replacing the previous one) and a new one begins, so both together stay within 2 x LIMIT.
"""

import contextlib
import errno
import fcntl
import json
import os
import pathlib

from gateway.runtime.clock import now_ns, wall
from gateway.runtime.console import Console

LIMIT = 32 << 20
AT_ONCE = 1 << 20  # bytes read at one look


class Journal:
    """Append-only; `echo` also prints the sentence for a person."""

    def __init__(self, path: pathlib.Path | None, process: str, *, echo: bool = False, limit: int = LIMIT) -> None:
        self._path, self._process, self._limit = path, process, limit
        self._console = Console() if echo else None
        self._fd, self._identity = -1, (0, 0)
        self._fresh = True  # nothing was appended to the open file yet
        self._reason = ""
        self.lost = 0  # records not written since one was
        self.lost_in_all = 0
        if path is not None:
            with contextlib.suppress(OSError):  # the first record reports it
                path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
                self._current(path)

    def write(self, kind: str, text: str, **facts: object) -> None:
        """`kind` is a word to filter by (process, link, command, error), `text` the sentence."""
        moment = wall()
        self._keep(moment, kind, text, facts)
        if self._console is not None:
            self._console.say(f"{moment[11:23]} {self._process}: {text}")
            for news in self._console.take_news():
                self._keep(moment, "output", news, {})

    def close(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1
        if self._console is not None:
            self._console.close()
        self._path = None

    # ---- the file ----------------------------------------------------------------------------------------------------
    def _keep(self, moment: str, kind: str, text: str, facts: dict[str, object]) -> None:
        if self._path is None:
            return
        lines = [self._line(moment, kind, text, facts)]
        if self.lost:
            over = f"the journal is written again; {self.lost} records of {self._process} are lost ({self._reason})"
            lines.insert(0, self._line(moment, "alarm", over, {"lost": self.lost}))
        try:
            self._current(self._path)
            self._append("".join(lines).encode(errors="replace"))
        except OSError as error:
            self._lose(error)
        else:
            self.lost, self._reason = 0, ""

    def _line(self, moment: str, kind: str, text: str, facts: dict[str, object]) -> str:
        record = {"wall": moment, "ns": now_ns(), "process": self._process, "kind": kind, "text": text, **facts}
        return json.dumps(record, ensure_ascii=False, default=str) + "\n"

    def _lose(self, error: OSError) -> None:
        self.lost += 1
        self.lost_in_all += 1
        if not self._reason:
            self._reason = error.strerror or str(error)
            if self._console is not None:
                self._console.say(f"the journal {self._path} is not written: {self._reason}; free disk space; the run continues meanwhile")

    def _append(self, octets: bytes) -> None:
        if (self.lost or self._fresh) and _torn(self._fd):
            octets = b"\n" + octets  # the rest of a line cut by a full disk or a power failure stays a separate line
        self._fresh = False
        written = os.write(self._fd, octets)
        if written < len(octets):
            raise OSError(errno.ENOSPC, "No space left on device")

    def _current(self, path: pathlib.Path) -> None:
        """Make the file of that name the one being written: another process may have rotated it, or it was removed."""
        try:
            here = os.stat(path)
        except FileNotFoundError:
            here = None
        if here is not None and self._fd >= 0 and (here.st_dev, here.st_ino) == self._identity:
            if here.st_size < self._limit:
                return
            turn_over(path, self._limit)
        fresh = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)
        if self._fd >= 0:
            os.close(self._fd)
        self._fd, self._fresh = fresh, True
        found = os.fstat(fresh)
        self._identity = found.st_dev, found.st_ino


def _torn(fd: int) -> bool:
    with contextlib.suppress(OSError):
        size = os.fstat(fd).st_size
        return size > 0 and os.pread(fd, 1, size - 1) != b"\n"
    return False


def turn_over(path: pathlib.Path, limit: int = LIMIT) -> None:
    """Keep one old journal when the present one has grown beyond `limit`; of several callers one does it."""
    with contextlib.suppress(OSError):
        fd = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        try:
            fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.samestat(os.fstat(fd), os.stat(path)) and os.fstat(fd).st_size >= limit:
                path.replace(path.with_suffix(path.suffix + ".1"))
        finally:
            os.close(fd)


class JournalReader:
    """Follows a journal as it grows, also over a rotation.  `tail`: begin so many bytes before its end; None: at its beginning."""

    def __init__(self, path: pathlib.Path, tail: int | None = None) -> None:
        self._path = path
        self._fd, self._at, self._rest = -1, 0, b""
        self._cut = False  # the first line read may be half of one
        with contextlib.suppress(OSError):
            self._open(tail)

    def lines(self) -> list[bytes]:
        """Complete lines written since; at most AT_ONCE bytes of them."""
        with contextlib.suppress(OSError):
            data = self._more() or (self._follow() and self._more()) or b""
            self._at += len(data)
            *lines, self._rest = (self._rest + data).split(b"\n")
            if self._cut and lines:
                del lines[0]
                self._cut = False
            return lines
        return []

    def _more(self) -> bytes:
        return os.pread(self._fd, AT_ONCE, self._at) if self._fd >= 0 or self._open() else b""

    def close(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def _open(self, tail: int | None = None) -> bool:
        with contextlib.suppress(FileNotFoundError):
            self._fd = os.open(self._path, os.O_RDONLY | os.O_CLOEXEC)
            self._at = 0 if tail is None else max(0, os.fstat(self._fd).st_size - tail)
            self._rest, self._cut = b"", bool(self._at and tail)
        return self._fd >= 0

    def _follow(self) -> bool:
        """Everything of this file is read: True where another one or its beginning is to be read."""
        if self._fd < 0:
            return False
        try:
            same = os.path.samestat(os.fstat(self._fd), os.stat(self._path))
        except FileNotFoundError:
            return False
        if not same:
            self.close()
        elif os.fstat(self._fd).st_size >= self._at:
            return False
        self._at, self._rest = 0, b""
        return True
