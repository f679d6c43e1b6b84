"""Set machine position (rho3 4.13) in programs of several kinematics: an arm and a SCARA of one cell, each by itself.  AX-578, AX-592."""

import numpy as np
import pytest

from gateway.pure.image.reasons import CommandState
from gateway.tools.motion.dry_run_team import team_findings, team_traces
from hil_tests.lab.cells.arm_and_scara import CELL, HEAD
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.teams import pair
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Planned
from hil_tests.unit.motion.program.close import same
from hil_tests.unit.motion.program.test_robots_and_inputs import AWAY, HOME, SEEN, run
from hil_tests.unit.motion.program.test_robots_that_measure import ARM, CHANNELS, SCARA
from motion.program.errors import TextFaults
from motion.program.text.team import read_team, write_team

BOTH = f"move {AWAY[0]} and {AWAY[1]}"
AT_HOME = (0, 30, 90, 0, 60, 0, 0, 90, -200, 0)


@pytest.fixture
def cell() -> Planned:
    planned = Planned(Cell402Bench(8, cell=CELL))
    planned.bench.permit(SEEN, value=False)
    planned.programs.cell.channels = CHANNELS
    assert run(planned, HOME) is CommandState.DONE
    gone(planned)
    return planned


def gone(cell: Planned) -> Array:
    """deg and mm of all axes by the emulator's record since the last look: increments, as the drives count them."""
    cell.bench.run(0.05)
    sets = cell.driven().sets
    return np.asarray((sets[-1] - sets[0]) * [1e3 if axis.unit == "mm" else 180 / np.pi for axis in CELL.axis])


@pytest.mark.requirement("RHO-MOT-37", by="gateway.pure.planning.parts:_placed")
@pytest.mark.requirement("RHO-MOT-37", by="gateway.pure.planning.trial:Trial._set_position")
def test_one_is_at_other_numbers_and_all_go_on_from_there_each_by_its_own(cell: Planned) -> None:
    assert run(cell, "kinematic scara", "mach_pos joints 10 80 -150 5", "move arm ptp rel joints 0 0 0 0 0 0") is CommandState.DONE
    assert np.abs(gone(cell)).max() < 0.01, "nothing moves"
    assert cell.bench.set() == pytest.approx((*AT_HOME[:6], 10, 80, -150, 5), abs=1e-6), "and the arm keeps its numbers"
    assert cell.bench.actual()[6:] == pytest.approx((10, 80, -150, 5), abs=0.02), "@POS"
    assert cell.programs.state.placed == SCARA
    assert run(cell, "move arm ptp joints 5 30 90 0 60 0 and scara ptp joints 40 80 -150 5") is CommandState.DONE
    assert gone(cell)[[0, 6]] == pytest.approx([5.0, 30.0], abs=0.01)
    assert run(cell, "kinematic arm", "mach_pos joints 1 2 3 4 5 6", "kinematic scara", "mach_pos joints 0 0 0 0") is CommandState.DONE
    assert cell.bench.set() == pytest.approx((1, 2, 3, 4, 5, 6, 0, 0, 0, 0), abs=1e-6), "behind the last block, or without one"
    assert cell.programs.state.placed == ARM | SCARA and np.abs(gone(cell)).max() < 0.01
    assert run(cell, "kinematic scara", "mach_pos joints 0 0 -100 0", "move scara ptp rel joints 0 0 50 0") is CommandState.DONE, (
        "tried too"
    )


