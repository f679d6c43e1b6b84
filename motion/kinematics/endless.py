"""Endless axes and the two kinds of axes that carry a path: P303, P311.  Source: rho 3 Releases part 1, TO04 section 11, L5598-5644.

P303: 0 main axis, 1 manual (hand) axis, 3 endless main axis, 4 endless manual axis; 2 has no meaning.  P311: modulo value.
Without transformation (P306 RTYP = 0) the path speed V is that of the main axes alone; the manual axes go along in the same
time.  Before TO04 all endless axes counted as main axes and took part in the path, so the master changed its speed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from motion.errors import MotionError

TINY = 1e-12  # of the modulo: a position this near below it has gone round


class AxisType(IntEnum):
    """P303."""

    MAIN = 0
    MANUAL = 1
    ENDLESS_MAIN = 3
    ENDLESS_MANUAL = 4

    @property
    def endless(self) -> bool:
        """Goes round."""
        return self >= AxisType.ENDLESS_MAIN

    @property
    def main(self) -> bool:
        """Makes the path and its speed."""
        return self in (AxisType.MAIN, AxisType.ENDLESS_MAIN)


def axis_type(p303: int) -> AxisType:
    """The value of P303; MotionError for 2 and everything unknown."""
    try:
        return AxisType(p303)
    except ValueError:
        raise MotionError(f"P303 = {p303}: 0 main, 1 manual, 3 endless main, 4 endless manual axis") from None


def within(position: float, modulo: float) -> float:
    """Position in 0 <= position < modulo."""
    rest = math.fmod(position, modulo)
    if rest < 0.0:
        rest += modulo
    return 0.0 if rest >= modulo * (1.0 - TINY) else rest


@dataclass(frozen=True, slots=True)
class Span:
    """One block: travel of each axis, the main axes' path length, its duration and each axis' speed; units of the axes and s."""

    travel: tuple[float, ...]
    length: float
    duration: float
    speeds: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class EndlessAxes:
    """The axes of one kinematic without transformation; modulo: P311 of each axis (any number where the axis is not endless)."""

    types: tuple[AxisType, ...]
    modulo: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.types) != len(self.modulo):
            raise MotionError(f"{len(self.types)} values of P303, {len(self.modulo)} of P311")
        for number, (kind, modulo) in enumerate(zip(self.types, self.modulo, strict=True), 1):
            if kind.endless and not 0.0 < modulo < math.inf:
                raise MotionError(f"axis {number}: P311 = {modulo:g}, an endless axis needs a modulo above 0")
        if AxisType.ENDLESS_MANUAL in self.types and not self.types[0].main:
            raise MotionError("axis 1 must be the master: P303 = 0 or 3 before axes with P303 = 4 (L5614)")

    def position(self, position: Sequence[float]) -> tuple[float, ...]:
        """Endless axes brought back into 0 .. modulo, as after each block."""
        return tuple(
            within(value, modulo) if kind.endless else value for value, kind, modulo in zip(position, self.types, self.modulo, strict=True)
        )

    def span(self, start: Sequence[float], target: Sequence[float], v: float) -> Span:
        """The block from `start` to the programmed `target` at path speed v (units of the axes per s).

        An endless axis starts from its position within the modulo and travels the programmed difference, which may be a full turn or more
        (AX-354).
        """
        if not v > 0.0 or not all(map(math.isfinite, target)):
            raise MotionError(f"speed {v:g} and target {tuple(target)}: a speed above 0 and finite numbers are needed")
        travel = tuple(there - here for there, here in zip(target, self.position(start), strict=True))
        mains = [way for way, kind in zip(travel, self.types, strict=True) if kind.main]
        length = math.hypot(*mains) or math.hypot(*travel)  # manual axes alone: the speed is theirs
        duration = length / v
        return Span(travel, length, duration, tuple(way / duration if duration else 0.0 for way in travel))
