"""Settings of an axis for the core, and the state the core keeps of it.

Apart from the core: code that only describes axes (services, commands) does not load the motion core.
"""

import math
from dataclasses import dataclass, field

from drivers.drives.family import CyclicDrive, DriveHoming, DriveMaker, Power
from drivers.drives.reference_settings import ReferenceSettings
from drivers.drives.referencing import Referencing
from drivers.drives.scaling import Scaling
from drivers.drives.tracking import Tracking


@dataclass(frozen=True, slots=True)
class CoreAxis:
    """One axis as the core needs it; SI units."""

    name: str
    scaling: Scaling
    reference: ReferenceSettings | DriveHoming | None  # None: absolute, always referenced
    window: float  # in position within this distance
    drive: DriveMaker
    lag_warn: float = math.inf
    lag_trip: float = math.inf
    standstill: float = math.inf  # allowed distance of an axis from its standstill position
    zeroed: bool = True  # False: absolute encoder whose zero is not set yet
    modulo: float = 0.0  # an endless axis goes round at it; 0: an axis with ends
    kinematic: int = 1  # number of its robot in the cell
    travel: tuple[float, float] = (-math.inf, math.inf)  # ends, m or rad

    @property
    def absolute(self) -> bool:
        """Needs no reference run."""
        return self.reference is None and self.zeroed


@dataclass(slots=True)
class HeldAxis:
    """One axis as the core holds it from cycle to cycle."""

    plan: CoreAxis
    drive: CyclicDrive
    tracking: Tracking
    scaling: Scaling
    wanted: bool = False  # drives on asked for
    referenced: bool = False
    run: Referencing | None = None  # by the gateway
    led: bool = False  # set position and speed of this cycle come from the run
    by_drive: bool = False  # the drive references autonomously
    set: float = 0.0  # set position sent for the next SYNC
    active_inc: int = 0  # where the drive is asked to be at this SYNC: sent two bursts ago, activated by the last SYNC (AX-144)
    received_inc: int = 0  # sent with the burst before this one: the drive activated it at this SYNC
    sent_inc: int = 0  # sent with this SYNC's burst
    epoch: int = 0  # of the drive's increments; another one voids the reference (AX-110)
    speed: float = 0.0
    quiet: int = 0  # cycles inside the window
    power: Power = Power.OFF  # of the drive, after its step of this cycle
    gap: bool = False  # no actual value in the cycle before
    power_number: int = 0  # its value: asking an enum for it costs a microsecond
    limited: bool = field(init=False)  # has a place where it was referenced: travel limits of the drive hold from there
    finding: int = 0  # 647, 648: why the axis was switched off last; until somebody acknowledges it
    behind: float = 0.0  # active_inc minus the drive's actual position, in m or rad

    def __post_init__(self) -> None:
        self.limited = self.plan.reference is not None and not self.plan.modulo

    @property
    def actual(self) -> float:
        """Position reported by the drive, m or rad."""
        return (self.drive.position_inc - self.scaling.zero_inc) / self.scaling.inc_per_unit
