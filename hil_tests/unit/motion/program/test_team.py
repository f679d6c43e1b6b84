"""Several kinematics on one clock: shared blocks, alone ones, corners; set values judged axis by axis, tools against geometry, ruckig."""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
import ruckig

from hil_tests.lab.cells.arms import at, off_line, run, tool_path
from hil_tests.lab.cells.teams import ARM_START, SCARA_START, Array, own_rows, pair, portals, shares, together
from motion.errors import MotionError, PieceError
from motion.execution.pieces import record_size
from motion.execution.timed import decode_any, encode_timed
from motion.geometry.frames import Pose
from motion.planner.arm import Arm
from motion.planner.planner import Planner
from motion.planner.team import Team
from motion.planner.team_route import TeamRoute
from motion.program.blocks import Blend, Block, Interpolation, JointTarget, Output, Pace, PoseTarget, Rounding
from motion.program.errors import BlockError
from motion.program.team import Shared

UM = 1e-6
LINEAR, PTP, CIRCULAR = Interpolation.LINEAR, Interpolation.PTP, Interpolation.CIRCULAR
STOP, ROUND = Blend(), Blend(Rounding.CARTESIAN, 0.05, 0.05)


def line(x: float, y: float = 0.0, z: float = 0.0, blend: Blend = STOP) -> Block:
    return Block(LINEAR, at(x, y, z), blend=blend)


def driven(team: Team, *blocks: Shared, start: tuple[float, ...] | None = None) -> Array:
    arm = Arm(team, start or (0.0,) * team.axes)
    for block in blocks:
        arm.add(block)
    arm.finish()
    return run(arm)


def assert_within(team: Team, rows: Array) -> None:
    speed, accel, jerk = shares(team, rows)
    assert speed <= 1.00001
    assert accel <= 1.02
    assert jerk <= 1.05


def beside(pose: Pose, x: float, y: float) -> Pose:
    px, py, pz = pose.position
    return Pose((px + x, py + y, pz), pose.rotation)


@functools.cache
def arm_and_scara() -> tuple[Array, Array, Pose, Pose]:
    """A line of the arm and an arc of the SCARA together, slowed, stopped, taken back, resumed."""
    team = pair()
    one, two = (m.kinematics.forward(q) for m, q in zip(team.machines, (ARM_START, SCARA_START), strict=True))
    arm = Arm(team, (*ARM_START, *SCARA_START))
    arc = Block(CIRCULAR, PoseTarget(beside(two, -0.06, -0.06)), via=PoseTarget(beside(two, -0.06, 0.0)))
    arm.add(together(Block(LINEAR, PoseTarget(beside(one, 0.1, 0.05))), arc))
    arm.finish()
    rows = [arm.joints]
    for override, steps in ((1.0, 60), (0.3, 80), (0.0, 150), (-0.5, 120), (0.0, 100), (1.0, 60)):
        arm.override = override
        rows += [arm.step() for _ in range(steps)]
    whole = np.array([*rows, *run(arm)])
    first, second = own_rows(team, whole)
    return tool_path(team.machines[0], first), tool_path(team.machines[1], second), one, two


def test_each_tool_stays_on_its_own_curve_at_any_override_stop_retrace_and_resume() -> None:
    line_places, arc_places, one, two = arm_and_scara()
    assert off_line(line_places, one.position, beside(one, 0.1, 0.05).position) <= UM
    centre = np.array(beside(two, -0.03, -0.03).position)
    assert np.max(np.abs(np.linalg.norm(arc_places - centre, axis=1) - 0.03 * math.sqrt(2))) <= UM
    assert np.linalg.norm(line_places[-1] - beside(one, 0.1, 0.05).position) <= UM
    assert np.linalg.norm(arc_places[-1] - beside(two, -0.06, -0.06).position) <= UM


def test_one_s_for_all_each_tool_has_made_the_same_share_of_its_way_at_every_moment() -> None:
    line_places, arc_places, one, two = arm_and_scara()
    made = np.linalg.norm(line_places - one.position, axis=1) / math.hypot(0.1, 0.05)
    assert np.min(np.diff(made)) < -1e-4  # it was taken back
    x, y = (arc_places - beside(two, -0.03, -0.03).position)[:, :2].T
    angle = np.unwrap(np.arctan2(y, x))
    assert np.max(np.abs(np.abs(angle - angle[0]) / math.pi - made)) <= 1e-6


