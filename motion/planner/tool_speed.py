"""Way and turning of the tool as columns of paths that are made of axes: PTP, and corners rounded in the axes (AX-583).

A straight line of the axes bends the way of the tool, so a limit of its speed needs the true rates |p'| and |w|, from the Jacobian.  They
are worked out where a block sets such a limit and the axes are fast enough to reach it; elsewhere a path stays as it is.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from math import inf

import numpy as np
from numpy.typing import NDArray

from motion.geometry.frames import Pose, rotate
from motion.kinematics.identity import Identity
from motion.paths.base import add, cross, dot, norm, scale, sub
from motion.paths.joints import DEGREE, JointPath, shifted
from motion.paths.tool_path import FINEST, Rate, divided
from motion.planner.robot import Machine
from motion.planner.untransformed import main_rates
from motion.program.blocks import Block, Interpolation

LOOKS = 32  # at each quintic of a path: whether the tool may reach a limit
NEAR = 0.95  # of the limit; between the looks the tool may be that much faster
STILL = 1e-9
STEP, SHARE = 1e-5, 1e-3  # rad or m of the fastest axis, and share of a quintic: step for the change of a rate

Array = NDArray[np.float64]
Twist = tuple[tuple[float, float, float], tuple[float, float, float]]


def limited(path: JointPath, machine: Machine, source: Block, following: Block | None = None, *, anyhow: bool = False) -> JointPath:
    """The path with the columns that limits of the tool act on.  following: of a corner, the block after it, whose tool counts from the
    middle on; anyhow: its columns are too large, so compute true ones even where no limit is reached.
    """
    blocks = [source] if following is None else [source, following]
    tops = tool_tops(blocks, machine)
    if not any(top < inf for top in tops) or any(block.pace.time is not None for block in blocks):
        return path
    ptp = all(block.kind is Interpolation.PTP for block in blocks)
    if (anyhow and not ptp) or _reached(path, machine, blocks, tops):
        return _measured(path, machine, [block.tool.pose for block in blocks])
    return _bare(path) if ptp else path


def _bare(path: JointPath) -> JointPath:
    table = path.coefficients.copy()
    table[:, :, -2:] = 0.0
    return JointPath(path.knots, table)


def tool_tops(blocks: Sequence[Block], machine: Machine) -> tuple[float, float]:
    """Speed of the tool (m/s) and of its turning (rad/s): the smallest that is asked for."""
    ways = [block.pace.path_speed for block in blocks if block.pace.path_speed is not None]
    turns = [block.pace.turn_speed for block in blocks if block.pace.turn_speed is not None]
    return min(machine.path_speed, *ways, inf), min(machine.turn_speed, *turns, inf)


def tool_pulls(block: Block, machine: Machine) -> tuple[tuple[float, float], float]:
    """Acceleration and deceleration of the tool (m/s2) and acceleration of its turning (rad/s2) along its way: of PTP those of the robot
    alone."""
    own = (block.pace.path_accel, block.pace.path_decel) if block.kind is not Interpolation.PTP else (None, None)
    up, down = (min(machine.path_accel, each or inf) for each in own)
    return (up, down), machine.turn_accel


def _reached(path: JointPath, machine: Machine, blocks: Sequence[Block], tops: tuple[float, float]) -> bool:
    """Whether the tool may come near a limit with the axes at their programmed speed, whatever the factors are."""
    s = np.linspace(0.0, path.length, LOOKS * len(path.coefficients) + 1)
    places, slopes = path.at(s)[:, : path.axes], path.at(s, 1)[:, : path.axes]
    share = max(max(block.pace.speed, 1.0) if block.pace.lead else block.pace.speed for block in blocks)
    with np.errstate(divide="ignore"):
        most = np.min(share * np.array([axis.speed for axis in machine.limits]) / np.abs(slopes), axis=1)
    for q, q1, fastest in zip(places, slopes, most, strict=True):
        for tool in {block.tool.pose for block in blocks}:
            if any(norm(part) * fastest > NEAR * top for part, top in zip(_twist(machine, tool, q, q1), tops, strict=True)):
                return True
    return False


def _twist(machine: Machine, tool: Pose, q: Array, q1: Array) -> Twist:
    """p' and w of the tool where the axes are at q and change by q1; without transformation the rates of the main axes (AX-588)."""
    if isinstance(machine.kinematics, Identity):
        way, turn = main_rates([float(change) for change in q1], machine)
        return (way, 0.0, 0.0), (turn, 0.0, 0.0)
    count = machine.kinematics.axes
    at = [float(value) for value in q]
    x, y, z, u, v, w = (float(value) for value in machine.kinematics.jacobian(at[:count]) @ q1[:count])
    if not any(tool.position):
        return (x, y, z), (u, v, w)
    return add((x, y, z), cross((u, v, w), rotate(machine.forward(at).rotation, tool.position))), (u, v, w)


