"""wait=, until= and @MPOS in programs of several kinematics: an arm and a SCARA of one cell with emulated CiA 402 drives.  AX-341."""

import numpy as np
import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import Motion
from gateway.tools.motion.dry_run_team import team_findings
from hil_tests.lab.cells.arm_and_scara import CELL, HEAD, OWN
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.teams import pair
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Planned
from motion.program.text.team import read_team, write_team

GO, SEEN = 464, 465  # RC inputs
HOME = "move arm ptp joints 0 30 90 0 60 0 and scara ptp joints 0 90 -200 0"
AWAY = "arm ptp joints 40 30 90 0 60 20 speed=20", "scara ptp joints 40 60 -150 0 speed=20"


@pytest.fixture(scope="module")
def cell() -> Planned:
    planned = Planned(Cell402Bench(8, cell=CELL))
    planned.bench.permit(GO, SEEN, value=False)
    return planned


@pytest.fixture
def home(cell: Planned) -> Planned:
    cell.bench.permit(GO, SEEN, value=False)
    assert run(cell, HOME) is CommandState.DONE
    return cell


def run(cell: Planned, *lines: str) -> CommandState:
    return cell.bench.settle(cell.order(HEAD + "\n".join(lines))).state


def gone(cell: Planned) -> Array:
    """Share of the way of J1 of both."""
    at = np.array(cell.bench.set())
    return np.array([at[OWN[0]][0], at[OWN[1]][0]]) / 40.0


@pytest.mark.requirement("RHO-MOT-17", by="gateway.pure.planning.team:begun_part")
def test_a_shared_block_waits_for_its_input_and_all_begin_together(home: Planned) -> None:
    job = home.order(HEAD + f"move {AWAY[0]} wait={GO} and {AWAY[1]}")
    home.bench.run(2.0)  # without it they are half way by then
    assert job.open and np.abs(gone(home)).max() < 1e-6
    home.bench.permit(GO)
    while job.open:
        home.bench.cycle()
        shares = gone(home)
        assert abs(shares[0] - shares[1]) < 1e-4
    assert job.state is CommandState.DONE and gone(home) == pytest.approx([1.0, 1.0], abs=1e-4)


def test_a_stop_of_a_shared_block_that_waits_keeps_its_path_and_ends_one_that_is_still_prepared(home: Planned) -> None:
    """As of a robot alone (AX-322): abandon takes what was kept, and finds nothing where the stop was the end."""
    job = home.order(HEAD + f"move {AWAY[0]} wait={GO} and {AWAY[1]}")
    home.until(lambda _: home.bench.core.starved)
    home.done(Code.STOP)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.STOPPED_BY_SOURCE)
    late = home.bench.settle(home.bench.give(Code.ABANDON))
    assert (late.state, late.reason) == (CommandState.REFUSED, Reason.NOTHING_TO_RESUME)
    job = home.order(HEAD + f"move {AWAY[0]} wait={GO} and {AWAY[1]}")
    home.until(lambda _: home.bench.core.starved)
    home.until(lambda _: not home.bench.core.starved)  # its path is there, and it waits
    home.done(Code.STOP)
    assert (job.open, home.state.motion) == (True, Motion.STOPPED)
    home.bench.permit(GO)
    home.bench.run(1.0)
    assert np.abs(gone(home)).max() < 1e-6, "the input starts nothing behind a stop"
    home.done(Code.ABANDON)
    assert (home.bench.settle(job).state, job.reason) == (CommandState.ABORTED, Reason.ABANDONED)
    assert home.bench.core.state.motion == Motion.IDLE and np.abs(gone(home)).max() < 1e-6


@pytest.mark.requirement("RHO-MOT-10", by="gateway.pure.planning.team:begun_part")
def test_an_input_ends_the_block_of_all_on_their_path_and_mpos_is_that_of_the_one_that_asked(home: Planned) -> None:
    lines = [f"move {AWAY[0]} and {AWAY[1]} until={SEEN}", f"move arm ptp rel joints 5 0 0 0 0 0 wait={GO}", "move scara ptp mpos"]
    job = home.order(HEAD + "\n".join(lines))
    home.until(lambda state: gone(home)[0] > 0.5)
    home.bench.permit(SEEN)
    seen = gone(home)[1]
    home.until(lambda state: state.motion is not Motion.RUNNING)
    home.bench.run(0.3)
    stood = gone(home)
    assert 0.5 < stood[0] < 0.95 and abs(stood[0] - stood[1]) < 1e-4, "on the path, both"
    home.bench.permit(GO)
    assert home.bench.settle(job).state is CommandState.DONE
    arm, scara = gone(home)
    assert arm == pytest.approx(stood[0] + 5 / 40, abs=1e-4), "the next block begins where the axes stand"
    assert seen - 0.02 < scara < stood[1] - 0.01, "back to where the SCARA was at the edge"


LABELS = [
    f"move {AWAY[0]} and {AWAY[1]} until={SEEN} error=NONE",
    "move scara ptp mpos",
    "move arm ptp rel joints 5 0 0 0 0 0",
    "label NONE",
    "move arm ptp rel joints -10 0 0 0 0 0 and scara ptp rel joints -20 0 0 0",
]


