"""The language of start-ups and tools on CANopen nodes: steps that an executor carries out, and the answers it sends back.  Pure."""

from dataclasses import dataclass
from enum import Enum

from protocols.canopen.nmt import Command, State
from protocols.canopen.sdo import TEXTS


@dataclass(frozen=True, slots=True)
class Read:
    """SDO upload."""

    index: int
    sub: int = 0


@dataclass(frozen=True, slots=True)
class Write:
    """SDO download."""

    index: int
    sub: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Nmt:
    """A command to this node; `awaits`: the state its heartbeat has to show then, within the boot time-out."""

    command: Command
    awaits: State | None = None


@dataclass(frozen=True, slots=True)
class Pause:
    """Nothing for a while."""

    ms: int


@dataclass(frozen=True, slots=True)
class Sync:
    """One SYNC of a tool that plays the cycle for a moment, then a pause; never while a cycle owns the bus."""

    pause_ms: int


@dataclass(frozen=True, slots=True)
class Now:
    """The time in ms as eight bytes, low byte first: a limit is kept whatever the dialogue itself costs."""


Step = Read | Write | Nmt | Pause | Sync | Now


@dataclass(frozen=True, slots=True)
class Refused:
    """The node answered with an abort code."""

    code: int

    def __str__(self) -> str:
        return f"{TEXTS.get(self.code, 'unknown reason')} ({self.code:08X}h)"


class Silent(Enum):
    """The node did not answer in time."""

    YES = "no answer"


Answer = bytes | Refused | Silent
