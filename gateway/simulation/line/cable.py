"""A simulated serial cable between two ptys: both ends, both directions, one loop; without process and commands."""

import contextlib
import fcntl
import os
import pathlib
import select
import sys
import termios
import time
from collections.abc import Callable
from typing import IO

from drivers.ports.serial.cable import Direction
from drivers.ports.serial.line_format import Note, Run
from drivers.ports.serial.pty import READ_SIZE, marks_asked, offer_marks, set_raw
from drivers.ports.timerfd import Timer
from protocols.base.machine import Ns

RECORD_LINES = 512  # written to the file at the latest
RECORD_IDLE_S = 0.02
UNREAD_LIMIT = 2048  # bytes waiting for a reader; the kernel's own 4096 are never full, so that opening can forget all of them
OTHER = {"A": "B", "B": "A"}


class Side:
    """An adapter: a pty pair whose slave is offered under a lasting link."""

    def __init__(self, link: str, marks: bool) -> None:
        self.link, self._has_marks = link, marks
        self.master = self._slave = -1

    @property
    def inserted(self) -> bool:
        """False: the adapter is pulled out of the computer."""
        return self.master >= 0

    def insert(self) -> None:
        """Makes a new pty and offers it under the link at one stroke."""
        self.master, self._slave = os.openpty()
        set_raw(self._slave)  # and held open: a reader that comes and goes does not hang the line up
        if self._has_marks:
            offer_marks(self._slave)
        os.set_blocking(self.master, False)
        fresh = f"{self.link}.{os.getpid()}"
        with contextlib.suppress(FileNotFoundError):
            os.unlink(fresh)
        os.symlink(os.ttyname(self._slave), fresh)
        os.replace(fresh, self.link)

    def reads_marks(self) -> bool:
        """Whether the program at this side requested marks; a foreign one reads characters as they are (AX-1400)."""
        return self._has_marks and self.inserted and marks_asked(self._slave)

    def take(self, wire: bytes) -> bool:
        """Characters for the reader; False: there is no reader, and the buffer is full: these are lost, as in a UART."""
        if int.from_bytes(fcntl.ioctl(self._slave, termios.FIONREAD, bytes(4)), sys.byteorder) > UNREAD_LIMIT:
            return False
        try:
            return os.write(self.master, wire) == len(wire)
        except BlockingIOError:
            return False

    def remove(self) -> None:
        """Hang up the program that has the pty open; a second call is harmless."""
        if not self.inserted:
            return
        with contextlib.suppress(FileNotFoundError):
            if os.readlink(self.link) == os.ttyname(self._slave):
                os.unlink(self.link)
        os.close(self._slave)
        os.close(self.master)
        self.master = self._slave = -1


class Recorder:
    """Lines to a file, collected so that the line never waits for the disk character by character."""

    def __init__(self, file: IO[str] | None, limit: int) -> None:
        self._file, self._room = file, limit
        self._lines: list[str] = []
        self.unrecorded = 0

    @property
    def waiting(self) -> bool:
        """Something has not reached the file."""
        return bool(self._lines)

    def add(self, entry: Run | Note) -> None:
        """Keeps one entry; beyond the limit it is only counted."""
        if self._file is None:
            return
        line = entry.line()
        self._room -= len(line)
        if self._room < 0:
            self.unrecorded += 1
            return
        self._lines.append(line)
        if len(self._lines) >= RECORD_LINES:
            self.flush()

    def flush(self) -> None:
        """Everything reaches the file."""
        if self._file is not None and self._lines:
            try:
                os.write(self._file.fileno(), "".join(self._lines).encode("ascii"))
            except OSError:  # a full disk: counted, the line continues
                self.unrecorded += len(self._lines)
            self._lines.clear()


