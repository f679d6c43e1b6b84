"""What set values really do: finite differences of the samples, at rest before the first and after the last.

Second and third differences are means of acceleration and jerk over two and three periods: they can hide a peak inside a
period, never invent one, and they see every step between periods.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from motion.execution.pieces import Piece
from motion.execution.stepper import Sample, State, Stepper
from motion.geometry.limits import AxisLimits


class Worst(NamedTuple):
    """Largest value as share of the limit, over all axes."""

    speed: float
    accel: float
    jerk: float


def axes_limits(count: int = 6, speed: float = 2.0, accel: float = 10.0, jerk: float = 100.0, reach: float = 10.0) -> list[AxisLimits]:
    """Axes A1.. that differ a little, so that no symmetry hides a mistake."""
    return [
        AxisLimits(f"A{n + 1}", -reach, reach, speed * (1 + 0.2 * n), accel * (1 + 0.1 * n), jerk * (1 + 0.3 * n)) for n in range(count)
    ]


def differences(values: Sequence[float], times: int) -> list[float]:
    for _ in range(times):
        values = [b - a for a, b in pairwise(values)]
    return list(values)


def worst(samples: Sequence[Sequence[float]], limits: Sequence[AxisLimits], period_s: float) -> Worst:
    """samples: (n,) of (axes,) set positions, the first one where the axes stood."""
    padded = [samples[0]] * 3 + list(samples) + [samples[-1]] * 3
    shares = [
        [max(map(abs, differences([q[n] for q in padded], order))) / period_s**order / limit for order, limit in orders]
        for n, axis in enumerate(limits)
        for orders in [((1, axis.speed), (2, axis.accel), (3, axis.jerk))]
    ]
    return Worst(*(max(row[k] for row in shares) for k in range(3)))


def off_line(q: Sequence[float], start: Sequence[float], target: Sequence[float]) -> float:
    """Largest distance of one axis from the straight joint line, at the share of the way the longest axis has made."""
    ways = [b - a for a, b in zip(start, target, strict=True)]
    longest = max(range(len(ways)), key=lambda n: abs(ways[n]))
    share = (q[longest] - start[longest]) / ways[longest]
    return max(abs(q[n] - (start[n] + share * ways[n])) for n in range(len(ways)))


def run_out(stepper: Stepper, limit: int = 20_000) -> list[Sample]:
    """Steps until IDLE; the last sample is the first idle one."""
    samples = [stepper.step()]
    while samples[-1].state is not State.IDLE:
        assert len(samples) < limit, f"never idle: {samples[-1]}"
        samples.append(stepper.step())
    return samples


def loaded(piece: Piece, axes: int, period_s: float = 0.004) -> Stepper:
    stepper = Stepper(axes, period_s)
    stepper.place_for(piece)
    stepper.load(piece)
    return stepper
