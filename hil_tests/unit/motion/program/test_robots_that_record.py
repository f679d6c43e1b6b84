"""Reference paths in programs of several kinematics (rho3 4.12): an arm and a SCARA of one cell, each with its own.  AX-603."""

import numpy as np
import pytest

from gateway.pure.image.reasons import CommandState
from gateway.tools.motion.dry_run_team import team_findings
from hil_tests.lab.cells.arm_and_scara import CELL, HEAD
from hil_tests.lab.cells.teams import pair
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Planned
from hil_tests.unit.motion.program.close import same
from hil_tests.unit.motion.program.test_robots_and_inputs import AWAY, HOME, gone, run
from motion.program.errors import TextFaults
from motion.program.text.team import read_team, write_team

BOTH = f"move {AWAY[0]} and {AWAY[1]}"
RECORDS = ["kinematic arm", "record_on 1 13deg", "kinematic scara", "record_on 7 9deg", BOTH]  # J1 and S1
OFF = ["kinematic arm", "record_off", "kinematic scara", "record_off"]
LAG = 0.045  # of the way: what a drive lags behind its set value at that speed


@pytest.fixture(scope="module")
def cell() -> Planned:
    planned = Planned(Cell402Bench(8, cell=CELL))
    planned.programs.cell.systems = len(CELL.axis)
    return planned


@pytest.fixture
def recorded(cell: Planned) -> Planned:
    """Both at home, their ways to AWAY recorded."""
    assert run(cell, HOME, *RECORDS, *OFF, HOME) is CommandState.DONE
    assert gone(cell) == pytest.approx([0.0, 0.0], abs=1e-6)
    return cell


@pytest.mark.requirement("RHO-MOT-38", by="gateway.pure.cycle.points:ReferencePathRecorder.call")
def test_each_goes_back_over_its_own_path_alone_and_while_the_other_one_moves(recorded: Planned) -> None:
    assert run(recorded, "move arm ptp recorded 2 and scara ptp joints 20 90 -200 0") is CommandState.DONE
    assert gone(recorded) == pytest.approx([26 / 40, 0.5], abs=LAG)
    assert run(recorded, "move scara ptp recorded 1", "move arm ptp recorded 3") is CommandState.DONE
    assert gone(recorded) == pytest.approx([13 / 40, 36 / 40], abs=LAG)
    assert recorded.bench.set()[7] == pytest.approx(90 - 30 * gone(recorded)[1], abs=1e-3), "its other axes, too: on the path"


def test_what_one_records_anew_leaves_the_path_of_the_other_one(recorded: Planned) -> None:
    assert run(recorded, "kinematic scara", "record_on 7 5deg", "ptp joints 12 90 -200 0 speed=20") is CommandState.DONE
    assert run(recorded, "move scara ptp recorded 2", "move arm ptp recorded 2") is CommandState.DONE
    assert gone(recorded) == pytest.approx([26 / 40, 5 / 40], abs=LAG)
    assert run(recorded, "move scara ptp recorded 9") is CommandState.ABORTED
    assert "block 1: Point is invalid: no entry 9 is stored (rho 3 90)" in recorded.programs.state.fault


@pytest.mark.requirement("RHO-MOT-38", by="gateway.pure.planning.trial:Trial.together")
def test_an_entry_that_is_not_stored_leads_all_on_at_the_label(recorded: Planned) -> None:
    lines = ["move arm ptp recorded 9 error=ON and scara ptp rel joints 8 0 0 0", "move scara ptp rel joints 4 0 0 0", "label ON"]
    assert run(recorded, *lines, "move scara ptp rel joints 2 0 0 0") is CommandState.DONE
    assert gone(recorded) == pytest.approx([0.0, 2 / 40], abs=1e-6)
    assert run(recorded, *lines[:1], "label ON") is CommandState.DONE
    assert run(recorded, lines[0].replace("9", "1"), "label ON") is CommandState.DONE
    assert gone(recorded) == pytest.approx([39 / 40, 10 / 40], abs=LAG)


def test_a_call_begins_with_the_next_block_of_the_kinematic_named_last_and_is_called_once(recorded: Planned) -> None:
    job = recorded.order(HEAD + "\n".join(["kinematic arm", "record_on 1 10cycles", f"move {AWAY[1]}", f"move {AWAY[0]}", *OFF[:2], HOME]))
    on = []
    while job.open:
        recorded.bench.cycle()
        on.append((*gone(recorded), recorded.bench.core.lanes[0].mover.storing.tape.on))
    assert job.state is CommandState.DONE
    moving = [(arm, scara) for arm, scara, running in on if running]
    assert all(scara > 0.999 for _, scara in moving) and np.ptp([arm for arm, _ in moving]) > 0.99
    assert not recorded.bench.core.lanes[0].mover.storing.tape.on
    lines = ["kinematic arm", "record_on 1 2deg", "move arm ptp recorded 1", "move arm ptp joints 30 30 90 0 60 0 until=465", "record_off"]
    assert run(recorded, *lines, "move arm ptp rel joints 0 0 0 0 0 0", "move arm ptp recorded 15") is CommandState.DONE, (
        "those of the way to the entry"
    )


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("move arm ptp recorded 1 and scara ptp recorded 1", "block 1: only one kinematic of a shared block can move to an entry"),
        ("kinematic scara\nrecord_on 11 5mm\nlinear rel pose 5 0 0 0 0 0", "block 1: Inadmiss. meas. sys. 11: 1 .. 10 exist (rho 3 91)"),
        (f"move {AWAY[0]} until=464\nmove arm ptp recorded 1\nmove arm ptp mpos", "block 3, axis J1: point not defined"),
        (f"kinematic arm\nrecord_off\nmove {AWAY[1]}", "record_off: kinematic arm: begins with a block, and none follows"),
    ],
)
def test_what_cannot_be_is_reported_before_anything_moves(recorded: Planned, line: str, words: str) -> None:
    job = recorded.bench.settle(recorded.order(HEAD + line))
    assert job.state is CommandState.REFUSED and words in job.detail, job.detail


def test_in_the_dry_run_and_written_again() -> None:
    text = HEAD + "\n".join([*RECORDS, *OFF, "move arm ptp recorded 2 error=END and scara linear rel pose 5 0 0 0 0 0", "label END", HOME])
    program = read_team(text)
    assert same(read_team(write_team(program)), program) and not team_findings(program, pair()).faults
    with pytest.raises(TextFaults, match="line 8: record_on: measuring system from 1 on"):
        read_team(f"{HEAD}kinematic arm\nrecord_on x 5mm\n{HOME}")
