"""Increments and SI of an axis of the cell, and the distance that counts as in position."""

from drivers.drives.scaling import Scaling
from gateway.pure.cell.cell import Axis
from motion.geometry.units import to_si

WINDOW_TURNS = 0.01  # in position: inside a hundredth of a motor turn


def scaling_of(axis: Axis) -> Scaling:
    """Increments and SI of one axis; its zero is found by referencing."""
    mechanics = axis.mechanics
    return Scaling(
        axis.drive.inc_per_turn, mechanics.ratio, to_si(mechanics.feed_per_turn, axis.unit), -1 if mechanics.direction == "-" else 1
    )


def window_of(axis: Axis) -> float:
    """In position within this distance; m or rad."""
    return float(WINDOW_TURNS * axis.drive.inc_per_turn / abs(scaling_of(axis).inc_per_unit))
