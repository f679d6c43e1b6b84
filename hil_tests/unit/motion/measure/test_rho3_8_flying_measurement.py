"""rho 3 Releases part 2, section 8 (L7594-7679): flying measurement, SF 43 MEASURE_ON and SF 44 MEASURE_OFF."""

from dataclasses import replace

import pytest

from hil_tests.unit.motion.measure.benches import P5_NS, Rig, bench, undisturbed
from motion.errors import MotionError
from motion.execution.stepper import State
from motion.measure.errors import POINT_NOT_DEFINED, ProgramFault
from motion.measure.flying import FlyingMeasurement
from motion.measure.inputs import Board, Edge
from motion.measure.mpos import MeasuredPosition

EDGE_NS = 401_234_567
EDGES = (Edge(610, EDGE_NS - 50_000_000, False), Edge(610, EDGE_NS, True), Edge(610, EDGE_NS + 60_000_000, False))


def passed(rig: Rig, probes: FlyingMeasurement) -> list[int]:
    """The whole move; what channel 610 reads in each cycle."""
    rig.stepper.load(rig.piece)
    read = []
    while rig.stepper.state is not State.IDLE:
        rig.samples.append(rig.stepper.step())
        rig.now_ns += P5_NS
        rig.bench.history.add(rig.now_ns, rig.samples[-1].q, rig.samples[-1].qd)
        probes.step(tuple(e for e in EDGES if rig.now_ns - P5_NS < e.stamp_ns <= rig.now_ns))
        read.append(probes.input(610))
    return read


def fault(mpos: MeasuredPosition) -> str:
    try:
        mpos.read()
    except ProgramFault as found:
        return found.text
    return ""


@pytest.mark.requirement("RHO-MOT-16", by="motion.measure.flying:FlyingMeasurement.step")
@pytest.mark.requirement("RHO-MOT-16", by="motion.measure.flying:FlyingMeasurement.input")
@pytest.mark.requirement("RHO-MOT-16", by="motion.measure.flying:FlyingMeasurement.on")
def test_edge_1_the_input_reads_1_after_the_edge_and_the_motion_goes_on() -> None:
    rig, probes = Rig(bench()), FlyingMeasurement()
    with pytest.raises(MotionError, match="edge 2"):
        probes.on(1, 2, 610, rig.bench, 0)
    probes.on(1, 1, 610, rig.bench, 0)
    with pytest.raises(MotionError, match="for kinematic 1"):
        probes.on(2, 1, 610, rig.bench, 0)
    read = passed(rig, probes)
    seen = EDGE_NS // P5_NS
    assert read == [0] * seen + [1] * (len(read) - seen)
    assert rig.bench.mpos.read() == pytest.approx(undisturbed(rig.piece, EDGE_NS)[:2], abs=2e-6)
    undisturbed_way = Rig(bench())
    plain = passed(undisturbed_way, FlyingMeasurement())
    assert [s.q for s in rig.samples] == [s.q for s in undisturbed_way.samples] and plain == [0] * len(read)


def test_edge_0_is_the_negative_one() -> None:
    rig, probes = Rig(bench()), FlyingMeasurement()
    probes.on(1, 0, 610, rig.bench, 0)
    read = passed(rig, probes)
    assert read.index(1) == (EDGE_NS - 50_000_000) // P5_NS


def test_switched_off_no_edge_counts_and_mpos_stays_undefined() -> None:
    rig, probes = Rig(bench()), FlyingMeasurement()
    probes.on(1, 1, 610, rig.bench, 0)
    probes.off(1, 610)
    assert set(passed(rig, probes)) == {0}
    assert fault(rig.bench.mpos) == POINT_NOT_DEFINED


def test_axes_of_another_board_are_not_stored() -> None:
    rig, probes = Rig(bench((0, 2))), FlyingMeasurement()
    probes.on(1, 1, 610, rig.bench, 0)
    assert passed(rig, probes)[-1] == 1
    assert rig.bench.mpos.component(0) > 0.0 and fault(rig.bench.mpos) == POINT_NOT_DEFINED


def test_one_probe_a_board_and_only_probes() -> None:
    rig, probes = Rig(bench()), FlyingMeasurement()
    probes.on(1, 1, 610, rig.bench, 0)
    with pytest.raises(MotionError, match="measures for kinematic 1"):
        probes.on(2, 1, 610, rig.bench, 0)
    probes.off(2, 610)  # somebody else's measurement goes on
    with pytest.raises(MotionError, match="measures for kinematic 1"):
        probes.on(2, 1, 610, rig.bench, 0)
    for channel in (611, 710, 620, 9):
        with pytest.raises(ProgramFault, match="inadmissable input"):
            probes.on(1, 1, channel, rig.bench, 0)
    with pytest.raises(MotionError, match="edge 2"):
        probes.on(1, 2, 610, rig.bench, 0)
    with pytest.raises(ProgramFault, match="inadmissable input"):
        probes.input(611)


def test_edges_before_it_was_switched_on_do_not_count() -> None:
    rig, probes = Rig(bench()), FlyingMeasurement()
    probes.on(1, 1, 610, rig.bench, 2_000_000)
    rig.bench.history.add(P5_NS, (0.0,) * 3)
    probes.step((Edge(610, 1_999_999, True),))
    assert probes.input(610) == 0
    probes.step((Edge(610, 2_000_001, True),))
    assert probes.input(610) == 1


def test_axes_without_incremental_encoders_are_not_stored() -> None:
    mixed = replace(bench(), boards={1: Board(frozenset({0, 1}), frozenset({0}))})
    rig, probes = Rig(mixed), FlyingMeasurement()
    probes.on(1, 1, 610, mixed, 0)
    assert passed(rig, probes)[-1] == 1
    assert mixed.mpos.component(0) > 0.0 and fault(mixed.mpos) == POINT_NOT_DEFINED
