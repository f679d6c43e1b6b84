"""Teams of kinematics that tests share, and what their set values are judged by."""

import functools
import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gateway.files.robots import load_robot
from hil_tests.lab.cells.arms import differences, portal
from motion.kinematics.portal import Portal
from motion.planner.robot import Machine
from motion.planner.team import Team, called, team_of
from motion.program.blocks import Block
from motion.program.team import Shared
from motion.robot import Installation

Array = NDArray[np.float64]
SCARA_START = (0.2, 1.2, -0.1, 0.0)
ARM_START = tuple(math.radians(v) for v in (0, 30, 90, 0, 60, 0))


@functools.cache
def pair() -> Team:
    """A six-axis arm and a SCARA."""
    return team_of(Installation((called("arm", load_robot("tx60-like")), called("scara", load_robot("sr60-like")))))


def portals(count: int, axes: str = "xyz") -> Team:
    """Equal portals."""
    names = tuple(f"P{n}" for n in range(1, count + 1))
    rows = [tuple(replace(axis, name=f"{name}.{axis.name}") for axis in portal(axes).limits) for name in names]
    return Team(names, tuple(Machine(Portal(axes, limits), limits) for limits in rows))


def together(*moves: Block | None) -> Shared:
    return Shared(moves)


def own_rows(team: Team, rows: Array) -> list[Array]:
    """Set values of each kinematic."""
    return [rows[:, a:b] for a, b in zip(team.firsts, team.firsts[1:], strict=False)]


def shares(team: Team, rows: Array, period_s: float = 1e-3) -> tuple[float, float, float]:
    """Largest speed, acceleration, jerk of all axes as shares of their limits."""
    found = []
    for order, name in ((1, "speed"), (2, "accel"), (3, "jerk")):
        limits = np.array([getattr(axis, name) for axis in team.limits])
        found.append(float(np.max(np.abs(differences(rows, period_s, order)) / limits)))
    return found[0], found[1], found[2]
