"""rho 3 Releases part 1, section 6: program slope, block slope, and what is never passed, on whole paths."""

import numpy as np
import pytest

from hil_tests.lab.cells.arms import Array, at, portal, robot
from motion.paths.joints import joined, joint_line, joint_part
from motion.planner.route import Route
from motion.planner.stretch import Kind, Stretch
from motion.program.blocks import Blend, Block, Interpolation, JointTarget, PoseTarget, Rounding, Slope
from motion.program.passing import Passing, Presets
from motion.program.slopes import earliest, frozen, overlap, ramped, summed, within
from motion.timing.jerk import jerk_limited
from motion.timing.limits import law_limits

LIMITS = portal().limits
R20 = Blend(Rounding.CARTESIAN, 0.02, 0.02)
LINEAR, PTP, CIRCULAR = Interpolation.LINEAR, Interpolation.PTP, Interpolation.CIRCULAR


def stretches(blocks: list[Block]) -> list[Stretch]:
    route = Route(portal(), (0.0, 0.0, 0.0))
    for block in blocks:
        route.add(block)
    route.finish()
    return route.take()


def places(row: list[Stretch]) -> Array:
    return np.concatenate([s.path.at(np.linspace(0.0, s.path.length, 400))[:, :3] for s in row])


def missed(row: list[Stretch], point: tuple[float, float, float]) -> float:
    return float(np.min(np.linalg.norm(places(row) - np.array(point), axis=1)))


@pytest.mark.requirement("RHO-MOT-04", by="motion.program.slopes:earliest")
@pytest.mark.requirement("RHO-MOT-04", by="motion.program.slopes:overlap")
@pytest.mark.requirement("RHO-MOT-04", by="motion.program.slopes:summed")
def test_block_slope_starts_the_next_block_not_before_the_middle_and_saves_t_b() -> None:
    up, over = joint_line((0.0, 0.0, 0.0), (0.0, 0.0, 0.025)), joint_line((0.0, 0.0, 0.025), (0.3, 0.0, 0.025))
    first, second = ramped(up, LIMITS), ramped(over, LIMITS)
    start = earliest(first, 0.05)
    assert start == pytest.approx(first.duration / 2, rel=1e-6), "not before the middle, however large the range"
    assert earliest(first, 0.005) > start
    found = overlap(first, second, start, LIMITS)
    assert found is not None
    assert found.start >= start - 1e-9 and found.shorter == pytest.approx(first.duration - found.start)
    whole = first.duration + second.duration - found.shorter
    grid = np.arange(0.0, whole + 0.002, 0.001)
    q = summed(first, second, found.start, grid)
    assert q[-1] == pytest.approx([0.3, 0.0, 0.025], abs=1e-9), "both added end at the target t_b earlier"
    assert float(np.abs(q[int((whole - 0.004) * 1000)] - q[-1]).max()) > 1e-7, "and no sooner"
    for order, name in ((1, "speed"), (2, "accel"), (3, "jerk")):
        limits = np.array([getattr(axis, name) for axis in LIMITS])
        assert float(np.max(np.abs(np.diff(q, order, axis=0)) / 0.001**order / limits)) <= 1.02
    assert first.duration + second.duration == pytest.approx(0.3635, abs=1e-3) and whole == pytest.approx(0.3168, abs=2e-3)


@pytest.mark.requirement("RHO-MOT-04", by=("motion.program.slopes:overlap", "motion.program.slopes:within"))
def test_the_start_is_delayed_where_the_sum_would_exceed_the_limits() -> None:
    """A sharp reversal: at the earliest start both accelerations point the same way and add up to twice the limit."""
    there, back = joint_line((0.0, 0.0, 0.0), (0.2, 0.0, 0.0)), joint_line((0.2, 0.0, 0.0), (0.05, 0.02, 0.0))
    first, second = ramped(there, LIMITS), ramped(back, LIMITS)
    start = earliest(first, 0.05)
    assert not within(first, second, start, LIMITS)
    found = overlap(first, second, start, LIMITS)
    assert found is not None and found.start > start + 0.01
    assert within(first, second, found.start, LIMITS)


@pytest.mark.requirement("RHO-MOT-04", by="motion.program.slopes:overlap")
def test_the_overlapped_block_ends_before_the_middle_of_the_next_one() -> None:
    long, short = joint_line((0.0, 0.0, 0.0), (0.4, 0.0, 0.0)), joint_line((0.4, 0.0, 0.0), (0.4, 0.004, 0.0))
    first, second = ramped(long, LIMITS), ramped(short, LIMITS)
    found = overlap(first, second, earliest(first, 0.2), LIMITS)
    assert found is not None and found.reach <= 0.5 * 0.004 + 1e-9


