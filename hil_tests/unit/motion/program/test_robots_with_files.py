"""MOVE_FILE (rho 3 SF 45) in programs of several kinematics: one runs its file, the others rest.  An arm and a SCARA.  AX-576, AX-593."""

import pathlib

import numpy as np
import pytest

from gateway.assembly.path_outputs import functions_of
from gateway.cell_file.load import CellFaults, load_cell
from gateway.commands import motion
from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion, get_bit
from gateway.pure.planning.trial import Files
from gateway.tools.motion.dry_run_team import team_findings, team_traces
from hil_tests.lab.cells.arm_and_scara import HEAD, cell_text
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.carried_cell import ARM
from hil_tests.lab.cells.teams import pair
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Planned
from hil_tests.unit.motion.program.close import same
from hil_tests.unit.motion.program.test_robots_and_inputs import AWAY, HOME, run
from hil_tests.unit.motion.program.test_robots_with_functions import tips
from motion.errors import MotionError
from motion.files import bnr
from motion.files.bnr import Header
from motion.program.errors import TextFaults
from motion.program.text.team import read_team, write_team

P5_US = 8000
K = np.arange(1, 201) / 200
START = (0.0, 90.0, -200.0, 0.0)
WAY = np.outer(10 * K**3 - 15 * K**4 + 6 * K**5, (40.0, -20.0, 30.0, 60.0)) + START  # deg and mm, from rest to rest
ARM_WAY = np.outer(10 * K**3 - 15 * K**4 + 6 * K**5, (20.0, 0.0, 0.0, 0.0, 0.0, 0.0)) + (0.0, 30.0, 90.0, 0.0, 60.0, 0.0)
FILES = {
    "scara.bnr": bnr.encode(Header(time_base_us=P5_US, axes=4), WAY.tolist()),
    "arm.bnr": bnr.encode(Header(time_base_us=P5_US, axes=6), ARM_WAY.tolist()),
}
SCARA_RUNS = ["kinematic scara", "read_begin scara.bnr", "move_file scara.bnr modulo=0,0,0,0"]
ARM_RUNS = ["kinematic arm", "read_begin arm.bnr 80", "move_file arm.bnr modulo=0,0,0,0,0,0"]
FINE = 0.6 / (65536 / 360.0)
IOL = '[[path_output]]\nkind = "iol"\nfunction = 2\noutput = 416\nrobot = "scara"\n\n'


def files(name: str, number: int) -> bytes:
    try:
        return FILES[name]
    except KeyError:
        raise MotionError(f"{name}: no such file") from None


@pytest.fixture(scope="module")
def cell() -> Planned:
    planned = Planned(Cell402Bench(8, cell=load_cell(str(ARM), cell_text(IOL))))
    planned.bench.core.lanes[0].mover.functions = functions_of(planned.cell, planned.bench.p5_ms)
    planned.programs.cell.files = Files(files, P5_US)
    return planned


@pytest.fixture
def home(cell: Planned) -> Planned:
    assert run(cell, HOME) is CommandState.DONE
    return cell


def rows(cell: Planned, text: str) -> Array:
    """Set values of all axes, cycle by cycle, deg and mm."""
    job, found = cell.order(HEAD + text), []
    while job.open:
        cell.bench.cycle()
        found.append(cell.bench.set())
    assert job.state is CommandState.DONE, job.detail
    return np.array(found)


@pytest.mark.requirement("RHO-MOT-43", by="gateway.pure.planning.trial:Files.played")
@pytest.mark.requirement("RHO-MOT-43", by="gateway.pure.planning.trial:Trial._file")
def test_the_points_of_a_file_are_set_values_of_its_kinematic_and_the_others_rest(home: Planned) -> None:
    lines = [*SCARA_RUNS, *ARM_RUNS, "move arm ptp rel joints 0 0 0 0 0 10 and scara ptp rel joints 1 0 0 0"]
    made = rows(home, "\n".join(lines))
    first = next(k for k, row in enumerate(made) if abs(row[6] - WAY[20][0]) < 1e-4)
    assert np.abs(made[first : first + 170, 6:] - WAY[20:190]).max() < 1e-4, "one after the other, one a cycle"
    assert np.abs(made[: first + 170, :6] - ARM_WAY[0]).max() < 0.01 and np.ptp(made[: first + 170, 0]) == 0.0, "the arm rests"
    then = next(k for k, row in enumerate(made) if abs(row[0] - ARM_WAY[20][0]) < 1e-4)
    assert then > first + 170 and np.abs(made[then : then + 170, :6] - ARM_WAY[20:190]).max() < 1e-4
    assert np.ptp(made[then : then + 170, 6:], axis=0).max() == 0.0, "the SCARA rests"
    assert made[-1] == pytest.approx((20, 30, 90, 0, 60, 10, 41, 70, -170, 60), abs=1e-3), "and both go on from there"


