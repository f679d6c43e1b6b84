"""Robots and programs that motion tests share: a portal, the shipped SCARA and six-axis arm, running in virtual time."""

import functools
import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from gateway.files.robots import load_robot
from motion.geometry.frames import NO_ROTATION, Pose
from motion.geometry.limits import limits_from
from motion.kinematics.portal import Portal
from motion.planner.arm import Arm
from motion.planner.robot import Machine, machine_of
from motion.program.blocks import PoseTarget

Array = NDArray[np.float64]


@functools.cache
def robot(name: str) -> Machine:
    """A shipped robot."""
    return machine_of(load_robot(name))


def portal(axes: str = "xyz", speed: float = 2000.0, accel: float = 20_000.0, jerk: float = 1e6) -> Machine:
    """mm, mm/s .. of every axis; travel +-2 m."""
    limits = tuple(limits_from(letter, "mm", lower=-2000, upper=2000, speed=speed, accel=accel, jerk=jerk) for letter in axes)
    return Machine(Portal(axes, limits), limits)


def at(x: float, y: float = 0.0, z: float = 0.0) -> PoseTarget:
    """mm, no rotation."""
    return PoseTarget(Pose((x * 1e-3, y * 1e-3, z * 1e-3), NO_ROTATION))


def run(arm: Arm, until: Callable[[], bool] | None = None, limit_s: float = 60.0) -> Array:
    """Steps until `until` (default: all blocks are done and the arm rests); (n, axes) set values, the first where it stood."""
    rows = [arm.joints]
    done = until or (lambda: arm.place().waiting == 0 and arm.resting)
    for _ in range(math.ceil(limit_s / arm.period_s)):
        rows.append(arm.step())
        if done():
            return np.array(rows)
    raise AssertionError(f"not done after {limit_s} s: {arm.place()}")


def tool_path(machine: Machine, rows: Array, tool: Pose | None = None) -> Array:
    """(n, 3) m of the tool centre point."""
    places = []
    for row in rows:
        flange = machine.forward([float(v) for v in row])
        places.append((flange @ tool if tool is not None else flange).position)
    return np.array(places)


def tool_speed(places: Array, period_s: float) -> Array:
    """(n - 1,) m/s between samples."""
    return np.asarray(np.linalg.norm(np.diff(places, axis=0), axis=1) / period_s)


def differences(rows: Array, period_s: float, order: int) -> Array:
    """Of set values by time, at rest before and after."""
    padded = np.concatenate([np.repeat(rows[:1], 3, axis=0), rows, np.repeat(rows[-1:], 3, axis=0)])
    return np.asarray(np.diff(padded, order, axis=0) / period_s**order)


def shares(machine: Machine, rows: Array, period_s: float) -> tuple[float, float, float]:
    """Largest speed, acceleration, jerk as shares of the limits of their axes."""
    found = []
    for order, name in ((1, "speed"), (2, "accel"), (3, "jerk")):
        limits = np.array([getattr(axis, name) for axis in machine.limits])
        found.append(float(np.max(np.abs(differences(rows, period_s, order)) / limits)))
    return found[0], found[1], found[2]


def off_line(places: Array, start: Sequence[float], end: Sequence[float]) -> float:
    """Largest distance of places from the straight line, m."""
    a, b = np.array(start), np.array(end)
    u = (b - a) / np.linalg.norm(b - a)
    away = places - a - np.outer((places - a) @ u, u)
    return float(np.max(np.linalg.norm(away, axis=1)))