def test_the_frozen_curve_is_the_sum_and_joins_both_paths() -> None:
    up, over = joint_line((0.0, 0.0, 0.0), (0.0, 0.0, 0.025)), joint_line((0.0, 0.0, 0.025), (0.3, 0.0, 0.025))
    first, second = ramped(up, LIMITS), ramped(over, LIMITS)
    found = overlap(first, second, earliest(first, 0.0125), LIMITS)
    assert found is not None
    made = frozen(first, second, found)
    assert made is not None
    curve = made[0]
    dense = curve.at(np.linspace(0.0, curve.length, 4000))[:, :3]
    sums = summed(first, second, found.start, np.linspace(found.start, first.duration, 50))
    away = max(float(np.min(np.linalg.norm(dense - row, axis=1))) for row in sums)
    assert away < 1e-5
    assert dense[0] == pytest.approx([0.0, 0.0, 0.025 - found.leave], abs=1e-9)
    assert dense[-1] == pytest.approx([found.reach, 0.0, 0.025], abs=1e-9)


@pytest.mark.requirement("RHO-MOT-04", by="motion.planner.route:Route._join_slopes")
def test_block_slope_in_a_program_rounds_the_point_and_outside_the_range_the_path_is_untouched() -> None:
    row = stretches([Block(LINEAR, at(0, 0, 50), blend=R20, slope=Slope.BLOCK), Block(LINEAR, at(200, 0, 50), slope=Slope.BLOCK)])
    assert [s.kind for s in row if s.kind is Kind.CORNER] == [Kind.CORNER]
    assert 0.001 < missed(row, (0.0, 0.0, 0.05)) < 0.02
    outside = places(row)[np.linalg.norm(places(row) - np.array([0.0, 0.0, 0.05]), axis=1) > 0.0215]
    assert float(np.max(np.minimum(np.abs(outside[:, 0]), np.abs(outside[:, 2] - 0.05)))) < 1e-9


@pytest.mark.requirement("RHO-MOT-05", by="motion.program.passing:passed")
def test_r_20_before_or_after_a_circle_goes_exactly_through_the_point() -> None:
    arc = Block(CIRCULAR, at(200), PoseTarget(at(150, 50).pose), blend=R20)
    row = stretches([Block(LINEAR, at(100), blend=R20), arc, Block(LINEAR, at(300), blend=R20), Block(LINEAR, at(300, 100))])
    assert missed(row, (0.1, 0.0, 0.0)) < 1e-9 and missed(row, (0.2, 0.0, 0.0)) < 1e-9
    assert missed(row, (0.3, 0.0, 0.0)) > 0.003, "the corner between two lines is passed"
    assert [s.block for s in row if s.stop] == [1, 2, 4]


@pytest.mark.requirement("RHO-MOT-06", by="motion.planner.route:Route._join")
def test_a_change_of_type_is_passed_with_program_slope_and_not_with_block_slope() -> None:
    def row(slope: Slope) -> list[Stretch]:
        return stretches(
            [Block(PTP, JointTarget((0.1, 0.0, 0.0)), blend=R20, slope=slope), Block(LINEAR, at(100, 100), slope=slope, blend=R20)]
        )

    assert missed(row(Slope.BLOCK), (0.1, 0.0, 0.0)) < 1e-9
    assert [s.block for s in row(Slope.BLOCK) if s.stop][:1] == [1]
    rounded = row(Slope.PROGRAM)
    assert missed(rounded, (0.1, 0.0, 0.0)) > 0.001
    assert not any(s.stop for s in rounded[:-1])
    outside = places(rounded)[np.linalg.norm(places(rounded) - np.array([0.1, 0.0, 0.0]), axis=1) > 0.02 + 1e-9]
    assert float(np.max(np.minimum(np.abs(outside[:, 1]), np.abs(outside[:, 0] - 0.1)))) < 1e-9, "left only inside the sphere"


@pytest.mark.requirement("RHO-MOT-07", by="motion.planner.route:Route._leave")
def test_r_0_goes_exactly_through_the_point_and_r_20_does_not() -> None:
    def row(radius: float) -> list[Stretch]:
        return stretches([Block(LINEAR, at(100), blend=Blend(Rounding.CARTESIAN, radius, radius)), Block(LINEAR, at(100, 100))])

    assert missed(row(0.0), (0.1, 0.0, 0.0)) < 1e-9 and row(0.0)[0].stop
    assert missed(row(0.02), (0.1, 0.0, 0.0)) == pytest.approx(0.1875 * 0.02 * 2**0.5, abs=1e-6) and not row(0.02)[0].stop


