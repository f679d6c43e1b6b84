"""VAL 3 chapter 13.1: alter, on a real planner and follower in virtual time."""

import math

import numpy as np
import pytest

from hil_tests.lab.cells.arms import at, robot
from hil_tests.unit.motion.sync.alter_lab import Altered, P
from motion.geometry.frames import IDENTITY, NO_ROTATION, Pose
from motion.geometry.orientation import rotation_by
from motion.planner.arm import Arm
from motion.program.blocks import Frame, JointTarget, PoseTarget, Tool
from motion.sync.alter import Alter, AlterFault, AlterLimits, Mode, Reference
from motion.sync.altered import AlteredArm, AlterMotion
from motion.val3.errors import RuntimeFault
from motion.val3.mdesc import BlendKind, Mdesc
from motion.val3.stack import MotionStack
from motion.val3.trsf import Trsf

OFF = Mdesc(blend=BlendKind.OFF, tvel=500.0)
FLANGE, WORLD = Tool(), Frame("world")
WIDE = AlterLimits((1e9,) * 3, 1e9, 1e9, 1.0, 1.0)


def moving(nominal: float = 2.0) -> Altered:
    """An alterable line of 300 mm under way, alter active."""
    rig = Altered(nominal=nominal)
    assert rig.moves.alter_movel(at(300), FLANGE, OFF) == 0
    rig.run(20)
    assert rig.moves.alter_begin(WORLD, Mdesc(vel=100, tvel=1000)) == 1
    return rig


@pytest.mark.requirement("VAL-ALT-01", by="motion.sync.alter:Alter.alter")
@pytest.mark.requirement("VAL-ALT-01", by="motion.sync.alter:Alter.step")
@pytest.mark.requirement("VAL-ALT-01", by="motion.sync.alter:Alter.begin")
def test_alter_before_begin_is_minus_1_and_of_two_within_4_ms_the_last_wins() -> None:
    rig = Altered()
    rig.moves.alter_movel(at(300), FLANGE, OFF)
    rig.run(20)
    assert rig.alter.alter(Trsf(y=1.0)) == -1
    assert rig.alter.end() == -1
    assert rig.moves.alter_begin(WORLD, Mdesc()) == 1
    assert rig.moves.alter_begin(WORLD, Mdesc()) == -1
    assert rig.alter.alter(Trsf(y=5.0)) == 1
    assert rig.alter.alter(Trsf(y=0.4)) == 1
    rows = rig.run(10)
    assert rows[-1][1] == pytest.approx(0.4e-3), "the last one of 4 ms"
    assert float(rows[:, 1].max()) <= 0.4e-3 + 1e-12, "nothing of the first is seen"
    assert rows[:4, 1] == pytest.approx([0.1e-3, 0.2e-3, 0.3e-3, 0.4e-3]), "from value to value in 4 ms"
    assert rows[:, 0] == pytest.approx([q[0] for q in rig.theory[-10:]]), "the path itself goes on"


@pytest.mark.requirement("VAL-ALT-01", by="motion.sync.alter:Alter.judge")
def test_too_fast_an_alteration_stops_the_arm_at_its_last_position_and_locks_until_reset_motion() -> None:
    rig = moving()
    rig.alter.alter(Trsf(y=0.4))
    rig.run(8)
    before = rig.rows[-1]
    assert rig.alter.alter(Trsf(y=50.0)) == 1
    rows = rig.run(40)
    assert isinstance(rig.arm.fault, AlterFault) and "tvel" in str(rig.arm.fault)
    assert np.all(rows == rows[0]) and rows[0] == pytest.approx(before, abs=2e-3), "halted at the last valid position"
    assert [rig.alter.alter(Trsf()), rig.alter.end(), rig.moves.alter_begin(WORLD, Mdesc())] == [-3, -3, -3]
    assert rig.alter.stop_time() == 0.0
    rig.stack.reset_motion()
    rig.run(400)
    assert rig.rows[-1] == pytest.approx(tuple(rows[0])), "the arm stays where it halted"
    assert rig.alter.alter(Trsf()) == -1
    assert rig.moves.alter_movel(at(100, 50), FLANGE, OFF) == 0
    rig.run(20)
    assert rig.moves.alter_begin(WORLD, Mdesc()) == 1
    rig.run(1500)
    assert rig.rows[-1] == pytest.approx((0.1, 0.05, 0.0)), "and moves on from there"
    assert float(rig.steps().max()) < 1e-3, "without a jump"


