"""Limits of an axis in SI, from its table of the cell."""

from dataclasses import replace

from gateway.pure.cell.cell import Axis
from motion.geometry.limits import AxisLimits, limits_from


def limits_of(axis: Axis) -> AxisLimits:
    """Travel, speed, acceleration, jerk in SI."""
    limits = axis.limits
    rates = {"speed": limits.speed, "accel": limits.accel, "jerk": limits.jerk}
    found = limits_from(axis.name, axis.unit, lower=limits.min, upper=limits.max, **rates, modulo=axis.modulo)
    return replace(found, manual=axis.manual)
