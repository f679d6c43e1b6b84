"""MOVE_FILE in programs (rho 3 Releases part 2, section 5): words, errors, paper; a cell judged by the emulator's own record.  AX-576."""

import pathlib
import struct

import numpy as np
import pytest

from gateway.commands import motion
from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion
from gateway.pure.planning.trial import Files
from gateway.tools.motion.dry_run import DryRun, sections_of
from hil_tests.lab.cells import arms
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.turning_cell import turning_cell
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot
from hil_tests.unit.motion.program.close import same_program
from motion.errors import MotionError
from motion.files import bnr
from motion.files.bnr import Header
from motion.program.errors import TextFaults
from motion.program.text.reader import read
from motion.program.text.writer import write

P5_US = 4000
HEAD = "robot turntables\naxes deg deg deg deg deg\nstart 0 0 0 0 0\n"
AWAY = (1.0, 0.25, -0.25, 0.5, 0.0)  # of each axis, of the way of the first
K = np.arange(1, 401) / 400
TURN = 360.0 * (10 * K**3 - 15 * K**4 + 6 * K**5)  # deg, in 1.6 s; from rest to rest
ROWS = np.outer(TURN, AWAY)
HALF = np.concatenate([ROWS[:200], ROWS[199::-1], np.zeros((1, 5))])  # there and back, at once: faster than any law of the axes
KEEP = "modulo=2,0,0,0,0"
BY_FILE = "modulo=1,0,0,0,0"


def file_of(rows: Array, **fields: int) -> bytes:
    return bnr.encode(Header(**{"time_base_us": P5_US, "axes": rows.shape[1], **fields}), rows.tolist())


FILES = {
    "turn.bnr": file_of(ROWS),
    "quarter.bnr": file_of(ROWS),
    "half.bnr": file_of(HALF),
    "axes.bnr": file_of(ROWS[:, :4]),
    "base.bnr": file_of(ROWS, base=2),
    "time.bnr": file_of(ROWS, time_base_us=400),
    "off.bnr": file_of(ROWS, time_base_us=400, base_check_off=1),
    "version.bnr": file_of(ROWS, version=501),
    "cut.bnr": file_of(ROWS)[:-4],
    "nan.bnr": file_of(ROWS)[:-4] + struct.pack("<f", float("nan")),
    "fast.bnr": file_of(3 * ROWS),
    "long.bnr": file_of(np.zeros((20000, 5))),
}


def files(name: str, number: int) -> bytes:
    try:
        return FILES[name]
    except KeyError:
        raise MotionError(f"{name}: no such file") from None


class Turning:
    """A cell of five axes that go round, with files."""

    def __init__(self) -> None:
        self.bench = ServodynRobot(cell=turning_cell())
        self.planned = Planned(self.bench)
        self.planned.programs.cell.files = Files(files, P5_US)

    def run(self, *lines: str) -> CommandState:
        return self.bench.settle(self.planned.order(HEAD + "\n".join(lines))).state

    def home(self) -> None:
        assert self.run("ptp joints 0 0 0 0 0") is CommandState.DONE
        self.bench.run(0.1)
        self.planned.driven()

    def sets(self) -> Array:
        """deg, as the drives were asked for since the last look, from where they stood then."""
        self.bench.run(0.05)
        sets = np.degrees(self.planned.driven().sets)
        return np.asarray(sets - sets[0])


@pytest.fixture(scope="module")
def cell() -> Turning:
    return Turning()


@pytest.fixture
def turning(cell: Turning) -> Turning:
    if cell.planned.state.motion is Motion.STOPPED:
        cell.planned.done(Code.ABANDON)
    cell.home()
    return cell


def moved(sets: Array) -> Array:
    """From the last set value at rest to the first one there."""
    changes = np.flatnonzero(np.abs(np.diff(sets, axis=0)).max(axis=1) > 0)
    return sets[changes[0] : changes[-1] + 2]


FINE = 0.6 / (16384 * 7.3 / 360.0)  # deg: a little more than half an increment of the coarsest axis


