"""VAL 3, chapter 9.3: what the numbers of a trsf mean, and its instructions."""

import itertools
import math
from collections.abc import Callable

import pytest

from motion.geometry.conventions import VAL3
from motion.geometry.frames import IDENTITY
from motion.geometry.orientation import angle_between, between
from motion.val3.errors import RuntimeFault
from motion.val3.trsf import Trsf, align, distance, interpolate_c, interpolate_l, inverted, times, trsf_of

EXAMPLE = Trsf(250, 350, 450, 20, 10, 30)


def same(one: Trsf, two: Trsf, most: float = 1e-9) -> bool:
    return max(abs(a - b) for a, b in zip(one, two, strict=True)) <= most


def code(call: Callable[..., object], *arguments: object) -> int:
    """Number of the run-time error of a call; 0: it went through."""
    try:
        call(*arguments)
    except RuntimeFault as fault:
        return fault.code
    return 0


@pytest.mark.requirement("VAL-TRSF-01", by=("motion.geometry.conventions:rotation_xyz", "motion.geometry.conventions:Convention.pose"))
def test_20_10_30_turns_about_x_then_y_then_z_of_the_moving_frame() -> None:
    rows = (0.852869, -0.492404, 0.173648, 0.521281, 0.784102, -0.336824, 0.029696, 0.377786, 0.925417)
    pose = EXAMPLE.pose
    assert math.dist(pose.position, (0.25, 0.35, 0.45)) < 1e-12
    assert max(abs(a - b) for a, b in zip(pose.rotation, rows, strict=True)) < 1e-6


@pytest.mark.requirement("VAL-TRSF-01", by="motion.geometry.conventions:angles_xyz")
def test_the_angles_come_back_and_179_1_110_is_not_rewritten() -> None:
    assert same(trsf_of(EXAMPLE.pose), EXAMPLE)
    corner = Trsf(0, 0, 0, 179, 1, 110)
    assert same(trsf_of(corner.pose), corner), "doubt D12: it is canonical as it stands"
    assert same(trsf_of(Trsf(0, 0, 0, 0, 100, 0).pose), Trsf(0, 0, 0, 180, 80, 180)), "ry within +-90"
    assert same(trsf_of(Trsf(0, 0, 0, 20, 90, 15).pose), Trsf(0, 0, 0, 35, 90, 0), 1e-6), "ry = 90: rz = 0"


@pytest.mark.requirement("VAL-TRSF-02", by=("motion.val3.trsf:times", "motion.val3.trsf:inverted"))
def test_a_trsf_times_its_inverse_is_nothing_and_the_order_matters() -> None:
    other = Trsf(10, 0, 0, 0, 0, 90)
    assert inverted(other) == pytest.approx(Trsf(0, 10, 0, 0, 0, -90), abs=1e-9), "what lies behind is beside it after the turn"
    assert times(other, Trsf(1, 0, 0)) == pytest.approx(Trsf(10, 1, 0, 0, 0, 90), abs=1e-9)
    assert same(times(EXAMPLE, inverted(EXAMPLE)), Trsf())
    assert same(times(inverted(EXAMPLE), EXAMPLE), Trsf())
    assert not same(times(EXAMPLE, other), times(other, EXAMPLE), 1.0)


@pytest.mark.requirement("VAL-TRSF-03", by="motion.val3.trsf:interpolate_l")
def test_interpolate_l_at_0_1_and_one_half() -> None:
    start, end = Trsf(0, 0, 0, 0, 0, 10), Trsf(100, -50, 20, 0, 0, 50)
    assert same(interpolate_l(start, end, 0), start)
    assert same(interpolate_l(start, end, 1), end)
    assert same(interpolate_l(start, end, 0.5), Trsf(50, -25, 10, 0, 0, 30))
    assert same(interpolate_l(start, end, -0.5), Trsf(-50, 25, -10, 0, 0, -10)), "before the start"
    assert same(interpolate_l(start, end, 1.5), Trsf(150, -75, 30, 0, 0, 70)), "behind the end"
    for outside in (-1, 2, 2.5, math.nan):
        assert code(interpolate_l, start, end, outside) == 70


