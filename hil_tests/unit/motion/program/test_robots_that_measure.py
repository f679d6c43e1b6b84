"""Flying measurement and latch in programs of several kinematics: an arm and a SCARA of one cell, each with inputs of its own.  AX-603."""

import pytest

from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.planner import MeasuringFacts
from gateway.tools.motion.dry_run_team import team_findings
from hil_tests.lab.cells.arm_and_scara import CELL, HEAD
from hil_tests.lab.cells.teams import pair
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Planned
from hil_tests.unit.motion.program.close import same
from hil_tests.unit.motion.program.test_robots_and_inputs import AWAY, HOME, gone, run
from motion.program.text.team import read_team, write_team

OF_ARM, OF_SCARA = 464, 465  # RC inputs
ARM, SCARA = 0b111111, 0b1111000000
CHANNELS = {
    610: MeasuringFacts(OF_ARM, ARM),
    620: MeasuringFacts(OF_SCARA, SCARA),
    630: MeasuringFacts(OF_SCARA, ARM | SCARA),  # axes of both are on its board
    640: MeasuringFacts(OF_SCARA, 0b11),  # its board has two axes of the arm
    621: MeasuringFacts(OF_SCARA, SCARA, latch="fIn0"),
}
BOTH = f"move {AWAY[0]} and {AWAY[1]}"


@pytest.fixture(scope="module")
def cell() -> Planned:
    planned = Planned(Cell402Bench(8, cell=CELL))
    planned.programs.cell.channels, planned.programs.cell.systems = CHANNELS, len(CELL.axis)
    return planned


@pytest.fixture
def home(cell: Planned) -> Planned:
    cell.bench.permit(OF_ARM, OF_SCARA, value=False)
    assert run(cell, HOME) is CommandState.DONE
    return cell


@pytest.mark.requirement("RHO-MOT-16", by="motion.planner.team_route:_owned")
@pytest.mark.parametrize("call", ["measure_on ch620", "measure_on ch630", "set_latch fIn0"])
def test_where_one_was_at_the_edge_is_stored_while_all_go_on_and_it_goes_back_there(home: Planned, call: str) -> None:
    job = home.order(HEAD + "\n".join(["kinematic scara", call, BOTH, "move scara ptp mpos"]))
    home.until(lambda state: gone(home)[1] > 0.5)
    home.bench.permit(OF_SCARA)
    at = gone(home)[1]
    home.bench.run(0.05)
    assert home.state.measured_mask == SCARA, "of its axes alone"
    assert home.bench.settle(job).state is CommandState.DONE
    arm, scara = gone(home)
    assert arm == pytest.approx(1.0, abs=1e-4) and at - 0.05 < scara <= at + 0.01, "the drive lags behind its set value"


def test_of_one_kinematic_a_later_measurement_of_some_axes_leaves_no_earlier_place_of_the_others(home: Planned) -> None:
    job = home.order(HEAD + "\n".join(["kinematic arm", "measure_on ch610", "measure_on ch640", BOTH]))
    home.until(lambda state: gone(home)[0] > 0.3)
    home.bench.permit(OF_ARM)
    home.until(lambda state: state.measured_mask == ARM)
    home.until(lambda state: gone(home)[0] > 0.5)
    home.bench.permit(OF_SCARA)
    assert home.bench.settle(job).state is CommandState.DONE and home.state.measured_mask == 0b11


def test_a_probe_that_is_off_again_stores_nothing_and_leads_on_at_the_label(home: Planned) -> None:
    lines = ["kinematic arm", "measure_on ch610", f"move {AWAY[0]}", "measure_off ch610", HOME, "move arm ptp mpos error=ON", "label ON"]
    job = home.order(HEAD + "\n".join([*lines, "move scara ptp rel joints 4 0 0 0"]))
    home.until(lambda state: gone(home)[0] > 0.99)
    home.until(lambda state: gone(home)[0] < 0.5)
    home.bench.permit(OF_ARM)
    assert home.bench.settle(job).state is CommandState.DONE, job
    assert gone(home) == pytest.approx([0.0, 0.1], abs=1e-4)


