"""Partners in process for `sim:NAME`: good stations, and hostile ones that each have one fault seen in real stations.

Sources of the faults: serial-protocols 1.2 (block check), 1.3 (NAK at giving up, attempts), 1.6 (conflicts), 6 (21 ms: one more than the
tolerance of the probe); AX-201.
"""

from collections import Counter, deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from drivers.ports.serial.line_format import LineFormat
from gateway.conformance.serial.faulty_lines import FAULTY
from gateway.links.serial.tool_wire import VirtualWire, Wire
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char, check_of
from protocols.p3964r.events import BlockReceived
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, RHO3, Priority, Profile
from protocols.rk512.passive import ErrorNumber, Passive

WORDS = 128
BLOCKS = (5, 10, 11, 16)
SLOW = ms(21)
STX, DLE, ETX, NAK = (bytes((char,)) for char in (Char.STX, Char.DLE, Char.ETX, Char.NAK))


class Blocks:
    """Data blocks of a simulated station, WORDS words each; written values stay."""

    def __init__(self, numbers: Sequence[int] = BLOCKS) -> None:
        self.content = {number: bytearray(bytes((number, 0)) * WORDS) for number in numbers}

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        if db not in self.content or word + words > WORDS:
            return ErrorNumber.BLOCK
        return bytes(self.content[db][2 * word : 2 * (word + words)])

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        if db not in self.content or 2 * word + len(data) > 2 * WORDS:
            return ErrorNumber.BLOCK
        self.content[db][2 * word : 2 * word + len(data)] = data
        return None


class Station:
    """The product's link with its passive RK512 station (or raw blocks, kept in `received`) as one byte machine."""

    def __init__(self, profile: Profile, priority: Priority, layer: str = "rk512") -> None:
        self.profile, self.priority = profile, priority
        self.link = Link(profile, priority)
        self.blocks = Blocks()
        self.passive = Passive(self.blocks) if layer == "rk512" else None
        self.received: list[bytes] = []
        self.counts: Counter[str] = Counter()

    def stimulate(self, now: Ns, block: bytes = b"U\x01\x02\x03") -> None:
        """It has something to send."""
        self.link.send(block, now)

    def hold(self, held: bool, now: Ns) -> None:
        """True: its buffer stays full."""
        self.link.set_buffer_free(not held, now)

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        return self._handle(self.link.receive(data, now), now)

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        return self._handle(self.link.damaged(kind, now), now)

    def sent(self, now: Ns) -> Sequence[object]:
        return self._handle(self.link.sent(now), now)

    def wake(self, now: Ns) -> Sequence[object]:
        return self._handle(self.link.wake(now), now)

    def deadline(self) -> Ns | None:
        return self.link.deadline()

    def take_output(self) -> bytes:
        return self.link.take_output()

    def lost(self, now: Ns) -> Sequence[object]:
        return self._handle(self.link.lost(now), now)

    def _handle(self, events: Sequence[object], now: Ns) -> Sequence[object]:
        for event in events:
            self.counts[type(event).__name__] += 1
            if isinstance(event, BlockReceived):
                self.received.append(event.data)
                self._serve(event.data, now)
        return events

    def _serve(self, data: bytes, now: Ns) -> None:
        if self.passive is None:
            return
        self.passive.telegram(data, now)
        while (reaction := self.passive.take_output()) is not None:
            self.link.send(reaction, now)


class Silent(Station):
    """Receives everything, sends nothing."""

    def take_output(self) -> bytes:
        self.link.take_output()
        return b""


class NoNak(Station):
    """Never sends NAK: its refusals and its aborted jobs are silent."""

    def take_output(self) -> bytes:
        output = self.link.take_output()
        return output if _is_block(output) else output.replace(NAK, b"")


