"""rho 3 Releases part 1, TO04 sections 15 and 16: synchronous parts of belt types 2 and 3, and TO08 section 4: the endless belt."""

import itertools
import math
from functools import partial

import pytest

from hil_tests.unit.motion.sync.belt_lab import CYCLE, MM, Conveyor, code
from motion.errors import MotionError
from motion.geometry.frames import NO_ROTATION, Pose
from motion.program.blocks import Interpolation
from motion.sync.belts import Condition, Sync
from motion.sync.cam import LEAST, Cam, cam, section
from motion.sync.errors import BeltError
from motion.sync.pace import Pace
from motion.sync.parallel import Carrier, ParallelPart
from motion.sync.synchronous_part import BeltBlock, Phase, SynchronPart

GENTLE = Pace(accel=2.0, decel=2.0)


def part_of(conveyor: Conveyor, kind: int = 2, at: float = 50.0, kinematic: int = 1, robot: tuple[float, ...] = (0.0,)) -> SynchronPart:
    conveyor.belts.belt_type(1, kind)
    return SynchronPart(conveyor.belts.belt(1), kinematic, robot, at * MM)


def block(robot: float, belt: float, pace: Pace = GENTLE, first: float = 0.0, third: float = 0.0) -> BeltBlock:
    return BeltBlock((robot * MM,), belt * MM, pace=pace, first=first, third=third)


def follow(conveyor: Conveyor, part: SynchronPart, speed: float, periods: int) -> list[tuple[float, float]]:
    """(belt, robot) mm of every cycle."""
    rows = []
    conveyor.run(speed, periods=periods, each=lambda: rows.append((conveyor.counter(), part.step()[0] / MM)))
    return rows


@pytest.mark.requirement("RHO-MOT-23", by="motion.sync.synchronous_part:SynchronPart.step")
@pytest.mark.requirement("RHO-MOT-23", by="motion.sync.pace:Pace.next_speed")
def test_robot_and_belt_reach_the_end_points_of_the_manual_s_program_together() -> None:
    conveyor = Conveyor()
    part = part_of(conveyor)
    for target, value in ((150, 200), (150, 240), (0, 360)):
        part.add(block(target, value))
    rows = follow(conveyor, part, 200.0, 200)
    step = 200.0 * CYCLE
    for belt, robot in rows:
        if belt < 50:
            assert robot == 0.0, "waits for belt value 50"
        if 200 + step <= belt <= 240:
            assert robot == pytest.approx(150.0), "the block that only waits for the belt"
        if belt > 360 + step:
            assert robot == pytest.approx(0.0)
        if belt < 200 - 2 * step:
            assert robot < 150 - 1e-6, "not before the belt"
    at_200 = next(robot for belt, robot in rows if belt >= 200 + step)
    assert at_200 == pytest.approx(150.0)
    speeds = [(b - a) * MM / CYCLE for (_, a), (_, b) in itertools.pairwise(rows)]
    changes = [abs(b - a) / CYCLE for a, b in itertools.pairwise(speeds)]
    assert max(changes) < 2.0 * 1.02, "the programmed acceleration"
    assert max(speeds) > 0.15, "not the programmed but the needed speed"
    assert part.passed == 3 and part.phase is Phase.BETWEEN


@pytest.mark.requirement("RHO-MOT-23", by="motion.sync.synchronous_part:SynchronPart.add")
def test_ptp_gives_23_circular_with_the_cam_20_and_a_zero_belt_difference_89() -> None:
    for kind in (2, 3):
        part = part_of(Conveyor(), kind)
        assert code(partial(part.add, BeltBlock((0.1,), 0.2, Interpolation.PTP))) == 23
        part = part_of(Conveyor(), kind)
        assert code(partial(part.add, block(150, 50))) == 89
        part = part_of(Conveyor(), kind)
        assert code(partial(part.add, BeltBlock((0.1,), 0.0, relative=True))) == 89
        part.phase = Phase.WAITING
        part.add(BeltBlock((0.15,), 0.15, relative=True))
        assert part._legs[0].end == pytest.approx(0.2), "MOVE_REL as first block"
    part = part_of(Conveyor(), 3)
    with pytest.raises(BeltError) as fault:
        part.add(BeltBlock((0.1,), 0.2, Interpolation.CIRCULAR))
    assert fault.value.code == 20 and fault.value.codes == (20, 528) and fault.value.opens_ready
    with pytest.raises(MotionError):
        part_of(Conveyor(), 2).add(BeltBlock((math.nan,), 0.2))


