"""rho3 2.8, mode 0: on to the encoder zero behind the switch, actual = P207, then P208; what goes wrong is told."""

import math
from itertools import pairwise

import pytest

from drivers.drives.reference_settings import ReferenceMove, ReferenceSettings
from drivers.drives.referencing import Failure, Referencing, RefStep, RunState
from drivers.drives.scaling import Scaling, ScalingError

P5 = 0.004
TURN = 16384
SPEED, SLOW, ACCEL, JERK = 10 * TURN, 2 * TURN, 100 * TURN, 2000 * TURN
FREE = (-(10**12), -(10**12) + 1)  # a switch that is nowhere


def wanted(
    direction: int = -1, position_inc: float = 0.0, offset_inc: float = 0.0, way_inc: float = math.inf, timeout_s: float = 60.0
) -> ReferenceSettings:
    return ReferenceSettings(TURN, direction, SPEED, SLOW, ACCEL, JERK, position_inc, offset_inc, way_inc, timeout_s)


class Axis:
    """A motor that follows its set position with a lag of speed / kv, and a switch between two positions."""

    def __init__(self, start_inc: int, switch: tuple[float, float], kv: float = 50.0) -> None:
        self.position = float(start_inc)
        self.switch, self.share = switch, 1 - math.exp(-kv * P5)
        self.steps: list[RefStep] = []
        self.zeros_behind_switch: list[int] = []

    def run(self, settings: ReferenceSettings, limit: int = 20_000, abort_at: int = -1) -> Referencing:
        run = Referencing(settings, round(self.position))
        for number in range(limit):
            if number == abort_at:
                run.abort()
            inc = round(self.position)
            self.steps.append(run.step(inc, self.switch[0] <= inc <= self.switch[1], P5))
            self.position += (self.steps[-1].set_inc - self.position) * self.share
            if self.steps[-1].state is not RunState.RUNNING:
                return run
        raise AssertionError("referencing never ends")

    @property
    def last(self) -> RefStep:
        return self.steps[-1]


def assert_smooth(axis: Axis) -> None:
    """Acceleration and jerk of the set speed, and set positions that are its integral."""
    speeds = [0.0, 0.0, *(step.speed_inc_s for step in axis.steps), 0.0]
    accels = [(b - a) / P5 for a, b in pairwise(speeds)]
    assert max(map(abs, accels)) <= ACCEL * 1.001
    assert max(abs(b - a) / P5 for a, b in pairwise(accels)) <= JERK * 1.001
    for before, after in pairwise(axis.steps):
        mean = (before.speed_inc_s + after.speed_inc_s) / 2 * P5
        assert after.set_inc - before.set_inc == pytest.approx(mean, abs=1.5 + JERK * P5**3)


@pytest.mark.requirement("RHO-CAN-22", by="drivers.drives.referencing:Referencing.step")
def test_runs_on_to_the_encoder_zero_after_the_switch_takes_p207_there_and_moves_p208() -> None:
    axis = Axis(200_000, (-50_000, 100_000))
    run = axis.run(wanted(position_inc=500.0, offset_inc=-2500.0))
    assert axis.last.state is RunState.DONE
    assert run.zero_inc is not None
    zero = 6 * TURN  # 98304: the first multiple of a turn below the edge at 100000
    assert run.zero_inc == zero - 500.0
    assert axis.last.set_inc == zero - 2500
    assert axis.last.set_inc - run.zero_inc == 500.0 - 2500.0  # the axis reads P207 + P208
    assert run.switch_to_zero_inc == pytest.approx(100_000 - zero, abs=SPEED * P5 + 1)
    assert_smooth(axis)


def test_the_other_direction_finds_the_zero_above() -> None:
    axis = Axis(-200_000, (-100_000, 50_000))
    run = axis.run(wanted(direction=1, offset_inc=3 * TURN))
    assert run.zero_inc == -6 * TURN
    assert axis.last.set_inc == -3 * TURN
    assert_smooth(axis)


def test_the_direction_is_kept_from_the_switch_to_the_zero() -> None:
    axis = Axis(200_000, (-50_000, 6 * TURN + 16_000))
    axis.run(wanted(offset_inc=-3.0 * TURN))
    sets = [step.set_inc for step in axis.steps]
    assert sets == sorted(sets, reverse=True)
    assert any(abs(step.speed_inc_s) == pytest.approx(SPEED) for step in axis.steps)
    assert any(abs(step.speed_inc_s) == pytest.approx(SLOW) for step in axis.steps), "never slow behind the switch"


