"""rho 3: fast, smooth start-off (part 1, section 4; TO04 section 2; TO05 section 15)."""

import pytest

from hil_tests.unit.motion.measure.benches import BOARDS, LRTAKT_NS, P5_NS, Rig, bench
from motion.errors import MotionError
from motion.measure.inputs import Edge, admitted
from motion.measure.start_off import Clock, StartOff, Wait

CLOCK = Clock(P5_NS, LRTAKT_NS)


def waiting(channel: int = 611, *, value: bool = True, max_time_s: float = 0.0, between: bool = False) -> StartOff:
    return StartOff(Wait(admitted(channel, BOARDS), value, max_time_s, between), CLOCK)


def started_ns(held: StartOff, edge_ns: int) -> int:
    """Instant of the first cycle whose set values have left the start, by a real stepper; the condition comes at edge_ns."""
    rig = Rig(bench())
    held.begin(False, 0)
    for cycle in range(400):
        now_ns = cycle * P5_NS
        coming = [Edge(611, edge_ns, True)] if now_ns - P5_NS < edge_ns <= now_ns else []
        if not rig.stepper.queued and rig.stepper.state.name == "IDLE" and held.step(now_ns, coming):
            rig.stepper.load(rig.piece)
        if rig.stepper.step().q[0] > 0.0:
            return now_ns
    return -1


@pytest.mark.requirement("RHO-MOT-17", by="motion.measure.start_off:StartOff.step")
def test_start_one_position_controller_cycle_after_the_condition_plus_at_most_one_interpolation_cycle() -> None:
    delays = []
    for edge_ns in range(40_000_001, 48_000_001, 123_457):
        delays.append(started_ns(waiting(), edge_ns) - edge_ns)
    assert min(delays) >= 0 and max(delays) <= LRTAKT_NS + P5_NS
    assert max(delays) - min(delays) <= P5_NS, "jitter of one interpolation cycle"


def test_a_condition_that_holds_already_starts_at_once() -> None:
    held = waiting()
    held.begin(True, 8_000_000)
    assert held.step(8_000_000, []) is True


def test_the_other_edge_and_other_inputs_start_nothing() -> None:
    held = waiting(612, value=False)
    held.begin(True, 0)
    assert held.step(P5_NS, [Edge(612, 3, True), Edge(611, 4, False), Edge(610, 5, False)]) is False
    assert held.step(2 * P5_NS, [Edge(612, P5_NS + 6, False)]) is True


@pytest.mark.requirement("RHO-MOT-19", by="motion.measure.start_off:StartOff.step")
@pytest.mark.requirement("RHO-MOT-19", by="motion.measure.start_off:StartOff._met")
def test_max_time_0_15_starts_the_block_0_15_s_after_the_condition() -> None:
    for edge_ns in (40_000_001, 42_345_678, 43_999_999, 44_000_000):
        delay = started_ns(waiting(max_time_s=0.15), edge_ns) - edge_ns
        assert 150_000_000 <= delay <= 150_000_000 + LRTAKT_NS + P5_NS


def test_max_time_counts_whole_position_controller_cycles() -> None:
    held = waiting(max_time_s=0.0103)
    held.begin(True, 0)
    assert held.due_ns == 11_000_000


def test_statements_in_between_cost_two_interpolation_cycles() -> None:
    held = waiting(between=True)
    held.begin(True, 0)
    assert [held.step(k * P5_NS, []) for k in range(4)] == [False, False, True, True]


def test_a_position_controller_cycle_divides_the_interpolation_cycle() -> None:
    with pytest.raises(MotionError, match="does not divide"):
        Clock(4_000_000, 3_000_000)