def test_speed_changes_of_the_belt_are_followed_to_the_point_and_onward_blocks_do_not_stop() -> None:
    conveyor = Conveyor()
    part = part_of(conveyor, 122)
    part.add(block(100, 150))
    part.add(block(250, 300))
    rows: list[tuple[float, float]] = []
    for k in range(200):
        rows += follow(conveyor, part, 200.0 * (1 + 0.1 * math.sin(2 * math.pi * k * CYCLE)), 1)
    speeds = [(b - a) * MM / CYCLE for (_, a), (_, b) in itertools.pairwise(rows)]
    inner = [v for v, (belt, _) in zip(speeds, rows, strict=False) if 110 < belt < 200]
    assert min(inner) > 0.15, "collinear blocks are run through"
    assert rows[-1][1] == pytest.approx(250.0)
    missed = [abs(robot - 100) for belt, robot in rows if abs(belt - 150) < 1.2]
    assert max(missed) < 6.0
    done = next(belt for belt, robot in rows if robot >= 250 - 1e-6)
    assert abs(done - 300) <= 2 * 2.2


@pytest.mark.requirement("RHO-MOT-24", by="motion.sync.synchronous_part:SynchronPart._check_tolerance")
def test_more_than_five_cycles_of_belt_way_at_a_block_give_944_of_kinematic_1() -> None:
    for kinematic, tens, cycles in ((1, 0, 5), (3, 7, 7)):
        for late, wrong in ((cycles, False), (cycles + 1, True)):
            conveyor = Conveyor()
            part = part_of(conveyor, 10 * tens + 2, kinematic=kinematic)
            part.add(block(100, 100))
            follow(conveyor, part, 100.0, 100)  # belt at 100, 1 mm a cycle
            assert part.phase is Phase.BETWEEN
            follow(conveyor, part, 100.0, late)
            part.add(block(200, 300))
            found = code(part.step)
            assert found == ((943 + kinematic) if wrong else 0), (cycles, late)
    slow = Conveyor()
    part = part_of(slow, 2)
    part.add(block(100, 100, Pace(top=0.05, accel=2.0, decel=2.0)))
    with pytest.raises(BeltError) as fault:
        follow(slow, part, 100.0, 200)
    assert fault.value.code == 944 and 528 in fault.value.codes
    assert 105.0 <= slow.counter() <= 106.5, "5 cycles of 1 mm beyond the end"
    assert fault.value.display == "other errors"
    stands = part.step()
    slow.run(100.0, periods=10)
    assert part.step() == stands


def test_feed_hold_inside_the_part_aborts_with_944() -> None:
    conveyor = Conveyor()
    part = part_of(conveyor, 3, kinematic=10)
    part.add(block(100, 100))
    follow(conveyor, part, 100.0, 60)
    fault = part.hindered()
    assert fault.code == 953 and fault.opens_ready and part.phase is Phase.FAILED


@pytest.mark.requirement("RHO-MOT-25", by="motion.sync.synchronous_part:SynchronPart._check_direction")
def test_a_belt_that_runs_back_before_the_start_gives_928_528_and_opens_ready() -> None:
    for kind, kinematic in ((2, 1), (3, 1), (2, 10)):
        conveyor = Conveyor()
        part = part_of(conveyor, kind, kinematic=kinematic)
        part.add(block(150, 200))
        follow(conveyor, part, 100.0, 20)
        with pytest.raises(BeltError) as fault:
            follow(conveyor, part, -100.0, 1)
        assert fault.value.code == 927 + kinematic
        assert fault.value.codes == (927 + kinematic, 528) and fault.value.opens_ready
        assert part.phase is Phase.FAILED
    standing = Conveyor()
    standing.belts.belt_parameters(1, 25.0, 25.0, 0)
    part = part_of(standing)
    part.add(block(150, 200))
    follow(standing, part, -15.0, 10)
    assert part.phase is Phase.WAITING, "hunting below the threshold is not a running back"


@pytest.mark.requirement("RHO-MOT-25", by="motion.sync.synchronous_part:SynchronPart.add")
def test_belt_values_that_turn_round_inside_a_part_give_928() -> None:
    part = part_of(Conveyor())
    part.add(block(150, 200))
    assert code(lambda: part.add(block(0, 100))) == 928
    falling = part_of(Conveyor(), 2, at=0.0)
    falling.add(block(150, -200))
    assert code(lambda: falling.add(block(0, -100))) == 928


