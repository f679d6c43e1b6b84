"""Events of a 3964R station.  Faults of the partner are events to be counted, never exceptions."""

from dataclasses import dataclass, field
from enum import Enum, auto

from protocols.p3964r.profiles import Priority


class Refusal(Enum):
    """Why a block was refused; the first fault found in it."""

    GAP = auto()  # silence for the character delay
    ORDER = auto()  # a DLE followed by neither DLE nor the end
    LENGTH = auto()  # more characters than a block may have
    CHECK = auto()  # block check wrong
    DAMAGED = auto()  # parity, framing or overrun
    BREAK = auto()
    NO_BUFFER = auto()  # the block before was not collected
    LOST = auto()  # the port went away inside the block


class Failure(Enum):
    """Why an attempt to send failed."""

    SILENT = auto()  # no answer within the acknowledgement delay
    NAK = auto()
    WRONG = auto()  # a character that is neither DLE nor NAK
    DAMAGED = auto()  # the answer was damaged
    CONFLICT = auto()  # gave way to the partner, which then sent no complete block
    BREAK = auto()
    CROWDED = auto()  # too many jobs waiting; the oldest waiting one is dropped
    LOST = auto()  # the port went away
    REVOKED = auto()  # its owner took it back


class Stage(Enum):
    """Where a job was when an attempt failed."""

    WAITING = auto()
    CONNECT = auto()
    BLOCK = auto()


@dataclass(frozen=True, slots=True)
class BlockReceived:
    """A good block, acknowledged; a duplicate is possible by design (3964R has no sequence number)."""

    data: bytes


@dataclass(frozen=True, slots=True)
class BlockRefused:
    """A refused block; `data_count` characters of it were received."""

    why: Refusal
    data_count: int


@dataclass(frozen=True, slots=True)
class BlockSent:
    """The partner acknowledged the block of this job."""

    job: int


@dataclass(frozen=True, slots=True)
class SendRepeated:
    """An attempt failed and another one was begun."""

    job: int
    why: Failure
    stage: Stage


@dataclass(frozen=True, slots=True)
class SendFailed:
    """The job is aborted; `why` is the last failure."""

    job: int
    why: Failure
    stage: Stage


@dataclass(frozen=True, slots=True)
class ReceptionFailed:
    """A refused block was not repeated in time, or refused as often as a partner may try; `why` is the first fault."""

    why: Refusal
    attempts: int


@dataclass(frozen=True, slots=True)
class StrayCharacters:
    """Number of characters in idle before an STX, an own job or a quiet line."""

    count: int


@dataclass(frozen=True, slots=True)
class LineBreak:
    """BREAK in idle."""


@dataclass(frozen=True, slots=True)
class SamePriority:
    """Both stations seem to have this priority: conflicts cannot be settled."""

    priority: Priority


Event = BlockReceived | BlockRefused | BlockSent | SendRepeated | SendFailed | ReceptionFailed | StrayCharacters | LineBreak | SamePriority


@dataclass(slots=True)
class Outbox:
    """Output of both directions of one line, in one order."""

    output: bytearray = field(default_factory=bytearray)
    events: list[Event] = field(default_factory=list)
    turn: int = 0  # how often output was read: bytes of this turn have not been passed out yet

    def say(self, char: int) -> None:
        self.output.append(char)

    def report(self, event: Event) -> None:
        self.events.append(event)

    def take_output(self) -> bytes:
        """Call it only if there is some: it begins a new turn."""
        output = bytes(self.output)
        self.output.clear()
        self.turn += 1
        return output

    def take_events(self) -> list[Event]:
        if not (events := self.events):
            return []
        self.events = []
        return events