@pytest.mark.requirement("RHO-MOT-43", by="motion.files.playing:FilePath.pieces")
@pytest.mark.requirement("RHO-MOT-43", by="motion.planner.file_plan:FilePlan.take")
def test_each_point_is_a_set_value_of_one_cycle_unchanged_as_the_drives_record_it(turning: Turning) -> None:
    assert turning.run("read_begin turn.bnr 80", f"move_file turn.bnr {KEEP}") is CommandState.DONE
    sets = moved(turning.sets())
    quiet = int(np.flatnonzero(np.abs(ROWS).max(axis=1) > FINE)[0])  # points that are still less than an increment
    assert len(sets) >= len(ROWS) - 2 * quiet
    best = min(float(np.abs(ROWS[k : k + len(sets)] - sets[: len(ROWS) - k]).max()) for k in range(quiet + 2) if len(sets) <= len(ROWS) - k)
    assert best < FINE, "one after the other, one a cycle"


@pytest.mark.requirement("RHO-MOT-42", by="motion.planner.file_plan:control_of")
def test_an_endless_axis_is_within_its_modulo_behind_the_block_and_the_program_goes_on_from_there(turning: Turning) -> None:
    assert turning.run("read_begin turn.bnr", f"move_file turn.bnr {BY_FILE}", "ptp rel joints 10 0 0 0 0") is CommandState.DONE
    assert turning.sets()[-1] == pytest.approx([370.0, 90.0, -90.0, 180.0, 0.0], abs=0.01)
    assert turning.bench.set() == pytest.approx([10.0, 90.0, 270.0, 180.0, 0.0], abs=0.01)
    assert turning.run("read_begin turn.bnr", f"move_file turn.bnr {KEEP}") is CommandState.REFUSED, "the file begins at 0"
    assert "block 1, axis M: turn.bnr: speed to point 1" in turning.planned.programs.state.fault


def test_a_stop_stays_on_the_curve_and_resume_ends_it_and_at_half_the_speed_it_lasts_twice_as_long(turning: Turning) -> None:
    job = turning.planned.order(HEAD + f"read_begin turn.bnr\nmove_file turn.bnr {KEEP}")
    turning.planned.until(lambda state: state.axes[0].set > 1.5)
    turning.planned.done(Code.STOP)
    turning.planned.until(lambda state: state.motion is Motion.STOPPED)
    turning.bench.run(0.2)
    turning.planned.done(Code.RESUME)
    assert turning.bench.settle(job).state is CommandState.DONE
    sets = turning.sets()
    assert np.abs(sets - np.outer(sets[:, 0], AWAY)).max() < 2 * FINE and sets[-1][0] == pytest.approx(360.0, abs=0.01)
    turning.home()
    turning.planned.done(Code.OVERRIDE, velocity=0.5)
    assert turning.run("read_begin turn.bnr", f"move_file turn.bnr {KEEP}") is CommandState.DONE
    assert len(moved(turning.sets())) == pytest.approx(2 * len(ROWS), rel=0.05)
    turning.planned.done(Code.OVERRIDE, velocity=1.0)


def test_the_acceleration_is_the_files_own_affair_and_still_the_axes_can_be_stopped(turning: Turning) -> None:
    assert turning.run("read_begin half.bnr", f"move_file half.bnr {KEEP}") is CommandState.DONE
    sets = turning.sets()
    assert sets[:, 0].max() == pytest.approx(180.0, abs=0.01) and sets[-1] == pytest.approx([0.0] * 5, abs=0.01)
    job = turning.planned.order(HEAD + f"read_begin half.bnr\nmove_file half.bnr {KEEP}")
    turning.planned.until(lambda state: state.axes[0].set > 3.0)
    turning.planned.done(Code.STOP)
    turning.planned.until(lambda state: state.motion is Motion.STOPPED)
    assert job.open


