"""Set machine position (rho3 4.13), reference path (4.12) and VAL 3's latch in programs: words, paper, cells.  AX-578, AX-579."""

import numpy as np
import pytest

from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.planner import MeasuringFacts
from gateway.pure.image.records.points import LatchAt, ReferencePathPoint, latch_of, latch_record, tape_of, tape_record
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.cycle_view import CycleView
from gateway.pure.planning.planner import Programs
from gateway.tools.motion.dry_run import DryRun, sections_of
from hil_tests.lab.cells import arms
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.virtual.belt_bench import CELL
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot
from hil_tests.lab.virtual.probing import CHANNELS, CLOSE, FAST, ON_ALL, ON_TWO, PROBE, Probing
from hil_tests.lab.virtual.program_bench import joints
from hil_tests.unit.motion.program.close import same_program
from motion.program.errors import TextFaults
from motion.program.text.reader import read
from motion.program.text.writer import write

HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\n"


class Portal(Planned):
    """X, Y, Z, C with absolute encoders."""

    def __init__(self) -> None:
        super().__init__(ServodynRobot(cell=CELL))
        self.programs.cell.systems = 4

    def run(self, *lines: str) -> CommandState:
        return self.bench.settle(self.order(HEAD + "\n".join(lines))).state

    def sets(self) -> Array:
        """mm and deg by the emulator's record since the last look: increments, as the drives count them."""
        self.bench.run(0.05)
        return np.asarray(self.driven().sets * (1e3, 1e3, 1e3, 180 / np.pi))


@pytest.fixture
def cell() -> Portal:
    """At 100, 100, 50, 0."""
    portal = Portal()
    assert portal.run("ptp joints 100 100 50 0") is CommandState.DONE
    portal.sets()
    return portal


# ---- set machine position ----------------------------------------------------------------------------------------------------


@pytest.mark.requirement("RHO-MOT-37", by="gateway.pure.cycle.points:set_machine_position")
@pytest.mark.requirement("RHO-MOT-37", by="gateway.pure.planning.parts:Coming.own")
def test_the_axes_are_at_other_numbers_nothing_moves_and_the_next_block_and_the_limits_count_from_them(cell: Portal) -> None:
    assert cell.run("mach_pos joints 30 20 50 0", "ptp rel joints 0 0 0 0") is CommandState.DONE
    assert np.ptp(cell.sets(), axis=0).max() < 0.01, "nothing moves"
    assert cell.bench.set() == pytest.approx([30.0, 20.0, 50.0, 0.0], abs=1e-6)
    assert cell.bench.actual() == pytest.approx([30.0, 20.0, 50.0, 0.0], abs=0.02), "@POS"
    assert cell.programs.state.placed == 0b1111
    assert cell.run("ptp joints 40 20 50 0", "linear pose 40 60 50 0 0 0") is CommandState.DONE
    assert cell.sets()[-1] == pytest.approx([110.0, 140.0, 50.0, 0.0], abs=0.02)
    far = next(axis for axis in CELL.axis if axis.name == "X").limits
    assert far is not None
    assert cell.run(f"ptp joints {far.max - 5} 20 50 0") is CommandState.DONE, "the limits are those of the new numbers"
    assert cell.run(f"ptp joints {far.max + 5} 20 50 0") is CommandState.REFUSED
    cell.bench.restart_cycle()
    cell.bench.run(0.3)
    assert cell.bench.actual()[0] == pytest.approx(far.max - 5 + 70, abs=0.05), "a start-up undoes it"


def test_behind_a_block_and_before_one_and_what_it_may_not_be_is_reported_before_anything_moves(cell: Portal) -> None:
    assert (
        cell.run("linear pose 120 100 50 0 0 0", "mach_pos joints 0 0 0 0", "linear pose 10 0 0 0 0 0", "mach_pos joints 7 7 7 7")
        is CommandState.DONE
    )
    assert cell.sets()[-1] == pytest.approx([130.0, 100.0, 50.0, 0.0], abs=0.02)
    assert cell.bench.set() == pytest.approx([7.0] * 4, abs=1e-6)
    assert cell.run("ptp joints 8 8 8 8", "mach_pos joints 0 9999 0 0", "ptp joints 0 0 0 0") is CommandState.REFUSED
    state = cell.programs.state
    assert state.fault.startswith("line 7: block 2, axis Y: mach_pos: target 9999 mm is outside") and state.fault_block == 2
    cell.programs.cell.channels = {610: MeasuringFacts(PROBE, 15)}
    lines = ("measure_on ch610", "ptp joints 8 8 8 8", "mach_pos joints 0 0 0 0", "ptp joints 1 1 1 1")
    assert cell.run(*lines) is CommandState.REFUSED and "mach_pos: ch610 waits for its edge" in cell.programs.state.fault
    assert np.ptp(cell.sets(), axis=0).max() < 0.01


