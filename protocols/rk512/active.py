"""Active RK512 station: SEND and FETCH jobs, one in progress at a time, each ending in exactly one event.

Works on telegrams: `take_output` returns the next block for the link, `acknowledged` or `unsent` reports its outcome, `reaction` accepts a
reaction telegram.  Source: SIMATIC CP 341 manual 09/2008 (RK512, event classes 6, 9, 10); long jobs: AX-222.
"""

from collections import deque
from dataclasses import dataclass, field
from enum import Enum, auto

from protocols.base.errors import EncodeError
from protocols.base.machine import Ns
from protocols.rk512.dialects import STANDARD, Dialect
from protocols.rk512.header import (
    FIRST,
    FOLLOW_ON,
    HEADER_BYTES,
    MOST_BYTES,
    REACTION_BYTES,
    Command,
    Flag,
    Header,
    Kind,
    encode_follow_on,
)

MOST_JOBS = 64  # waiting ones; nothing grows while a partner is away


class Trouble(Enum):
    """Why a job ended without an error number of the partner."""

    LINK = auto()  # the command could not be sent
    NO_REACTION = auto()  # none in time
    TOO_SHORT = auto()  # reaction shorter than 4 bytes
    FIRST_BYTE = auto()  # neither 00 nor FF
    HEADER = auto()  # byte 2 or 3 is not 00
    TOO_MUCH_DATA = auto()
    TOO_LITTLE_DATA = auto()
    DATA_AFTER_SEND = auto()
    COMMAND_INSTEAD = auto()  # the partner sent a command instead of the reaction (without nesting)
    EARLY = auto()  # inside a long job: a reaction to a command not acknowledged yet; which one it answers cannot be known
    CROWDED = auto()  # too many jobs waiting; the oldest waiting one is dropped
    LOST = auto()  # the port went away


@dataclass(frozen=True, slots=True)
class Done:
    """SEND: the partner accepted all of it (data empty).  FETCH: the complete data."""

    job: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Denied:
    """The reaction carried this error number; it may be one of the partner's own."""

    job: int
    number: int


@dataclass(frozen=True, slots=True)
class Failed:
    """No valid reaction."""

    job: int
    why: Trouble


@dataclass(frozen=True, slots=True)
class Unasked:
    """A reaction telegram, though none is expected."""

    head: bytes


Event = Done | Denied | Failed | Unasked


@dataclass(slots=True)
class _Job:
    number: int
    header: Header
    total: int  # bytes
    data: bytes  # SEND
    got: bytearray = field(default_factory=bytearray)  # FETCH
    moved: int = 0  # bytes that the partner has reported as over
    telegrams: int = 0  # passed out

    @property
    def fetch(self) -> bool:
        return self.header.command == Command.FETCH

    @property
    def piece(self) -> int:
        """Bytes the telegram on its way moves."""
        return min(self.total - self.moved, MOST_BYTES)

    def telegram(self) -> bytes:
        data = self.data[self.moved : self.moved + MOST_BYTES]
        self.telegrams += 1
        if self.telegrams == 1:
            return self.header.encode() + data
        return encode_follow_on(self.header.command, self.header.kind, data)