def test_it_is_done_at_rest_before_the_next_block_of_any_and_a_label_may_be_before_it(cell: Planned) -> None:
    corner = "move arm ptp joints 10 30 90 0 60 0 blend=joint leave=40 reach=40"
    lines = [corner, "kinematic scara", "mach_pos joints 50 90 -200 0", "move arm ptp joints 10 50 90 0 60 0"]
    job, near = cell.order(HEAD + "\n".join([*lines, "move scara ptp rel joints 4 0 0 0"])), []
    while job.open:
        cell.bench.cycle()
        near.append((abs(cell.bench.set()[0] - 10) + abs(cell.bench.set()[1] - 30), cell.bench.set()[6]))
    assert job.state is CommandState.DONE and min(near)[0] < 1e-5, "it stops in the point"
    assert near[-1][1] == pytest.approx(54.0, abs=1e-6)
    assert next(away for away, scara in near if scara == pytest.approx(50.0, abs=1e-6)) < 1e-5, "there, and not where the SCARA begins"
    lines = [f"move scara ptp rel joints 8 0 0 0 until={SEEN} error=ON", "move scara ptp rel joints 9 0 0 0", "label ON"]
    assert run(cell, *lines, "kinematic scara", "mach_pos joints 0 90 -200 0") is CommandState.DONE
    assert cell.bench.set()[6:] == pytest.approx((0, 90, -200, 0), abs=1e-6)
    assert gone(cell)[6] == pytest.approx(12.0, abs=0.01), "the block between is left out"


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (
            ["kinematic scara", "mach_pos joints 0 0 5 0", BOTH],
            "line 9: block 1, axis S3: kinematic scara: mach_pos: target 5 mm is outside",
        ),
        (["kinematic arm", "measure_on ch610", BOTH, "mach_pos joints 0 0 0 0 0 0"], "block 2: mach_pos: ch610 waits for its edge"),
        (
            ["kinematic arm", "mach_pos joints 0 0 0 0 0 0", "move arm ptp joints 400 0 0 0 0 0"],
            "axis J1: kinematic arm: target 400 deg is outside",
        ),
    ],
)
def test_what_cannot_be_is_reported_before_anything_moves(cell: Planned, lines: list[str], words: str) -> None:
    job = cell.bench.settle(cell.order(HEAD + "\n".join(lines)))
    assert job.state is CommandState.REFUSED and words in job.detail, job.detail
    assert cell.bench.set() == pytest.approx(AT_HOME, abs=1e-6) and np.abs(gone(cell)).max() < 0.01


def test_a_probe_of_another_one_may_wait_and_stores_its_own_axes(cell: Planned) -> None:
    lines = ["kinematic arm", "measure_on ch630", BOTH, "kinematic scara", "mach_pos joints 0 0 -100 0", "move arm ptp mpos"]
    job = cell.order(HEAD + "\n".join(lines))
    cell.until(lambda _: cell.bench.set()[0] > 20)
    cell.bench.permit(SEEN)
    assert cell.bench.settle(job).state is CommandState.DONE
    assert cell.bench.set()[0] == pytest.approx(20, abs=2) and cell.bench.set()[6:] == pytest.approx((0, 0, -100, 0), abs=1e-6)


def test_the_dry_run_goes_on_from_the_new_numbers_and_sees_no_movement_in_them() -> None:
    lines = ["move scara ptp joints 20 90 -200 0", "kinematic scara", "mach_pos joints 0 90 -200 0", "move arm ptp rel joints 0 0 0 0 0 0"]
    lines += ["kinematic arm", "mach_pos joints 1 30 90 0 60 0", "move arm ptp rel joints 4 0 0 0 0 0 and scara ptp rel joints 8 0 0 0"]
    program = read_team(HEAD + "\n".join([*lines, "kinematic scara", "mach_pos joints 1 1 -1 1"]))
    assert same(read_team(write_team(program)), program)
    findings = team_findings(program, pair())
    arm, scara = team_traces(findings, pair())
    assert not findings.faults and np.degrees(arm.q[-1][0]) == pytest.approx(5) and np.degrees(scara.q[-1][0]) == pytest.approx(8)
    for machine, made in zip(pair().machines, (arm, scara), strict=True):
        assert all(made.loads(machine, order).max() < 1.1 for order in (1, 2, 3)) and made.tool_speed().max() < 3.0
        assert np.abs(made.q).max() < 3.0 and set(made.block.tolist()) == {1, 2, 3}
    faults = team_findings(read_team(HEAD + "kinematic arm\nmach_pos joints 900 0 0 0 0 0\n" + BOTH), pair()).faults
    assert str(faults[0]).startswith("block 1, axis arm.J1: kinematic arm: mach_pos: target 900 deg is outside")


def test_words_are_reported_with_line_kinematic_and_key() -> None:
    for line, says in (
        ("kinematic arm\nmach_pos joints 1 2", "line 8: mach_pos: kinematic arm: 2 values; 6 axes"),
        ("mach_pos joints 1 2 3 4\nlabel X\n" + HOME, "line 8: label: X must be before sync, mach_pos and belt functions"),
    ):
        with pytest.raises(TextFaults) as caught:
            read_team(HEAD + line)
        assert says in str(caught.value)