def test_a_planner_that_follows_knows_of_it_as_long_as_the_cycle_runs(cell: Portal) -> None:
    assert cell.run("mach_pos joints 0 0 0 0") is CommandState.DONE
    after = Programs(CellPrograms(lambda *_: cell.machine, lambda _: 15))
    after.follows(cell.programs.state)
    after.turn([], CycleView(cell.state.generation, 0, [0.0] * 4, moving=False))
    assert after.state.placed == 15
    after.turn([], CycleView(cell.state.generation + 1, 0, [0.0] * 4, moving=False))
    assert after.state.placed == 0


def test_the_dry_run_goes_on_from_the_new_numbers_and_sees_no_movement_in_them() -> None:
    program = read("axes mm mm mm\nstart 0 0 0\nptp joints 100 0 0\nmach_pos joints 0 0 0\nlinear rel pose 20 0 0 0 0 0\n")
    sections, faults = sections_of(program, arms.portal(), ())
    made = DryRun(arms.portal(), (), ()).run(sections)
    assert not faults and made.q[-1] == pytest.approx((0.02, 0.0, 0.0), abs=1e-9)
    assert all(made.loads(arms.portal(), order).max() < 1.1 for order in (1, 2, 3)) and made.tool_speed().max() < 3.0
    lines = "ptp joints 100 9 0\nmach_pos joints 50 9 0\nptp joints 50 9 0\nmach_pos joints 80 9 0\nlinear rel pose 20 0 0 0 0 0\n"
    made = DryRun(arms.portal(), (), ()).run(sections_of(read("axes mm mm mm\nstart 0 9 0\n" + lines), arms.portal(), ())[0])
    assert made.q[:, 1] == pytest.approx(0.009) and made.q[made.block == 2] == pytest.approx(np.array([(0.05, 0.009, 0.0)])), "no way"
    faults = sections_of(read("axes mm mm mm\nstart 0 0 0\nmach_pos joints 0 0 9e5\nptp joints 1 0 0\n"), arms.portal(), ())[1]
    assert "block 1, axis z: mach_pos" in str(faults[0])


# ---- reference path ----------------------------------------------------------------------------------------------------------


@pytest.mark.requirement("RHO-MOT-38", by="gateway.pure.cycle.points:ReferencePathRecorder.store")
@pytest.mark.requirement("RHO-MOT-38", by="gateway.pure.cycle.points:ReferencePathRecorder.recall")
@pytest.mark.requirement("RHO-MOT-38", by="gateway.pure.image.records.points:tape_of")
def test_each_13_mm_of_a_measuring_system_is_kept_and_the_program_goes_back_over_it(cell: Portal) -> None:
    written = ReferencePathPoint(7, 0.25, 1, 0.013, kinematic=2)
    assert tape_of(tape_record(1, 1, written)) == written, "through the ring of the cycle"
    assert (
        cell.run("record_on 1 13mm", "linear pose 165 120 50 0 0 0 path=40", "record_off", "linear pose 300 120 50 0 0 0")
        is CommandState.DONE
    )
    cell.sets()
    assert cell.run("linear recorded 1", "linear recorded 2") is CommandState.DONE
    here = cell.bench.set()
    assert here[0] == pytest.approx(139.0, abs=1.5), "the one before the latest of four; the drive lags behind its set value"
    assert here[1] == pytest.approx(100.0 + (here[0] - 100.0) * 20.0 / 65.0, abs=1e-3), "on the path"
    assert cell.run("ptp recorded 4") is CommandState.DONE and cell.bench.set()[0] == pytest.approx(113.0, abs=1.5)
    cell.sets()
    assert cell.run("ptp recorded 5") is CommandState.ABORTED
    assert "block 1: Point is invalid: no entry 5 is stored (rho 3 90)" in cell.programs.state.fault
    assert np.ptp(cell.sets(), axis=0).max() < 0.01


def test_cycles_count_too_and_a_measuring_system_that_is_not_there_is_91_before_anything_moves(cell: Portal) -> None:
    assert cell.run("record_on 4 10cycles", "linear pose 165 120 50 0 0 0 path=40") is CommandState.DONE
    first = cell.bench.core.lanes[0].mover.storing.tape
    cell.bench.cycle(600)
    assert cell.run("record_off", "ptp rel joints 1 0 0 0", "ptp recorded 50") is CommandState.DONE, "fifty entries of rest, and no more"
    assert cell.bench.set()[0] == pytest.approx(165.0, abs=1e-6) and not first.on
    assert cell.run("ptp joints 1 1 1 1", "record_on 5 10mm", "ptp joints 100 100 50 0") is CommandState.REFUSED
    assert cell.programs.state.fault == "line 7: block 2: Inadmiss. meas. sys. 5: 1 .. 4 exist (rho 3 91)"


# ---- setLatch, getLatch ------------------------------------------------------------------------------------------------------

LATCHES = {**CHANNELS, 611: MeasuringFacts(FAST, ON_ALL, latch="fIn0"), 621: MeasuringFacts(PROBE, ON_TWO, latch="fIn1")}