class DropsItsJob(Station):
    """Yields in a conflict, as without priority, and drops its own job."""

    def __init__(self, profile: Profile, priority: Priority, layer: str = "rk512") -> None:
        super().__init__(profile, Priority.LOW, layer)
        self._offered = False

    def take_output(self) -> bytes:
        output = super().take_output()
        if output:
            self._offered = output[-1:] == STX and not _is_block(output)
        return output

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        events: list[object] = []
        for at in range(len(data)):
            if self._offered and data[at : at + 1] == STX:
                self.link = Link(replace(self.profile, nak_at_start=False), Priority.LOW)
            self._offered = False
            events += super().receive(data[at : at + 1], now)
        return events


class NaksConflicts(Station):
    """Answers a STX that meets its own with NAK, then offers again."""

    def __init__(self, profile: Profile, priority: Priority, layer: str = "rk512") -> None:
        super().__init__(profile, priority, layer)
        self._offered = False
        self._first = b""

    def take_output(self) -> bytes:
        output = super().take_output()
        if output:
            self._offered = output[-1:] == STX and not _is_block(output)
        first, self._first = self._first, b""
        return first + output

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        events: list[object] = []
        for at in range(len(data)):
            if self._offered and data[at : at + 1] == STX:
                self._first = NAK
            self._offered = False
            events += super().receive(self._first or data[at : at + 1], now)
        return events


class Late(Station):
    """Sends everything late by `late`."""

    def __init__(self, profile: Profile, priority: Priority, layer: str = "rk512", late: Ns = SLOW) -> None:
        super().__init__(profile, priority, layer)
        self._late = late
        self._queue: deque[tuple[Ns, bytes]] = deque()
        self._now: Ns = 0
        self._due_output = b""

    def _collect(self, now: Ns) -> None:
        output = self.link.take_output()
        if output:
            self._queue.append((now + self._late, output))

    def _handle(self, events: Sequence[object], now: Ns) -> Sequence[object]:
        handled = super()._handle(events, now)
        self._collect(now)
        return handled

    def stimulate(self, now: Ns, block: bytes = b"U\x01\x02\x03") -> None:
        super().stimulate(now, block)
        self._collect(now)

    def wake(self, now: Ns) -> Sequence[object]:
        while self._queue and self._queue[0][0] <= now:
            self._due_output += self._queue.popleft()[1]
        due = self.link.deadline()
        return super().wake(now) if due is not None and due <= now else []

    def deadline(self) -> Ns | None:
        moments = [moment for moment in (self.link.deadline(), self._queue[0][0] if self._queue else None) if moment is not None]
        return min(moments) if moments else None

    def sent(self, now: Ns) -> Sequence[object]:
        return [] if self._queue else super().sent(now)

    def take_output(self) -> bytes:
        output, self._due_output = self._due_output, b""
        return output


class OwnCheck(Station):
    """Forms and judges the block check in its own wrong way: `wrong(block after STX with its right check) -> the check it believes in`."""

    def __init__(self, profile: Profile, priority: Priority, layer: str, wrong: Callable[[bytes], int]) -> None:
        super().__init__(profile, priority, layer)
        self._wrong = wrong
        self._heard = bytearray()
        self._inside = self._escaped = self._check_next = False

    def take_output(self) -> bytes:
        output = super().take_output()
        if _is_block(output):
            return output[:-1] + bytes((self._wrong(output),))
        if output[-1:] == NAK:
            self._inside = False  # the block was aborted
        return output

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        return [event for byte in data for event in Station.receive(self, bytes((self._seen(byte),)), now)]

    def _seen(self, byte: int) -> int:
        """Its own wrong check is turned into the right one for our link, and the other way round."""
        if not self._inside:
            if byte == Char.STX:
                self._inside, self._escaped, self._check_next = True, False, False
                self._heard.clear()
            return byte
        if self._check_next:
            self._inside = self._check_next = False
            right = check_of(bytes(self._heard))
            believed = self._wrong(bytes(self._heard) + bytes((right,)))
            return right if byte == believed else byte ^ 0xFF if byte == right else byte
        self._heard.append(byte)
        self._check_next = self._escaped and byte in (Char.ETX, Char.ETB)
        self._escaped = byte == Char.DLE and not self._escaped
        return byte


