"""rho 3 Releases part 1, TO04 section 11: endless axes as main and as manual axes."""

import math

import pytest

from hil_tests.lab.cells.printed_tables import PROGRAM
from motion.errors import MotionError
from motion.kinematics.endless import AxisType, EndlessAxes, axis_type, within

V = 500.0  # deg/s


def speeds_of_the_master(axes: EndlessAxes) -> list[float]:
    here: tuple[float, ...] = (0.0,) * 5
    found = []
    for target in PROGRAM:
        span = axes.span(here, target, V)
        found.append(span.speeds[0])
        assert span.duration > 0
        assert all(math.isclose(speed * span.duration, way) for speed, way in zip(span.speeds, span.travel, strict=True))
        here = axes.position(target)
    return found


@pytest.mark.requirement("RHO-MOT-30", by=("motion.kinematics.endless:EndlessAxes.span", "motion.kinematics.endless:axis_type"))
def test_the_master_keeps_500_deg_per_s_over_all_points_and_the_slaves_follow() -> None:
    kinds = [AxisType.MAIN, AxisType.MANUAL, AxisType.ENDLESS_MAIN, AxisType.ENDLESS_MANUAL]
    assert [axis_type(number) for number in (0, 1, 3, 4)] == kinds
    axes = EndlessAxes((axis_type(3), *(axis_type(4),) * 4), (360.0,) * 5)
    assert speeds_of_the_master(axes) == pytest.approx([V] * 8)
    span = axes.span((105, 150, 0, 0, 0), (190, 300, 160, 0, 180), V)
    assert span.duration == pytest.approx(85 / 500)
    assert span.speeds == pytest.approx((500, 150 * 500 / 85, 160 * 500 / 85, 0, 180 * 500 / 85))


@pytest.mark.requirement("RHO-MOT-30", by="motion.kinematics.endless:EndlessAxes.span")
def test_seen_every_millisecond_the_master_runs_on_evenly_and_all_slaves_arrive_with_it() -> None:
    axes = EndlessAxes((AxisType.ENDLESS_MAIN, *(AxisType.ENDLESS_MANUAL,) * 4), (360.0,) * 5)
    here: tuple[float, ...] = (0.0,) * 5
    begun, clock = 0.0, 0
    for target in PROGRAM:
        span = axes.span(here, target, V)
        while clock * 1e-3 < begun + span.duration:
            now = [start + speed * (clock * 1e-3 - begun) for start, speed in zip(here, span.speeds, strict=True)]
            assert math.isclose(now[0], V * clock * 1e-3, abs_tol=1e-9), "one straight line in time, over all points"
            clock += 1
        ends = [start + speed * span.duration for start, speed in zip(here, span.speeds, strict=True)]
        assert ends == pytest.approx(target)
        begun, here = begun + span.duration, axes.position(target)
    assert begun == pytest.approx(360 / V)


def test_with_all_axes_main_the_master_changes_its_speed_as_before_to04() -> None:
    axes = EndlessAxes((AxisType.ENDLESS_MAIN,) * 5, (360.0,) * 5)
    speeds = speeds_of_the_master(axes)
    assert max(speeds) - min(speeds) > 200
    assert speeds[2] == pytest.approx(V * 15 / math.hypot(15, 30))


@pytest.mark.requirement("RHO-MOT-30", by=("motion.kinematics.endless:within", "motion.kinematics.endless:EndlessAxes.position"))
def test_positions_go_round_at_p311() -> None:
    axes = EndlessAxes((AxisType.ENDLESS_MAIN, AxisType.ENDLESS_MANUAL, AxisType.MANUAL), (360.0, 100.0, 0.0))
    assert axes.position((725.0, -30.0, -30.0)) == pytest.approx((5.0, 70.0, -30.0))
    assert axes.position((360.0, 100.0, 0.0)) == (0.0, 0.0, 0.0)
    assert within(-1e-14, 360.0) == 0.0
    span = axes.span((360.0, 20.0, 0.0), (0.0, 20.0, 0.0), V)
    assert span.travel == (0.0, 0.0, 0.0), "360 is 0 after the block"
    assert span.duration == 0
    assert axes.span((0, 0, 0), (720.0, 0, 0), V).travel[0] == 720, "two turns are two turns"


def test_values_of_p303_and_p311_that_cannot_be() -> None:
    for value in (2, 5, -1):
        with pytest.raises(MotionError, match="P303"):
            axis_type(value)
    with pytest.raises(MotionError, match="master"):
        EndlessAxes((AxisType.MANUAL, AxisType.ENDLESS_MANUAL), (0.0, 360.0))
    with pytest.raises(MotionError, match="P311"):
        EndlessAxes((AxisType.ENDLESS_MAIN,), (0.0,))
    with pytest.raises(MotionError, match="speed"):
        EndlessAxes((AxisType.MAIN,), (0.0,)).span((0,), (1,), 0.0)


def test_manual_axes_alone_have_the_speed_for_themselves() -> None:
    span = EndlessAxes((AxisType.MAIN, AxisType.MANUAL), (0.0, 0.0)).span((0.0, 0.0), (0.0, 50.0), 100.0)
    assert span.duration == 0.5
