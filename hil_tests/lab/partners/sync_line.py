"""Drives one byte machine over one port in the caller's thread: for scripts that read from top to bottom (a PLC of the demo, a bench)."""

import select
import time
from collections.abc import Callable
from typing import Generic, TypeVar

from drivers.ports.base import BytePort, PortError
from gateway.links.serial.machine_loop import PAUSE_NS, LineCore, LineState
from protocols.base.machine import Machine, Ns

E = TypeVar("E")
ASKED_NS = 100_000_000  # a predicate may look at something else than this line


class SyncLine(Generic[E]):
    """`port` is an open port, or a function that opens it: then a port that is gone is opened again every quarter of a second."""

    def __init__(self, port: BytePort | Callable[[], BytePort], machine: Machine[E]) -> None:
        self.events: list[tuple[Ns, E]] = []  # everything the machine reported, with its moment
        self._reopen = port if callable(port) else None
        self._core = LineCore(machine, lambda event, now: self.events.append((now, event)), self._raise)
        self._try_at: Ns = 0
        if callable(port):
            self._open()
        else:
            self._core.connect(port, time.monotonic_ns())

    @property
    def state(self) -> LineState:
        """Connected or why not, since when, counters."""
        return self._core.state

    def run_until(self, predicate: Callable[[], bool], timeout_s: float) -> bool:
        """Serves the line until the predicate holds (True) or the time is over (False).  The predicate is asked after every
        step, and every 100 ms while none is due."""
        end = time.monotonic_ns() + round(timeout_s * 1e9)
        self._step(self._core.pump)
        while not predicate():
            now = time.monotonic_ns()
            if now >= end:
                return False
            self._wait(min(end, now + ASKED_NS, self._core.next_wake() or end), now)
        return True

    def run_for(self, duration_s: float) -> None:
        """Serves the line that long."""
        self.run_until(lambda: False, duration_s)

    def close(self) -> None:
        """Tells the machine `lost` and gives the port back; twice does no harm."""
        self._core.disconnect("closed", time.monotonic_ns())

    def __enter__(self) -> "SyncLine[E]":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _wait(self, until: Ns, now: Ns) -> None:
        if self._core.port is None:
            if self._reopen is not None:
                until = min(until, max(self._try_at, now))
            time.sleep(max(0, until - now) / 1e9)
            if self._reopen is not None and time.monotonic_ns() >= self._try_at:
                self._open()
            self._step(self._core.wake)
            return
        fd = self._core.port.fileno()
        readable, writable, _ = select.select([fd], [fd] if self._core.wants_write else [], [], max(0, until - now) / 1e9)
        if readable:
            self._step(self._core.readable)
        if writable:
            self._step(self._core.pump)
        due = self._core.next_wake()
        if due is not None and time.monotonic_ns() >= due:
            self._step(self._core.wake)

    def _step(self, step: Callable[[Ns], None]) -> None:
        now = time.monotonic_ns()
        try:
            step(now)
        except PortError as error:
            self._core.disconnect(str(error.args[-1]), now)
            self._try_at = now + PAUSE_NS
            if self._reopen is None:
                raise

    def _open(self) -> None:
        assert self._reopen is not None
        now = time.monotonic_ns()
        self._try_at = now + PAUSE_NS
        try:
            port = self._reopen()
        except PortError as error:
            self._core.refuse(error, now)
        else:
            self._step(lambda now: self._core.connect(port, now))

    @staticmethod
    def _raise(error: Exception) -> None:
        raise error