def counts_once(block: bytes) -> int:
    """The check of a station that enters a doubled DLE once."""
    body = block[:-1]
    return check_of(body[:-2].replace(DLE + DLE, DLE) + body[-2:])


def includes_stx(block: bytes) -> int:
    """The check of a station that begins with STX."""
    return block[-1] ^ Char.STX


class NeverDoubles(Station):
    """Sends a DLE of its data once; reads doubled ones as it should."""

    def take_output(self) -> bytes:
        output = super().take_output()
        if not _is_block(output):
            return output
        body = output[:-3].replace(DLE + DLE, DLE) + output[-3:-1]
        return body + bytes((check_of(body),))


def _is_block(output: bytes) -> bool:
    """Characters after STX, in distinction to single control characters."""
    return len(output) >= 4 and (DLE + ETX) in output


@dataclass(frozen=True, slots=True)
class Partner:
    """One name after `sim:`."""

    what: str
    make: Callable[[Profile, Priority], Station]


def _two(profile: Profile, priority: Priority) -> Station:
    return Station(replace(profile, connect_attempts=2, block_attempts=2), priority)


def _bad(profile: Profile, priority: Priority) -> Station:
    """Three faults at once, for a first look at a report."""
    return OwnCheck(replace(profile, connect_attempts=2, nak_when_giving_up=False), priority, "rk512", counts_once)


PARTNERS: dict[str, Partner] = {
    "good": Partner("keeps to its profile; passive RK512, DB 5, 10, 11, 16", Station),
    "raw": Partner("keeps to its profile; raw blocks, no RK512", lambda profile, priority: Station(profile, priority, "raw")),
    "bad-partner": Partner("2 connection attempts, no NAK at giving up, a doubled DLE enters the check once", _bad),
    "silent": Partner("never answers", Silent),
    "no-nak": Partner("never sends NAK", NoNak),
    "drops-its-job": Partner("gives way in a conflict and forgets its own job", DropsItsJob),
    "never-doubles": Partner("sends a DLE of its data once", NeverDoubles),
    "slow-3s": Partner("everything 3 s late, after every acknowledgement delay", lambda p, q: Late(p, q, late=ms(3000))),
    "slow-21ms": Partner("everything 21 ms late", Late),
    "naks-conflicts": Partner("answers a conflicting STX with NAK", NaksConflicts),
    "two-attempts": Partner("2 attempts only", _two),
    "includes-stx": Partner("begins the block check with STX", lambda p, q: OwnCheck(p, q, "rk512", includes_stx)),
    "counts-once": Partner("a doubled DLE enters the check once", lambda p, q: OwnCheck(p, q, "rk512", counts_once)),
}


def make(name: str, profile: Profile = RHO3, priority: Priority = Priority.LOW) -> Station:
    """The partner of that name; ValueError lists the names."""
    if name not in PARTNERS:
        raise ValueError(
            f'port "sim:{name}": partners are {", ".join((*PARTNERS, *FAULTY))}; sim:NAME,PROFILE,high|low sets profile and priority'
        )
    return PARTNERS[name].make(profile, priority)


def simulated(text: str, line_format: LineFormat) -> Wire:
    """`NAME[,PROFILE[,high|low]]` at the other end of a virtual line; NAME is a partner, or a line with a fault and a good partner."""
    name, *rest = text.split(",")
    profile = PROFILES.get(rest[0]) if rest else RHO3
    if profile is None:
        raise ValueError(f'port "sim:{text}": profile {rest[0]!r} is unknown; there are {", ".join(PROFILES)}')
    priority = Priority.LOW if rest[1:] == ["low"] else Priority.HIGH  # as old processors are set
    station = make("good" if name in FAULTY else name, profile, priority)
    wire = VirtualWire(station, line_format.char_ns, f"sim:{text}")
    return FAULTY[name](wire, line_format) if name in FAULTY else wire
