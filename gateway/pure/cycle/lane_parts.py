"""What the core of a cycle has for its lanes.  Pure."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gateway.pure.cycle.alter import CoreAlter
from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.cycle.belts import CoreBelts
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import CellState
from motion.timing.foresight import Foresight

if TYPE_CHECKING:
    from gateway.pure.cycle.path_outputs import CoreOutputs


@dataclass(frozen=True, slots=True)
class LaneParts:
    """`off` switches drives off."""

    axes: list[HeldAxis]
    state: CellState
    outputs: bytearray
    period_s: float
    override_step: float
    foresight: type[Foresight]
    belts: CoreBelts | None
    alter: CoreAlter | None
    functions: "CoreOutputs | None"
    off: Callable[[Reason], None]
