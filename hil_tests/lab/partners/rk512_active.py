"""Active RK512 station, as a PLC's communication processor is one: SEND and FETCH jobs on top of our 3964R link.

A byte machine: hand it to a loop like any other, give it jobs, handle its events.  Source: SIMATIC CP 341 manual 09/2008 (RK512, waiting
times for the reaction).  Headers are written out here byte by byte, not taken from protocols.rk512, which serves the other side.
"""

from collections import Counter, deque
from dataclasses import dataclass
from enum import Enum, auto

from protocols.base.errors import EncodeError
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.events import BlockReceived, BlockSent, SendFailed
from protocols.p3964r.events import Event as LinkEvent
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import SIEMENS_CP525, Priority, Profile

MOST_BYTES = 128  # in one telegram; longer jobs would need follow-on telegrams, which are not used


class Trouble(Enum):
    """Why a job failed where no error number came."""

    LINK = auto()  # the command could not be sent
    NO_REACTION = auto()  # none came in time
    BAD_REACTION = auto()  # not 00 or FF, 00, 00, number, or the wrong amount of data
    COMMAND_INSTEAD = auto()  # the partner sent something else than a reaction
    LOST = auto()  # the port went away


@dataclass(frozen=True, slots=True)
class Done:
    """The partner took (SEND: data empty) or delivered (FETCH) the data."""

    job: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Refused:
    """The reaction carried an error number."""

    job: int
    number: int


@dataclass(frozen=True, slots=True)
class Failed:
    """No valid reaction."""

    job: int
    why: Trouble


@dataclass(frozen=True, slots=True)
class Unasked:
    """A block came though no reaction was awaited."""

    data: bytes


Event = Done | Refused | Failed | Unasked


@dataclass(slots=True)
class _Job:
    number: int
    telegram: bytes
    data_expected: int
    link_job: int = 0


def reaction_time(baud: int) -> Ns:
    """Longest wait for a reaction by the speed of the line, from when the command was acknowledged."""
    for limit, time_ms in ((300, 10_000), (600, 7_000), (19_200, 5_000)):
        if baud <= limit:
            return ms(time_ms)
    return ms(3_000)


class ActiveStation:
    """One job at a time, in the order given; `counts` holds the link's events by name."""

    def __init__(self, baud: int = 9600, profile: Profile = SIEMENS_CP525, priority: Priority = Priority.HIGH) -> None:
        self.link = Link(profile, priority)
        self.counts: Counter[str] = Counter()
        self._reaction_time = reaction_time(baud)
        self._jobs: deque[_Job] = deque()
        self._number = 0
        self._awaiting_until: Ns | None = None

    # ---- for its owner
    def send(self, db: int, word: int, data: bytes, now: Ns, flag: tuple[int, int] = (0xFF, 0xFF)) -> int:
        """SEND an even number of bytes, 2..128, to DB `db` from DW `word` on; returns the job number."""
        if not 2 <= len(data) <= MOST_BYTES or len(data) % 2:
            raise EncodeError(f"data of {len(data)} bytes, range 2..{MOST_BYTES}, even")
        return self.command(_header(0x41, db, word, len(data) // 2, flag) + data, 0, now)

    def fetch(self, db: int, word: int, words: int, now: Ns, flag: tuple[int, int] = (0xFF, 0xFF)) -> int:
        """FETCH 1..64 words; returns the job number."""
        if not 1 <= words <= MOST_BYTES // 2:
            raise EncodeError(f"words = {words}, range 1..{MOST_BYTES // 2}")
        return self.command(_header(0x45, db, word, words, flag), 2 * words, now)

    def command(self, telegram: bytes, data_expected: int, now: Ns) -> int:
        """Any telegram, right or wrong, as a job; `data_expected` bytes must come with its reaction."""
        self._number += 1
        self._jobs.append(_Job(self._number, telegram, data_expected))
        self._next(now)
        return self._number

    @property
    def pending(self) -> int:
        """Jobs without a result."""
        return len(self._jobs)

    # ---- the machine
    def receive(self, data: bytes, now: Ns) -> list[Event]:
        return self._handle(self.link.receive(data, now), now)

    def damaged(self, kind: Damage, now: Ns) -> list[Event]:
        return self._handle(self.link.damaged(kind, now), now)

    def sent(self, now: Ns) -> list[Event]:
        return self._handle(self.link.sent(now), now)

    def wake(self, now: Ns) -> list[Event]:
        events = self._handle(self.link.wake(now), now)
        if self._awaiting_until is not None and now >= self._awaiting_until:
            events += self._finish(Failed(self._jobs[0].number, Trouble.NO_REACTION), now)
        return events

    def deadline(self) -> Ns | None:
        link = self.link.deadline()
        if link is None or self._awaiting_until is None:
            return self._awaiting_until if link is None else link
        return min(link, self._awaiting_until)

    def take_output(self) -> bytes:
        return self.link.take_output()

    def lost(self, now: Ns) -> list[Event]:
        self.counts.update(type(event).__name__ for event in self.link.lost(now))
        failed: list[Event] = [Failed(job.number, Trouble.LOST) for job in self._jobs]
        self._jobs.clear()
        self._awaiting_until = None
        return failed

    # ---- inside
    def _next(self, now: Ns) -> None:
        if self._jobs and not self._jobs[0].link_job:
            self._jobs[0].link_job = self.link.send(self._jobs[0].telegram, now)

    def _handle(self, link_events: list[LinkEvent], now: Ns) -> list[Event]:
        events: list[Event] = []
        for event in link_events:
            self.counts[type(event).__name__] += 1
            match event:
                case BlockSent():
                    self._awaiting_until = now + self._reaction_time
                case SendFailed():
                    events += self._finish(Failed(self._jobs[0].number, Trouble.LINK), now)
                case BlockReceived(data) if self._awaiting_until is None:
                    events.append(Unasked(data))
                case BlockReceived(data):
                    events += self._finish(self._judge(self._jobs[0], data), now)
        return events

    def _judge(self, job: _Job, reaction: bytes) -> Event:
        if len(reaction) < 4 or reaction[0] not in (0x00, 0xFF) or reaction[1] != 0:
            return Failed(job.number, Trouble.BAD_REACTION)
        if reaction[2] != 0:
            return Failed(job.number, Trouble.COMMAND_INSTEAD)
        if reaction[3] != 0:
            return Refused(job.number, reaction[3])
        data = reaction[4:]
        return Done(job.number, data) if len(data) == job.data_expected else Failed(job.number, Trouble.BAD_REACTION)

    def _finish(self, event: Event, now: Ns) -> list[Event]:
        self._jobs.popleft()
        self._awaiting_until = None
        self._next(now)
        return [event]


def _header(command: int, db: int, word: int, words: int, flag: tuple[int, int]) -> bytes:
    for name, value in (("db", db), ("word", word)):
        if not 0 <= value <= 255:
            raise EncodeError(f"{name} = {value}, range 0..255")
    return bytes((0x00, 0x00, command, 0x44, db, word, words >> 8, words & 0xFF, *flag))
