"""R and R_PTP of the rho 3: presets, modal values, values of one block, and the resulting range around a target.

Source: rho 3 Releases part 1, section 6 (L1842-1908): R absolute in the unit of the measuring system (here m), R_PTP a factor
0.01 .. 100 on P213; P212 presets both at program start; P214 = 0 axis distances, 1 one spatial distance per kinematic (D-21).
"""

from dataclasses import dataclass
from enum import Enum

from motion.errors import MotionError
from motion.program.blocks import Interpolation

FACTOR_RANGE = (0.01, 100.0)


class Criterion(Enum):
    """P214."""

    AXES = 0
    SPACE = 1


@dataclass(frozen=True, slots=True)
class Presets:
    """P212, P213, P214 of one kinematic.  radius, space: lengths; axes: a way of each axis; a range is in the same units."""

    radius: float = 0.0  # P212 in world coordinates; 0 (off) is what the manual recommends
    factor: float = 0.0  # P212 in joint coordinates
    axes: tuple[float, ...] = ()  # P213 with P214 = 0
    space: float = 0.0  # P213 with P214 = 1
    criterion: Criterion = Criterion.AXES

    def __post_init__(self) -> None:
        _radius("P212", self.radius)
        _factor("P212", self.factor)
        for value in (*self.axes, self.space):
            _radius("P213", value)


@dataclass(frozen=True, slots=True)
class Range:
    """Where passing of a point may begin and must have ended; all 0: the path goes exactly through the point."""

    radius: float = 0.0  # m, sphere of the TCP path (LINEAR), or of PTP by the spatial criterion
    axes: tuple[float, ...] = ()  # m or rad per axis (PTP by the axis criterion)

    @property
    def off(self) -> bool:
        """R = 0 or R_PTP = 0 (L1882)."""
        return self.radius == 0.0 and not any(self.axes)


class Passing:
    """The standard variables R and R_PTP of one kinematic while a program runs."""

    def __init__(self, presets: Presets) -> None:
        self._presets = presets
        self._radius, self._factor = presets.radius, presets.factor

    def set_radius(self, radius: float) -> None:
        """R = x; acts beyond the block, until written over."""
        self._radius = _radius("R", radius)

    def set_factor(self, factor: float) -> None:
        """R_PTP = x (1.4 or 140 %)."""
        self._factor = _factor("R_PTP", factor)

    def block(self, kind: Interpolation, *, radius: float | None = None, factor: float | None = None) -> Range:
        """Range of one block; radius, factor: WITH R = x, WITH R_PTP = x, which act on this block alone."""
        if kind is Interpolation.CIRCULAR:
            return Range()  # never passed (L1906)
        if kind is not Interpolation.PTP:
            return Range(self._radius if radius is None else _radius("R", radius))
        acting = self._factor if factor is None else _factor("R_PTP", factor)
        if self._presets.criterion is Criterion.SPACE:
            return Range(self._presets.space * acting)
        return Range(0.0, tuple(distance * acting for distance in self._presets.axes))


def passed(before: Interpolation, after: Interpolation, *, block_slope: bool) -> bool:
    """Whether the point between two blocks may be passed: never next to a circle (L1906-1908), and with block slope not where
    the interpolation changes (L1838-1840)."""
    if Interpolation.CIRCULAR in (before, after):
        return False
    return not block_slope or before is after


def _radius(name: str, value: float) -> float:
    if not 0.0 <= value < float("inf"):
        raise MotionError(f"{name} {value:.6g} is not a distance >= 0")
    return value


def _factor(name: str, value: float) -> float:
    low, high = FACTOR_RANGE
    if value != 0.0 and not low <= value <= high:
        raise MotionError(f"{name} {value:.6g} is outside {low} .. {high:g} (0: off)")
    return value
