"""Stepper, belt and alteration together at 1 ms: P = F_belt(t) * P(s) * A(t), and s slowed where joints would be too fast."""

import itertools
import math

import numpy as np
import pytest

from hil_tests.lab.cells.motion_paths import MS
from hil_tests.unit.motion.sync.belt_lab import Conveyor
from hil_tests.unit.motion.sync.carry_lab import LIMITS, ROBOT, SPEEDS, down, joined, shares, straight
from motion.errors import MotionError
from motion.execution.stepper import State, Stepper
from motion.geometry.frames import IDENTITY, Pose, translation
from motion.geometry.orientation import angle_between, rotation_by
from motion.kinematics.base import Unreachable
from motion.sync.belt_frame import Carried
from motion.sync.join import SyncStepper
from motion.sync.joint_lookahead import allowed
from motion.sync.parallel import Carrier, Coupling, Hold, ParallelPart
from motion.sync.reserve import borne, left_over, reserved
from motion.sync.tracker import Tracker

START, END = down(0.35, -0.2, 0.3), down(0.35, 0.1, 0.3)


def apart(a: Pose, b: Pose) -> float:
    """m plus rad."""
    return math.dist(a.position, b.position) + angle_between(a.rotation, b.rotation)


def test_belt_in_front_and_alteration_behind_the_path_to_1e_9_at_any_override_and_stop() -> None:
    rig = joined(START)
    for piece in straight(START, END):
        rig.load(piece)
    rows, frame = [rig.q], IDENTITY
    for k in range(3000):
        frame = translation(0.0, 0.1 * k * MS * min(k / 100, 1.0), 0.0)
        by = Pose((0.0, 0.0, 0.005 * math.sin(k / 50)), rotation_by((0.0, 0.0, 0.1 * math.sin(k / 80))))
        if k in (100, 300, 500):
            rig.set_override({100: 0.4, 300: 1.0, 500: 0.7}[k])
        made = rig.step(frame, by)
        rows.append(made.q)
        expected = frame @ ROBOT.forward(made.path.q) @ by
        assert apart(ROBOT.forward(made.q), expected) < 1e-9 and not made.short
        if made.path.state is State.IDLE:
            break
    assert k < 2000 and apart(ROBOT.forward(made.path.q), END) < 1e-9
    assert rig.fault is None and float(shares(rows).max()) <= 1.0


def too_fast(belt: float, *, reserve: bool = True) -> tuple[SyncStepper, list[float], list[tuple[float, ...]], list[float], list[bool]]:
    """A quick path past the column of the arm, along with or against a belt (m/s): rig, overrides, joints, ways, clipped."""
    start, end = down(0.2, -0.3, 0.3), down(0.2, 0.1, 0.3)
    rig = joined(start)
    for piece in straight(start, end, speed=1.3, reserve=reserve):
        rig.load(piece)
    rows, ways, granted, short = [rig.q], [], [], []
    speed = place = 0.0
    for _ in range(3000):
        speed = belt * min(len(rows) / 150, 1.0)
        place += speed * MS
        made = rig.step(translation(0.0, place, 0.0))
        rows.append(made.q)
        ways.append(made.path.s)
        granted.append(made.share)
        short.append(made.short)
        if made.path.state is State.IDLE:
            break
    return rig, granted, rows, ways, short


def test_s_is_slowed_on_the_path_before_a_joint_would_be_too_fast() -> None:
    rig, granted, rows, ways, short = too_fast(0.5)
    assert rig.fault is None and ways[-1] == pytest.approx(0.4)
    assert float(shares(rows).max()) <= 1.0 + 1e-9, "joint speeds are kept"
    assert min(granted) < 0.95, "the path had to be slowed"
    assert not any(short), "in time: no joint fell short, so nothing left the path"
    assert demanded(0.5) > 1.1, "unslowed it would have been too fast"


def test_without_a_reserve_joints_fall_short_but_keep_their_speed_and_arrive() -> None:
    rig, _, rows, ways, short = too_fast(0.6, reserve=False)
    assert rig.fault is None and ways[-1] == pytest.approx(0.4)
    assert any(short) and not short[-1]
    assert float(shares(rows).max()) <= 1.0 + 1e-9


