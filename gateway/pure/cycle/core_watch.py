"""What the cycle logic watches from cycle to cycle: the enabling inputs, the services, and its drives.  Pure."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from drivers.drives.family import Actual, SetRecord
from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.cycle.enabling_inputs import EnablingInputs
from protocols.base.machine import Ns, ms

SERVICES_LIMIT = ms(250)  # life counter of services older than this: dead
DriveAxes = Callable[[list[HeldAxis], Sequence[Actual | None], Sequence[float], Sequence[float], bool], tuple[list[SetRecord], bool, bool]]
WatchAxes = Callable[[list[HeldAxis], Sequence[Actual | None], int], int]


@dataclass(slots=True)
class Permissions:
    """`permits`: those of the last cycle, as plain numbers."""

    inputs: EnablingInputs
    permits: int = 0
    chain_seen: bool = False  # before it was seen closed once there is nothing to latch
    lost_cycles: int = 0  # since chain or control was lost

    def changed(self, permits: int) -> bool:
        before, self.permits = self.permits, permits
        return permits != before


@dataclass(slots=True)
class ServicesWatch:
    """`finish`: a path continues to its end without them."""

    finish: bool
    alive: bool = False

    def heard(self, services_ns: Ns, now: Ns) -> bool:
        """Whether they live, by the stamp of their last beat."""
        return services_ns != 0 and now - services_ns < SERVICES_LIMIT

    def lost(self) -> bool:
        """They are silent; True where that was not noticed before."""
        before, self.alive = self.alive, False
        return before


@dataclass(slots=True)
class DriveWatch:
    """The loops over the axes, in Python or in C, and what they found in this cycle."""

    drive: DriveAxes
    watch: WatchAxes
    settled: bool = False  # every drive follows, and none lost its increments
    eventful: bool = False  # a drive acted spontaneously