@pytest.fixture(scope="module")
def arm() -> Probing:
    found = Probing()
    found.programs.cell.channels = LATCHES
    return found


@pytest.mark.requirement("VAL-LATCH-01", by="gateway.pure.cycle.points:CoreLatch.look")
@pytest.mark.requirement("VAL-LATCH-01", by="gateway.pure.cycle.points:CoreLatch.store")
@pytest.mark.requirement("VAL-LATCH-01", by="gateway.pure.image.records.points:latch_of")
def test_set_latch_stores_where_the_axes_were_at_the_rising_edge_and_the_program_goes_there(arm: Probing) -> None:
    asked = LatchAt(7, 0.25, 611, 0b11, "fIn0")
    assert latch_of(latch_record(1, 1, asked)) == asked, "through the ring of the cycle"
    job = arm.order("set_latch fIn0", f"ptp joints {joints(50)}", "ptp mpos")
    stamp = arm.edge_at(20.0, FAST, ago=0.37)
    arm.cell.run(0.02)
    was = arm.was(stamp)
    assert arm.measured == pytest.approx(was, abs=CLOSE)
    arm.change(FAST, value=False)
    arm.cell.run(0.02)
    arm.change(FAST)
    assert arm.finished(job).state is CommandState.DONE
    place = arm.places()[0] * arm.cell.dispatcher.axes[0].si
    assert place == pytest.approx(was, abs=CLOSE), "the first edge, and no later one"


def refused(arm: Probing, *lines: str) -> str:
    assert arm.finished(arm.order(*lines)).state is CommandState.REFUSED
    return arm.programs.state.fault


def test_a_level_that_stays_and_a_falling_edge_latch_nothing_and_a_second_set_latch_forgets(arm: Probing) -> None:
    arm.change(FAST)
    assert arm.finished(arm.order(f"ptp joints {joints(2)}")).state is CommandState.DONE
    job = arm.order("set_latch fIn0", f"ptp joints {joints(40)}", "ptp mpos")
    arm.edge_at(20.0, PROBE)
    arm.change(FAST, value=False)
    assert arm.finished(job).state is CommandState.ABORTED and "point not defined" in job.detail
    assert arm.finished(arm.order(f"ptp joints {joints(2)}")).state is CommandState.DONE
    job = arm.order("set_latch fIn0", f"ptp joints {joints(40)}", "set_latch fIn0", f"ptp joints {joints(41)}")
    arm.edge_at(20.0, FAST)
    arm.cell.run(0.02)
    assert arm.cell.core.state.measured_mask == ON_ALL
    assert arm.finished(job).state is CommandState.DONE and not arm.cell.core.state.measured_mask


def test_what_is_no_fast_input_of_the_cell_is_reported_before_anything_moves(arm: Probing) -> None:
    arm.programs.cell.channels = {611: MeasuringFacts(FAST, ON_ALL)}
    assert "inadmissable input: set_latch fIn0; the robot has none" in refused(arm, "set_latch fIn0", f"ptp joints {joints(9)}")
    arm.programs.cell.channels = LATCHES
    assert "point not defined" in refused(arm, "set_latch fIn1", f"ptp joints {joints(9)}", "ptp mpos"), "its board has two axes"
    assert "point not defined" in refused(arm, "set_latch fIn0", f"ptp joints {joints(9)}", "ptp recorded 1", "ptp mpos")


# ---- words -------------------------------------------------------------------------------------------------------------------


def told(line: str) -> str:
    with pytest.raises(TextFaults) as caught:
        read(HEAD + line)
    return str(caught.value)


def test_words_are_read_and_written_and_reported_with_line_and_key() -> None:
    lines = (
        "record_on 4 13.5mm\nset_latch fIn1\nlinear rel pose 1 0 0 0 0 0\nmach_pos joints 1 2 3 4\nrecord_off\nptp joints 1 2 3 4\n"
        "record_on 1 5deg\nlinear recorded 3 path=50\nrecord_on 2 10cycles\nptp recorded 50\nmach_pos joints 0 0 0 0\n"
    )
    program = read(HEAD + lines)
    assert same_program(read(write(program, "rho3")), program)
    assert "line 5: set_latch: dIn0 is not a fast input, fIn0 and fIn1 are (VAL 3 70)" in told("set_latch dIn0\nptp joints 1 1 1 1")
    assert "set_latch: begins with a block" in told("set_latch fIn0")
    assert "record_on: measuring system from 1 on" in told("record_on 0 5mm") and "13mm" in told("record_on 1")
    assert "record_on: 0.5: a whole number of cycles" in told("record_on 1 0.5cycles")
    assert "recorded: '51'" in told("ptp recorded 51") and "recorded" in told("spline recorded 1")
    assert "mach_pos: 2 values; 4 axes" in told("mach_pos joints 1 2") and "mach_pos joints" in told("mach_pos 1 2 3 4")
