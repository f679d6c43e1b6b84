"""Lines beside the wrist pole: run wherever the joints can follow them without a jump, both ways, told where they cannot; judged by
OPW, which knows nothing of ours."""

import math
import os

import numpy as np
import pytest

from hil_tests.lab.cells.motion_paths import worst_shares
from hil_tests.lab.judges.pole_lines import PoleLine, machine, matrix, pole_lines, pose_on, truth
from motion.geometry.frames import Pose
from motion.planner.route import Route
from motion.planner.runs import runs
from motion.planner.stretch import Stretch
from motion.planner.trace import trace
from motion.program.blocks import Block, Interpolation, Pace, PoseTarget
from motion.program.errors import BlockError
from motion.timing.jerk import estimate

LINES = int(os.environ.get("AXISGATE_POLE_LINES", "30"))  # 10,000 in `make soak`
TIMED = 5  # of so many lines one is run, too: its law takes longer than its path
SPEED = 0.3  # m/s
LOOKS = 200  # along a line
LONGEST = 1.5  # times the seconds of the estimate, which knows nothing of the jerk beside a pole: as a whole law they were 50 and more
TRUE = 1e-6  # m or rad between tool and line, and rad between the ends of the joints


def block(to: Pose) -> Block:
    return Block(Interpolation.LINEAR, PoseTarget(to), pace=Pace(path_speed=SPEED))


def routed(line: PoleLine, to: Pose, start: tuple[float, ...]) -> list[Stretch] | BlockError:
    route = Route(machine(line.arm), start)
    try:
        route.add(block(to))
        route.finish()
    except BlockError as error:
        return error
    return route.take()


def beside(line: PoleLine, q: np.ndarray) -> float:
    """m or rad by which the tool leaves the line, at most."""
    robot, a, b = machine(line.arm), np.array(line.a.position), np.array(line.b.position)
    worst = 0.0
    for row in q:
        pose = robot.forward(tuple(row))
        share = float((np.array(pose.position) - a) @ (b - a) / ((b - a) @ (b - a)))
        worst = max(worst, float(np.abs(matrix(pose) - matrix(pose_on(line, min(max(share, 0.0), 1.0)))).max()))
    return worst


def wrong(line: PoleLine, *, timed: bool) -> str:
    """What is wrong with it; empty: nothing.  timed: its speeds are looked at as well."""
    known, robot = truth(line), machine(line.arm)
    if known.possible is None:
        return ""
    found = routed(line, line.b, line.start)
    if isinstance(found, BlockError):
        return f"refused: {found}" if known.possible else ""
    if not known.possible:
        return "accepted, though its joints would jump or leave their travel"
    end = found[-1].path.q(found[-1].path.length)
    if max(abs(x - y) for x, y in zip(end, known.end, strict=True)) > TRUE:
        return f"ends at {end}, not at {known.end}"
    path = found[-1].path
    if beside(line, path.at(np.linspace(0.0, path.length, LOOKS))[:, :6]) > TRUE:
        return "the tool leaves the line"
    if timed:
        made = trace(found, robot)
        speed, accel, jerk = worst_shares(made.q, robot.limits)
        if made.t[-1] > LONGEST * (least := sum(estimate(run.path, run.limits) for run in runs(found, robot))):
            return f"takes {made.t[-1]:.3f} s, about {least:.3f} s are needed"
        if speed > 1.001 or accel > 1.02 or jerk > 1.05:
            return f"axes at {speed:.3f}, {accel:.3f}, {jerk:.3f} of their limits"
    back = routed(line, line.a, tuple(end))
    if isinstance(back, BlockError):
        return f"the way back is refused: {back}"
    home = back[-1].path.q(back[-1].path.length)
    if max(abs(x - y) for x, y in zip(home, line.start, strict=True)) > TRUE:
        return f"the way back ends at {home}, not at {line.start}"
    return ""


@pytest.mark.timeout(60 + 20 * LINES)  # a hang, not a slow machine: 5 s here, 220 s on two cores that others use
def test_every_line_beside_the_wrist_pole_is_run_where_its_joints_can_follow_it_and_reported_where_not() -> None:
    faults = []
    for n, line in enumerate(pole_lines(18, LINES)):
        if what := wrong(line, timed=n % TIMED == 0):
            faults.append(f"{n} {line.arm}, {line.miss:.3g} m beside: {what}")
    assert not faults, f"{len(faults)} of {LINES}: " + "; ".join(faults[:10])


def in_plane(bend: float) -> PoleLine:
    """A line in the plane of an upright arm, across its wrist pole; bend: of the wrist in the middle (rad)."""
    robot = machine("straight")
    pole = robot.forward((0.0, 0.2, 1.6, 0.0, bend, 0.0))
    x, y, z = pole.position
    a, b = (Pose((x + k * 0.02, y, z + k * 0.08), pole.rotation) for k in (-1, 1))
    start = robot.inverse(a, (0.0, 0.2, 1.6, 0.0, 0.5, 0.0))
    return PoleLine("straight", start if abs(start[3]) < 1.0 else robot.inverse(a, (0.0, 0.2, 1.6, 0.0, -0.5, 0.0)), a, b, 0.0)


def test_a_line_exactly_through_the_pole_goes_straight_on_and_one_from_or_into_it_as_well() -> None:
    line = in_plane(0.0)
    whole = routed(line, line.b, line.start)
    assert not isinstance(whole, BlockError), whole
    q = whole[0].path.at(np.linspace(0.0, whole[0].path.length, 400))[:, :6]
    assert np.abs(q[:, 3] - q[0, 3]).max() < 1e-6 and q[0, 4] * q[-1, 4] < 0.0, "axis 4 stays, and the wrist bends the other way"
    assert beside(line, q) < TRUE
    middle = pose_on(line, 0.5)
    into = routed(line, middle, line.start)
    assert not isinstance(into, BlockError), into
    stands = into[0].path.q(into[0].path.length)
    assert abs(math.sin(stands[4])) < 1e-7
    for to in (line.a, line.b):
        on = routed(line, to, stands)
        assert not isinstance(on, BlockError), on
        assert beside(line, on[0].path.at(np.linspace(0.0, on[0].path.length, 200))[:, :6]) < TRUE
    turned = (*stands[:3], stands[3] + 0.4, stands[4], stands[5] - 0.4)  # the same pose: axis 4 has to turn before the wrist can bend
    swings = routed(line, line.b, turned)
    assert not isinstance(swings, BlockError), swings
    made = trace(swings, machine("straight"))
    assert max(worst_shares(made.q, machine("straight").limits)) < 1.05 and beside(line, made.q) < TRUE
