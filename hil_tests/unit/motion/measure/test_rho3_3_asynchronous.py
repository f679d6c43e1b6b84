"""rho 3 Releases part 2, section 3 (L6756-6830): modified MOVE UNTIL, SF 41 POTI_MODIFY and SF 42 MOVE_DIST from another process."""

import math
from itertools import pairwise

import pytest

from hil_tests.unit.motion.measure.benches import P5_NS, Rig, bench, undisturbed
from motion.errors import MotionError
from motion.execution.ptp import plan_ptp
from motion.execution.stepper import State
from motion.geometry.limits import AxisLimits
from motion.measure.asynchronous import Asynchronous
from motion.measure.inputs import Edge
from motion.measure.until import Outcome
from motion.program.factors import FactorTable

DEG = math.pi / 180
SHAFT = tuple(AxisLimits(f"A_{n + 1}", -1e4, 1e4, 720 * DEG, 3600 * DEG, 36_000 * DEG, "deg") for n in range(3))
FAR = (100.0, 0.0, 0.0)  # rad: the very large set position of the example
EDGE_NS = 1_501_234_567
P5 = P5_NS * 1e-9


def balancing(mailbox: Asynchronous, edges: list[Edge], orders: dict[int, tuple[float, float]], most: int = 900) -> tuple[Rig, Outcome]:
    """The balancing machine of the manual; orders: cycle -> (V factor, distance) given by the parallel process."""
    rig = Rig(bench((0,), limits=SHAFT), FAR, SHAFT)
    move = rig.until(710, distance=lambda: mailbox.distance(1))
    assert move.begin(False, 0)
    rig.stepper.load(rig.piece)
    while move.outcome is Outcome.RUNNING and len(rig.samples) < most:
        if len(rig.samples) in orders:
            poti, distance = orders[len(rig.samples)]
            mailbox.poti_modify(1, poti)
            mailbox.move_dist(1, distance)
        rig.stepper.set_override(mailbox.override(1))
        rig.cycle(move, edges)
    return rig, move.outcome


@pytest.mark.requirement("RHO-MOT-14", by="motion.measure.until:MoveUntil._run_on")
@pytest.mark.requirement("RHO-MOT-14", by="motion.measure.asynchronous:Asynchronous.move_dist")
@pytest.mark.requirement("RHO-MOT-14", by="motion.execution.run_on:RunOn.step")
def test_a_probe_edge_with_move_dist_45_ends_45_degrees_past_it_without_a_ramp() -> None:
    rig, outcome = balancing(Asynchronous(1, FactorTable(1)), [Edge(610, EDGE_NS, True)], {100: (0.2, 45.0)})
    assert outcome is Outcome.MET
    at_edge = undisturbed_of(rig)
    end = rig.samples[-1].q[0]
    assert abs(end - at_edge - 45 * DEG) <= 1e-6, "45 past the edge, not past the cycle that saw it"
    speeds = [(b.q[0] - a.q[0]) / P5 for a, b in pairwise(rig.samples)]
    seen = EDGE_NS // P5_NS + 1
    assert all(abs(v - 144 * DEG) <= 1e-6 for v in speeds[seen - 5 : -2]), "20 % of 720 deg/s up to the last cycle: no ramp"
    assert 0.0 < speeds[-1] <= 144 * DEG + 1e-9
    assert rig.stepper.state is State.IDLE
    rig.stepper.load(plan_ptp((end, 0.0, 0.0), (0.0,) * 3, SHAFT, piece_id=2, mask=7))  # POS was made anew: the next block fits