def test_a_stop_stays_on_the_curve_and_functions_begin_with_it(home: Planned) -> None:
    z = tips(home)[1]
    job = home.order(HEAD + "\n".join(["kinematic scara", f"iol 2 2 3 {z + 10:.3f} 1 0", *SCARA_RUNS, "iol -2 2 3 0 0 0", HOME]))
    home.until(lambda _: get_bit(home.bench.core.outputs, 416))
    assert tips(home)[1] == pytest.approx(z + 10, abs=0.7), "led by its own z"
    home.until(lambda state: state.axes[6].set > 0.4)
    home.done(Code.STOP)
    home.until(lambda state: state.motion is Motion.STOPPED)
    home.bench.run(0.2)
    share = (np.array(home.bench.set()[6:]) - START) / (40, -20, 30, 60)
    assert 0.3 < share[0] < 0.9 and share == pytest.approx([share[0]] * 4, abs=1e-4)
    home.done(Code.RESUME)
    assert home.bench.settle(job).state is CommandState.DONE


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([HOME, *SCARA_RUNS[:1], "move_file scara.bnr"], "line 9: block 2: kinematic scara: READ_BEGIN expected: scara.bnr"),
        (
            [HOME, "kinematic scara", "read_begin arm.bnr", "move_file arm.bnr"],
            "kinematic scara: MF: No. of axes: arm.bnr: 6, the kinematic has 4",
        ),
        ([f"move {AWAY[1]}", *SCARA_RUNS], "block 2, axis S1: kinematic scara: scara.bnr: speed to point 1"),
        ([*SCARA_RUNS, "read_begin no.bnr", "move_file no.bnr"], "line 11: block 2: move_file no.bnr: no such file"),
        (["move scara linear rel pose 0 0 0 0 0 0 out=400:1", *SCARA_RUNS], "block 1: this action needs a motion to attach to"),
    ],
)
def test_a_cell_reports_errors_with_line_block_and_kinematic_before_anything_moves(home: Planned, lines: list[str], words: str) -> None:
    before = home.bench.set()
    job = home.bench.settle(home.order(HEAD + "\n".join(lines)))
    assert job.state is CommandState.REFUSED and words in job.detail, job.detail
    assert home.bench.set() == before


def test_the_dry_run_runs_it_point_by_point_and_what_follows_begins_where_it_ends() -> None:
    lines = [f"move {AWAY[0]}", *SCARA_RUNS, "move scara ptp rel joints 1 0 0 0", *ARM_RUNS[:2], "move_file arm.bnr", HOME]
    program = read_team(HEAD + "\n".join(lines))
    assert same(read_team(write_team(program)), program)
    (fault,) = team_findings(program, pair(), Files(files, P5_US)).faults
    assert str(fault).startswith("block 4, axis arm.J1: kinematic arm: MF: MOD-Flag n. init.")
    program = read_team(HEAD + "\n".join([*lines[:5], "close scara.bnr", "label X", HOME]))
    assert same(read_team(write_team(program)), program)
    findings = team_findings(program, pair(), Files(files, P5_US))
    arm, scara = team_traces(findings, pair())
    filed = np.degrees(scara.q[scara.block == 2][8::8][: len(WAY)])
    assert np.abs(filed[:, [0, 1, 3]] - WAY[: len(filed), [0, 1, 3]]).max() < 1e-4 and len(filed) == len(WAY), (
        "1 ms grid, a point each 8 ms"
    )
    assert np.degrees(arm.q[arm.block == 2][:, 0]) == pytest.approx(40.0) and np.degrees(scara.q[scara.block == 3][-1][0]) == pytest.approx(
        41.0
    )
    assert scara.loads(pair().machines[1], 1).max() <= 1.0 and set(scara.block.tolist()) == {1, 2, 3, 4}


def test_words_are_reported_with_line_kinematic_and_key() -> None:
    for line, says in (
        ("move_file a.bnr speed=3", "line 8: speed: kinematic scara: move_file accepts only base= and modulo="),
        (
            "move arm move_file a.bnr and scara ptp joints 0 0 0 0",
            "move_file: only one kinematic runs a file, in its own line: kinematic arm,",
        ),
    ):
        with pytest.raises(TextFaults) as caught:
            read_team(HEAD + "\n" + line)
        assert says in str(caught.value)


def test_the_command_and_a_cell_find_the_files_beside_the_program(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = HEAD + "\n".join([*SCARA_RUNS, "kinematic arm", "measure_on ch610", HOME])
    (tmp_path / "it.txt").write_text(text)
    assert motion.main(["check", str(tmp_path / "it.txt")]) == 1 and "scara.bnr: no such file" in capsys.readouterr().out
    path = tmp_path / "cell.toml"
    table = cell_text().replace('file   = "arm-and-scara"', 'file   = "it.txt"')
    path.write_text(table)
    with pytest.raises(CellFaults) as caught:
        load_cell(str(path))
    assert "line 9: move_file scara.bnr" in str(caught.value) and "channel 610 is in no [[measuring]] table" in str(caught.value)
    (tmp_path / "scara.bnr").write_bytes(FILES["scara.bnr"])
    assert motion.main(["check", str(tmp_path / "it.txt")]) == 0
    assert motion.main(["plot", str(tmp_path / "it.txt"), "--out", str(tmp_path / "it.html")]) == 0
    assert (tmp_path / "it.html").stat().st_size > 1000
