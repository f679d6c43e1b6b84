"""A Modbus client with many devices on one connection or line: scheduling, retries, busy answers, polling, dead devices.

Orders (reads and writes with a waiting caller) go before polling; devices take turns, so none starves another.  A device
that does not answer is demoted: its orders fail at once, and a single request per probe interval checks whether it is back (AX-346).
A read without further answers fails all groups of its device with it, and two devices silent in a row fail what is overdue on the
whole link: a value never stays GOOD because its turn to be read has not come yet (AX-640).
Sources: V1.1b3, section 7 (05 and 06); serial line guide, 2.4.1 (one request at a time, turnaround after a broadcast).
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from protocols.base.machine import Damage, Ns, ms
from protocols.modbus.orders import (
    MOST,
    READS,
    Device,
    DeviceBack,
    DeviceLost,
    Done,
    Event,
    Failed,
    Failure,
    Group,
    Polled,
    PollFailed,
    Refused,
    read_pdu,
    values_of,
)
from protocols.modbus.view import ExceptionCode, Kind
from protocols.modbus.wires import Answer, Heard, Wire

WAITING_LIMIT = 64  # orders of one device that wait; more are refused at once
LEAVE_LIMIT = ms(5000)  # a request that does not leave the port; 256 bytes take 2.4 s at 1200 Bd
TURNAROUND = ms(100)  # after a broadcast (serial line guide, 2.4.1: 100..200 ms)


@dataclass(slots=True)
class _Order:
    number: int
    pdu: bytes


@dataclass(slots=True)
class _Poll:
    """Progress of a group through its reads: `taken` values so far."""

    group: Group
    due: Ns
    taken: list[int] = field(default_factory=list)
    good: bool = False  # its last round was read completely, and nothing was reported lost since

    def piece(self, device: Device) -> int:
        words = self.group.kind in (Kind.HOLDING_REGISTERS, Kind.INPUT_REGISTERS)
        most = min(device.most_words if words else device.most_bits, MOST[self.group.kind])
        return min(self.group.count - len(self.taken), most)

    def pdu(self, device: Device) -> bytes:
        return read_pdu(self.group.kind, self.group.address + len(self.taken), self.piece(device))

    def next_turn(self, now: Ns) -> None:
        """The grid is kept; rounds that could not be are left out."""
        self.taken = []
        behind = max(0, now - self.due) // self.group.every
        self.due += (behind + 1) * self.group.every


@dataclass(slots=True)
class Seen:
    """State of a device, for pages and status blocks."""

    device: Device
    alive: bool = False
    dead: bool = False  # demoted; neither alive nor dead: not polled yet, or failing for the first time
    answered_ns: Ns | None = None
    requests: int = 0  # sent, with repeats
    answers: int = 0
    exceptions: int = 0
    timeouts: int = 0
    spoiled: int = 0
    losses: int = 0
    failures: int = 0  # in a row
    ready: Ns = 0  # not before: pause, busy pause, probe
    orders: deque[_Order] = field(default_factory=deque)
    polls: list[_Poll] = field(default_factory=list)


@dataclass(slots=True)
class _Running:
    """The request under way."""

    seen: Seen
    what: _Order | _Poll
    pdu: bytes
    attempts: int = 1
    busy: int = 0
    due: Ns | None = None  # of the answer, or of leaving the line
    left: bool = False
    again: Ns | None = None  # a repeat waits for this moment
    broadcast: bool = False


class Master:
    """One connection or line (a byte machine).  `order` and `poll` may be called at any time; kick the line afterwards."""

    def __init__(self, wire: Wire, devices: Sequence[Device], turnaround: Ns = TURNAROUND) -> None:
        self._wire, self._turnaround = wire, turnaround
        self.seen = {device.name: Seen(device) for device in devices}
        self._round = deque(self.seen.values())
        self._running: _Running | None = None
        self._output = b""
        self._events: list[Event] = []
        self._numbers = 0
        self._quiet_until: Ns = 0
        self._silent: Seen | None = None  # a device that ran into a time-out; no device has answered since
        self._open = False
        self._ordered = False  # the last turn was an order's: a poll overdue by a full round goes before the next one

    # ---- requests of its owner
    def order(self, device: str, pdu: bytes, now: Ns) -> int:
        """Queue a request (1..253 bytes); Done, Refused or Failed return its number.  KeyError: no such device.

        Without a connection it fails at once: it is not kept, because it would be executed at an unintended moment.
        """
        seen = self.seen[device]
        self._numbers += 1
        if not self._open:
            self._events.append(Failed(self._numbers, device, Failure.LOST))
        elif len(seen.orders) >= WAITING_LIMIT:
            self._events.append(Failed(self._numbers, device, Failure.FULL))
        elif seen.dead and now < seen.ready:
            self._events.append(Failed(self._numbers, device, Failure.DEAD))
        else:
            seen.orders.append(_Order(self._numbers, pdu))
            self._next(now)
        return self._numbers

    def poll(self, group: Group, now: Ns) -> None:
        """Reads the group from now on."""
        if group.every <= 0 or group.count <= 0:
            raise ValueError(f"group {group.name}: every and count must be positive")
        self.seen[group.device].polls.append(_Poll(group, now))
        self._next(now)

    def opened(self, now: Ns) -> None:
        """The port is open (again): every device is polled at once, also those that counted as dead."""
        self._open = True
        for seen in self._round:
            seen.dead, seen.failures, seen.ready = False, 0, now
            for poll in seen.polls:
                poll.due = max(poll.due, now) if poll.due > now + poll.group.every else now
        self._next(now)

    # ---- the seven methods
    def receive(self, data: bytes, now: Ns) -> list[Event]:
        events = self.wake(now)
        self._quiet_until = now + self._wire.quiet
        self._heard(self._wire.receive(data, now), now)
        return events + self._next_events(now)

    def damaged(self, kind: Damage, now: Ns) -> list[Event]:
        self._quiet_until = now + self._wire.quiet
        self._heard(self._wire.damaged(kind, now), now)
        return self._next_events(now)

    def sent(self, now: Ns) -> list[Event]:
        running = self._running
        if running is not None and not running.left and running.again is None:
            running.left = True
            running.due = now + (self._turnaround if running.broadcast else running.seen.device.timeout)
        return self._next_events(now)

    def wake(self, now: Ns) -> list[Event]:
        self._heard(self._wire.wake(now), now)
        running = self._running
        if running is not None and running.again is not None and now >= max(running.again, self._quiet_until):
            self._send(running, now)
        elif running is not None and running.due is not None and now >= running.due:
            self._overdue(running, now)
        self._next(now)
        return self._next_events(now)

    def deadline(self) -> Ns | None:
        if self._events:
            return 0  # an order was refused when it was queued: report it at the next chance
        running, silence = self._running, self._wire.deadline()
        if not self._open:
            return None
        if running is None:
            due = min((self._ready(seen) for seen in self._round if self._has_work(seen)), default=None)
            return None if due is None else max(due, self._quiet_until)
        own = running.due if running.again is None else max(running.again, self._quiet_until)
        return min((moment for moment in (own, silence) if moment is not None), default=None)

    def take_output(self) -> bytes:
        output, self._output = self._output, b""
        return output

    def lost(self, now: Ns) -> list[Event]:
        """Pending and waiting requests fail, every group is reported lost; nothing is sent until opened()."""
        self._output, self._quiet_until, self._open, self._silent = b"", 0, False, None
        self._wire.forget()
        running, self._running = self._running, None
        if running is not None and isinstance(running.what, _Order):
            self._events.append(Failed(running.what.number, running.seen.device.name, Failure.LOST))
        for seen in self.seen.values():
            while seen.orders:
                self._events.append(Failed(seen.orders.popleft().number, seen.device.name, Failure.LOST))
            for poll in seen.polls:
                poll.taken, poll.good = [], False
                self._events.append(PollFailed(poll.group.name, Failure.LOST))
            if seen.alive:
                seen.alive = False
                seen.losses += 1
                self._events.append(DeviceLost(seen.device.name))
        return self._next_events(now)

    # ---- one request
    def _next(self, now: Ns) -> None:
        """Starts the next request if none is under way: orders first, then the poll that is due longest; turns go round."""
        if self._running is not None or now < self._quiet_until or not self._open:
            return
        ready = [seen for seen in self._round if self._has_work(seen) and self._ready(seen) <= now]
        if not ready:
            return
        ordered = [seen for seen in ready if seen.orders]
        late = [seen for seen in ready if any(poll.due + poll.group.every <= now for poll in seen.polls)]
        polls = not ordered or bool(late and self._ordered)
        seen = min(late or ready, key=_longest_due) if polls else ordered[0]
        self._ordered = not polls
        self._round.remove(seen)
        self._round.append(seen)
        what: _Order | _Poll = min(seen.polls, key=lambda poll: poll.due) if polls else seen.orders.popleft()
        pdu = what.pdu if isinstance(what, _Order) else what.pdu(seen.device)
        broadcast = self._wire.broadcasts and seen.device.unit == 0
        self._running = _Running(seen, what, pdu, broadcast=broadcast)
        self._send(self._running, now)

    def _send(self, running: _Running, now: Ns) -> None:
        running.left, running.again = False, None
        running.due = now + running.seen.device.timeout + LEAVE_LIMIT
        running.seen.requests += 1
        self._output += self._wire.ask(running.seen.device.unit, running.pdu)

    def _heard(self, heard: Heard, now: Ns) -> None:
        running = self._running
        if heard is None or running is None:
            return
        seen = running.seen
        if not isinstance(heard, Answer):
            seen.spoiled += 1
            self._repeat(running, Failure.SPOILED, now)
            return
        seen.answers += 1
        self._silent = None
        seen.answered_ns, seen.failures = now, 0
        seen.ready = now + seen.device.pause
        self._back(seen)
        if heard.pdu[0] & 0x80:
            self._exception(running, heard.pdu[1], now)
        else:
            self._answered(running, heard.pdu, now)

    def _exception(self, running: _Running, code: int, now: Ns) -> None:
        """06: repeat later.  05: accepted; a read is repeated, a write is not, because it would be executed twice."""
        running.seen.exceptions += 1
        later = code == ExceptionCode.SERVER_DEVICE_BUSY or (code == ExceptionCode.ACKNOWLEDGE and running.pdu[0] in READS)
        if later and running.busy < running.seen.device.busy_retries:
            running.busy += 1
            running.due, running.again = None, now + running.seen.device.busy_pause
            return
        self._running = None
        if isinstance(running.what, _Order):
            self._events.append(Refused(running.what.number, running.seen.device.name, code))
        else:
            self._failed(running.what, code, now)

    def _answered(self, running: _Running, pdu: bytes, now: Ns) -> None:
        what = running.what
        self._running = None
        if isinstance(what, _Order):
            self._events.append(Done(what.number, running.seen.device.name, pdu))
            return
        values = values_of(pdu, what.piece(running.seen.device))
        if values is None:
            running.seen.spoiled += 1
            self._failed(what, Failure.SPOILED, now)
            return
        what.taken += values
        if len(what.taken) == what.group.count:
            what.good = True
            self._events.append(Polled(what.group.name, tuple(what.taken)))
            what.next_turn(now)

    def _overdue(self, running: _Running, now: Ns) -> None:
        self._wire.forget()
        if running.broadcast and isinstance(running.what, _Order):
            self._running = None
            self._events.append(Done(running.what.number, running.seen.device.name, b""))
            return
        running.seen.timeouts += 1
        self._unheard(running.seen, now)
        self._repeat(running, Failure.TIMEOUT, now)

    def _repeat(self, running: _Running, why: Failure, now: Ns) -> None:
        """Another attempt, unless there were enough, or the device is dead: a probe is one request."""
        device = running.seen.device
        once = running.seen.dead or (running.pdu[0] not in READS and not device.repeat_writes)
        if once or running.attempts > device.retries:
            self._running = None
            self._give_up(running, why, now)
            return
        running.attempts += 1
        running.due, running.again = None, now + device.pause

    def _give_up(self, running: _Running, why: Failure, now: Ns) -> None:
        seen = running.seen
        seen.failures += 1
        seen.ready = now + seen.device.pause
        if isinstance(running.what, _Order):
            self._events.append(Failed(running.what.number, seen.device.name, why))
        else:
            was_good = running.what.good
            self._failed(running.what, why, now)
            if was_good and why is Failure.TIMEOUT:
                self._doubt(seen)  # a read this device answers differently; a register it never answered proves nothing about the others
        if seen.dead or seen.failures >= seen.device.demote_after:
            self._demote(seen, now)

    def _demote(self, seen: Seen, now: Ns) -> None:
        seen.ready = now + seen.device.probe_every
        if not seen.dead:
            seen.dead, seen.alive = True, False
            seen.losses += 1
            self._events.append(DeviceLost(seen.device.name))
        self._doubt(seen)
        while seen.orders:
            self._events.append(Failed(seen.orders.popleft().number, seen.device.name, Failure.DEAD))

    def _failed(self, poll: _Poll, why: Failure | int, now: Ns) -> None:
        poll.good = False
        poll.next_turn(now)
        self._events.append(PollFailed(poll.group.name, why))

    def _doubt(self, seen: Seen, overdue: Ns | None = None) -> None:
        """Groups of a silent device fail at once, not each at its own turn; with `overdue` those that were due by then."""
        for poll in seen.polls:
            if poll.good and (overdue is None or poll.due <= overdue):
                poll.taken, poll.good = [], False
                self._events.append(PollFailed(poll.group.name, Failure.TIMEOUT))

    def _unheard(self, seen: Seen, now: Ns) -> None:
        """A second device silent in a row: the connection to the devices has failed, not the devices."""
        if seen.dead:
            return  # a probe; that one is away is known
        if self._silent not in (None, seen):
            for other in self._round:
                self._doubt(other, now)
        self._silent = seen

    def _back(self, seen: Seen) -> None:
        if not seen.alive:
            seen.alive, seen.dead = True, False
            self._events.append(DeviceBack(seen.device.name))

    # ---- turns
    def _has_work(self, seen: Seen) -> bool:
        return bool(seen.orders or seen.polls)

    def _ready(self, seen: Seen) -> Ns:
        if seen.orders:
            return seen.ready
        return max(seen.ready, min(poll.due for poll in seen.polls))

    def _next_events(self, now: Ns) -> list[Event]:
        self._next(now)
        events, self._events = self._events, []
        return events


def _longest_due(seen: Seen) -> Ns:
    return min(poll.due for poll in seen.polls)
