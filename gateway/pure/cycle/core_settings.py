"""Settings of the core of a cycle in addition to its axes.  Pure."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gateway.pure.cycle.alter import CoreAlter
from gateway.pure.cycle.belts import CoreBelts
from gateway.pure.cycle.enabling_inputs import AS_SHIPPED, NO_PERMIT, RcNumbers
from gateway.pure.image.records.cell import Permit

if TYPE_CHECKING:
    from gateway.pure.cycle.path_outputs import CoreOutputs
    from gateway.pure.cycle.shared_output import CoreShared


@dataclass(frozen=True, slots=True)
class CoreRules:
    """What a cell states of its control: RC numbers, permits that are assumed, a path that ends without services, step of the override
    in a cycle."""

    numbers: RcNumbers = AS_SHIPPED
    assumed: Permit = NO_PERMIT
    finish_without_services: bool = False
    override_step: float = 1.0


@dataclass(frozen=True, slots=True)
class CoreParts:
    """What only some cells have."""

    belts: CoreBelts | None = None
    functions: "CoreOutputs | None" = None
    alter: CoreAlter | None = None
    shared: "CoreShared | None" = None


AS_SHIPPED_RULES, NO_PARTS = CoreRules(), CoreParts()
