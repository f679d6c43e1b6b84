"""The curve of belt type 3: quadratic, linear, quadratic in the belt's position.

Source: rho 3 Releases part 1, TO04 section 16.2-16.5 (L6347-6459).  A and D are belt paths of the first and the third section.
"""

from dataclasses import dataclass

from motion.errors import MotionError

LEAST = 0.01  # of the entire path: shorter sections are widened to it


@dataclass(frozen=True, slots=True)
class Cam:
    """length: belt path > 0; first, third: sections; all in m or rad, with 1 % of length at least and a second section as long."""

    length: float
    first: float
    third: float

    def at(self, belt: float) -> tuple[float, float]:
        """Share of the robot's way (0 .. 1) and its slope (per m or rad) where the belt has run so far into the block."""
        slope = 1.0 / (self.length - 0.5 * (self.first + self.third))
        if belt <= 0.0:
            return 0.0, 0.0
        if belt < self.first:
            return 0.5 * slope * belt * belt / self.first, slope * belt / self.first
        rest = self.length - belt
        if rest <= 0.0:
            return 1.0, 0.0
        if rest < self.third:
            return 1.0 - 0.5 * slope * rest * rest / self.third, slope * rest / self.third
        return slope * (belt - 0.5 * self.first), slope


def cam(length: float, first: float, third: float) -> Cam:
    """Sections as programmed -> curve.  A section below 1 % of the length becomes 1 %; where both leave less than 1 % for the second
    one, it gets 1 % and they share the rest in their proportion."""
    if not 0.0 < length < float("inf") or not (0.0 <= first < float("inf") and 0.0 <= third < float("inf")):
        raise MotionError(f"cam: belt path {length:g}, sections {first:g} and {third:g}: the path must be above 0, the sections not below")
    least = LEAST * length
    first, third = max(first, least), max(third, least)
    room = length - least
    if first + third > room:
        shrink = room / (first + third)
        first, third = first * shrink, third * shrink
        if first < least or third < least:  # the shorter one fell below the minimum: it keeps that, the longer one is shortened
            first, third = (least, room - least) if first < third else (room - least, least)
    return Cam(length, first, third)


def section(value: float, kinematic_factor: float, global_factor: float, p5_ms: float | None = None) -> float:
    """Belt path of a section: A (or D) times the kinematic's and the global factor; mm as programmed, or the unit of `value`.

    p5_ms: interpolation cycle; the programmed value is limited to 2000 / P5^2 (L6459), the factors are not.
    """
    if p5_ms is not None:
        value = min(value, 2000.0 / (p5_ms * p5_ms))
    return value * kinematic_factor * global_factor
