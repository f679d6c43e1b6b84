"""Connects one byte machine to one byte port in any loop: bytes, damage, sending, `sent`, deadlines, loss and return of the port.

The calling loop (LineRunner in asyncio, SyncLine with select) only waits and calls.  Time is passed in as `now`.
"""

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from drivers.ports.base import BytePort, PortError
from protocols.base.machine import Machine, Ns

E = TypeVar("E")
PAUSE_NS: Ns = 250_000_000  # before a port is opened again, and before a machine that failed is woken again
UNTAKEN_LIMIT = 65536  # bytes a port did not accept; a machine that waits for answers never gets there


@dataclass(slots=True)
class LineCounters:
    """Since the start of the loop."""

    received: int = 0  # good characters
    sent: int = 0  # characters the port took
    damaged: int = 0
    events: int = 0
    opened: int = 0
    lost: int = 0  # the open port went away
    refused: int = 0  # attempts to open that failed
    machine_faults: int = 0  # exceptions out of a machine: an internal error, the line restarts
    listener_faults: int = 0  # exceptions out of a listener: an internal error too; the line continues
    latest_wake_ns: Ns = 0  # worst lateness of a deadline


@dataclass(slots=True)
class LineState:
    """State of a line for a page or a status block."""

    connected: bool = False
    since_ns: Ns = 0  # of `connected`
    why: str = "not opened yet"  # why it is not connected; "" while it is
    counters: LineCounters = field(default_factory=LineCounters)


class LineCore(Generic[E]):
    """One machine, at most one open port."""

    def __init__(self, machine: Machine[E], on_event: Callable[[E, Ns], None], on_fault: Callable[[Exception], None]) -> None:
        self.machine = machine
        self._receive, self._sent = machine.receive, machine.sent  # these four are called for each burst
        self._take_output, self._deadline = machine.take_output, machine.deadline
        self.state = LineState()
        self.port: BytePort | None = None
        self._on_event, self._on_fault = on_event, on_fault
        self._rest_until: Ns = 0
        self._untaken = b""
        self._sent_owed = False
        self._sent_at: Ns | None = None  # look at unsent() then

    def connect(self, port: BytePort, now: Ns) -> None:
        """A port has been opened."""
        self.port = port
        self._untaken, self._sent_owed, self._sent_at = b"", False, None
        self.state.connected, self.state.since_ns, self.state.why = True, now, ""
        self.state.counters.opened += 1
        self.pump(now)

    def refuse(self, error: Exception, now: Ns) -> None:
        """The port could not be opened; the machine continues without it (its jobs end by their own time limits)."""
        self.state.why = str(error.args[-1]) if error.args else repr(error)
        self.state.counters.refused += 1

    def disconnect(self, why: str, now: Ns) -> None:
        """Close the port, notify the machine.  The loop must stop watching it before."""
        if self.port is None:
            return
        port, self.port = self.port, None
        port.close()
        self._untaken, self._sent_owed, self._sent_at = b"", False, None
        self.state.connected, self.state.since_ns, self.state.why = False, now, why
        self.state.counters.lost += 1
        with contextlib.suppress(PortError):  # a machine that fails here as well has been counted
            self._report(self._ask(self.machine.lost, now), now)

    @property
    def wants_write(self) -> bool:
        """The port did not accept everything; call pump when it is writable."""
        return bool(self._untaken)

    def next_wake(self) -> Ns | None:
        """When to call wake at the latest."""
        deadline, sent_at = self._deadline(), self._sent_at
        if deadline is None:
            return sent_at
        if deadline < self._rest_until:
            deadline = self._rest_until
        return deadline if sent_at is None or deadline <= sent_at else sent_at

    def readable(self, now: Ns) -> None:
        """The port has data.  Raises PortError when it is lost."""
        if self.port is None:
            return
        items = self.port.read()
        if self._sent_owed and not self._untaken:
            self._look_for_sent(now)  # the answer cannot be older than the end of its request
        counters, flushed = self.state.counters, False
        for item in items:
            try:
                if isinstance(item, bytes):
                    counters.received += len(item)
                    events = self._receive(item, now)
                else:
                    counters.damaged += 1
                    events = self.machine.damaged(item, now)
            except Exception as error:  # a partner's bytes must not end a line
                events = self._broken(error, now)
            flushed = bool(events)
            if events:
                self._flush(now)  # the partner waits for the answer; our listeners can wait
                self._report(events, now)
        if not flushed:
            self._flush(now)

    def wake(self, now: Ns) -> None:
        """A moment named by next_wake has come (or not yet: harmless).  Raises PortError when the port is lost."""
        if self._sent_at is not None and now >= self._sent_at:
            self._look_for_sent(now)
        due = self._deadline()
        if due is not None and now >= due and now >= self._rest_until:
            self.state.counters.latest_wake_ns = max(self.state.counters.latest_wake_ns, now - due)
            events = self._ask(self.machine.wake, now)
            self._flush(now)
            self._report(events, now)
        self._flush(now)

    def pump(self, now: Ns) -> None:
        """The machine may have output, or the port room again.  Raises PortError when the port is lost."""
        self._flush(now)

    def _ask(self, method: Callable[[Ns], Sequence[E]], now: Ns) -> Sequence[E]:
        try:
            return method(now)
        except Exception as error:  # as above
            return self._broken(error, now)

    def _broken(self, error: Exception, now: Ns) -> Sequence[E]:
        """A machine never raises on data of a partner; if one does, it is counted and the line restarts."""
        self.state.counters.machine_faults += 1
        self._rest_until = now + PAUSE_NS
        self._on_fault(error)
        raise PortError(f"line machine failed ({error!r}); the line is started afresh") from error

    def _flush(self, now: Ns) -> None:
        port = self.port
        if port is None:
            return  # the machine's output waits for the port; its times run from `sent`
        while True:
            data = self._take_output()
            if data:
                self._sent_owed = True
                if self._untaken:
                    data = self._untaken + data
            elif self._untaken:
                data = self._untaken
            else:
                break
            count = port.write(data)
            self.state.counters.sent += count
            self._untaken = data[count:]
            if self._untaken:
                if len(self._untaken) > UNTAKEN_LIMIT:
                    raise PortError(f"{port.name}: accepts nothing any more, {len(self._untaken)} bytes wait; opened again")
                return
            if self._look_for_sent(now):
                continue  # the machine may have more output once this has left
            break
        if self._sent_owed and self._sent_at is None:
            self._look_for_sent(now)

    def _look_for_sent(self, now: Ns) -> bool:
        """Call `sent` if all has left, else determine when to look again."""
        port = self.port
        if port is None or not self._sent_owed or self._untaken:
            return False
        left = port.unsent()
        if left:
            self._sent_at = now + (left * port.char_ns or 1_000_000)
            return False
        self._sent_owed, self._sent_at = False, None
        try:
            events = self._sent(now)
        except Exception as error:  # as above
            events = self._broken(error, now)
        if events:
            self._report(events, now)
        return True

    def _report(self, events: Sequence[E], now: Ns) -> None:
        for event in events:
            self.state.counters.events += 1
            try:
                self._on_event(event, now)
            except Exception as error:  # a listener's mistake must not cost the line its answer times
                self.state.counters.listener_faults += 1
                self._on_fault(error)