def tool_rates(machine: Machine, tool: Pose, places: Array, speeds: Array) -> Array:
    """(n, 2) m/s and rad/s of the tool where the axes are at these places (n, axes) and as fast as that."""
    return np.array([[norm(part) for part in _twist(machine, tool, q, v)] for q, v in zip(places, speeds, strict=True)]).reshape(-1, 2)


def _measured(path: JointPath, machine: Machine, tools: Sequence[Pose]) -> JointPath:
    """The same axes with the true way and turning; tools: of all of the path, or of either half."""
    knots, tables = [0.0], []
    made = (float(path.coefficients[0, 0, -2]), float(path.coefficients[0, 0, -1]))
    for start, end, index, tool in _stretches(path, tools):
        rows = path.coefficients[index]
        origin = float(path.knots[index])
        for there, way, turn in divided(_rates(machine, tool, rows[:, :-2], origin, end - start), start, end, made, FINEST * path.length):
            table = shifted(rows, knots[-1] - origin)
            for column, row in ((-2, way), (-1, turn)):
                table[:, column] = 0.0
                table[: len(row), column] = row
            powers = (there - knots[-1]) ** np.arange(DEGREE + 1)
            made = (float(table[:, -2] @ powers), float(table[:, -1] @ powers))
            tables.append(table)
            knots.append(there)
    return JointPath(np.array(knots), np.array(tables))


def _stretches(path: JointPath, tools: Sequence[Pose]) -> Iterator[tuple[float, float, int, Pose]]:
    """(from, to, which quintic, tool): cut where a quintic ends and where the tool changes."""
    middle = 0.5 * path.length
    edges = [float(knot) for knot in path.knots]
    if tools[0] != tools[-1] and middle not in edges:
        edges = sorted([*edges, middle])
    for start, end in pairwise(edges):
        index = int(np.searchsorted(path.knots, start, side="right")) - 1
        yield start, end, index, tools[0] if end <= middle else tools[-1]


def _rates(machine: Machine, tool: Pose, rows: Array, origin: float, span: float) -> Callable[[float], Rate]:
    """By s of the path, along one of its quintics."""
    powers = np.arange(DEGREE + 1)
    slopes = rows[1:] * powers[1:, None]

    def at(u: float) -> tuple[Twist, float]:
        base = u**powers
        q1 = base[:-1] @ slopes
        return _twist(machine, tool, base @ rows, q1), float(np.max(np.abs(q1)))

    def rate(s: float) -> Rate:
        u = s - origin
        parts, fastest = at(u)
        step = min(STEP / max(fastest, STILL), SHARE * span)
        ahead, behind = at(u + step)[0], at(u - step)[0]
        found = []
        for part, a, b in zip(parts, ahead, behind, strict=True):
            size, bend = norm(part), scale(sub(a, b), 0.5 / step)
            found.append((size, dot(part, bend) / size if size > 0.0 else 0.0))
        (way, way_bend), (turn, turn_bend) = found
        return Rate(way, turn, way_bend, turn_bend)

    return rate