ERRORS = [
    ("close turn.bnr", "turn.bnr", KEEP, 63, "READ_BEGIN expected: turn.bnr"),
    ("read_begin nan.bnr", "nan.bnr", KEEP, 38, "Inad. Real-Expression: nan.bnr: point 400"),
    ("read_begin version.bnr", "version.bnr", KEEP, 95, "MF: Version identification: version.bnr: 501"),
    ("read_begin axes.bnr", "axes.bnr", KEEP, 96, "MF: No. of axes: axes.bnr: 4, the kinematic has 5"),
    ("read_begin turn.bnr 40", "turn.bnr", KEEP, 97, "MF: Read marker err.: turn.bnr: byte 40 lies in the header of 80"),
    ("read_begin time.bnr", "time.bnr", KEEP, 98, "MF: Time base: time.bnr: 400 us, the control has 4000 us"),
    ("read_begin base.bnr", "base.bnr", KEEP, 99, "MF: IP-PL base: base.bnr: 2, the call has 1"),
    ("read_begin cut.bnr", "cut.bnr", KEEP, 100, "MF: Format error: cut.bnr"),
    ("read_begin turn.bnr 84", "turn.bnr", KEEP, 100, "MF: Format error: turn.bnr"),
    ("read_begin turn.bnr", "turn.bnr", "", 101, "axis M: MF: MOD-Flag n. init.: none: 5 values"),
    ("read_begin turn.bnr", "turn.bnr", "modulo=0,0,-,0,0", 101, "axis S2: MF: MOD-Flag n. init.: 0, 0, not set, 0, 0"),
    ("read_begin fast.bnr", "fast.bnr", KEEP, 0, "axis M: fast.bnr: speed to point"),
    ("read_begin long.bnr", "long.bnr", KEEP, 0, "a file of 20000 points: one block has at most"),
    ("read_begin quarter.bnr", "quarter.bnr", "modulo=0,1,0,0,0", 0, "axis S1: quarter.bnr: modulo flag 1, and 90 deg at its end"),
    ("read_begin no.bnr", "no.bnr", KEEP, 0, "move_file no.bnr: no such file"),
]


@pytest.mark.requirement("RHO-MOT-40", by="motion.planner.file_plan:file_path")
@pytest.mark.requirement("RHO-MOT-40", by="gateway.pure.planning.trial:Files.path")
def test_a_cell_reports_each_error_by_its_number_with_line_block_and_axis_before_anything_moves(turning: Turning) -> None:
    for opened, name, flags, code, says in ERRORS:
        assert turning.run("ptp joints 0 0 0 0 0", opened, f"move_file {name} {flags}") is CommandState.REFUSED, name
        state = turning.planned.programs.state
        assert (state.fault_block, state.fault_code) == (2, code), state.fault
        assert state.fault.startswith("line 6: block 2") and says in state.fault, state.fault
    assert np.abs(turning.sets()).max() < 0.01


@pytest.mark.requirement("RHO-MOT-41", by="motion.planner.file_plan:file_path")
def test_base_check_off_lets_another_time_base_run(turning: Turning) -> None:
    assert turning.run("read_begin off.bnr", f"move_file off.bnr {KEEP}") is CommandState.DONE
    assert len(moved(turning.sets())) == pytest.approx(len(ROWS), rel=0.05)


PAPER = "axes mm mm mm\nstart 0 0 0\n"
WAY = np.outer(1 - np.cos(np.pi * K), (50.0, 20.0, -10.0))
ON_PAPER = {
    "way.bnr": file_of(WAY),
    "far.bnr": file_of(np.concatenate([WAY, WAY[-1] + np.outer(np.arange(1, 9000) * 0.5, (0.0, 0.0, 1.0))])),
}


def looked_at(lines: str, files: dict[str, bytes] = ON_PAPER) -> list[str]:
    return [str(fault) for fault in sections_of(read(PAPER + lines), arms.portal(), (), files=Files(lambda name, _: files[name], P5_US))[1]]


