"""Interface of every protocol machine of axisgate: bytes (or frames) and time in, events and output out.

Time is an int of nanoseconds of one monotonic clock, passed in as `now`; a machine never reads a clock.
"""

from collections.abc import Sequence
from enum import Enum, auto
from typing import NamedTuple, Protocol, TypeVar

E_co = TypeVar("E_co", covariant=True)
Ns = int  # nanoseconds on the caller's monotonic clock; only differences have a meaning


def ms(value: float) -> Ns:
    """Milliseconds as nanoseconds."""
    return round(value * 1_000_000)


class Damage(Enum):
    """Why a character (or the line) is damaged; in line order with the bytes."""

    PARITY = auto()
    FRAMING = auto()
    OVERRUN = auto()
    BREAK = auto()


class Machine(Protocol[E_co]):
    """A byte protocol.  No method ever raises on what the partner sends."""

    def receive(self, data: bytes, now: Ns) -> Sequence[E_co]: ...  # these bytes came in: return their events
    def damaged(self, kind: Damage, now: Ns) -> Sequence[E_co]: ...  # a damaged character, in line order with the bytes
    def sent(self, now: Ns) -> Sequence[E_co]: ...  # all you gave me has left the line: answers are due from now
    def wake(self, now: Ns) -> Sequence[E_co]: ...  # time has passed: did anything expire?
    def deadline(self) -> Ns | None: ...  # call wake() then; None: no timer runs
    def take_output(self) -> bytes: ...  # send this, in this order, once
    def lost(self, now: Ns) -> Sequence[E_co]: ...  # the port is lost: report open work, discard the rest


class Frame(NamedTuple):
    """A classic CAN frame with an 11-bit identifier."""

    identifier: int
    data: bytes = b""
    stamp_ns: Ns = 0  # when the bus saw it; 0: not yet sent


class FrameFault(Enum):
    """Faults that a CAN controller reports in addition to frames."""

    BUS_OFF = auto()
    ERROR_PASSIVE = auto()
    NO_ACK = auto()
    OTHER = auto()


class FrameMachine(Protocol[E_co]):
    """A CAN protocol: the same seven methods with frames for bytes."""

    def receive(self, frames: Sequence[Frame], now: Ns) -> Sequence[E_co]: ...
    def error_frame(self, kind: FrameFault, now: Ns) -> Sequence[E_co]: ...
    def sent(self, now: Ns) -> Sequence[E_co]: ...
    def wake(self, now: Ns) -> Sequence[E_co]: ...
    def deadline(self) -> Ns | None: ...
    def take_output(self) -> Sequence[Frame]: ...
    def lost(self, now: Ns) -> Sequence[E_co]: ...