def demanded(belt: float) -> float:
    """Largest share of a joint speed the same motion asks for when nobody slows it."""
    start, end = down(0.2, -0.3, 0.3), down(0.2, 0.1, 0.3)
    stepper = Stepper(6, MS, joined(start).q)
    for piece in straight(start, end, speed=1.3):
        stepper.load(piece)
    q, place, worst = joined(start).q, 0.0, 0.0
    for k in range(3000):
        place += belt * min((k + 1) / 150, 1.0) * MS
        sample = stepper.step()
        made = ROBOT.follow(translation(0.0, place, 0.0) @ ROBOT.forward(sample.q), q)
        worst = max(worst, *(abs(b - a) / MS / v for a, b, v in zip(q, made, SPEEDS, strict=True)))
        q = made
        if sample.state is State.IDLE:
            break
    return worst


def test_a_belt_that_jumps_is_stretched_over_periods_and_caught_up() -> None:
    rig = joined(START)
    for piece in straight(START, END):
        rig.load(piece)
    rows = [rig.q]
    for k in range(900):
        made = rig.step(translation(0.0, 0.02 if k > 200 else 0.0, 0.0))
        rows.append(made.q)
        if k == 201:
            assert made.short, "20 mm in one period"
    assert float(shares(rows).max()) <= 1.0 + 1e-9
    assert apart(ROBOT.forward(made.q), translation(0.0, 0.02, 0.0) @ END) < 1e-9 and made.share == 1.0


def test_carried_out_of_reach_the_joints_stay_the_path_stops_and_place_goes_on() -> None:
    rig = joined(START)
    for piece in straight(START, END, speed=0.1):
        rig.load(piece)
    for k in range(3000):
        made = rig.step(translation(0.4 * k * MS, 0.0, 0.0))
        if rig.fault is not None:
            break
    assert isinstance(rig.fault, Unreachable) and made.short
    held = made.q
    for _ in range(300):
        made = rig.step(translation(2.0, 0.0, 0.0))
        assert made.q == held
    assert made.path.state is State.STOPPED


def test_what_getting_on_leaves_to_the_path_adds_up_to_the_limits() -> None:
    along, axes = (1.0, -0.5, 0.0), LIMITS[:3]
    accel, jerk = borne(along, axes)
    assert accel == pytest.approx(min(0.9 * axes[0].accel, 1.8 * axes[1].accel))
    assert jerk == pytest.approx(min(0.7 * axes[0].jerk, 1.4 * axes[1].jerk))
    for by_accel, by_jerk in ((0.6 * accel, 0.1 * jerk), (0.1 * accel, jerk), (0.0, 0.0)):
        share = left_over(along, axes, by_accel, by_jerk)
        sums = [
            (0.9 * share**2 + abs(p) * by_accel / axis.accel, 0.7 * share**3 + abs(p) * by_jerk / axis.jerk)
            for p, axis in zip(along, axes, strict=True)
            if p
        ]
        assert max(max(pair) for pair in sums) == pytest.approx(1.0) if share < 1.0 else by_accel == 0.0
    assert left_over(along, axes, 2 * axes[0].accel, 0.0) == 0.0


def test_additional_axes_go_through_and_the_wrong_number_of_limits_is_refused() -> None:
    start, end = down(0.35, -0.2, 0.3), down(0.35, 0.1, 0.3)
    q = (*ROBOT.inverse(start, (0.0, 0.5, 1.2, 0.0, 1.0, 0.0)), 0.25)
    rig = SyncStepper(Stepper(7, MS, q), ROBOT, SPEEDS, MS, q)
    for piece in straight(start, end):
        rig.load(piece)
    for _ in range(50):
        made = rig.step(translation(0.0, 0.01, 0.0))
    assert made.q[6] == 0.25 and len(made.q) == 7
    with pytest.raises(MotionError):
        SyncStepper(Stepper(6, MS, q[:6]), ROBOT, SPEEDS[:5], MS, q)
    with pytest.raises(MotionError):
        rig.set_override(1.5)


def test_place_begins_a_path_in_the_frame_in_which_the_robot_stands() -> None:
    rig = joined(START)
    frame = translation(0.05, 0.02, 0.0)
    rig.place(frame)
    assert apart(frame @ ROBOT.forward(rig.step(frame).path.q), START) < 1e-9
    seen = frame.inverse() @ START
    for piece in straight(seen, down(0.3, 0.1, 0.3)):
        rig.load(piece)
    rows = [rig.q]
    for _ in range(1200):
        made = rig.step(frame)
        rows.append(made.q)
    assert made.path.state is State.IDLE and apart(ROBOT.forward(made.q), frame @ down(0.3, 0.1, 0.3)) < 1e-9
    assert float(shares(rows).max()) <= 1.0


