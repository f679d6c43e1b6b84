"""Drives one byte machine over one port inside asyncio.

asyncio's own timers are late by a millisecond and more, so deadlines come from a timerfd.  A lost port is reopened every quarter of a
second, in a thread (opening a USB adapter or a TCP connection may wait), so a dead partner never slows another.
"""

import asyncio
import contextlib
import time
from collections.abc import Callable
from typing import Generic, TypeVar

from drivers.ports.base import BytePort, PortError
from drivers.ports.timerfd import Timer
from gateway.links.serial.machine_loop import PAUSE_NS, LineCore, LineState
from gateway.links.serial.shared_turn import shared_turn
from protocols.base.machine import Machine, Ns

E = TypeVar("E")


class LineRunner(Generic[E]):
    """Starts at once, inside a running loop; `on_event(event, now)` is called after the machine's answer has been written."""

    def __init__(self, open_port: Callable[[], BytePort], machine: Machine[E], on_event: Callable[[E, Ns], None]) -> None:
        self._loop = asyncio.get_running_loop()
        self._turn = shared_turn(self._loop)
        self._open_port = open_port
        self._core = LineCore(machine, on_event, self._report)
        self._timer = Timer()
        self._armed: Ns | None = None
        self._watched = -1
        self._writing = False
        self._inside = False  # within a step: a kick by a listener then needs no timer of its own
        self._closed = False
        self._loop.add_reader(self._timer.fileno(), self._on_timer)
        self._opener: asyncio.Task[None] | None = self._loop.create_task(self._keep_opening())

    @property
    def state(self) -> LineState:
        """Connected or why not, since when, counters; live, read only."""
        return self._core.state

    def kick(self) -> None:
        """Call after queueing work at the machine; also from inside on_event."""
        self._guarded(self._core.pump)

    def close(self) -> None:
        """Call `lost` of the machine, release port and timer; a second call is harmless."""
        if self._closed:
            return
        self._closed = True
        if self._opener is not None:
            self._opener.cancel()
        self._unwatch()
        self._core.disconnect("closed", time.monotonic_ns())
        self._loop.remove_reader(self._timer.fileno())
        self._timer.close()

    def _on_readable(self) -> None:
        if self._turn.may_read(self):
            self._guarded(self._core.readable)
            self._turn.has_read()

    def _on_timer(self) -> None:
        self._timer.clear()
        self._armed = None
        self._guarded(self._core.wake)

    def _guarded(self, step: Callable[[Ns], None]) -> None:
        if self._closed:
            return
        now, outermost = time.monotonic_ns(), not self._inside
        self._inside = True
        try:
            step(now)
        except PortError as error:
            self._drop(error, now)
        finally:
            self._inside = not outermost
        if outermost:
            if self._writing != self._core.wants_write:
                self._watch_writing()
            self._arm()

    def _arm(self) -> None:
        """An earlier wake than needed costs less than setting the timer for every answer time that moves on."""
        due = self._core.next_wake()
        if due is not None and (self._armed is None or due < self._armed) and not self._closed:
            self._timer.arm(due)
            self._armed = due

    def _watch_writing(self) -> None:
        if self._watched < 0:
            self._writing = False
            return
        self._writing = self._core.wants_write
        if self._writing:
            self._loop.add_writer(self._watched, self.kick)
        else:
            self._loop.remove_writer(self._watched)

    def _drop(self, error: PortError, now: Ns) -> None:
        self._unwatch()
        self._core.disconnect(str(error.args[-1]), now)
        if self._opener is None and not self._closed:
            self._opener = self._loop.create_task(self._keep_opening())

    def _unwatch(self) -> None:
        if self._watched >= 0:
            self._loop.remove_reader(self._watched)
            self._loop.remove_writer(self._watched)
            self._watched, self._writing = -1, False

    async def _keep_opening(self) -> None:
        """Until the port is open.  A machine that waits for time is woken as usual."""
        if self._core.state.counters.opened:
            await asyncio.sleep(PAUSE_NS / 1e9)
        while True:
            opening = self._loop.run_in_executor(None, self._open_port)
            try:
                port = await asyncio.shield(opening)
            except asyncio.CancelledError:
                opening.add_done_callback(_close_late)
                raise
            except Exception as error:  # PortError mostly; whatever it is, the line is tried again and shows why
                self._core.refuse(error, time.monotonic_ns())
                await asyncio.sleep(PAUSE_NS / 1e9)
            else:
                break
        self._opener = None
        self._watched = port.fileno()
        self._loop.add_reader(self._watched, self._on_readable)
        self._guarded(lambda now: self._core.connect(port, now))

    def _report(self, error: Exception) -> None:
        self._loop.call_exception_handler({"message": "line: a protocol machine or listener failed", "exception": error})


def _close_late(opening: "asyncio.Future[BytePort]") -> None:
    """Close a port that was opened after it was no longer needed."""
    with contextlib.suppress(Exception):
        opening.result().close()
