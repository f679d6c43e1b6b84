"""What planner and cycle must know of a belt, and what they exchange about a synchronous part.  Frozen data, SI units."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import nan

from motion.geometry.frames import IDENTITY, Pose
from motion.sync.belts import STANDARD_TOLERANCE, BeltData, Belts, Type
from motion.sync.parallel import Carrier


@dataclass(frozen=True, slots=True)
class BeltFacts:
    """One belt.  carriers: how it carries each kinematic of the cell (by its number, from 1) that follows it; thresholds: SF 15 as (v_stop,
    v_run in unit/s, ms), None: those of the start-up; accel, jerk: of catching up."""

    name: str
    data: BeltData
    kind: Type = Type.PARALLEL
    tolerance: int = STANDARD_TOLERANCE
    carriers: Mapping[int, Carrier] = field(default_factory=lambda: {1: Carrier()})
    thresholds: tuple[float, float, int] | None = None
    accel: float = 2.0
    jerk: float = 20.0


@dataclass(frozen=True, slots=True)
class SynchronOrder:
    """SYNCHRON of one part.  belt: place among the belts, from 0; at: belt value it begins at, NaN: at once; reference: belt value at
    which the path is planned, NaN: the one it begins at; block: number of its first block; tool: of types 2 and 3; kinematic: of the
    cell, from 1.  Kind and tolerance are those the belt has from here on (SF 21)."""

    belt: int
    kind: Type
    at: float = nan
    reference: float = nan
    block: int = 1
    tool: Pose = IDENTITY
    tolerance: int = STANDARD_TOLERANCE
    kinematic: int = 1


def make_belts(facts: tuple[BeltFacts, ...], period_s: float) -> Belts:
    """Counters of all of them, as their cell has set them; a period is an interpolation cycle."""
    belts = Belts([each.data for each in facts], period_s, period_s)
    for number, each in enumerate(facts, 1):
        belts.all[number - 1].kind, belts.all[number - 1].tolerance = each.kind, each.tolerance
        if each.thresholds is not None:
            belts.belt_parameters(number, *each.thresholds)
    return belts
