"""Turn count of an axis from its motor's resolver: referencing modes 1 and 3.

Source: rho 3 Releases part 3, 6.3.1 (L3814-3824): one resolver turn is divided into n = 1 / (decimals of the gear factor) segments, the
zero in the middle of a segment; GF 4.1: n = 10, segments of 36 degrees, -18..+18 each, 8.78 degrees at the axis.  Each segment
is one turn of the axis.  Gear factors whose decimals are m/n, and integer ones: AX-264.
"""

from fractions import Fraction
from typing import NamedTuple

MOST_SEGMENTS = 60  # a cam cannot be set within less than 6 degrees at the resolver


class Orientation(NamedTuple):
    """Resolver reading at the edge of the reference cam."""

    segments: int  # n
    turns: int  # of the axis away from its original turn, signed in the direction of rising increments
    deviation_inc: float  # of the edge from the middle of its segment
    zero_inc: float  # the axis' zero


def segments(gear: float) -> tuple[int, int]:
    """(n, m): the decimals of the gear factor as m/n; (1, 0) for an integer one."""
    decimals = Fraction(gear).limit_denominator(MOST_SEGMENTS) % 1
    return decimals.denominator, decimals.numerator


def segment_deg(gear: float) -> tuple[float, float]:
    """Width of a segment in degrees at the resolver and at the axis."""
    width = 360.0 / segments(gear)[0]
    return width, width / gear


def orientation(position_inc: float, inc_per_turn: int, gear: float) -> Orientation:
    """Position at the edge -> where the axis' own zero lies; the way back is at most half the n turns."""
    count, step = segments(gear)
    width = inc_per_turn / count
    inside = position_inc % inc_per_turn
    segment = round(inside / width)  # its middle is a multiple of the width
    deviation = inside - segment * width
    turns = segment * pow(step, -1, count) % count if count > 1 else 0
    turns = turns - count if 2 * turns > count else turns
    return Orientation(count, turns, deviation, position_inc - deviation - turns * gear * inc_per_turn)