@pytest.mark.requirement("RHO-MOT-26", by="motion.sync.belt_state:Watch.update")
@pytest.mark.requirement("RHO-MOT-26", by="motion.sync.belt_state:Watch.parametrise")
def test_below_the_stop_threshold_the_robot_is_braked_to_0_without_a_tolerance_error() -> None:
    conveyor = Conveyor()
    conveyor.belts.belt_parameters(1, 25.0, 50.0, 300)
    part = part_of(conveyor)
    part.add(block(150, 200))
    part.add(block(0, 400))
    follow(conveyor, part, 200.0, 60)
    assert part.speed > 0.1
    rows = follow(conveyor, part, 8.0, 100)
    assert part.speed == 0.0 and rows[-1][1] == rows[-20][1], "stands although the belt creeps at 8 mm/s"
    rows = follow(conveyor, part, 200.0, 250)
    assert part.phase is Phase.BETWEEN and rows[-1][1] == pytest.approx(0.0)
    stopped = Conveyor()
    stopped.belts.belt_parameters(1, 15.0, 50.0, 0)
    late = part_of(stopped)
    late.add(block(100, 100))
    follow(stopped, late, 100.0, 101)
    follow(stopped, late, 9.0, 200)
    late.add(block(200, 300))
    assert code(late.step) == 0, "18 mm off, but the belt counts as stopped"
    assert code(lambda: follow(stopped, late, 200.0, 1)) in (0, 944)


def test_the_belt_stops_and_starts_inside_a_block_and_both_still_end_together() -> None:
    conveyor = Conveyor()
    conveyor.belts.belt_parameters(1, 5.0, 20.0, 500)
    part = part_of(conveyor)
    part.add(block(150, 400))
    for speed in [*[300.0] * 30, *[300.0 - 10 * k for k in range(30)], *[0.0] * 50, *[10.0 * k for k in range(30)], *[300.0] * 120]:
        follow(conveyor, part, speed, 1)
    assert part.passed == 1 and part.position[0] == pytest.approx(0.15)


@pytest.mark.requirement("RHO-MOT-27", by="motion.sync.cam:Cam.at")
@pytest.mark.requirement("RHO-MOT-27", by="motion.sync.synchronous_part:SynchronPart.step")
def test_the_cam_of_the_manual_is_quadratic_to_80_linear_to_130_quadratic_to_200() -> None:
    conveyor = Conveyor(increment=1e-5)
    part = part_of(conveyor, 3)
    part.add(block(150, 200, first=section(100, 0.3, 1.0) * MM, third=section(100, 0.7, 1.0) * MM))
    rows = follow(conveyor, part, 100.0, 210)
    slope = 150.0 / (150.0 - 0.5 * (30 + 70))
    for belt, robot in rows:
        if belt <= 50:
            expected = 0.0
        elif belt <= 80:
            expected = slope * (belt - 50) ** 2 / 60
        elif belt <= 130:
            expected = slope * (belt - 65)
        elif belt < 200:
            expected = 150 - slope * (200 - belt) ** 2 / 140
        else:
            expected = 150.0
        assert robot == pytest.approx(expected, abs=1e-6), belt
    assert rows[-1][1] == pytest.approx(150.0)
    curve = Cam(0.15, 0.03, 0.07)
    for joint in (0.03, 0.08):
        (a, u), (b, v) = curve.at(joint - 1e-12), curve.at(joint + 1e-12)
        assert abs(a - b) < 1e-9 and abs(u - v) < 1e-6, "position and slope go on"
    assert curve.at(0.0) == (0.0, 0.0) and curve.at(0.15) == (1.0, 0.0)
    assert section(100, 0.2, 0.5, p5_ms=20) == pytest.approx(0.5), "A is limited to 2000 / P5^2 = 5"
    assert section(3, 0.2, 0.5, p5_ms=20) == pytest.approx(0.3)


