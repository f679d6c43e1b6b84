"""VAL 3 chapter 10: the motion stack, on a real planner and follower in virtual time."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from hil_tests.lab.cells.arms import Array, at, differences, off_line, portal, robot, run, tool_path, tool_speed
from motion.geometry.conventions import VAL3
from motion.geometry.frames import NO_ROTATION, Pose
from motion.kinematics.base import Configuration, Elbow
from motion.planner.arm import Arm
from motion.planner.route import Route
from motion.program.blocks import Block, Interpolation, JointTarget, PoseTarget, Tool
from motion.val3.errors import RuntimeFault
from motion.val3.mdesc import BlendKind, Mdesc
from motion.val3.stack import Connection, Mode, MotionStack, Settling, connects_by_itself

FLANGE = Tool()
OFF = Mdesc(blend=BlendKind.OFF)
P = 2e-3


def stack(**more: object) -> tuple[Arm, MotionStack]:
    arm = Arm(portal(), (0.0, 0.0, 0.0), P)
    made = MotionStack(arm)
    for name, value in more.items():
        setattr(made, name, value)
    return arm, made


def rounded(leave: float, reach: float, kind: BlendKind = BlendKind.JOINT) -> Mdesc:
    return Mdesc(blend=kind, leave=leave, reach=reach)


def code(action: Callable[[], object]) -> int:
    try:
        action()
    except RuntimeFault as fault:
        return fault.code
    return 0


def off_path(rows: Array, path: Array) -> float:
    """Largest distance of set values from the polyline through `path`, m."""
    a, b = path[:-1], path[1:]
    way = b - a
    square = np.maximum(np.sum(way * way, axis=1), 1e-18)
    worst = 0.0
    for row in rows:
        share = np.clip(np.sum((row - a) * way, axis=1) / square, 0.0, 1.0)
        worst = max(worst, float(np.min(np.linalg.norm(a + share[:, None] * way - row, axis=1))))
    return worst


@pytest.mark.requirement("VAL-MOV-01", by="motion.val3.stack:MotionStack._queue")
def test_moves_queue_and_return_ids_while_the_arm_is_on_the_first_and_a_full_queue_waits() -> None:
    arm, moves = stack(capacity=4)
    ids = [moves.movej(at(10.0 * k), FLANGE, OFF) for k in range(1, 5)]
    assert ids == [0, 1, 2, 3]
    arm.step()
    assert arm.place().block <= 1, "the arm is still on the first"
    assert moves.movej(at(60), FLANGE, OFF) is None, "full: the instruction waits"
    run(arm, lambda: arm.place().block >= 2)
    assert moves.movej(at(60), FLANGE, OFF) == 4


@pytest.mark.requirement("VAL-MOV-04", by="motion.val3.mdesc:Mdesc.blending")
@pytest.mark.requirement("VAL-MOV-04", by="motion.val3.stack:MotionStack.wait_end_move")
def test_u_cycle_with_leave_50_and_reach_200_does_not_stop_at_depart_and_appro() -> None:
    arm, moves = stack()
    moves.movel(at(0, 0, 120), FLANGE, rounded(50, 200))
    moves.movej(at(500, 0, 120), FLANGE, rounded(200, 50))
    moves.movel(at(500, 0, 0), FLANGE, OFF)
    rows = run(arm, moves.wait_end_move)
    speed = tool_speed(rows, P)
    inner = speed[20:-20]
    assert float(inner.min()) > 0.1, "stops on the way"
    for corner in ((0.0, 0.0, 0.12), (0.5, 0.0, 0.12)):
        assert float(np.min(np.linalg.norm(rows - np.array(corner), axis=1))) > 0.005, "goes through the point"
    assert rows[-1] == pytest.approx([0.5, 0.0, 0.0], abs=1e-9)


@pytest.mark.requirement("VAL-MOV-04", by=("motion.planner.route:Route.finish", "motion.val3.stack:MotionStack.wait_end_move"))
def test_wait_end_move_ends_exactly_at_the_point_and_blends_the_others() -> None:
    arm, moves = stack()
    mdesc = rounded(10, 10)
    moves.movej(at(100), FLANGE, mdesc)
    moves.movej(at(100, 100), FLANGE, mdesc)
    first = run(arm, moves.wait_end_move)
    assert first[-1] == pytest.approx([0.1, 0.1, 0.0], abs=1e-9) and arm.resting
    moves.movej(at(200, 100), FLANGE, mdesc)
    moves.movej(at(200, 200), FLANGE, mdesc)
    second = run(arm, moves.wait_end_move)
    for point, rows in (((0.1, 0.0, 0.0), first), ((0.2, 0.1, 0.0), second)):
        missed = float(np.min(np.linalg.norm(rows - np.array(point), axis=1)))
        assert 0.001 < missed <= 0.1875 * 0.01 * math.sqrt(2) + 2e-5, "A and C are blended within the bound"


@pytest.mark.requirement("VAL-MOV-05", by="motion.planner.route:Route._leave")
def test_with_only_a_queued_the_arm_halts_at_a_leave_and_the_path_is_the_same() -> None:
    mdesc = rounded(30, 20, BlendKind.CARTESIAN)
    arm, moves = stack()
    for target in (at(100), at(100, 100)):
        moves.movel(target, FLANGE, mdesc)
    normal = run(arm, moves.wait_end_move)

    route = Route(portal(), (0.0, 0.0, 0.0))
    for target in (at(100), at(100, 100)):
        route.add(Block(Interpolation.LINEAR, target, blend=mdesc.blending()))
    route.finish()
    curve = np.concatenate([s.path.at(np.linspace(0.0, s.path.length, 800))[:, :3] for s in route.take()])
    assert off_path(normal[::5], curve) < 1e-7

    stepped_arm, stepped = stack()
    stepped.movel(at(100), FLANGE, mdesc)
    first = run(stepped_arm, lambda: stepped_arm.resting and stepped_arm.place().block == 1)
    assert first[-1] == pytest.approx([0.07, 0.0, 0.0], abs=1e-9), "A leave: 30 mm before A"
    assert not stepped.is_empty()
    stepped.movel(at(100, 100), FLANGE, mdesc)
    second = run(stepped_arm, lambda: stepped_arm.resting and stepped_arm.place().block == 2)
    assert second[-1] == pytest.approx([0.1, 0.07, 0.0], abs=1e-9), "B leave"
    third = run(stepped_arm, stepped.wait_end_move)
    assert third[-1] == pytest.approx([0.1, 0.1, 0.0], abs=1e-9)
    assert off_path(np.concatenate([first, second, third])[::5], curve) < 1e-7, "another path than in normal running"


@pytest.mark.requirement("VAL-MOV-06", by="motion.val3.stack:MotionStack.stop_move")
@pytest.mark.requirement("VAL-MOV-06", by="motion.val3.stack:MotionStack.restart_move")
def test_stop_move_stops_on_the_path_and_restart_move_goes_on() -> None:
    arm, moves = stack()
    moves.movel(at(300, 100), FLANGE, OFF)
    moves.restart_move()
    rows = [run(arm, lambda: arm.joints[0] > 0.1)]
    moves.stop_move()
    assert not moves.permitted
    rows.append(run(arm, lambda: arm.resting))
    stopped = arm.joints
    assert 0.1 < stopped[0] < 0.29
    for _ in range(50):
        arm.step()
    assert arm.joints == stopped and not moves.is_empty()
    moves.restart_move()
    assert moves.permitted
    rows.append(run(arm, moves.wait_end_move))
    every = np.concatenate(rows)
    assert off_line(every, (0, 0, 0), (0.3, 0.1, 0)) < 1e-6 and every[-1] == pytest.approx([0.3, 0.1, 0.0], abs=1e-9)


@pytest.mark.requirement("VAL-MOV-07", by="motion.val3.stack:MotionStack.reset_motion")
def test_reset_motion_empties_the_queue_sets_id_0_and_restores_the_permission() -> None:
    arm, moves = stack(mode=Mode.REMOTE)
    for target in (at(300), at(300, 300)):
        moves.movel(target, FLANGE, OFF)
    run(arm, lambda: arm.joints[0] > 0.05)
    moves.stop_move()
    moves.reset_motion((0.2, 0.0, 0.0))
    run(arm, lambda: arm.resting)
    assert moves.is_empty() and moves.get_move_id() == 0.0 and moves.permitted
    assert 0.05 < arm.joints[0] < 0.3
    assert moves.movel(at(200, 100), FLANGE, OFF) == 0
    assert moves.connection is Connection.OPERATOR, "the connection move to jStartingPoint waits"
    before = arm.joints
    for _ in range(20):
        arm.step()
    assert arm.joints == before
    moves.confirm_connection()
    rows = run(arm, moves.wait_end_move)
    assert float(np.min(np.linalg.norm(rows - np.array([0.2, 0.0, 0.0]), axis=1))) < 1e-6, "goes through jStartingPoint"
    assert rows[-1] == pytest.approx([0.2, 0.1, 0.0], abs=1e-9)


def test_without_a_starting_point_the_next_move_begins_where_the_arm_is() -> None:
    arm, moves = stack()
    moves.movel(at(300), FLANGE, OFF)
    run(arm, lambda: arm.joints[0] > 0.1)
    moves.reset_motion()
    assert moves.movel(at(0), FLANGE, OFF) is None, "still braking"
    run(arm, lambda: arm.resting)
    moves.movel(at(300, 50), FLANGE, OFF)
    assert moves.connection is Connection.NONE
    assert run(arm, moves.wait_end_move)[-1] == pytest.approx([0.3, 0.05, 0.0], abs=1e-9)


@pytest.mark.requirement("VAL-MOV-08", by="motion.val3.stack:MotionStack.is_empty")
@pytest.mark.requirement("VAL-MOV-08", by="motion.val3.stack:Settling.joints")
def test_stopped_in_the_middle_the_arm_is_settled_and_not_empty() -> None:
    arm, moves = stack()
    assert moves.is_empty() is True
    moves.movel(at(300), FLANGE, OFF)
    run(arm, lambda: arm.joints[0] > 0.1)
    settling, errors = Settling(0.05), (0.004, 0.0)
    assert not settling.joints((0.02, 0.0), (1.0, 1.0), 0.0), "2 % of the largest allowed error"
    moves.stop_move()
    run(arm, lambda: arm.resting)
    assert not settling.joints(errors, (1.0, 1.0), 1.0)
    assert not settling.joints(errors, (1.0, 1.0), 1.049)
    assert settling.joints(errors, (1.0, 1.0), 1.05) is True
    for error, good in ((0.0199, True), (0.0201, False)):
        other = Settling(0.05)
        assert [other.joints((0.0, error), (1.0, 2.0), now_s) for now_s in (0.0, 0.05)] == [False, good], "1 % of what is allowed"
    assert moves.is_empty() is False
    assert not settling.tool(0.001, 0.0, 0.0005, None, None, 2.0)
    assert not settling.tool(0.0004, 0.1, 0.0005, 0.2, 0.3, 3.0) and settling.tool(0.0004, 0.1, 0.0005, 0.2, 0.3, 3.3)


@pytest.mark.requirement("VAL-MOV-09", by="motion.val3.stack:connects_by_itself")
@pytest.mark.requirement("VAL-MOV-09", by="motion.val3.stack:MotionStack._begin_connection")
def test_connection_move_by_itself_only_in_remote_mode_near_the_path_or_when_allowed() -> None:
    table = {
        (Mode.REMOTE, 0.5, False): True, (Mode.REMOTE, 0.5, True): True, (Mode.REMOTE, 2.0, False): False, (Mode.REMOTE, 2.0, True): True,
        (Mode.LOCAL, 0.5, True): False, (Mode.MANUAL, 0.5, True): False, (Mode.TEST, 0.0, True): False,
    }  # fmt: skip
    assert {key: connects_by_itself(key[0], key[1], 1.0, key[2]) for key in table} == table
    arm, moves = stack(following_error=(0.01, 0.01, 0.01))
    assert moves.auto_connect_move() is False, "default"
    moves.reset_motion((0.005, 0.0, 0.0))
    moves.movel(at(100), FLANGE, OFF)
    assert moves.connection is Connection.RUNNING, "5 mm away, 10 mm allowed"
    assert run(arm, moves.wait_end_move)[-1] == pytest.approx([0.1, 0.0, 0.0], abs=1e-9)
    ended: Connection = moves.connection
    assert ended == Connection.NONE
    for start in ((0.112, 0.0, 0.0), (0.1, -0.012, 0.0)):  # 12 mm from where the arm stands on one axis
        waiting_arm, waiting = stack(following_error=(0.01, 0.01, 0.01), mode=Mode.REMOTE)
        waiting.movel(at(100), FLANGE, OFF)
        run(waiting_arm, waiting.wait_end_move)
        waiting.reset_motion(start)
        waiting.movel(at(200), FLANGE, OFF)
        assert waiting.connection is Connection.OPERATOR, "beyond what is allowed: somebody has to confirm it"
        assert [waiting_arm.step() for _ in range(20)] == [waiting_arm.joints] * 20
    far_arm, far = stack(following_error=(0.01, 0.01, 0.01))
    far.auto_connect_move(True)
    far.reset_motion((0.5, 0.0, 0.0))
    far.movel(at(100), FLANGE, OFF)
    assert far.connection is Connection.RUNNING
    assert len(run(far_arm, far.wait_end_move)) > 100


@pytest.mark.requirement("VAL-MOV-09", by="motion.val3.stack:MotionStack.observe")
def test_a_connection_move_that_waits_runs_when_auto_connect_move_is_switched_on() -> None:
    """In remote mode alone: a recovery task switches it on while another task waits for the end of its moves."""
    arm, moves = stack(following_error=(0.01, 0.01, 0.01), mode=Mode.LOCAL)
    moves.reset_motion((0.5, 0.0, 0.0))
    moves.movel(at(100), FLANGE, OFF)
    moves.auto_connect_move(True)
    moves.observe()
    assert moves.connection is Connection.OPERATOR
    moves.mode = Mode.REMOTE
    assert run(arm, moves.wait_end_move)[-1] == pytest.approx([0.1, 0.0, 0.0], abs=1e-9)


def ring(angle: float) -> PoseTarget:
    """On a circle of 100 mm about (100, 0)."""
    return at(100 - 100 * math.cos(math.radians(angle)), 100 * math.sin(math.radians(angle)))


@pytest.mark.requirement("VAL-MOV-10", by="motion.planner.block_paths:_arc")
def test_a_full_circle_takes_two_movec_and_an_arc_above_180_degrees_is_550_or_551() -> None:
    arm, moves = stack()
    slow = Mdesc(tvel=2000.0, blend=BlendKind.CARTESIAN, leave=1.0, reach=1.0)
    moves.movec(ring(90), ring(180), FLANGE, slow)
    moves.movec(ring(270), ring(0), FLANGE, OFF)
    rows = run(arm, moves.wait_end_move)
    radius = np.linalg.norm(rows - np.array([0.1, 0.0, 0.0]), axis=1)
    assert float(np.max(np.abs(radius - 0.1))) < 1e-5
    assert {int(np.sign(x)) for x in rows[:, 1]} >= {-1, 1} and rows[-1] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    _, again = stack()
    assert code(lambda: again.movec(ring(200), ring(300), FLANGE, OFF)) == 550
    assert code(lambda: again.movec(ring(60), ring(300), FLANGE, OFF)) == 551
    assert code(lambda: again.movec(at(50), at(100), FLANGE, OFF)) == 552


def tx(elbow: Elbow | None = None) -> Configuration:
    return Configuration() if elbow is None else Configuration(elbow=elbow)


@pytest.mark.requirement("VAL-MOV-11", by="motion.planner.block_paths:check_end")
def test_a_straight_move_cannot_force_the_other_elbow_and_movej_can() -> None:
    machine = robot("tx60-like")
    start = (0.0, math.radians(30), math.radians(90), 0.0, math.radians(60), 0.0)
    arm = Arm(machine, start, P)
    moves = MotionStack(arm)
    pose = machine.kinematics.forward(start)
    target = Pose((pose.position[0] - 0.05, pose.position[1], pose.position[2]), pose.rotation)
    found = machine.kinematics.configuration(start).elbow
    other = Elbow.NEGATIVE if found is Elbow.POSITIVE else Elbow.POSITIVE
    assert code(lambda: moves.movel(PoseTarget(target, tx(other)), FLANGE, OFF)) in (533, 542)
    assert arm.joints == start and moves.is_empty()
    assert code(lambda: moves.movel(PoseTarget(target, tx(found)), FLANGE, OFF)) == 0, "the same is always possible"
    assert code(lambda: moves.movel(PoseTarget(pose, tx()), FLANGE, OFF)) == 0, "and free"
    run(arm, moves.wait_end_move)
    assert machine.kinematics.configuration(arm.joints).elbow is found
    assert code(lambda: moves.movej(PoseTarget(target, tx(other)), FLANGE, OFF)) == 0, "movej does it"
    run(arm, moves.wait_end_move)
    assert machine.kinematics.configuration(arm.joints).elbow is other
    assert machine.kinematics.forward(arm.joints).position == pytest.approx(target.position, abs=1e-6)
    high = Pose((target.position[0], target.position[1], target.position[2] + 0.03), pose.rotation)
    again = MotionStack(Arm(machine, start, P))
    assert code(lambda: again.movec(PoseTarget(high, tx(other)), PoseTarget(target), FLANGE, OFF)) == 0, "that of the middle is ignored"


@pytest.mark.requirement("VAL-MID-01", by="motion.val3.stack:MotionStack.get_move_id")
@pytest.mark.requirement("VAL-MID-01", by="motion.planner.runs:progress")
def test_get_move_id_reports_move_and_progress() -> None:
    arm, moves = stack()
    moves.set_move_id(15)
    assert moves.movel(at(100), FLANGE, OFF) == 15
    assert moves.movel(at(100, 100), FLANGE, OFF) == 16
    seen = []

    def watched() -> bool:
        if moves.wait_end_move():
            return True
        seen.append((moves.get_move_id(), arm.joints))
        return False

    run(arm, watched)
    assert moves.get_move_id() == 17.0
    for number, (x, y, _) in seen:
        made = 15 + x / 0.1 if y == 0.0 else 16 + y / 0.1
        assert number == pytest.approx(made, abs=2e-3)
    ids = [number for number, _ in seen]
    assert ids == sorted(ids) and any(15.7 < n < 15.9 for n in ids) and any(16.5 < n < 16.7 for n in ids)


@pytest.mark.requirement("VAL-MID-01", by="motion.planner.runs:progress")
def test_get_move_id_runs_on_through_a_blended_point_and_turns_in_its_middle() -> None:
    arm, moves = stack()
    moves.set_move_id(15)
    moves.movel(at(100), FLANGE, rounded(40, 20, BlendKind.CARTESIAN))
    moves.movel(at(100, 100), FLANGE, OFF)
    rows, ids = [], []
    while not moves.wait_end_move():
        rows.append(arm.step())
        ids.append(moves.get_move_id())
    places, numbers = np.array(rows), np.array(ids)
    straight = (places[:, 0] < 0.06) & (places[:, 1] == 0.0)
    assert numbers[straight] == pytest.approx(15.0 + places[straight, 0] / 0.1, abs=5e-3)
    behind = places[:, 1] > 0.02
    assert numbers[behind] == pytest.approx(16.0 + places[behind, 1] / 0.1, abs=5e-3)
    assert np.all(np.diff(numbers) >= 0.0) and float(np.diff(numbers).max()) < 0.06, "without a jump"
    middle = int(np.argmax(numbers >= 16.0))
    assert 0.06 < places[middle, 0] < 0.1 and 0.0 < places[middle, 1] < 0.02


@pytest.mark.requirement("VAL-MID-02", by="motion.val3.stack:MotionStack.set_move_id")
def test_set_move_id_acts_on_the_next_move_alone() -> None:
    arm, moves = stack()
    moves.movel(at(10), FLANGE, OFF)
    run(arm, moves.wait_end_move)
    moves.reset_motion()
    assert moves.get_move_id() == 0.0
    moves.set_move_id(1000)
    assert moves.get_move_id() == 0.0, "not changed yet"
    assert moves.movel(at(50), FLANGE, OFF) == 1000
    assert moves.movel(at(80), FLANGE, OFF) == 1001
    run(arm, moves.wait_end_move)
    assert moves.get_move_id() == 1002.0
    assert code(lambda: moves.set_move_id(-1)) == 70


def test_a_move_that_cannot_be_run_is_reported_with_its_number_and_the_arm_stays() -> None:
    arm, moves = stack()
    assert code(lambda: moves.movej(JointTarget((9.0, 0.0, 0.0)), FLANGE, OFF)) == 520
    assert code(lambda: moves.movel(PoseTarget(Pose((0.0, 0.0, math.nan), NO_ROTATION)), FLANGE, OFF)) == 154
    assert code(lambda: moves.movel(at(9000), FLANGE, OFF)) in (530, 531, 532)
    assert code(lambda: moves.movel(at(10), FLANGE, Mdesc(vel=-1))) == 100
    assert moves.is_empty() and arm.step() == (0.0, 0.0, 0.0)
    moves.failed(RuntimeFault(540))
    assert code(moves.wait_end_move) == 150 and code(lambda: moves.movel(at(10), FLANGE, OFF)) == 150
    moves.reset_motion()
    assert code(lambda: moves.movel(at(10), FLANGE, OFF)) == 0


def test_set_values_keep_all_limits_through_blends_and_a_stop() -> None:
    arm, moves = stack()
    arm = Arm(portal(), (0.0, 0.0, 0.0), 1e-3)
    moves = MotionStack(arm)
    for target in (at(100), at(100, 100), at(0, 100)):
        moves.movel(target, FLANGE, rounded(20, 20, BlendKind.CARTESIAN))
    rows = [run(arm, lambda: arm.joints[0] > 0.08)]
    moves.stop_move()
    rows.append(run(arm, lambda: arm.resting)[1:])
    rows.append(np.array([arm.step() for _ in range(10)]))
    moves.restart_move()
    rows.append(run(arm, moves.wait_end_move)[1:])
    every = np.concatenate(rows)
    for order, limit, room in ((1, 2.0, 1.0001), (2, 20.0, 1.02), (3, 1000.0, 1.10)):
        assert float(np.max(np.abs(differences(every, 1e-3, order)))) <= limit * room
    assert VAL3.values(machine_pose(every))[0] == pytest.approx(0.0, abs=1e-6)


def machine_pose(rows: Array) -> Pose:
    x, y, z = tool_path(portal(), rows[-1:])[0]
    return Pose((float(x), float(y), float(z)), NO_ROTATION)
