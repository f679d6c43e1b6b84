"""rho3 2.8, modes 1 to 3 (L3810-3891): axis turned back to its own zero, stop with the ramp, and both together."""

import pytest

from drivers.drives.orientation import Orientation, orientation, segment_deg
from drivers.drives.reference_settings import ReferenceSettings
from drivers.drives.referencing import Referencing, RunState
from drivers.drives.scaling import ScalingError
from hil_tests.unit.drivers.drives.test_referencing import ACCEL, JERK, P5, SLOW, SPEED, TURN, Axis, assert_smooth

DEG = TURN / 360.0  # increments of one degree at the resolver


def wanted(mode: int, gear: float = 4.1, position_inc: float = 0.0, offset_inc: float = 0.0, direction: int = -1) -> ReferenceSettings:
    return ReferenceSettings(TURN, direction, SPEED, SLOW, ACCEL, JERK, position_inc, offset_inc, mode=mode, gear=gear)


def zero_of(position_inc: float, gear: float = 4.1) -> Orientation:
    return orientation(position_inc, TURN, gear)


@pytest.mark.requirement("RHO-CAN-23", by="drivers.drives.orientation:segment_deg")
def test_36_degrees_of_the_resolver_are_8_78_degrees_of_the_axis_with_gear_4_1() -> None:
    widths = segment_deg(4.1)
    assert widths == pytest.approx((36.0, 8.78), abs=0.005)


@pytest.mark.requirement("RHO-CAN-23", by="drivers.drives.orientation:orientation")
@pytest.mark.parametrize("turns", [-4, -1, 0, 1, 3, 5])
def test_an_edge_inside_one_segment_gives_the_same_zero_however_often_the_axis_turned(turns: int) -> None:
    """The axis' zero is at increment 8 x 16384; after `turns` turns the cam comes by again, the resolver 0.1 turn further each time."""
    zero = 8 * TURN
    for degrees in (-17.9, -9.0, 0.0, 9.0, 17.9):
        found = zero_of(zero + turns * 4.1 * TURN + degrees * DEG)
        assert isinstance(found, Orientation), found
        assert (found.segments, found.turns) == (10, turns)
        assert found.zero_inc == pytest.approx(zero, abs=1e-3) and found.deviation_inc == pytest.approx(degrees * DEG, abs=1e-6)
    beyond = zero_of(zero + turns * 4.1 * TURN + 18.1 * DEG)
    assert isinstance(beyond, Orientation) and beyond.turns != turns  # why the cam must not stand near a border (L3824)


@pytest.mark.parametrize(("gear", "segments", "turns"), [(4.9, 10, 3), (4.3, 10, -4), (5.25, 4, 2), (49 / 12, 12, 5), (121.0, 1, 0)])
def test_other_decimals_tell_turns_apart_too_and_none_shows_nothing(gear: float, segments: int, turns: int) -> None:
    found = zero_of(3 * TURN + turns * gear * TURN + 5 * DEG, gear)
    assert isinstance(found, Orientation)
    assert (found.segments, found.turns) == (segments, turns)
    assert found.zero_inc == pytest.approx(3 * TURN, abs=1e-3)


def run(axis: Axis, settings: ReferenceSettings) -> Referencing:
    found = axis.run(settings)
    assert axis.last.state is RunState.DONE
    assert_smooth(axis)
    return found


@pytest.mark.requirement("RHO-CAN-23", by="drivers.drives.referencing:Referencing._found")
def test_mode_1_turns_back_to_the_axis_zero_takes_p207_there_and_moves_p208() -> None:
    edge = round(8 * TURN + 2 * 4.1 * TURN + 5 * DEG)  # the axis is two turns too far
    axis = Axis(edge + 100_000, (-(10**9), edge))
    reference = run(axis, wanted(1, position_inc=700.0, offset_inc=-3000.0))
    assert reference.zero_inc == pytest.approx(8 * TURN - 700.0, abs=1.0)
    assert axis.last.set_inc == pytest.approx(8 * TURN - 3000, abs=1.0)
    stops = [step.set_inc for step in axis.steps if step.speed_inc_s == 0.0]
    assert any(abs(stop - 8 * TURN) <= 1 for stop in stops), "never stood in the zero"


@pytest.mark.requirement("RHO-CAN-24", by="drivers.drives.referencing:Referencing._take_zero")
def test_mode_2_stops_with_the_ramp_and_knows_its_position_without_seeing_the_zero() -> None:
    edge = 8 * TURN + 6000  # the encoder zero next to it is below, the axis comes from above and stops above it
    axis = Axis(edge + 100_000, (-(10**9), edge))
    reference = run(axis, wanted(2, position_inc=700.0))
    assert reference.zero_inc == 8 * TURN - 700.0
    sets = [step.set_inc for step in axis.steps]
    assert sets == sorted(sets, reverse=True) and sets[-1] > 8 * TURN, "the encoder zero was approached"
    assert max(abs(step.speed_inc_s) for step in axis.steps) == pytest.approx(SLOW)  # P109 allows braking before the limit


@pytest.mark.requirement("RHO-CAN-24", by="drivers.drives.referencing:Referencing._found")
def test_mode_2_takes_the_nearest_zero_on_either_side_and_moves_p208_when_there_is_one() -> None:
    for edge, zero in ((8 * TURN - 50, 8 * TURN), (8 * TURN + 50, 8 * TURN), (8 * TURN + 9000, 9 * TURN)):
        axis = Axis(edge + 60_000, (-(10**9), edge))
        reference = run(axis, wanted(2, offset_inc=2500.0))
        assert reference.zero_inc == zero
        assert axis.last.set_inc == zero + 2500


@pytest.mark.requirement("RHO-CAN-25", by="drivers.drives.referencing:Referencing._found")
def test_mode_3_stops_like_mode_2_and_computes_the_zero_like_mode_1() -> None:
    edge = round(8 * TURN - 3 * 4.1 * TURN - 8 * DEG)
    axis = Axis(edge - 100_000, (edge, 10**9))
    reference = run(axis, wanted(3, position_inc=-40.0, direction=1))
    assert reference.zero_inc == pytest.approx(8 * TURN + 40.0, abs=1.0)
    sets = [step.set_inc for step in axis.steps]
    assert sets == sorted(sets) and 0 < sets[-1] - edge < TURN  # stopped behind the switch, three turns from its zero
    last = round(axis.position)
    assert reference.zero_inc is not None
    assert last - reference.zero_inc == pytest.approx(-3 * 4.1 * TURN - 40.0, abs=TURN)  # the axis knows where it is


@pytest.mark.parametrize("mode", [1, 2, 3])
def test_an_abort_in_every_mode_comes_to_rest_and_knows_nothing(mode: int) -> None:
    axis = Axis(200_000, (-(10**9), 150_000))
    found = axis.run(wanted(mode), abort_at=round(0.4 / P5))
    assert (axis.last.state, found.zero_inc) == (RunState.FAILED, None)


def test_there_are_four_modes() -> None:
    for mode in (-1, 4):
        with pytest.raises(ScalingError, match=r"outside 0\.\.3"):
            wanted(mode)