def synchron(speed: float = 300.0, accel: float = 5.0, jerk: float = 200.0) -> tuple[list[float], list[float], Carried]:
    """SYNCHRON onto a running belt, 0.4 s on it, SYNCHRON_END: place of the frame and of the belt (m), every ms."""
    conveyor = Conveyor(cycle_s=4e-3, period_s=MS)
    part = ParallelPart(conveyor.belts.belt(1), Carrier(factors=(0.0, 1.0, 0.0)))
    carried = Carried(part, Tracker(MS, MS), Coupling(accel, jerk))
    places, belt = [], []
    for k in range(1600):
        conveyor.run(speed)
        carried.step(MS)
        if k == 300:
            carried.engage()
        if k == 1000:
            carried.release()
        places.append(carried.frame.position[1])
        belt.append(conveyor.ways[0] + speed * 1e-3 * MS)
    return places, belt, carried


def test_the_robot_gets_up_to_the_belt_and_down_again_within_acceleration_and_jerk() -> None:
    places, belt, carried = synchron()
    on = [abs(a - b) for a, b in zip(places[600:1000], belt[600:1000], strict=True)]
    assert max(on) < 1e-4, "where the belt will be when the set value acts"
    assert carried.coupling.state is Hold.OFF and places[-1] == places[-200], "comes to rest"
    window = 20  # ms: the encoder's steps are not the law's
    rows = np.array(places[301:])
    smooth = np.convolve(rows, np.full(window, 1 / window), "valid")
    speed = np.diff(smooth) / MS
    accel = (speed[window:] - speed[:-window]) / (window * MS)
    assert float(np.abs(accel).max()) <= 5.0 * 1.15
    assert float(speed.min()) > -0.02 and float(speed.max()) < 0.46, "1.52 x the belt while it makes good what it is behind"
    assert float(np.abs(np.diff(rows)).max()) < 0.5 * MS, "no jump"


def test_engaging_twice_and_limits_of_what_is_reported() -> None:
    _, _, carried = synchron()
    carried.engage()
    with pytest.raises(MotionError, match="catching"):
        carried.engage()
    with pytest.raises(MotionError):
        Tracker(0.0, 1e-3)


def test_the_filter_follows_a_varying_belt_to_a_stop_and_knows_the_delay() -> None:
    for delay, rms, most in ((1, 0.05, 0.2), (4, 0.06, 0.3)):
        tracker, place, ways = Tracker(MS, delay * MS), 0.0, []
        for k in range(4000 + delay):
            speed = 0.3 * (1 + 0.1 * math.sin(2 * math.pi * k * MS)) * min(max(1 - (k - 3000) / 300, 0.0), 1.0)
            place += speed * MS
            ways.append(place)
        errors = []
        for k in range(4000):
            tracker.update((math.floor(ways[k] / 1e-4) + 0.5) * 1e-4, at_rest=k > 3310)
            if k > 150:
                errors.append(tracker.ahead() - ways[k + delay])
        assert math.sqrt(sum(e * e for e in errors) / len(errors)) * 1e3 < rms
        assert max(map(abs, errors)) * 1e3 < most
        assert tracker.speed == 0.0


def test_shares_that_joints_allow() -> None:
    assert allowed((1.0,), (0.0,), (2.0,)) == 1.0
    assert allowed((2.0,), (0.0,), (1.0,), top=1.0) == pytest.approx(0.5)
    assert allowed((2.0,), (0.5,), (1.0,), top=1.0) == pytest.approx(0.25)
    assert allowed((-2.0,), (0.5,), (1.0,), top=1.0) == pytest.approx(0.75), "the path goes against the belt"
    assert allowed((1.0, 0.0), (0.0, 1.0), (1.0, 1.0), top=1.0) == 0.0
    assert [axis.speed for axis in reserved(LIMITS[:2], (0.5, -99.0))] == pytest.approx([LIMITS[0].speed - 0.5, 0.1 * LIMITS[1].speed])
    with pytest.raises(MotionError):
        reserved(LIMITS, (0.1,))


def test_a_round_table_carries_the_tool_round() -> None:
    rig = joined(START)
    carrier = Carrier(axis=(0.0, 0.0, 1.0), centre=(0.45, 0.0, 0.0))
    for piece in straight(START, END, speed=0.2):
        rig.load(piece)
    rows = [rig.q]
    for k, _ in itertools.product(range(1500), (0,)):
        frame = carrier.frame(0.2 * k * MS)
        made = rig.step(frame)
        rows.append(made.q)
        assert apart(ROBOT.forward(made.q), frame @ ROBOT.forward(made.path.q)) < 1e-9
    assert float(shares(rows).max()) <= 1.0 and len(LIMITS) == 6