def test_joint_speed_rotation_and_reach_are_judged_too() -> None:
    rig = moving(nominal=0.4)
    rig.alter.alter(Trsf(y=2.0))
    rig.run(8)
    assert "joint 2" in str(rig.arm.fault)
    alter = Alter(4e-3)
    alter.path(alterable=True)
    alter.begin(Reference.FRAME, IDENTITY, AlterLimits((), 1.0, 0.1, 1.0, 1.0))
    with pytest.raises(AlterFault, match="rvel"):
        alter.judge(IDENTITY, Pose((0.0, 0.0, 0.0), rotation_by((0.0, 0.0, 0.001))), (), ())
    far = moving()
    for k in range(1, 700):
        far.alter.alter(Trsf(z=3.0 * k))
        far.run(4)
    assert far.arm.fault is not None and not isinstance(far.arm.fault, AlterFault), "out of the workspace"
    assert far.alter.alter(Trsf()) == -3
    assert far.rows[-1] == far.rows[-30]
    nan = moving()
    assert nan.alter.alter(Trsf(x=math.nan)) == -3
    with pytest.raises(RuntimeFault) as fault:
        nan.moves.alter_begin(WORLD, Mdesc(vel=0.0))
    assert fault.value.code == 100


@pytest.mark.requirement("VAL-ALT-02", by="motion.sync.alter:Alter.end")
@pytest.mark.requirement("VAL-ALT-02", by="motion.sync.alter:Alter.begin")
def test_alter_end_freezes_for_the_rest_of_the_path_and_a_second_begin_needs_a_standard_move() -> None:
    rig = moving()
    rig.moves.alter_movel(at(300, 100), FLANGE, OFF)
    for k in range(1, 11):
        rig.alter.alter(Trsf(z=0.5 * k))
        rig.run(4)
    assert rig.alter.end() == 1
    assert rig.alter.mode is Mode.FROZEN
    assert rig.alter.alter(Trsf(z=9.0)) == -1
    assert rig.moves.alter_begin(WORLD, Mdesc()) == -1, "one begin for each alterable path"
    frozen = rig.rows[-1][2]
    rows = rig.run(1500)
    assert rows[:, 2] == pytest.approx(np.full(len(rows), frozen)), "the alteration stays to the end"
    assert rig.rows[-1] == pytest.approx((0.3, 0.1, frozen)) and frozen > 0.004
    assert rig.moves.alter_begin(WORLD, Mdesc()) == -1
    rig.stack.movel(at(0), FLANGE, OFF)
    rig.run(1500)
    assert rig.rows[-1] == pytest.approx((0.0, 0.0, 0.0)), "computed from where the arm stood"
    assert float(rig.steps().max()) < 1e-3
    rig.moves.alter_movel(at(100), FLANGE, OFF)
    assert rig.moves.alter_begin(WORLD, Mdesc()) == 0, "waits for the alterable move"
    assert rig.alter.alter(Trsf()) == -1
    rig.run(50)
    assert rig.alter.alter(Trsf()) == 1


@pytest.mark.requirement("VAL-ALT-02", by="motion.sync.altered:AlteredArm._release")
def test_at_the_end_of_the_path_the_mode_stays_and_after_alter_end_the_next_move_starts_at_once() -> None:
    rig = moving()
    rig.stack.movel(at(300, -100), FLANGE, OFF)
    rig.run(1200)
    assert rig.inner.resting and rig.rows[-1] == pytest.approx((0.3, 0.0, 0.0)), "the standard move waits"
    for k in range(1, 21):
        assert rig.alter.alter(Trsf(y=0.5 * k)) == 1
        rig.run(4)
    assert rig.rows[-1][1] == pytest.approx(0.0100, abs=1e-6), "the arm is moved by alter alone"
    rig.run(50)
    assert rig.alter.end() == 1
    rows = rig.run(30)
    assert rows[-1][1] < 0.01 - 1e-6, "starts at once"
    rig.run(1500)
    assert rig.rows[-1] == pytest.approx((0.3, -0.1, 0.0))
    assert float(rig.steps().max()) < 1e-3
    assert rig.stack.is_empty()


@pytest.mark.requirement("VAL-ALT-03", by="motion.sync.altered:AlteredArm.place")
@pytest.mark.requirement("VAL-ALT-03", by="motion.sync.altered:AlteredArm._altered")
def test_wait_end_move_returns_at_the_end_of_the_theoretical_path_while_alter_moves_the_arm() -> None:
    rig = moving()
    returned = None
    for k in range(400):
        rig.alter.alter(Trsf(z=0.2 * k))
        rig.run(4)
        if returned is None and rig.stack.wait_end_move():
            returned = len(rig.rows)
    assert returned is not None and returned < 1500
    heights = np.array(rig.rows)[returned:, 2]
    assert float(np.diff(heights).min()) >= 0 and heights[-1] - heights[0] > 0.01, "the arm still moves"
    assert rig.theory[returned][0] == pytest.approx(0.3) and rig.theory[returned] == rig.theory[-1]
    assert rig.alter.alter(Trsf()) == 1, "the mode is active until alterEnd"