class Active:
    """Jobs in the order of queueing."""

    def __init__(self, dialect: Dialect = STANDARD, baud: int = 9600) -> None:
        self._dialect, self._wait = dialect, dialect.waits(baud)
        self._jobs: deque[_Job] = deque()
        self._events: list[Event] = []
        self._number = 0
        self._output: bytes | None = None
        self._on_its_way = False  # passed out, the link has not reported its outcome
        self._orphan = False  # the job of that telegram has ended
        self._until: Ns | None = None

    # ---- for its owner
    def send(self, address: int, data: bytes, block: int = 0, kind: Kind = Kind.BLOCK, flag: Flag | None = None) -> int:
        """SEND to word, byte or number `address`; returns the job number.  EncodeError names what is out of range."""
        if kind not in self._dialect.send_kinds:
            raise EncodeError(f"SEND to {chr(kind)}: {self._dialect.name} needs {' '.join(map(chr, self._dialect.send_kinds))}")
        if len(data) % kind.unit:
            raise EncodeError(f"data of {len(data)} bytes, {chr(kind)} counts {kind.unit} bytes each")
        pair = self._dialect.extended_send if kind is Kind.EXTENDED else bytes((Command.SEND, kind))
        return self._add(pair, kind, block, address, len(data) // kind.unit, flag, data)

    def fetch(self, address: int, amount: int, block: int = 0, kind: Kind = Kind.BLOCK, flag: Flag | None = None) -> int:
        """FETCH `amount` words or bytes, as the type counts them; returns the job number."""
        if not self._dialect.reaction:
            raise EncodeError(f"FETCH: {self._dialect.name} has no reaction telegrams, which would carry the data")
        return self._add(bytes((Command.FETCH, kind)), kind, block, address, amount, flag, b"")

    def _add(self, pair: bytes, kind: Kind, block: int, address: int, amount: int, flag: Flag | None, data: bytes) -> int:
        header = Header(pair[0], pair[1], *self._bytes_of(kind, block, address), amount, flag)
        total = amount * kind.unit
        if not kind.unit <= total <= self._dialect.most_bytes:
            raise EncodeError(f"amount = {total} bytes, range {kind.unit}..{self._dialect.most_bytes} of {self._dialect.name}")
        header.encode()  # raises now, not when its turn comes
        if len(self._jobs) > MOST_JOBS:
            self._events.append(Failed(self._jobs[1].number, Trouble.CROWDED))
            del self._jobs[1]
        self._number += 1
        self._jobs.append(_Job(self._number, header, total, data))
        self._next()
        return self._number

    def _bytes_of(self, kind: Kind, block: int, address: int) -> tuple[int, int]:
        """Bytes 5 and 6 of the header."""
        if not kind.in_blocks:
            if not 0 <= address <= 0xFFFF:
                raise EncodeError(f"address = {address}, range 0..65535")
            return address >> 8, address & 0xFF
        if not 0 <= address <= self._dialect.most_word:
            raise EncodeError(f"word = {address}, range 0..{self._dialect.most_word} of {self._dialect.name}")
        return block, 2 * address if self._dialect.db_address_unit == "byte" else address

    @property
    def name(self) -> str:
        """Name of the dialect."""
        return self._dialect.name

    @property
    def pending(self) -> int:
        """Jobs without a result."""
        return len(self._jobs)

    @property
    def awaiting(self) -> bool:
        """A reaction is due."""
        return self._until is not None

    # ---- reports of the link
    def take_output(self) -> bytes | None:
        """The next telegram for the link, once."""
        if self._on_its_way:
            return None
        output, self._output = self._output, None
        self._on_its_way = output is not None
        return output

    def acknowledged(self, now: Ns) -> list[Event]:
        """The partner has the telegram: the reaction is due from now on."""
        events = self._take_events()
        if self._free_link():
            return events
        if self._dialect.reaction:
            self._until = now + self._wait
            return events
        return [*events, *self._advance(b"")]

    def unsent(self, now: Ns) -> list[Event]:
        """The link has aborted the telegram."""
        events = self._take_events()
        return events if self._free_link() else [*events, self._fail(Trouble.LINK)]

    def reaction(self, data: bytes, now: Ns) -> list[Event]:
        """A reaction telegram, or another block instead."""
        events = self._take_events()
        if self._until is None:
            if self._on_its_way and not self._orphan and self._jobs[0].telegrams > 1:
                return [*events, self._fail(Trouble.EARLY)]
            return [*events, Unasked(data[:HEADER_BYTES])]
        self._until = None
        job = self._jobs[0]
        trouble = _fault_of(job, data)
        if trouble is not None:
            return [*events, self._fail(trouble)]
        if data[3] != 0:
            return [*events, self._finish(Denied(job.number, data[3]))]
        return [*events, *self._advance(data[REACTION_BYTES:])]

    def interrupted(self, now: Ns) -> list[Event]:
        """The partner sent a command while our reaction was due and this dialect has no nesting."""
        return [*self._take_events(), *([self._fail(Trouble.COMMAND_INSTEAD)] if self.awaiting else [])]

    def wake(self, now: Ns) -> list[Event]:
        events = self._take_events()
        if self._until is not None and now >= self._until:
            events.append(self._fail(Trouble.NO_REACTION))
        return events

    def deadline(self) -> Ns | None:
        return self._until

    def lost(self) -> list[Event]:
        """The port is lost: every job is reported."""
        events = [*self._take_events(), *(Failed(job.number, Trouble.LOST) for job in self._jobs)]
        self._jobs.clear()
        self._on_its_way, self._orphan, self._until, self._output = False, False, None, None
        return events

    # ---- inside
    def _next(self) -> None:
        if self._jobs and self._jobs[0].telegrams == 0:
            self._output = self._jobs[0].telegram()

    def _advance(self, data: bytes) -> list[Event]:
        """The partner has, or gave, one more piece; without reactions the acknowledgement of the link is all there is."""
        job = self._jobs[0]
        job.moved += job.piece
        job.got += data
        if job.moved == job.total:
            return [self._finish(Done(job.number, bytes(job.got)))]
        self._output = job.telegram()
        return []

    def _free_link(self) -> bool:
        """The link is done with our telegram; True: its job had ended before."""
        orphan, self._on_its_way, self._orphan = self._orphan, False, False
        return orphan

    def _fail(self, why: Trouble) -> Event:
        return self._finish(Failed(self._jobs[0].number, why))

    def _finish(self, event: Event) -> Event:
        self._jobs.popleft()
        self._orphan, self._until, self._output = self._on_its_way, None, None
        self._next()
        return event

    def _take_events(self) -> list[Event]:
        events, self._events = self._events, []
        return events


def _fault_of(job: _Job, data: bytes) -> Trouble | None:
    if len(data) < REACTION_BYTES:
        return Trouble.TOO_SHORT
    if data[0] not in (FIRST, FOLLOW_ON):
        return Trouble.FIRST_BYTE
    if data[1] != 0 or data[2] != 0:
        return Trouble.HEADER
    expected = job.piece if job.fetch and data[3] == 0 else 0
    found = len(data) - REACTION_BYTES
    if found > expected:
        return Trouble.TOO_MUCH_DATA if job.fetch else Trouble.DATA_AFTER_SEND
    return Trouble.TOO_LITTLE_DATA if found < expected else None