class Line:
    """Both sides, both directions, one loop."""

    def __init__(self, folder: pathlib.Path, name: str, baud: int, bits: int, plain: str, recorder: Recorder) -> None:
        """`folder`: where the links NAME-a and NAME-b are offered; `plain`: sides whose program reads no marks."""
        self.name, self.baud, self.bits = name, baud, bits
        self.recorder = recorder
        self.plugged, self.stopping = True, False
        self.sides = {side: Side(str(folder / f"{name}-{side.lower()}"), side not in plain) for side in OTHER}
        self.ways = {side: Direction(baud, bits, marks=self.sides[OTHER[side]].reads_marks) for side in self.sides}  # by sender
        self.lost = self.overflow = self.damaged = 0
        self.scheduling = "normal"
        self._epoll = select.epoll()
        self._handlers: dict[int, Callable[[Ns], None]] = {}
        self._listening: set[str] = set()
        self._timer = Timer()
        self._armed: Ns | None = None

    def open(self) -> None:
        """Offers both ends."""
        self.watch(self._timer.fileno(), lambda now: self._timer.clear())
        for side in self.sides:
            self.insert(side)

    def close(self) -> None:
        """Remove the links."""
        for side in self.sides.values():
            side.remove()
        self.recorder.flush()

    def watch(self, fd: int, handler: Callable[[Ns], None]) -> None:
        """Calls the handler whenever `fd` is readable."""
        self._handlers[fd] = handler
        self._epoll.register(fd, select.EPOLLIN)

    def unwatch(self, fd: int) -> None:
        """No more."""
        if self._handlers.pop(fd, None):
            self._epoll.unregister(fd)

    def run(self) -> None:
        """Until stopped."""
        while not self.stopping:
            ready = self._epoll.poll(RECORD_IDLE_S if self.recorder.waiting else -1)
            if not ready:
                self.recorder.flush()
            for fd, _ in ready:
                handler = self._handlers.get(fd)
                if handler is not None:
                    handler(time.monotonic_ns())
            self.move(time.monotonic_ns())
            self._arm()

    def insert(self, side: str) -> None:
        """The adapter of this side is (again) in the computer."""
        if not self.sides[side].inserted:
            self.sides[side].insert()
            self._listen(side)

    def remove(self, side: str) -> None:
        """The adapter of this side is pulled out; its unsent characters are lost."""
        if self.sides[side].inserted:
            self._deafen(side)
            self.ways[side].forget()
            self.sides[side].remove()

    def move(self, now: Ns) -> None:
        """Passes on every character whose time has come."""
        for side, way in self.ways.items():
            due = way.due()
            if due is None or due > now:
                continue
            for data, wire, mark in way.take(now):
                self._deliver(side, data, wire, mark, now)
            if side not in self._listening and not way.full:
                self._listen(side)

    def note(self, text: str) -> Ns:
        """Records an event; returns its stamp."""
        now = time.monotonic_ns()
        self.recorder.add(Note(now, text))
        return now

    def _deliver(self, side: str, data: bytes, wire: bytes, mark: str, now: Ns) -> None:
        receiver = self.sides[OTHER[side]]
        if not self.plugged:
            mark = "lost"
            self.lost += len(data)
        elif not receiver.inserted:
            mark = "gone"
            self.lost += len(data)
        elif wire and not receiver.take(wire):
            mark = "overflow"
            self.overflow += len(data)
        elif mark:
            self.damaged += 1
        self.recorder.add(Run(now, side, data, mark))

    def _read(self, side: str, now: Ns) -> None:
        try:
            data = os.read(self.sides[side].master, READ_SIZE)
        except BlockingIOError:
            return
        self.ways[side].offer(data, now)
        if self.ways[side].full:
            self._deafen(side)

    def _listen(self, side: str) -> None:
        if self.sides[side].inserted and side not in self._listening:
            self._listening.add(side)
            self.watch(self.sides[side].master, lambda now: self._read(side, now))

    def _deafen(self, side: str) -> None:
        if side in self._listening:
            self._listening.discard(side)
            self.unwatch(self.sides[side].master)

    def _arm(self) -> None:
        dues = [due for way in self.ways.values() if (due := way.due()) is not None]
        due = min(dues) if dues else None
        if due is not None and due != self._armed:
            self._timer.arm(due)
        self._armed = due