@pytest.mark.requirement("RHO-MOT-12", by="gateway.pure.planning.trial:Trial.together")
@pytest.mark.parametrize("seen", [True, False])
def test_without_its_input_a_shared_block_leads_on_at_its_label_for_all(home: Planned, seen: bool) -> None:
    job = home.order(HEAD + "\n".join(LABELS))
    home.until(lambda state: gone(home)[0] > 0.5)
    home.bench.permit(SEEN, value=seen)
    at = gone(home)
    assert home.bench.settle(job).state is CommandState.DONE
    ends = np.array([1.0 - 10 / 40, 1.0 - 20 / 40])
    if seen:  # the arm stopped with the SCARA, and goes on by 5 - 10
        arm, scara = gone(home)
        assert at[0] - 0.02 < arm + 5 / 40 < at[0] + 0.2 and at[1] - 0.05 < scara + 20 / 40 < at[1] + 0.02
    else:
        assert gone(home) == pytest.approx(ends, abs=1e-4), "blocks 2 and 3 are left out"


@pytest.mark.requirement("RHO-MOT-13", by="gateway.pure.planning.team:not_measured")
def test_mpos_of_one_where_nothing_was_measured_leads_all_on_at_its_label(home: Planned) -> None:
    lines = [f"move {AWAY[0]} and {AWAY[1]} until={SEEN}", "move arm ptp rel joints 5 0 0 0 0 0 and scara ptp mpos error=END"]
    job = home.order(HEAD + "\n".join([*lines, "move arm ptp rel joints 5 0 0 0 0 0", "label END"]))
    assert home.bench.settle(job).state is CommandState.DONE
    assert gone(home) == pytest.approx([1.0, 1.0], abs=1e-4), "neither of them went on"
    job = home.bench.settle(home.order(HEAD + "\n".join([HOME, *lines]).replace(" error=END", "")))
    assert job.state is CommandState.ABORTED and "block 3" in job.detail and "point not defined" in job.detail


@pytest.mark.requirement("RHO-MOT-12", by="gateway.pure.planning.parts:Coming.takes")
def test_a_labelled_block_begins_from_rest_and_is_a_part_of_its_own(home: Planned) -> None:
    rounded = "move arm ptp joints 10 30 90 0 60 0 blend=joint leave=20 reach=20"
    end = "move arm ptp joints 40 60 90 0 60 0"

    def nearest(*lines: str) -> float:
        """How near the point of the rounded block comes, in shares of the arm's way."""
        job, near = home.order(HEAD + "\n".join(lines)), []
        home.until(lambda state: gone(home)[0] > 0.5)
        home.bench.permit(SEEN)
        while job.open:
            home.bench.cycle()
            near.append(abs(gone(home)[0] - 0.25))
        home.bench.permit(SEEN, value=False)
        assert job.state is CommandState.DONE
        return float(min(near))

    assert nearest(f"move {AWAY[0]} until={SEEN} error=ON", rounded, "label ON", end) < 1e-5, "it stops in the point before the label"
    assert nearest(HOME, f"move {AWAY[0]} until={SEEN}", rounded, end) > 1e-3, "and rounds it where there is none"


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (
            f"move {AWAY[0]} until={GO} and {AWAY[1]} until={SEEN}",
            "only one kinematic may define what a shared block waits for, or ends with",
        ),
        (f"move {AWAY[0]} until={GO}\nmove scara ptp mpos", "@MPOS is measured by until= or measure_on before it"),
        (f"move {AWAY[0]} until={GO} error=X\nmove {AWAY[1]}", "error: label X does not follow the block"),
        ("move arm ptp joints 400 0 0 0 0 0 until=464", "J1"),
        (f"move {AWAY[0]} until={GO}\nmove arm ptp joints 400 0 0 0 0 0", "block 2"),
    ],
)
def test_what_cannot_be_is_reported_before_anything_moves(home: Planned, line: str, words: str) -> None:
    before = home.bench.set()
    job = home.bench.settle(home.order(HEAD + line))
    assert job.state is CommandState.REFUSED and words in job.detail, job.detail
    assert home.bench.set() == before


def test_in_the_dry_run_and_written_again() -> None:
    text = HEAD + f"move {AWAY[0]} and {AWAY[1]} until={SEEN}\nmove scara linear mpos wait={GO} delay=0.1\n"
    program = read_team(text)
    assert not team_findings(program, pair()).faults
    again = read_team(write_team(program))
    assert [shared.asks for shared in again.blocks] == [True, True] and again.blocks[0].ends
    text = f"{HEAD}move {AWAY[0]} until={SEEN}\nmove arm ptp mpos error=X and scara ptp mpos error=Y\nlabel X\nlabel Y\n"
    (fault,) = team_findings(read_team(text), pair()).faults
    assert "block 2: a shared block continues at one label, not at X and Y: error= of one of them" in str(fault)


def test_the_time_of_one_kinematic_ends_a_shared_block_for_all_and_leads_to_its_label(home: Planned) -> None:
    lines = [f"move {AWAY[0]} and {AWAY[1]} until={SEEN} within=1.0 error=LATE", HOME, "label LATE", "move arm ptp rel joints 1 0 0 0 0 0"]
    job = home.order(HEAD + "\n".join(lines))
    home.until(lambda state: state.motion is Motion.RUNNING)
    home.bench.run(1.0)
    assert home.bench.settle(job).state is CommandState.DONE
    arm, scara = gone(home)
    assert 0.1 < scara < 0.9 and arm == pytest.approx(scara + 1 / 40, abs=1e-3), "both stopped on the way, and none went home"
    assert home.state.measured_mask == 0
