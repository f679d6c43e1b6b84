"""[[belt]] tables as planner and cycle take them.  The motion core is loaded inside: whoever has no belts need not have it."""

from typing import TYPE_CHECKING

from gateway.cell import Cell
from gateway.cell_belts import Belt

if TYPE_CHECKING:
    from motion.sync.facts import BeltFacts


def belt_facts(cell: Cell) -> "tuple[BeltFacts, ...]":
    """All belts of a checked cell, in the order of the file."""
    return tuple(_facts(belt) for belt in cell.belt)


def _facts(belt: Belt) -> "BeltFacts":
    from motion.sync.belts import BeltData, Type
    from motion.sync.facts import BeltFacts
    from motion.sync.parallel import Carrier
    from motion.units import to_si

    thresholds = None
    if belt.v_stop is not None or belt.v_run is not None:
        low = belt.v_stop if belt.v_stop is not None else belt.v_run or 0.0
        thresholds = (low, low if belt.v_run is None else belt.v_run, belt.patience_ms)
    x, y, z = belt.factors
    return BeltFacts(
        belt.name,
        BeltData(to_si(belt.increment, belt.unit), belt.simulated, belt.unit),
        Type(belt.type),
        belt.tolerance,
        Carrier((x, y, z)),
        thresholds,
        to_si(belt.accel, belt.unit),
        to_si(belt.jerk, belt.unit),
    )
