"""Jog keys of the page in a cell with the speeds of its rho 3: P113 and P114, slopes by P128 or P104 (AX-1720)."""

from dataclasses import dataclass, field
from itertools import zip_longest

from gateway.assembly.limits import limits_of
from gateway.pure.cell.cell import Cell
from motion.errors import MotionError
from motion.geometry.limits import AxisLimits
from motion.geometry.units import from_si, to_si
from motion.program.jog import JogKeys, JogSpeeds, SlopeParameters, manual_speed

ROUNDED = 1e-9  # of a limit: two ways to the same number in SI


@dataclass(slots=True)
class Jog:
    """limits: of each axis; shares are of the highest speed and acceleration of an axis.  Times in s of the caller's clock."""

    limits: tuple[AxisLimits, ...]
    speeds: JogSpeeds
    slopes: tuple[SlopeParameters, ...]
    keys: JogKeys = field(init=False)

    def __post_init__(self) -> None:
        self.keys = JogKeys(self.speeds)

    def share(self, axis: int, now_s: float) -> float:
        """Speed of an axis whose key is held: slow, or fast since 1.5 s."""
        return abs(manual_speed(self.keys.wanted(now_s), self.speeds)[axis]) / self.limits[axis].speed

    def most(self, axis: int) -> float:
        """Its fast speed."""
        return self.speeds.joint_fast[axis] / self.limits[axis].speed

    def acceleration(self, axis: int) -> float:
        """P128, or P104 where it is not set; never above the limit of the axis."""
        return min(self.slopes[axis].jogging()[0] / self.limits[axis].accel, 1.0)


def jog_of(cell: Cell) -> Jog | None:
    """None: the cell has no P113.  MotionError names the parameter."""
    if cell.rho3 is None or "P113" not in cell.rho3.others or not cell.axis:
        return None
    limits = tuple(limits_of(axis) for axis in cell.axis)
    slow, fast = _row(cell, "P113"), _row(cell, "P114")
    ramps = _row(cell, "P128") if "P128" in cell.rho3.others else ()
    speeds = JogSpeeds(joint_slow=slow, joint_fast=fast)
    for axis, speed in zip(limits, fast, strict=True):
        if speed > axis.speed * (1.0 + ROUNDED):
            most = f"{from_si(axis.speed, axis.unit):.6g} {axis.unit}/s"
            raise MotionError(f"P114 of axis {axis.name}: {from_si(speed, axis.unit):.6g} is above its speed limit, {most}")
    if any(ramp <= 0.0 for ramp in ramps):
        raise MotionError("P128: a slope acceleration must be > 0")
    slopes = [SlopeParameters(axis.accel, p128=ramp) for axis, ramp in zip_longest(limits, ramps)]
    return Jog(limits, speeds, tuple(slopes))


def _row(cell: Cell, name: str) -> tuple[float, ...]:
    """Values of each axis, in SI."""
    given = cell.rho3.others.get(name, ()) if cell.rho3 else ()
    values = given if isinstance(given, list | tuple) else (given,)
    numbers = [float(value) for value in values if isinstance(value, int | float) and not isinstance(value, bool)]
    if len(numbers) != len(values) or len(numbers) != len(cell.axis):
        raise MotionError(f"{name}: {len(cell.axis)} axes need {len(cell.axis)} numbers")
    return tuple(to_si(number, axis.unit) for number, axis in zip(numbers, cell.axis, strict=True))