def test_interpolate_l_turns_by_the_least_rotation_and_refuses_a_half_turn() -> None:
    start, end = Trsf(0, 0, 0, 80, 20, -30), Trsf(0, 0, 0, -60, 10, 170)
    whole = angle_between(start.pose.rotation, end.pose.rotation)
    for part in (0.25, 0.5, 0.9):
        there = interpolate_l(start, end, part).pose.rotation
        assert abs(angle_between(start.pose.rotation, there) - part * whole) < 1e-9
        assert abs(angle_between(there, end.pose.rotation) - (1 - part) * whole) < 1e-9
    assert code(interpolate_l, Trsf(), Trsf(0, 0, 0, 180), 0.5) == 553


@pytest.mark.requirement("VAL-TRSF-04", by="motion.val3.trsf:interpolate_c")
def test_interpolate_c_has_the_middle_of_the_arc_at_one_half() -> None:
    start, via, end = (
        Trsf(100, 0, 0),
        Trsf(100 * math.cos(0.3), 100 * math.sin(0.3), 0),
        Trsf(-100 * math.cos(1.2), 100 * math.sin(1.2), 0, 0, 0, 40),
    )
    assert same(interpolate_c(start, via, end, 0), start, 1e-9)
    assert same(interpolate_c(start, via, end, 1), end, 1e-9)
    half = (math.pi - 1.2) / 2
    assert distance(interpolate_c(start, via, end, 0.5), Trsf(100 * math.cos(half), 100 * math.sin(half), 0)) < 1e-9
    assert distance(interpolate_c(start, via, end, -0.5), Trsf(100 * math.cos(half), -100 * math.sin(half), 0)) < 1e-9
    assert distance(interpolate_c(start, via, end, 1.5), Trsf(100 * math.cos(3 * half), 100 * math.sin(3 * half), 0)) < 1e-9
    assert code(interpolate_c, start, Trsf(50), Trsf(-100), 0.5) == 552, "on one line"
    assert code(interpolate_c, start, start, end, 0.5) == 552, "too near"
    assert code(interpolate_c, start, Trsf(0, 100, 0, 180), end, 0.5) == 553, "orientation undefined"


def test_interpolate_c_goes_on_smoothly_before_the_start_and_behind_the_end() -> None:
    start, via, end = Trsf(100, 0, 0, 5, 0, 0), Trsf(0, 100, 0, 10, 20, 0), Trsf(-100, 0, 0, 0, 20, 40)
    steps = [interpolate_c(start, via, end, n / 100).pose for n in range(-50, 151)]
    turns = [between(one.rotation, two.rotation) for one, two in itertools.pairwise(steps)]
    ways = [math.dist(one.position, two.position) for one, two in itertools.pairwise(steps)]
    assert max(ways) - min(ways) < 1e-9
    assert max(math.dist(one, two) for one, two in itertools.pairwise(turns)) < 0.1 * max(math.hypot(*turn) for turn in turns)


@pytest.mark.requirement("VAL-TRSF-04", by="motion.val3.trsf:align")
def test_align_turns_z_to_the_nearest_axis_of_the_reference_and_keeps_the_place() -> None:
    assert same(align(Trsf(1, 2, 3, 20, 0, 0), Trsf(9, 9, 9)), Trsf(1, 2, 3, 0, 0, 0))
    assert same(align(Trsf(1, 2, 3, 170, 0, 0), Trsf()), Trsf(1, 2, 3, 180, 0, 0)), "-z is an axis, too"
    assert same(align(Trsf(1, 2, 3, 0, 70, 0), Trsf()), Trsf(1, 2, 3, 0, 90, 0))
    turned = align(Trsf(1, 2, 3, 20, 0, 35), Trsf(0, 0, 0, 10, 0, 0))
    assert same(turned, Trsf(1, 2, 3, 10, 0, 35)), "the least rotation: none about z"


def test_distance_counts_the_shift_alone() -> None:
    assert distance(Trsf(0, 0, 0, 10, 20, 30), Trsf(3, 4, 12)) == 13


def test_nothing_but_six_finite_numbers_makes_a_pose() -> None:
    assert VAL3.pose((0, 0, 0, 0, 0, 0)) == IDENTITY
    for values in ((0, 0, 0, 0, 0), (0, 0, math.nan, 0, 0, 0), (0, 0, 0, 0, 0, math.inf)):
        with pytest.raises(Exception, match="six finite numbers"):
            VAL3.pose(values)
