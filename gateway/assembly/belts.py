"""[[belt]] tables in the form planner and cycle read.  The motion core is imported inside: cells without belts do not load it."""

from typing import TYPE_CHECKING

from gateway.assembly.programs import kinematic_by_axis, numbers_of
from gateway.pure.cell.belts import Belt
from gateway.pure.cell.cell import Cell

if TYPE_CHECKING:
    from motion.sync.facts import BeltFacts


def belt_facts(cell: Cell) -> "tuple[BeltFacts, ...]":
    """All belts of a checked cell, in the order of the file."""
    return tuple(_facts(cell, belt) for belt in cell.belt)


def _facts(cell: Cell, belt: Belt) -> "BeltFacts":
    from motion.geometry.units import to_si
    from motion.sync.belts import BeltData, Type
    from motion.sync.facts import BeltFacts
    from motion.sync.parallel import Carrier

    thresholds = None
    if belt.v_stop is not None or belt.v_run is not None:
        low = belt.v_stop if belt.v_stop is not None else belt.v_run or 0.0
        thresholds = (low, low if belt.v_run is None else belt.v_run, belt.patience_ms)
    names = [robot.name for robot in cell.robot] or [""]
    factors = {n: belt.factors_of.get(names[n - 1], belt.factors) for n in numbers_of(cell, belt.robot)}
    carriers = {n: Carrier((x, y, z)) for n, (x, y, z) in factors.items()}
    by_axis = kinematic_by_axis(cell) if belt.axis else []
    for n, axis in enumerate(cell.axis):
        if axis.name == belt.axis:
            factor = belt.factor * to_si(1.0, axis.unit) / to_si(1.0, belt.unit)
            carriers = dict.fromkeys(factors, Carrier((factor, 0.0, 0.0), joint=n - by_axis.index(by_axis[n])))
    return BeltFacts(
        belt.name,
        BeltData(to_si(belt.increment, belt.unit), belt.simulated, belt.unit),
        Type(belt.type),
        belt.tolerance,
        carriers,
        thresholds,
        to_si(belt.accel, belt.unit),
        to_si(belt.jerk, belt.unit),
    )
