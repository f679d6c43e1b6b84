"""Interface of every drive family to the rest of the gateway: one object per drive, one per bus.

The core steps the drives and sees neutral records only; the cycle sends the frames that the bus' family builds from them and passes it the
received ones.  Only the family knows bits, identifiers and frames (AX-300).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple, Protocol, runtime_checkable

from protocols.base.machine import Frame, Ns


class Power(Enum):
    """Power states as far as the rest of the gateway needs them."""

    OFF = 0
    SWITCHING_ON = 1
    ENABLED = 2
    SWITCHING_OFF = 3
    FAULT = 4
    LOST = 5


class Event(Enum):
    """An event of the last step."""

    ENABLED = auto()
    OFF = auto()
    FAULT = auto()
    FAULT_CLEARED = auto()
    LOST = auto()
    RETURNED = auto()
    DROPPED = auto()  # the drive left control on its own, without a fault
    TIMEOUT = auto()  # a phase took too long
    JUMP = auto()  # a set position too far from the last one was not sent
    RANGE = auto()  # a set position beyond int32 was not sent


class Homing(Enum):
    """Reference run performed by the drive."""

    NONE = auto()
    RUNNING = auto()
    DONE = auto()  # reported once the drive follows again
    FAILED = auto()


class Demand(NamedTuple):
    """The cycle's demand on a drive."""

    on: bool = False  # counts by its rising edge, goes off by its level
    reset: bool = False  # rising edge
    position_inc: int = 0
    speed_rpm: float = 0.0  # feed-forward
    limit_switch: bool = False  # ENABLE LIMIT SWITCH (rho3 2.7)
    home: bool = False  # reference run by the drive: a rising edge starts it, level 0 aborts it


class Latched(NamedTuple):
    """Edges caught by a drive's own touch probe so far: number of each kind, and the position at the last one."""

    rises: int = 0
    rising_inc: int = 0
    falls: int = 0
    falling_inc: int = 0


@runtime_checkable
class Latching(Protocol):
    """Touch-probe status of an actual value; None: this drive has none, or has not sent one yet."""

    @property
    def latched(self) -> Latched | None: ...


class Actual(Protocol):
    """What a drive reported for this SYNC, as far as the core needs it."""

    @property
    def position_inc(self) -> int: ...  # latched at SYNC
    @property
    def reference_switch(self) -> bool: ...


class SetRecord(Protocol):
    """Data for a drive at the next SYNC."""

    @property
    def position_inc(self) -> int: ...


class CyclicDrive(Protocol):
    """One drive in the cycle; `step` once per SYNC, after the actual values of that SYNC.  Never raises on a message of the drive."""

    position_inc: int  # last actual
    fault_code: int
    epoch: int  # +1 whenever increments may have lost their meaning (AX-110)
    events: list[Event]  # of the last step

    @property
    def torque_permille(self) -> int: ...  # last actual
    @property
    def warning(self) -> bool: ...
    @property
    def set_inc(self) -> int: ...  # last sent
    @property
    def power(self) -> Power: ...
    @property
    def follows(self) -> bool: ...  # enabled and taking the demanded position: lag counts
    @property
    def homing(self) -> Homing: ...
    @property
    def configured(self) -> bool: ...  # it needs nothing more before it may be switched on
    def step(self, actual: Actual | None, demand: Demand) -> SetRecord: ...  # a record of another family counts as none
    def idle(self) -> SetRecord: ...  # before the first SYNC


class DriveMaker(Protocol):
    """Settings of one drive of some family."""

    def make(self) -> CyclicDrive: ...


@dataclass(frozen=True, slots=True)
class DriveHoming:
    """The drive references on its own; `position` is the axis reading (m or rad) at its home (AX-306)."""

    position: float = 0.0


class Heard(NamedTuple):
    """A frame that was the actual value of an axis."""

    axis: int  # its index in the cell
    actual: Actual


class BusFamily(Protocol):
    """Protocol of one bus and the axes on it.

    `aside` collects the frames of the bus that are not cyclic data (CANopen: SDO, EMCY, heartbeat); its reader clears it.
    """

    aside: list[Frame]

    @property
    def expected(self) -> int: ...  # axes that answer every SYNC
    @property
    def unconfigured(self) -> int: ...  # axes that are sent nothing yet: their place in the burst is free
    def burst(self, values: Sequence[SetRecord]) -> list[Frame]: ...  # SYNC, set values (by index of the cell), what belongs to the cycle
    def hear(self, frame: Frame) -> Heard | None: ...  # None: handled, not an actual value; DecodeError: not a frame of this bus
    def release(self, node: int, mode: int) -> None: ...  # this node is configured: it may get cyclic data
    def hold(self, node: int) -> None: ...  # no longer configured
    def began(self, now: Ns) -> None: ...  # the cycle's first instant