def test_all_coordinates_follow_the_cam_by_their_differences_and_back_with_the_belt() -> None:
    conveyor = Conveyor()
    part = part_of(conveyor, 3, at=0.0, robot=(0.0, 1.0, 5.0))
    part.add(BeltBlock((0.1, 0.8, 5.0), 0.2, first=0.05, third=0.05))
    seen: list[tuple[float, ...]] = []
    conveyor.run(100.0, periods=100, each=lambda: seen.append(part.step()))
    for a, b, c in seen:
        assert (b - 1.0) == pytest.approx(-2 * a) and c == 5.0
    forward = seen[-1][0]
    conveyor.run(-100.0, periods=40, each=lambda: seen.append(part.step()))
    assert seen[-1][0] < forward - 0.02, "the kinematic moves back within the block"
    assert seen[-1] == pytest.approx(seen[59]), "on the same curve"
    conveyor.run(-100.0, periods=100, each=lambda: seen.append(part.step()))
    assert seen[-1] == pytest.approx((0.0, 1.0, 5.0)), "but not beyond its start"
    conveyor.run(100.0, periods=300, each=lambda: seen.append(part.step()))
    assert seen[-1] == pytest.approx((0.1, 0.8, 5.0)) and part.passed == 1


@pytest.mark.requirement("RHO-MOT-28", by="motion.sync.cam:cam")
def test_sections_below_1_percent_are_widened_and_too_long_ones_share_the_rest() -> None:
    narrow = cam(0.15, 0.0, 0.0)
    assert (narrow.first, narrow.third) == pytest.approx((0.0015, 0.0015))
    assert cam(0.15, 0.03, 0.0001).third == pytest.approx(0.0015)
    assert cam(0.15, 0.03, 0.07) == Cam(0.15, 0.03, 0.07)
    both = cam(0.1, 0.3, 0.1)
    assert both.first == pytest.approx(0.099 * 0.75) and both.third == pytest.approx(0.099 * 0.25)
    assert both.length - both.first - both.third == pytest.approx(LEAST * 0.1), "the second keeps 1 %"
    uneven = cam(0.1, 50.0, 0.0)
    assert uneven.third == pytest.approx(0.001) and uneven.first == pytest.approx(0.098)
    for curve in (both, uneven):
        shares = [curve.at(0.1 * k / 1000)[0] for k in range(1001)]
        assert all(a <= b for a, b in itertools.pairwise(shares)) and shares[-1] == 1.0
    for wrong in ((0.0, 0.1, 0.1), (0.1, -0.1, 0.1), (0.1, math.nan, 0.1), (math.inf, 0.1, 0.1)):
        with pytest.raises(MotionError):
            cam(*wrong)


@pytest.mark.requirement("RHO-MOT-29", by="motion.sync.belts:Belt.subtract")
@pytest.mark.requirement("RHO-MOT-29", by=("motion.sync.belts:Sync.met", "motion.sync.parallel:ParallelPart.value"))
def test_sync_bn1_1000_inside_subtracts_1000_and_the_frame_goes_on() -> None:
    conveyor = Conveyor()
    belt = conveyor.belts.belt(1)
    part = ParallelPart(belt)
    statement = Sync(belt, Condition.AT_LEAST, 1000 * MM, inside=True)
    counters, frames, times = [], [], 0
    for _ in range(405):
        conveyor.run(1000.0)
        if statement.met():
            times += 1
        counters.append(conveyor.counter())
        frames.append(part.carrier.frame(part.value(belt.way)).position[0])
    assert times == 4 and counters[-1] < 60.0 and max(counters) < 1010
    assert all(b - a == pytest.approx(0.01) for a, b in itertools.pairwise(frames))


def test_inside_the_part_no_sync_with_an_input_and_no_absolute_points_afterwards() -> None:
    conveyor = Conveyor()
    belt = conveyor.belts.belt(1)
    assert code(lambda: Sync(belt, Condition.INPUT, inside=True)) == 20
    parallel = ParallelPart(belt)
    parallel.point(Pose((0.1, 0.0, 0.0), NO_ROTATION), 0.1)
    cams = part_of(conveyor, 3, at=0.0)
    conveyor.run(1000.0, periods=101)
    assert Sync(belt, Condition.AT_LEAST, 1.0, inside=True).met()
    with pytest.raises(MotionError, match="MOVE_REL"):
        parallel.point(Pose((0.1, 0.0, 0.0), NO_ROTATION), 0.1)
    assert code(lambda: cams.add(block(1, 2000))) == 20