def test_32_axes_of_16_kinematics_in_the_time_ruckig_finds_and_inside_every_limit() -> None:
    team = portals(16, "xy")
    slow = team.machines[11]
    limits = (replace(slow.limits[0], speed=0.5, accel=3.0, jerk=60.0), slow.limits[1])
    team = replace(team, machines=(*team.machines[:11], replace(slow, limits=limits), *team.machines[12:]))
    ends = [((-1) ** n * 0.02 * (n + 1), 0.3 - 0.01 * n) for n in range(16)]
    rows = driven(team, together(*(Block(PTP, JointTarget(end)) for end in ends)))
    judge = ruckig.Ruckig(32)
    wanted, found = ruckig.InputParameter(32), ruckig.Trajectory(32)
    wanted.synchronization = ruckig.Synchronization.Phase
    wanted.target_position = [value for end in ends for value in end]
    wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = (
        [getattr(axis, name) for axis in team.limits] for name in ("speed", "accel", "jerk")
    )
    judge.calculate(wanted, found)
    moving = np.flatnonzero(np.any(np.diff(rows, axis=0), axis=1))
    assert (moving[-1] - moving[0] + 1) * 1e-3 == pytest.approx(found.duration, abs=2.5e-3)
    assert rows[-1] == pytest.approx(wanted.target_position, abs=1e-9)
    assert_within(team, rows)
    part = rows[:, [0, 31]] / rows[-1, [0, 31]]
    assert np.max(np.abs(part[:, 0] - part[:, 1])) <= 1e-9


def test_a_kinematic_that_moves_alone_leaves_the_others_where_they_are() -> None:
    team = portals(3)
    rows = driven(team, together(line(100), line(0, 200), None), together(None, None, line(50)), together(line(0), None, None))
    one, two, three = own_rows(team, rows)
    still = np.any(np.diff(three, axis=0), axis=1)
    assert np.any(still)
    assert not np.any(np.diff(one, axis=0)[still])
    assert not np.any(np.diff(two, axis=0)[still])
    assert rows[-1] == pytest.approx([0, 0, 0, 0, 0.2, 0, 0.05, 0, 0], abs=1e-9)


def test_the_slowest_tool_holds_all_back_and_each_pace_is_that_of_its_own_block() -> None:
    team = portals(2)
    slow = replace(team.machines[1], path_speed=0.1)
    team = replace(team, machines=(team.machines[0], slow))
    rows = driven(team, together(line(200), line(0, 100)), together(line(0), replace(line(0, 110), pace=Pace(path_speed=0.05))))
    one, two = own_rows(team, rows)
    speed = np.linalg.norm(np.diff(two, axis=0), axis=1) / 1e-3
    back = np.diff(one[:, 0]) < 0
    assert np.max(speed) == pytest.approx(0.1, rel=1e-3)
    assert np.max(speed[back]) == pytest.approx(0.05, rel=1e-3)


@functools.cache
def rounded() -> tuple[Team, Array]:
    team = portals(3, "xy")
    blocks = (
        together(line(100, blend=ROUND), line(0, 60, blend=ROUND), None),
        together(line(100, 80), line(40, 60), line(0, 50)),
    )
    return team, driven(team, *blocks)


def test_a_point_between_shared_blocks_is_rounded_inside_each_sphere_and_inside_all_limits() -> None:
    team, rows = rounded()
    one, two, three = own_rows(team, rows)
    assert_within(team, rows)
    begins = np.flatnonzero(np.any(np.diff(rows, axis=0), axis=1))[0]
    moving = np.any(np.diff(rows, axis=0), axis=1)[begins:-6]
    assert np.all(moving)  # no stop between the blocks
    for places, point in ((one, (0.1, 0.0)), (two, (0.0, 0.06))):
        away = np.linalg.norm(places - point, axis=1)
        assert 1e-3 < np.min(away) < 0.266 * 0.05
    before = (np.linalg.norm(one - (0.1, 0.0), axis=1) > 0.05) & (one[:, 0] < 0.05)
    assert np.max(np.abs(one[before, 1])) <= UM  # outside the sphere the line is untouched
    assert np.max(np.abs(three[before])) <= UM  # who begins there begins inside it
    assert rows[-1] == pytest.approx((0.1, 0.08, 0.04, 0.06, 0.0, 0.05), abs=1e-9)