@pytest.mark.requirement("RHO-MOT-07", by="motion.planner.ranges:axis_range")
def test_r_ptp_0_stops_exactly_at_the_point_on_either_slope_and_r_ptp_1_passes_it() -> None:
    passing = Passing(Presets(0.0, 1.0, axes=(0.02, 0.02, 0.02)))

    def row(factor: float, slope: Slope) -> list[Stretch]:
        found = passing.block(PTP, factor=factor)
        blend = Blend(Rounding.JOINT, found.radius, found.radius, axes=found.axes)
        path = [Block(PTP, JointTarget(q), blend=blend, slope=slope) for q in ((0.2, 0.0, 0.0), (0.2, 0.2, 0.0), (0.0, 0.2, 0.1))]
        return stretches(path)

    for slope in Slope:
        exact, round_ = row(0.0, slope), row(1.0, slope)
        for point in ((0.2, 0.0, 0.0), (0.2, 0.2, 0.0)):
            assert missed(exact, point) < 1e-9 and missed(round_, point) > 1e-4, slope
        assert [s.kind for s in exact] == [Kind.MAIN] * 3 and all(s.stop for s in exact), slope
        assert not any(s.stop for s in round_[:-1]), slope
    one = passing.block(PTP, factor=0.0)
    alone = stretches([Block(PTP, JointTarget((0.2, 0.0, 0.0)), blend=Blend(Rounding.JOINT, axes=one.axes)), Block(LINEAR, at(100, 100))])
    assert missed(alone, (0.2, 0.0, 0.0)) < 1e-9 and alone[0].stop, "into a LINEAR block too"


def outside(row: list[Stretch], corner: tuple[float, float, float], radius: float) -> Array:
    every = places(row)
    return np.asarray(every[np.linalg.norm(every - np.array(corner), axis=1) > radius + 1e-9])


@pytest.mark.requirement("RHO-MOT-02", by="motion.planner.route:Route._corner")
def test_r_20_leaves_the_path_only_inside_its_sphere_and_is_tangent_where_it_enters_and_leaves_it() -> None:
    row = stretches([Block(LINEAR, at(100), blend=R20), Block(LINEAR, at(100, 100))])
    assert [s.kind for s in row] == [Kind.MAIN, Kind.CORNER, Kind.MAIN]
    assert missed(row, (0.1, 0.0, 0.0)) > 0.001
    away = outside(row, (0.1, 0.0, 0.0), 0.02)
    assert float(np.max(np.minimum(np.abs(away[:, 1]), np.abs(away[:, 0] - 0.1)))) < 1e-9, "programmed path outside of the sphere"
    rounded = row[1].path
    ends = rounded.at(np.array([0.0, rounded.length]), 0)[:, :3]
    assert ends == pytest.approx(np.array([[0.08, 0.0, 0.0], [0.1, 0.02, 0.0]]), abs=1e-9)
    directions = rounded.at(np.array([0.0, rounded.length]), 1)[:, :3]
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    assert directions == pytest.approx(np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), abs=1e-9), "tangent"


@pytest.mark.requirement("RHO-MOT-03", by="motion.paths.corner:clipped")
@pytest.mark.requirement("RHO-MOT-03", by="motion.planner.route:Route._ranges")
def test_points_10_apart_with_r_20_are_passed_by_the_largest_overlap_there_is() -> None:
    corners = [(0.01, 0.0, 0.0), (0.01, 0.01, 0.0), (0.02, 0.01, 0.0)]
    row = stretches([Block(LINEAR, at(x, y), blend=R20) for x, y in ((10, 0), (10, 10), (20, 10), (20, 20))])
    assert [s.kind for s in row].count(Kind.CORNER) == 3 and not any(s.stop for s in row[:-1])
    largest = 0.1875 * 0.005 * 2**0.5  # the half of 10 mm each
    assert [missed(row, corner) for corner in corners] == pytest.approx([largest] * 3, abs=2e-6)
    short = stretches([Block(LINEAR, at(x, y), blend=R20) for x, y in ((100, 0), (100, 10), (200, 10))])
    assert missed(short, (0.1, 0.0, 0.0)) == pytest.approx(largest, abs=2e-6), "the long side shrinks with the short one: one sphere"
    assert next(s for s in short if s.kind is Kind.CORNER).path.q(0.0)[0] == pytest.approx(0.095, abs=1e-9)
    free = stretches([Block(LINEAR, at(x, y), blend=R20) for x, y in ((50, 0), (50, 50))])
    assert missed(free, (0.05, 0.0, 0.0)) == pytest.approx(4 * largest, abs=2e-6), "not reduced where there is room"


