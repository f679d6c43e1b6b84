"""Random limits, targets and schedules of override, stop and resume: no promise of the stepper may break."""

from hypothesis import given, seed, settings
from hypothesis import strategies as st

from hil_tests.unit.motion.execution.measure import off_line, run_out, worst
from motion.execution.pieces import decode, encode
from motion.execution.ptp import nominal_duration, plan_ptp
from motion.execution.stepper import State, Stepper
from motion.geometry.limits import AxisLimits

SLACK = 2000  # steps beyond the nominal duration: stops and slow stretches before the last resume cost no more

shares = st.floats(0.2, 5.0)
places = st.floats(-3.0, 3.0)
axes = st.lists(st.tuples(shares, shares, shares, places, places), min_size=1, max_size=6)
orders = st.one_of(
    st.just("stop"),
    st.just("resume"),
    st.sampled_from([0.0, 0.001, 0.01, 0.1, 0.3, 0.5, 1.0]),
    st.floats(0.0, 1.0),
)
schedules = st.lists(st.tuples(st.integers(0, 120), orders), max_size=25)


def limits_of(drawn: list[tuple[float, float, float, float, float]]) -> list[AxisLimits]:
    return [AxisLimits(f"A{n}", -10, 10, 2 * v, 10 * a, 100 * j) for n, (v, a, j, _, _) in enumerate(drawn)]


def obey(stepper: Stepper, order: str | float) -> None:
    match order:
        case "stop":
            stepper.stop()
        case "resume":
            stepper.resume()
        case float():
            stepper.set_override(order)


@seed(2)
@settings(max_examples=400, deadline=None, derandomize=True, database=None)
@given(axes, schedules, st.sampled_from([0.002, 0.004, 0.01, 0.032]), st.sampled_from([1.0, 1e-3, 1e-6]))
def test_path_limits_and_end_point_hold_for_any_schedule(
    drawn: list[tuple[float, float, float, float, float]], schedule: list[tuple[int, str | float]], period_s: float, size: float
) -> None:
    limits = limits_of(drawn)
    start = [row[3] for row in drawn]
    target = [row[3] + size * (row[4] - row[3]) for row in drawn]
    piece = decode(encode(plan_ptp(start, target, limits)))
    stepper = Stepper(len(limits), period_s, start)
    stepper.load(piece)
    samples = []
    for wait, order in schedule:
        samples += [stepper.step() for _ in range(wait)]
        obey(stepper, order)
    stepper.set_override(1.0)
    stepper.resume()
    samples += run_out(stepper, int(nominal_duration(piece) / period_s) + SLACK)
    assert max(abs(a - b) for a, b in zip(samples[-1].q, target, strict=True)) <= 1e-9
    if piece.length > 0:
        assert max(off_line(sample.q, start, target) for sample in samples) <= 1e-9
    way = [sample.s for sample in samples if sample.piece_id]
    assert way == sorted(way)
    measured = worst([start, *(sample.q for sample in samples)], limits, period_s)
    assert measured.speed <= 1.0001
    assert measured.accel <= 1.02
    assert measured.jerk <= 1.10


@seed(3)
@settings(max_examples=200, deadline=None, derandomize=True, database=None)
@given(axes, st.integers(0, 400), st.booleans())
def test_stop_at_any_instant_comes_to_rest_and_resume_to_the_end(
    drawn: list[tuple[float, float, float, float, float]], at: int, near_the_end: bool
) -> None:
    limits, start, target = limits_of(drawn), [row[3] for row in drawn], [row[4] for row in drawn]
    piece = plan_ptp(start, target, limits)
    stepper = Stepper(len(limits), 0.004, start)
    stepper.load(piece)
    total = int(nominal_duration(piece) / 0.004)
    samples = [stepper.step() for _ in range(max(total - at // 20, 0) if near_the_end else min(at, total))]
    stepper.stop()
    for _ in range(SLACK):
        samples.append(stepper.step())
        if samples[-1].state in (State.STOPPED, State.IDLE):
            break
    assert samples[-1].state in (State.STOPPED, State.IDLE)
    assert samples[-1].qd == (0.0,) * len(limits)
    stepper.resume()
    samples += run_out(stepper, total + SLACK)
    assert max(abs(a - b) for a, b in zip(samples[-1].q, target, strict=True)) <= 1e-9
    measured = worst([start, *(sample.q for sample in samples)], limits, 0.004)
    assert measured.accel <= 1.02
    assert measured.jerk <= 1.10