@pytest.mark.requirement("RHO-MOT-10", by="gateway.pure.cycle.measured:Measured.store")
@pytest.mark.requirement("RHO-MOT-16", by="gateway.pure.cycle.measured:Measured.store")
def test_each_has_measured_its_own_place_and_all_go_back_to_theirs_in_one_block(home: Planned) -> None:
    lines = ["kinematic arm", "measure_on ch610", "kinematic scara", "measure_on ch620", BOTH, "move arm ptp mpos and scara ptp mpos"]
    job = home.order(HEAD + "\n".join(lines))
    home.until(lambda state: gone(home)[0] > 0.3)
    home.bench.permit(OF_ARM)
    home.until(lambda state: gone(home)[1] > 0.7)
    assert home.state.measured_mask == ARM
    home.bench.permit(OF_SCARA)
    assert home.bench.settle(job).state is CommandState.DONE
    arm, scara = gone(home)
    assert 0.25 < arm < 0.31 and 0.65 < scara < 0.71 and home.state.measured_mask == ARM | SCARA
    lines = ["kinematic scara", "set_latch fIn0", "move scara ptp rel joints 1 0 0 0 speed=20", "move arm ptp mpos"]
    assert run(home, *lines) is CommandState.REFUSED, "of another program it has none"


@pytest.mark.requirement("RHO-MOT-13", by="gateway.pure.cycle.measured:Measured.store")
@pytest.mark.requirement("RHO-MOT-38", by="gateway.pure.cycle.points:ReferencePathRecorder.recall")
@pytest.mark.parametrize("other", ["measure_on ch620", "set_latch fIn0", "record_on 7 1deg"])
def test_what_another_one_measures_or_fetches_later_takes_nothing_from_it(home: Planned, other: str) -> None:
    ends = [f"move {AWAY[0]} until={OF_ARM}", "kinematic scara", other, "move scara ptp joints 4 90 -200 0"]
    fetched = "move scara ptp recorded 2" if other.startswith("record_on") else "move scara ptp mpos error=ON"
    job = home.order(HEAD + "\n".join([*ends, fetched, "move scara ptp rel joints 9 0 0 0", "label ON", "move arm ptp mpos"]))
    home.until(lambda state: gone(home)[0] > 0.5)
    home.bench.permit(OF_ARM)
    at = gone(home)[0]
    assert home.bench.settle(job).state is CommandState.DONE, job.detail
    arm, scara = gone(home)
    assert at - 0.05 < arm < at + 0.01, "where it was at its own edge"
    assert scara == pytest.approx(12 / 40 if "recorded" in fetched else 4 / 40, abs=0.011)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (f"kinematic scara\nmeasure_on ch620\n{BOTH}\nmove arm ptp mpos", "block 2, axis J1: point not defined"),
        (f"kinematic scara\nmeasure_on ch610\n{BOTH}", "inadmissable input: channel 610; probes of the robot: ch620, ch630"),
        (f"kinematic arm\nset_latch fIn0\n{BOTH}", "inadmissable input: set_latch fIn0; the robot has none"),
        (f"kinematic arm\nmeasure_on ch610\nmove {AWAY[1]}", "measure_on: kinematic arm: begins with a block, and none follows"),
    ],
)
def test_what_is_another_ones_is_reported_before_anything_moves(home: Planned, line: str, words: str) -> None:
    job = home.bench.settle(home.order(HEAD + line))
    assert job.state is CommandState.REFUSED and words in job.detail, job.detail


def test_in_the_dry_run_and_written_again() -> None:
    program = read_team(HEAD + "\n".join(["set_latch fIn0", "kinematic arm", "measure_on ch610 edge=0", BOTH, "move arm ptp mpos"]))
    assert same(read_team(write_team(program)), program) and not team_findings(program, pair()).faults