@pytest.mark.requirement("RHO-MOT-01", by=("motion.planner.ranges:axis_range", "motion.planner.route:Route._corner"))
@pytest.mark.requirement("RHO-MOT-01", by="motion.program.passing:Passing.block")
def test_r_ptp_2_passes_the_point_within_twice_p213_and_no_axis_changes_its_speed_in_a_step() -> None:
    """P213: 20 mm of the axes; R_PTP 1 and 2."""
    passing = Passing(Presets(0.0, 1.0, axes=(0.02, 0.02, 0.02)))

    def row(factor: float) -> list[Stretch]:
        found = passing.block(PTP, factor=factor)
        first = Block(PTP, JointTarget((0.2, 0.0, 0.0)), blend=Blend(Rounding.JOINT, axes=found.axes))
        return stretches([first, Block(PTP, JointTarget((0.2, 0.2, 0.0)))])

    for factor in (1.0, 2.0):
        before, rounded, after = row(factor)
        assert rounded.kind is Kind.CORNER and before.path.q(before.path.length)[0] == pytest.approx(0.2 - 0.02 * factor, abs=1e-9)
        assert rounded.path.q(rounded.path.length)[1] == pytest.approx(0.02 * factor, abs=1e-9), "doubled"
        assert len(outside([before, rounded, after], (0.2, 0.0, 0.0), 0.02 * factor)) > 100
        assert not before.stop and not rounded.stop
        for one, other in ((before, rounded), (rounded, after)):
            ends = [s.path.at(np.array([at_s]), 1)[0, :3] for s, at_s in ((one, one.path.length), (other, 0.0))]
            speeds = [end / np.linalg.norm(end) for end in ends]
            assert speeds[0] == pytest.approx(speeds[1], abs=1e-9), "from block to block without a corner"
    uneven = Blend(Rounding.JOINT, axes=(0.02, 0.03, 0.02))
    before, _, _ = stretches([Block(PTP, JointTarget((0.2, 0.1, 0.0)), blend=uneven), Block(PTP, JointTarget((0.2, 0.3, 0.2)))])
    assert before.path.q(before.path.length)[:2] == pytest.approx((0.18, 0.09), abs=1e-9), "the first axis that comes near begins"


def test_two_ptp_blocks_with_block_slope_and_axis_ranges() -> None:
    axes = Blend(Rounding.JOINT, axes=(0.02, 0.02, 0.02))
    row = stretches(
        [
            Block(PTP, JointTarget((0.2, 0.0, 0.0)), blend=axes, slope=Slope.BLOCK),
            Block(PTP, JointTarget((0.2, 0.2, 0.0)), slope=Slope.BLOCK),
        ]
    )
    assert [s.kind for s in row] == [Kind.MAIN, Kind.CORNER, Kind.MAIN]
    assert row[0].path.length >= 0.18 - 1e-9


@pytest.mark.requirement("RHO-MOT-04", by="motion.program.slopes:frozen")
def test_the_frozen_curve_joins_slope_and_bend_of_blocks_that_move_several_axes() -> None:
    """Also where the parameter of a block is the travel of one axis and not the way of all of them."""
    machine = robot("tx60-like")
    first, second, third = (0.0, 0.5, 1.5, 0.0, 1.0, 0.0), (1.4, -0.3, 2.0, 1.0, -0.7, 1.7), (0.3, 0.5, 1.0, 0.0, 0.7, 0.2)
    legs = [joint_line(first, second), joint_line(second, third)]
    before, after = (ramped(leg, machine.limits) for leg in legs)
    found = overlap(before, after, earliest(before, 0.3), machine.limits)
    assert found is not None
    made = frozen(before, after, found)
    assert made is not None
    curve = made[0]
    for order in (1, 2):
        ends = curve.at(np.array([0.0, curve.length]), order)[:, :6]
        theirs = [leg.at(np.array([s]), order)[0, :6] for leg, s in zip(legs, (legs[0].length - found.leave, found.reach), strict=True)]
        assert ends == pytest.approx(np.array(theirs), abs=1e-6), f"derivative {order}"
    whole = joined([joint_part(legs[0], 0.0, legs[0].length - found.leave), curve, joint_part(legs[1], found.reach, legs[1].length)])
    assert jerk_limited(whole, law_limits(machine.limits)).duration < before.duration + after.duration