def test_the_dry_run_runs_it_point_by_point_and_what_follows_begins_where_it_ends() -> None:
    program = read(PAPER + "ptp joints 5 0 0\nptp joints 0 0 0\nread_begin way.bnr\nmove_file way.bnr modulo=0,0,0\nptp rel joints 1 0 0\n")
    sections, faults = sections_of(program, arms.portal(), (), files=Files(lambda name, _: ON_PAPER[name], P5_US))
    assert not faults
    made = DryRun(arms.portal(), (), ()).run(sections)
    filed = made.q[made.block == 3]
    assert np.abs(filed[4::4][: len(WAY)] - WAY * 1e-3).max() < 1e-8, "1 ms grid, a point each 4 ms"
    assert made.q[-1] == pytest.approx((0.101, 0.04, -0.02), abs=1e-7)
    loads = made.loads(arms.portal(), 1)
    assert loads.max() <= 1.0


def test_travel_and_axes_that_do_not_go_round_are_reported_by_the_dry_run_by_axis_and_point() -> None:
    (far,) = looked_at("read_begin far.bnr\nmove_file far.bnr modulo=0,0,0")
    assert far.startswith("block 1, axis z: far.bnr: point ") and "is outside" in far
    (flag,) = looked_at("read_begin way.bnr\nmove_file way.bnr modulo=0,1,0")
    assert flag == "block 1, axis y: MF: No endless axis: modulo flag 1 is for axes that go round (rho 3 102)"
    assert not looked_at("read_begin way.bnr 92\nmove_file way.bnr base=1 modulo=0,0,0\nclose way.bnr\nclose way.bnr")


def test_words_are_read_and_written_and_reported_with_line_and_key() -> None:
    text = PAPER + "read_begin a.bnr\nmove_file a.bnr modulo=0,-,2\nread_begin a.bnr 92\nlabel L\nmove_file a.bnr base=2\n"
    text += "close a.bnr\nmove_file a.bnr\n"
    program = read(text)
    assert [block.file.offset for block in program.blocks if block.file] == [80, 92, None]
    assert same_program(read(write(program)), program)
    for line, says in [
        ("move_file", "move_file: '' is not a name"),
        ("move_file a.bnr speed=3", "speed: move_file accepts only base= and modulo="),
        ("move_file a.bnr base=1.5", "base: 1.5"),
        ("move_file a.bnr modulo=0,x", "modulo: 'x' is not a number"),
        ("read_begin ../a.bnr", "read_begin: '../a.bnr' is not a name"),
        ("read_begin a.bnr -1", "read_begin: -1 is outside"),
        ("read_begin a.bnr 80.5", "a whole number of bytes"),
        ("alter frame -\nmove_file a.bnr\nalter_end", "move_file: is not allowed in synchronous and alter sections"),
    ]:
        with pytest.raises(TextFaults) as caught:
            read(PAPER + line)
        assert says in str(caught.value)


def test_the_command_finds_the_file_beside_the_program_and_the_cells_cycle(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path
    head = "robot portal\naxes mm mm mm deg\nstart 500 300 300 0\n"
    (folder / "curve.txt").write_text(head + "read_begin way.bnr\nmove_file way.bnr modulo=0,0,0,0\n")
    assert motion.main(["check", str(folder / "curve.txt")]) == 1 and "way.bnr: no such file" in capsys.readouterr().out
    there = np.column_stack([WAY, 0.0 * K]) + (500.0, 300.0, 300.0, 0.0)
    (folder / "way.bnr").write_bytes(file_of(there))
    assert motion.main(["check", str(folder / "curve.txt")]) == 0
    assert motion.main(["plot", str(folder / "curve.txt"), "--out", str(folder / "curve.html")]) == 0
    assert "1.6" in capsys.readouterr().out and (folder / "curve.html").stat().st_size > 1000
    (folder / "way.bnr").write_bytes(file_of(there, time_base_us=1000))
    assert motion.main(["check", str(folder / "curve.txt"), "--cell", "portal"]) == 1
    assert "line 5: block 1: MF: Time base" in capsys.readouterr().out
