"""rho 3 Releases part 1, section 2 (L1100-1290): MOVE UNTIL with high-speed inputs, probes and normal inputs; @MPOS."""

import pytest

from hil_tests.unit.motion.measure.benches import BOARDS, LRTAKT_NS, P5_NS, Rig, bench, undisturbed
from motion.execution.stepper import State
from motion.geometry.limits import AxisLimits
from motion.measure.errors import INADMISSABLE_INPUT, POINT_NOT_DEFINED, ProgramFault
from motion.measure.history import History
from motion.measure.inputs import Edge, InputKind, admitted, greatest_error, input_of, stored_at
from motion.measure.mpos import MeasuredPosition
from motion.measure.until import Outcome

EDGE_NS = 401_234_567  # in the middle of the move, between two cycles


def refusal(mpos: MeasuredPosition, component: int | None = None) -> str:
    try:
        if component is None:
            mpos.read()
        else:
            mpos.component(component)
    except ProgramFault as fault:
        return fault.text
    return ""


@pytest.mark.requirement("RHO-MOT-10", by="motion.measure.until:MoveUntil.step")
@pytest.mark.requirement("RHO-MOT-10", by="motion.measure.mpos:measured")
@pytest.mark.requirement("RHO-MOT-10", by="motion.measure.inputs:stored_at")
def test_a_high_speed_input_stops_the_block_and_mpos_holds_the_position_at_its_edge() -> None:
    rig = Rig(bench())
    move = rig.until(611)
    assert move.begin(False, 0)
    rig.stepper.load(rig.piece)
    assert rig.run(move, [Edge(611, EDGE_NS, True)]) is Outcome.MET
    stored_ns = 402_000_000  # next position-controller cycle
    assert rig.bench.mpos.read() == pytest.approx(undisturbed(rig.piece, stored_ns)[:2], abs=2e-6)
    truth, found = undisturbed(rig.piece, EDGE_NS), rig.bench.mpos.read()
    for axis in (0, 1):
        speed = rig.samples[EDGE_NS // P5_NS].qd[axis]
        assert abs(found[axis] - truth[axis]) <= greatest_error(InputKind.HIGH_SPEED, speed, LRTAKT_NS) * 1.01
    assert rig.stepper.state is State.IDLE
    stopped = rig.samples[-1].q
    assert stopped[0] < 0.9 and abs(stopped[1] - stopped[0] / 2) <= 1e-9, "stopped on the path, long before the end"
    assert rig.samples[-1].qd == (0.0, 0.0, 0.0)


@pytest.mark.requirement("RHO-MOT-10", by="motion.measure.until:MoveUntil._look")
def test_the_cycle_after_the_edge_slows_down() -> None:
    rig = Rig(bench())
    free = Rig(bench())
    move, other = rig.until(611), free.until(611)
    for each, way in ((rig, move), (free, other)):
        assert way.begin(False, 0)
        each.stepper.load(each.piece)
    at = EDGE_NS // P5_NS + 1
    for _ in range(at + 3):
        rig.cycle(move, [Edge(611, EDGE_NS, True)])
        free.cycle(other)
    assert rig.samples[at - 1].q == free.samples[at - 1].q
    assert rig.samples[at].qd[0] < free.samples[at].qd[0] - 1e-6, "the interpolation cycle in which the edge is seen is changed already"


@pytest.mark.requirement("RHO-MOT-11", by="motion.measure.until:MoveUntil.begin")
def test_a_high_speed_input_that_is_true_before_lets_nothing_move() -> None:
    rig = Rig(bench())
    move = rig.until(611)
    assert move.begin(True, rig.now_ns) is False
    assert move.outcome is Outcome.MET
    assert rig.bench.mpos.read() == (0.0, 0.0), "measured where the axes stand"
    negative = rig.until(611, value=False)
    assert negative.begin(True, rig.now_ns) is True and negative.outcome is Outcome.RUNNING


@pytest.mark.requirement("RHO-MOT-11", by="motion.measure.until:MoveUntil.step")
def test_a_probe_that_says_1_before_the_block_must_change_in_it_or_the_end_is_reached() -> None:
    rig = Rig(bench())
    move = rig.until(610)
    assert move.begin(True, rig.now_ns) is True, "an old 1 stops nothing"
    rig.stepper.load(rig.piece)
    assert rig.run(move, [Edge(610, 200_000_000, False)]) is Outcome.NOT_MET, "the falling edge is not the wanted one"
    assert rig.samples[-1].q == pytest.approx((1.0, 0.5, 0.0), abs=1e-9)


@pytest.mark.requirement("RHO-MOT-12", by="motion.measure.until:MoveUntil._ended")
def test_no_response_leads_to_the_error_part_and_mpos_stays_what_it_was() -> None:
    rig = Rig(bench())
    rig.bench.mpos.take((7.0, 8.0))
    move = rig.until(611)
    assert move.begin(False, 0)
    rig.stepper.load(rig.piece)
    assert rig.run(move) is Outcome.NOT_MET
    assert rig.bench.mpos.read() == (7.0, 8.0), "a stale value: the program jumps to its ERROR part and does not read it"
    assert rig.samples[-1].done_id == rig.piece.id and rig.samples[-1].q[0] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.requirement("RHO-MOT-13", by="motion.measure.mpos:MeasuredPosition.read")
@pytest.mark.requirement("RHO-MOT-13", by="motion.measure.mpos:MeasuredPosition.component")
def test_reading_mpos_first_is_point_not_defined() -> None:
    measured = MeasuredPosition((0, 1))
    measured.take((0.25, 0.5))
    assert measured.read() == (0.25, 0.5)
    mpos = MeasuredPosition((0, 1))
    assert refusal(mpos) == refusal(mpos, 1) == "point not defined"
    mpos.take((0.25, None))
    assert refusal(mpos) == POINT_NOT_DEFINED and refusal(mpos, 1) == POINT_NOT_DEFINED
    assert mpos.component(0) == 0.25 and not mpos.occupied
    mpos.take((0.25, 0.5))
    assert mpos.read() == (0.25, 0.5) and mpos.occupied
    mpos.program_started()
    assert refusal(mpos) == POINT_NOT_DEFINED, "another program measured that"


def test_axes_on_other_boards_are_not_occupied() -> None:
    rig = Rig(bench((0, 2)))
    move = rig.until(610)
    move.begin(False, 0)
    rig.stepper.load(rig.piece)
    assert rig.run(move, [Edge(610, EDGE_NS, True)]) is Outcome.MET
    assert rig.bench.mpos.component(0) > 0.0
    assert refusal(rig.bench.mpos, 1) == POINT_NOT_DEFINED


def test_a_normal_input_ends_the_block_at_the_cycle_that_sees_it() -> None:
    rig = Rig(bench())
    move = rig.until(9)
    assert move.begin(False, 0)
    rig.stepper.load(rig.piece)
    for _ in range(80):
        rig.cycle(move)
    rig.cycle(move, level=True)
    while move.outcome is Outcome.RUNNING:
        rig.cycle(move)
    assert move.outcome is Outcome.MET and rig.samples[-1].q[0] < 0.9
    assert rig.bench.mpos.read() == pytest.approx(rig.samples[79].q[:2], abs=1e-12)


@pytest.mark.parametrize("channel", [0, 121, 501, 600, 601, 700, 711, 721, 805, -1])
def test_other_channels_are_inadmissable(channel: int) -> None:
    with pytest.raises(ProgramFault, match=INADMISSABLE_INPUT):
        input_of(channel)


@pytest.mark.parametrize("channel", [619, 631, 620, 720])
def test_inputs_that_are_not_there_are_inadmissable(channel: int) -> None:
    """P11 states board 1 eight inputs, board 3 is not fitted, board 2 has no probe."""
    with pytest.raises(ProgramFault, match=INADMISSABLE_INPUT):
        admitted(channel, BOARDS)
    assert admitted(618, BOARDS).number == 8 and admitted(710, BOARDS).wire == 610


def test_a_probe_on_an_absolute_encoder_stores_in_the_next_position_controller_cycle() -> None:
    assert stored_at(InputKind.PROBE, 1_000_001, LRTAKT_NS) == 1_000_001
    assert stored_at(InputKind.PROBE, 1_000_001, LRTAKT_NS, incremental=False) == 2_000_000
    assert stored_at(InputKind.HIGH_SPEED, 2_000_000, LRTAKT_NS) == 2_000_000


def test_the_manuals_model_of_the_error() -> None:
    """v / 100000 mm for the probe, v / 1000 x LRTAKT[ms] for high-speed inputs (L1268-1290)."""
    assert greatest_error(InputKind.PROBE, 1000.0, LRTAKT_NS) == pytest.approx(1000.0 / 100_000)
    assert greatest_error(InputKind.HIGH_SPEED, -250.0, 2 * LRTAKT_NS) == pytest.approx(250.0 / 1000 * 2)


@pytest.mark.parametrize("period_ns", [1_000_000, 4_000_000])
def test_probe_positions_are_within_10_us_of_way_and_2_um_at_1_m_per_s_with_stamps_of_1_us(period_ns: int) -> None:
    """The latch figure (motion.md C, goal 14), at edges all along a move: jerk phases, full speed, braking."""
    limits = tuple(AxisLimits(f"A{n + 1}", -50.0, 50.0, 1.0, 10.0, 200.0, "mm") for n in range(3))
    worst_share = worst_full = 0.0
    for edge_ns in range(33_337_777, 1_100_000_000, 51_713_311):
        rig = Rig(bench(period_ns=period_ns), limits=limits)
        move = rig.until(610)
        assert move.begin(False, 0)
        rig.stepper.load(rig.piece)
        stamp_ns = -(-edge_ns // 1000) * 1000  # what a drive with a clock of 1 us says
        assert rig.run(move, [Edge(610, stamp_ns, True)]) is Outcome.MET
        truth, found = undisturbed(rig.piece, edge_ns)[0], rig.bench.mpos.component(0)
        later = undisturbed(rig.piece, edge_ns + 10_000)[0]
        worst_share = max(worst_share, abs(found - truth) / max(later - truth, 2e-7))
        worst_full = max(worst_full, abs(found - truth))
    assert worst_share <= 1.0 and worst_full <= 2e-6


def test_history_without_speeds_goes_through_four_samples() -> None:
    known = History(1)
    for k in range(8):
        t = k * 0.004
        known.add(k * 4_000_000, (1e3 + 5 * t * t + 20 * t**3,))
    t = 0.0177
    assert known.at(17_700_000)[0] == pytest.approx(1e3 + 5 * t * t + 20 * t**3, abs=1e-12)
    assert known.at(16_000_000)[0] == 1e3 + 5 * 0.016**2 + 20 * 0.016**3


def test_history_says_what_it_does_not_know() -> None:
    known = History(1)
    with pytest.raises(Exception, match="nothing is kept"):
        known.at(0)
    known.add(10, (0.0,))
    for stamp, q, what in ((10, (0.0,), "come after"), (20, (float("nan"),), "not all numbers"), (20, (0.0, 1.0), "2 positions")):
        with pytest.raises(Exception, match=what):
            known.add(stamp, q)
    with pytest.raises(Exception, match=r"10 \.\. 10 ns is kept"):
        known.at(11)


def test_edges_from_before_the_block_do_not_count_and_stamps_of_the_future_are_now() -> None:
    rig = Rig(bench())
    rig.now_ns = 8_000_000
    rig.bench.history.add(rig.now_ns, (0.0,) * 3, (0.0,) * 3)
    move = rig.until(610)
    move.begin(False, rig.now_ns)
    rig.stepper.load(rig.piece)
    move.step(rig.now_ns, [Edge(610, 7_999_999, True)])
    assert rig.stepper.state is State.RUNNING
    for _ in range(50):
        rig.cycle(move)
    now_ns = rig.now_ns
    rig.bench.history.at(now_ns)
    move.step(now_ns, [Edge(610, now_ns + 10**12, True)])
    while move.outcome is Outcome.RUNNING:
        rig.cycle(move)
    assert move.outcome is Outcome.MET and rig.bench.mpos.read() == rig.bench.history.at(now_ns)[:2]


def test_an_edge_reported_too_late_to_know_its_position_stops_but_measures_nothing() -> None:
    rig = Rig(bench())
    move = rig.until(610)
    move.begin(False, 0)
    rig.stepper.load(rig.piece)
    for _ in range(100):
        rig.cycle(move)
    move.step(rig.now_ns, [Edge(610, 4_000_001, True)])
    while move.outcome is Outcome.RUNNING:
        rig.cycle(move)
    assert move.outcome is Outcome.MET and refusal(rig.bench.mpos) == POINT_NOT_DEFINED