def test_a_stop_locks_alter_after_its_time_and_a_restart_unlocks_it() -> None:
    rig = moving()
    assert rig.alter.stop_time() < 0, "no stop is pending"
    rig.stack.stop_move()
    assert rig.alter.stop_time() == pytest.approx(0.2)
    rig.alter.alter(Trsf(z=0.4))
    rig.run(20)
    assert rig.rows[-1][2] == pytest.approx(0.4e-3) and 0 < rig.alter.stop_time() < 0.2
    rig.run(200)
    assert rig.alter.stop_time() == 0.0 and rig.alter.alter(Trsf(z=0.8)) == 0
    still = rig.run(20)
    assert np.all(still == still[0])
    rig.stack.restart_move()
    assert rig.alter.stop_time() < 0 and rig.alter.alter(Trsf(z=0.8)) == 1
    rig.run(1500)
    assert rig.rows[-1] == pytest.approx((0.3, 0.0, 0.8e-3))
    soft = Alter(P, stop_time_s=0.2)
    soft.path(alterable=True)
    soft.begin(Reference.TOOL, IDENTITY, AlterLimits((), 1.0, 1.0, 0.2, 0.5))
    soft.stopping()
    assert soft.stop_time() == pytest.approx(0.5), "the system's limit is the shorter one"


def test_without_the_option_everything_answers_minus_2() -> None:
    rig = Altered(enabled=False)
    rig.moves.alter_movel(at(300), FLANGE, OFF)
    assert rig.moves.alter_begin(WORLD, Mdesc()) == -2
    assert rig.alter.alter(Trsf()) == -2


def test_a_frame_turns_the_whole_path_about_its_origin_and_a_tool_shifts_in_its_own_axes() -> None:
    alter = Alter(4e-3)
    alter.path(alterable=True)
    frame = Pose((1.0, 0.0, 0.0), rotation_by((0.0, 0.0, math.pi / 2)))
    assert alter.begin(Reference.FRAME, frame, WIDE) == 1
    alter.alter(Trsf(x=100.0, rz=90.0))
    alter.step()
    moved = alter.altered(Pose((2.0, 0.0, 0.5), NO_ROTATION))
    assert moved.position == pytest.approx((1.0, 1.1, 0.5)), "turned about (1, 0, 0), then 100 mm along the frame's x"
    tool = Alter(4e-3)
    tool.path(alterable=True)
    tip = Pose((0.0, 0.0, 0.2), NO_ROTATION)
    assert tool.begin(Reference.TOOL, tip, WIDE) == 1
    tool.alter(Trsf(z=10.0, ry=90.0))
    tool.step()
    flange = Pose((0.5, 0.0, 0.5), rotation_by((math.pi, 0.0, 0.0)))
    altered = tool.altered(flange)
    assert (altered @ tip).position == pytest.approx((0.5, 0.0, 0.29)), "the tool centre point goes 10 mm along its own z"
    with pytest.raises(Exception, match="4 ms"):
        Alter(3e-3)


def test_an_arm_with_six_axes_follows_movej_movel_and_movec_under_a_sine() -> None:
    machine = robot("tx60-like")
    home = machine.kinematics.inverse(Pose((0.35, 0.0, 0.3), (1.0, 0, 0, 0, -1.0, 0, 0, 0, -1.0)), (0.0, 0.5, 1.2, 0.0, 1.0, 0.0))
    inner = Arm(machine, home, P)
    arm = AlteredArm(inner, machine.kinematics, Alter(P))
    stack = MotionStack(arm)
    moves = AlterMotion(stack, arm, [axis.speed for axis in machine.limits])
    pose = machine.kinematics.forward(home)

    def target(dx: float, dy: float) -> PoseTarget:
        x, y, z = pose.position
        return PoseTarget(Pose((x + dx, y + dy, z), pose.rotation))

    moves.alter_movel(target(0.0, 0.1), FLANGE, OFF)
    moves.alter_movec(target(0.05, 0.15), target(0.1, 0.1), FLANGE, OFF)
    moves.alter_movej(JointTarget(home), FLANGE, OFF)
    arm.step()
    assert moves.alter_begin(FLANGE, Mdesc()) in (0, 1)
    worst = 0.0
    for k in range(1000):
        arm.alter.alter(Trsf(z=3.0 * (1 - math.cos(2 * math.pi * k * 0.004 / 0.5))))
        for _ in range(4):
            q = arm.step()
        depth = 2 * 3e-3 if arm.alter.mode is Mode.ACTIVE else 0.0
        off = machine.kinematics.forward(inner.joints).inverse() @ machine.kinematics.forward(q)
        worst = max(worst, abs(off.position[0]), abs(off.position[1]), off.position[2] - depth, -off.position[2])
        if inner.place().waiting == 0:
            break
    assert arm.fault is None and worst < 1e-9
    assert stack.is_empty()