@pytest.mark.parametrize("edge", [TURN // 2, 100, TURN - 100])
def test_every_start_gives_the_same_zero_or_says_that_it_is_not_known(edge: int) -> None:
    """Half a turn away all starts agree; next to the zero the margin tells so, and where P5 looked before and behind it none is taken."""
    risky = SPEED * P5 + 101
    zeros, flagged, whys = set(), [], []
    for start in range(150_000, 150_000 + TURN, 1234):
        axis = Axis(start, (-500_000, 6 * TURN + edge))
        run = axis.run(wanted())
        margin = run.switch_to_zero_inc
        assert margin is not None
        whys.append(axis.last.why)
        zeros.add(run.zero_inc if axis.last.state is RunState.DONE else 6 * TURN)
        flagged.append(min(margin, TURN - margin) <= risky)
    assert zeros == {6 * TURN}
    assert flagged == [edge != TURN // 2] * len(flagged)
    assert set(whys) == ({None} if edge == TURN // 2 else {None, Failure.AMBIGUOUS})


def test_looks_that_stay_away_over_the_zero_make_it_unknown_not_a_turn_wrong() -> None:
    """The switch half a turn from the zero, and telegrams that stay away for more than that."""
    run = Referencing(wanted(), 6 * TURN + TURN)
    run.step(6 * TURN + TURN, False, P5)
    run.step(6 * TURN + TURN // 2 + 10, False, P5)
    run.step(6 * TURN - 10, True, P5)
    last = run.step(6 * TURN - 10, True, P5)
    for _ in range(1000):
        last = run.step(6 * TURN - 10, True, P5)
    assert (last.state, last.why, run.zero_inc) == (RunState.FAILED, Failure.AMBIGUOUS, None)


def test_a_switch_actuated_at_the_start_is_left_first_then_approached() -> None:
    axis = Axis(60_000, (-200_000, 100_000))
    run = axis.run(wanted())
    sets = [step.set_inc for step in axis.steps]
    assert max(sets) > 100_000
    assert run.zero_inc == 6 * TURN
    assert axis.last.state is RunState.DONE
    assert_smooth(axis)


def test_a_switch_that_is_never_left_fails_within_the_allowed_way() -> None:
    axis = Axis(0, (-(10**9), 10**9))
    run = axis.run(wanted(way_inc=100_000))
    assert (axis.last.state, axis.last.why, run.zero_inc) == (RunState.FAILED, Failure.NOT_LEFT, None)
    assert axis.last.speed_inc_s == 0.0
    assert 100_000 < axis.last.set_inc < 160_000
    assert_smooth(axis)


def test_a_switch_that_is_not_there_fails_within_the_allowed_way() -> None:
    axis = Axis(0, FREE)
    axis.run(wanted(way_inc=300_000))
    assert (axis.last.state, axis.last.why) == (RunState.FAILED, Failure.NOT_FOUND)
    assert -360_000 < axis.last.set_inc < -300_000
    assert_smooth(axis)


def test_the_time_out_stops_the_axis_and_reports_it_at_rest() -> None:
    axis = Axis(0, FREE)
    axis.run(wanted(timeout_s=1.0))
    assert (axis.last.state, axis.last.why) == (RunState.FAILED, Failure.TIMEOUT)
    assert 1.0 < len(axis.steps) * P5 < 1.4
    assert_smooth(axis)


def test_abort_comes_to_rest_and_a_failed_run_holds() -> None:
    axis = Axis(0, FREE)
    run = axis.run(wanted(), abort_at=200)
    assert (axis.last.state, axis.last.why) == (RunState.FAILED, Failure.ABORTED)
    assert_smooth(axis)
    assert run.step(0, True, P5) == axis.last


def test_settings_come_from_axis_values_and_the_direction_of_the_axis() -> None:
    scaling = Scaling(TURN, 5.0, 0.010, -1)
    settings = ReferenceMove(direction=-1, speed=0.02, slow_speed=0.004, accel=1.0, jerk=20.0, position=0.1, offset=0.01).at_motor(scaling)
    assert settings.direction == 1
    assert settings.speed_inc_s == pytest.approx(0.02 * 5 * TURN / 0.010)
    assert settings.position_inc == pytest.approx(-0.1 * 5 * TURN / 0.010)
    axis = Axis(-200_000, (-100_000, 50_000))
    run = axis.run(settings)
    assert run.zero_inc is not None
    assert scaling.with_zero(run.zero_inc).to_si(axis.last.set_inc) == pytest.approx(0.11, abs=1e-7)


def test_settings_nobody_can_run_with_are_refused() -> None:
    for direction, way, timeout in ((0, 1.0, 1.0), (1, 0.0, 1.0), (1, 1.0, math.nan)):
        with pytest.raises(ScalingError, match="referencing"):
            wanted(direction, way_inc=way, timeout_s=timeout)