def undisturbed_of(rig: Rig) -> float:
    """Where the shaft was at the edge, by its steady 144 deg/s around it."""
    before = rig.samples[EDGE_NS // P5_NS - 1]
    return before.q[0] + 144 * DEG * (EDGE_NS % P5_NS) * 1e-9


def test_a_distance_that_is_used_up_already_is_made_good_in_the_other_direction() -> None:
    """45 deg are more than the axis travels until the edge is seen, 0.1 deg are less: it goes back, never on to the far end."""
    rig, outcome = balancing(Asynchronous(1, FactorTable(1)), [Edge(610, EDGE_NS, True)], {100: (0.2, 0.1)})
    assert outcome is Outcome.MET
    assert rig.samples[-1].q[0] == pytest.approx(undisturbed_of(rig) + 0.1 * DEG, abs=1e-6)


def test_without_an_edge_the_modified_form_runs_to_its_end() -> None:
    mailbox = Asynchronous(1, FactorTable(1))
    rig = Rig(bench((0, 1)))
    move = rig.until(710, distance=lambda: mailbox.distance(1))
    assert move.begin(True, 0)
    rig.stepper.load(rig.piece)
    assert rig.run(move, [Edge(611, 300_000_000, True)]) is Outcome.NOT_MET
    assert rig.samples[-1].q == pytest.approx((1.0, 0.5, 0.0), abs=1e-9)


def test_with_several_axes_the_distance_goes_on_in_the_direction_of_the_path() -> None:
    mailbox = Asynchronous(1, FactorTable(1))
    mailbox.move_dist(1, 50.0)  # mm
    rig = Rig(bench((0, 1)))
    move = rig.until(710, distance=lambda: mailbox.distance(1))
    assert move.begin(False, 0)
    rig.stepper.load(rig.piece)
    edge_ns = 601_500_000
    assert rig.run(move, [Edge(610, edge_ns, True)]) is Outcome.MET
    at = undisturbed(rig.piece, edge_ns)
    x, y = rig.samples[-1].q[:2]
    assert math.hypot(x - at[0], y - at[1]) == pytest.approx(0.05, abs=2e-6)
    assert y == pytest.approx(x / 2, abs=1e-9), "still on the path"


@pytest.mark.requirement("RHO-MOT-15", by="motion.measure.asynchronous:Asynchronous.poti_modify")
@pytest.mark.requirement("RHO-MOT-15", by="motion.measure.asynchronous:Asynchronous.override")
def test_poti_modify_from_another_process_makes_20_percent_during_the_block() -> None:
    factors = FactorTable(1)
    rig, outcome = balancing(Asynchronous(1, factors), [], {150: (0.2, 0.0)}, most=400)
    assert outcome is Outcome.RUNNING
    assert rig.samples[149].qd[0] == pytest.approx(720 * DEG, abs=1e-9), "the program's factor of 1.0 up to there"
    assert rig.samples[399].qd[0] == pytest.approx(144 * DEG, abs=1e-9)
    speeds = [s.qd[0] for s in rig.samples]
    accelerations = [(b - a) / P5 for a, b in pairwise(speeds)]
    assert max(map(abs, accelerations)) <= 3600 * DEG * 1.02, "by the limits, not by a jump"
    assert factors.kinematic_factors(1).velocity == 0.2, "it replaces the VFACTOR of the program"
    assert Asynchronous(1, factors).override(1, 0.5) == pytest.approx(0.4) and Asynchronous(1, factors).override(1, 0.1) == 1.0
    for planned in (0.0, 1.01):
        with pytest.raises(MotionError, match="outside 0"):
            Asynchronous(1, factors).override(1, planned)


def test_the_global_factor_and_pieces_planned_slower_count_in_the_override() -> None:
    factors = FactorTable(2)
    mailbox = Asynchronous(2, factors)
    factors.set_global(velocity=0.5)
    mailbox.poti_modify(2, 0.4)
    assert mailbox.override(1) == 0.5 and mailbox.override(2) == pytest.approx(0.2)
    assert mailbox.override(2, planned=0.4) == pytest.approx(0.5)
    assert mailbox.override(2, planned=0.1) == 1.0, "a piece is never run faster than it was planned"


def test_orders_that_make_no_sense_are_refused() -> None:
    mailbox = Asynchronous(1, FactorTable(1))
    for order in (
        lambda: mailbox.poti_modify(2, 0.5),
        lambda: mailbox.poti_modify(1, 1.5),
        lambda: mailbox.move_dist(0, 1.0),
        lambda: mailbox.move_dist(1, float("nan")),
        lambda: mailbox.override(1, planned=0.0),
    ):
        with pytest.raises(MotionError):
            order()
    assert mailbox.distance(1) == 0.0 and mailbox.override(1) == 1.0


def test_a_distance_out_of_the_travel_stops_on_the_path_and_names_the_axis() -> None:
    mailbox = Asynchronous(1, FactorTable(1))
    mailbox.move_dist(1, 1e6)  # deg; the travel is 1e4 rad
    rig = Rig(bench((0,), limits=SHAFT), FAR, SHAFT)
    move = rig.until(710, distance=lambda: mailbox.distance(1))
    assert move.begin(False, 0)
    rig.stepper.load(rig.piece)
    assert rig.run(move, [Edge(610, EDGE_NS, True)]) is Outcome.FAULT
    assert move.fault is not None and move.fault.axis == "A_1"
    at_edge = rig.samples[EDGE_NS // P5_NS - 1].q[0]
    assert at_edge < rig.samples[-1].q[0] < at_edge + 3.0 and rig.samples[-1].qd[0] == 0.0