def test_a_point_meant_for_a_belt_value_is_met_when_the_belt_has_it() -> None:
    part = ParallelPart(Conveyor().belts.belt(1), Carrier(factors=(0.0, -1.0, 0.0)))
    seen = part.point(Pose((0.3, 0.2, 0.1), NO_ROTATION), 0.5)
    assert (part.carrier.frame(0.5) @ seen).position == pytest.approx((0.3, 0.2, 0.1))
    assert (part.carrier.frame(0.6) @ seen).position == pytest.approx((0.3, 0.1, 0.1))
    table = Carrier(axis=(0.0, 0.0, 1.0), centre=(1.0, 0.0, 0.0))
    assert table.frame(math.pi / 2).apply((2.0, 0.0, 0.3)) == pytest.approx((1.0, 1.0, 0.3))


def test_type_2_runs_on_circles_in_time_with_the_belt() -> None:
    conveyor = Conveyor()
    part = part_of(conveyor, 2, at=0.0, robot=(0.1, 0.0, 7.0))
    half = BeltBlock((-0.1, 0.0, 7.0), 0.3, Interpolation.CIRCULAR, pace=GENTLE, via=(0.0, 0.1, 7.0))
    part.add(half)
    part.add(BeltBlock((0.2, 0.0, 0.0), 0.3, Interpolation.CIRCULAR, relative=True, pace=GENTLE, via=(0.1, -0.1, 0.0)))
    seen: list[tuple[float, ...]] = []
    conveyor.run(200.0, periods=310, each=lambda: seen.append(part.step()))
    assert all(math.hypot(x, y) == pytest.approx(0.1) and z == 7.0 for x, y, z in seen)
    assert min(y for _, y, _ in seen) < -0.0999 < 0.0999 < max(y for _, y, _ in seen)
    assert seen[149][0] < -0.099 and seen[-1] == pytest.approx((0.1, 0.0, 7.0)) and part.passed == 2
    inner = [math.dist(a, b) / CYCLE for a, b in itertools.pairwise(seen[60:240])]
    assert min(inner) > 0.15, "tangential blocks are run through"
    for wrong in ((0.0, 0.1), (0.0, math.nan, 0.0), (0.0, 0.0, 7.0)):
        with pytest.raises(MotionError):
            part_of(Conveyor(), 2, at=0.0, robot=(0.1, 0.0, 7.0)).add(
                BeltBlock((-0.1, 0.0, 7.0), 0.3, Interpolation.CIRCULAR, via=wrong),
            )
    with pytest.raises(MotionError):
        part_of(Conveyor()).add(BeltBlock((0.1,), 0.3, Interpolation.SPLINE))


def test_belts_that_run_backwards_as_programmed_are_followed_too() -> None:
    for kind in (2, 3):
        conveyor = Conveyor(increment=-1e-4)
        part = part_of(conveyor, kind, at=-50.0)
        part.add(block(150, -200, first=30 * MM, third=30 * MM))
        part.add(block(0, -400, first=30 * MM, third=30 * MM))
        rows = follow(conveyor, part, -200.0, 215)
        assert all(robot == 0.0 for belt, robot in rows if belt > -50)
        assert max(robot for _, robot in rows) == pytest.approx(150.0, abs=0.5)
        assert rows[-1][1] == pytest.approx(0.0) and part.passed == 2
        assert code(partial(part.add, block(1, -300))) == 928


def test_a_cam_never_jumps_even_while_the_tolerance_is_not_judged() -> None:
    conveyor = Conveyor()
    conveyor.belts.belt_parameters(1, 10.0, 50.0, 5000)
    part = part_of(conveyor, 3, at=0.0)
    part.add(block(100, 100))
    follow(conveyor, part, 100.0, 150)
    assert not conveyor.belts.belt(1).watch.judges_tolerance
    part.add(block(0, 200))
    stands = part.position
    assert code(part.step) == 944, "50 mm beyond: on the curve it would jump by half of the way"
    assert part.position == stands == part.step()


def test_after_an_error_at_the_end_of_a_block_the_robot_stays_where_it_was_sent_last() -> None:
    conveyor = Conveyor()
    part = part_of(conveyor, 3, at=0.0)
    part.add(block(100, 100))
    part.add(block(200, 200))
    follow(conveyor, part, 100.0, 95)
    sent = part.position
    conveyor.run(3000.0)
    conveyor.run(10.0)
    assert code(part.step) == 944
    assert part.position == sent and part.step() == sent