def test_it_stops_in_the_point_where_one_of_them_may_not_round_it() -> None:
    team = portals(2)
    rows = driven(team, together(line(100, blend=ROUND), line(0, 50)), together(line(100, 100), line(50, 50)))
    one, two = own_rows(team, rows)
    assert np.min(np.linalg.norm(one - (0.1, 0.0, 0.0), axis=1)) <= UM
    assert np.min(np.linalg.norm(two - (0.0, 0.05, 0.0), axis=1)) <= UM


def test_it_stops_in_the_point_where_the_way_of_one_of_them_goes_back_on_itself() -> None:
    team = portals(2)
    rows = driven(team, together(line(100, blend=ROUND), line(0, 50, blend=ROUND)), together(line(200), line(0, 0)))
    one, two = own_rows(team, rows)
    assert np.min(np.linalg.norm(one - (0.1, 0.0, 0.0), axis=1) + np.linalg.norm(two - (0.0, 0.05, 0.0), axis=1)) <= UM
    assert rows[-1] == pytest.approx((0.2, 0, 0, 0, 0, 0), abs=1e-9)
    assert_within(team, rows)


def test_faults_name_block_kinematic_and_axis_and_nothing_of_the_block_is_taken() -> None:
    route = TeamRoute(portals(2), (0.0,) * 6)
    route.add(together(line(100), line(0, 50)))
    with pytest.raises(BlockError, match=r"block 2, axis P2\.y: kinematic P2: .*") as told:
        route.add(together(line(200), line(0, 9000)))
    assert (told.value.code, told.value.block, told.value.axis) == (531, 2, "P2.y")
    assert route.position == pytest.approx((0.1, 0, 0, 0, 0.05, 0), abs=1e-12)
    assert route.add(together(line(200), None)) == 2
    for block, words in (
        (together(Block(Interpolation.SPLINE, at(1)), line(5)), "only"),
        (together(replace(line(9), pace=Pace(time=1.0)), replace(line(8), pace=Pace(time=2.0))), "one time"),
        (together(*(replace(line(9, 9), outputs=(Output(3, 1, 0.001),)) for _ in "12")), "one kinematic"),
        (together(line(7)), "kinematics"),
    ):
        with pytest.raises(BlockError, match=f"block 3: .*{words}"):
            route.add(block)


def test_an_output_of_a_block_without_way_is_switched_once_by_whoever_moves_next_or_moved_last() -> None:
    here, out = line(0, 0), replace(line(0, 0), outputs=(Output(3, 1),))
    for blocks, switched in (
        ((together(out, line(0.1)), together(line(0.2), None)), [3]),  # it ends with the way of the other one
        ((together(out, here), together(None, line(0.1))), [3]),
        ((together(out, None), together(None, out), together(line(0.1), line(0.1))), [3, 3]),
        ((together(None, line(0.1)), together(out, None)), [3]),
    ):
        planner = Planner(portals(2), (0.0,) * 6)
        for block in blocks:
            planner.add(block)
        planner.finish()
        planner.plan(0.0, hurry=True)
        assert [mark.number for mark in planner.take_marks()] == switched and not planner.left()


def test_a_time_one_of_them_is_given_holds_for_all() -> None:
    rows = driven(portals(2), together(replace(line(100), pace=Pace(time=0.8)), line(0, 300)))
    moving = np.flatnonzero(np.any(np.abs(np.diff(rows, axis=0)) > 1e-12, axis=1))
    assert moving[-1] - moving[0] + 1 == pytest.approx(800, abs=2)


def test_more_than_a_cell_may_hold_is_refused_and_a_record_holds_all_of_them() -> None:
    one = portals(1)
    for names, machines, words in (
        ([f"P{n}" for n in range(17)], one.machines * 17, "17 names, 17 kinematics"),
        ([f"P{n}" for n in range(11)], one.machines * 11, "33 axes, at most 32"),
        (["P", "P"], one.machines * 2, "two kinematics are named P"),
        (["P", "Q"], one.machines * 2, "two axes are named P1.x, P1.y, P1.z"),
    ):
        with pytest.raises(MotionError, match=words):
            Team(tuple(names), machines)
    for robots, axes in ((5, "xyz"), (16, "xy")):
        team = portals(robots, axes)
        arm = Arm(team, (0.0,) * team.axes)
        arm.add(together(*[line(5)] * robots))
        arm.finish()
        (piece, *_) = arm.planner.plan(0.0, hurry=True)
        assert len(piece.axes) == len(axes) * robots
        record = encode_timed(piece)
        assert len(record) == record_size(len(piece.axes)) and decode_any(record) == piece
        with pytest.raises(PieceError, match="bytes expected"):
            decode_any(record[:-8])
