"""Belts and corrections in programs of several kinematics: the arm and the SCARA of one cell with eight belts and emulated CiA 402 drives.
One of them is on a belt, or corrected, and moves alone; before and behind it both move together.  Judged by the emulator's own record of
set values, and by what the encoders said (AX-1745)."""

import json
import pathlib

import numpy as np
import pytest

from gateway.commands.motion import main as motion
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.jobs import Job
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.planner import ProgramFacts
from hil_tests.lab.cells.arm_and_scara import HEAD, MACHINES, OWN, cell_text
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.two_on_belts import MASKS, STATUS, OnBelts, with_belts
from hil_tests.lab.running.belt_run import INCREMENT
from hil_tests.lab.virtual.planned_bench import Driven

SPEED = 0.1  # m/s of belts
ROUNDED = 25e-6  # m: half an increment of each axis
STANDS = 4e-6  # m, rad: an increment
ACTIVE = 2  # mode of the correction
BACK = "move arm ptp joints 0 30 90 0 60 0 and scara ptp joints 0 90 -200 0"
OVER = "move arm ptp pose 350 100 300 180 0 0 and scara linear pose 350 -100 100 180 0 0"
PICK = (
    "kinematic scara",
    "synchron B5 at=100mm",
    "linear pose 350 -50 100 180 0 0 belt=100mm",
    "linear pose 350 -50 60 180 0 0 belt=100mm path=60",
    "synchron_end",
)


BOTH = ProgramFacts("both", MASKS["arm"] | MASKS["scara"])


class Pair(OnBelts):
    """Programs of both robots."""

    def both(self, *lines: str) -> Job:
        self.bench.dispatcher.programs = {**self.bench.dispatcher.programs, 3: BOTH}
        self.driven()
        self.begun = self.state.parts
        self.robots.counted.clear()
        self.text = HEAD + "\n".join(lines)
        job = self.bench.dispatcher.command(1, Command(Code.PROGRAM, 3, 1.0, 1.0), self.bench.now)
        self.bench._hand_over()
        return job


@pytest.fixture(scope="module")
def pair() -> Pair:
    return Pair()


@pytest.fixture
def home(pair: Pair) -> Pair:
    pair.planner.streams = False
    pair.home()
    return pair


def tips(made: Driven, member: int) -> Array:
    """(SYNCs, 3) m: the flange by the set values."""
    return np.array([MACHINES[member].forward(tuple(float(v) for v in row[OWN[member]])).position for row in made.sets])


def on_its_belt(home: Pair, made: Driven) -> None:
    """The SCARA went along belt 5 while it came down, and the arm stood meanwhile; both had moved together before."""
    places, way = tips(made, 1), home.belt(5)
    low = float(places[:, 2].min())
    on = (places[:, 2] > low + 0.003) & (places[:, 2] < low + 0.037) & (np.arange(len(way)) < np.argmin(places[:, 2]))
    assert np.count_nonzero(on) > 40
    off = places[on][:, 1] + 0.05 - (way[on] - 0.1)
    assert float(np.abs(off - 0.5 * INCREMENT).max()) < ROUNDED, "at every SYNC where its belt is, between two increments"
    assert float(np.ptp(made.sets[on][:, OWN[0]], axis=0).max()) <= STANDS, "the arm stands"
    assert float(np.ptp(made.sets[:, OWN[0]], axis=0).max()) > 0.1, "and moves with the SCARA outside of the part"
    speed, accel = made.shares()
    assert 0.1 < speed <= 1.0 and accel <= 1.02, (speed, accel)


@pytest.mark.parametrize("streams", [False, True], ids=["program", "stream"])
def test_one_of_them_picks_from_its_belt_between_moves_of_both(home: Pair, streams: bool) -> None:
    home.started(5, SPEED)
    home.planner.streams = streams
    job = home.finished(home.both(OVER, *PICK, BACK))
    assert job.state is CommandState.DONE, job
    on_its_belt(home, home.driven())
    assert home.bench.set() == pytest.approx([0, 30, 90, 0, 60, 0, 0, 90, -200, 0], abs=1e-6)


@pytest.mark.parametrize("streams", [False, True], ids=["program", "stream"])
def test_a_correction_moves_one_of_them_and_the_other_stands(home: Pair, streams: bool) -> None:
    drift = 0.0

    def correct() -> tuple[float, ...]:
        nonlocal drift
        drift = min(drift + 0.1, 6.0) if home.bench.core.outputs[(STATUS >> 3) + 1] == ACTIVE else drift
        return (drift, 0.0, 0.0, 0.0, 0.0, 0.0)

    home.correct = correct
    home.planner.streams = streams
    line = "linear pose 350 100 100 180 0 0 path=60"
    job = home.finished(home.both(OVER, "kinematic scara", "alter frame - path=400 turn=60", line, "alter_end", BACK))
    assert job.state is CommandState.DONE, job
    made = home.driven()
    places = tips(made, 1)
    begin = int(np.argmin(places[:, 1]))
    moved = places[begin : begin + int(np.argmax(places[begin:, 1] > 0.1 - ROUNDED))]
    moved = moved[moved[:, 1] > 0.0]
    assert len(moved) > 150
    assert float(np.abs(moved[:, 0] - 0.356).max()) < ROUNDED, "6 mm in x beside the line"
    assert float(np.ptp(made.sets[begin : begin + len(moved)][:, OWN[0]], axis=0).max()) <= STANDS
    assert home.bench.set() == pytest.approx([0, 30, 90, 0, 60, 0, 0, 90, -200, 0], abs=1e-6)


def test_statements_of_belts_are_done_between_moves_of_both(home: Pair) -> None:
    home.started(5, SPEED)
    lines = ("set_beltcnt 5 30", "kinematic scara", "sync B5 >= 400mm", "synchron B5 at=80mm", PICK[2], "synchron_end", BACK)
    job = home.both(OVER, *lines)
    assert home.finished(job).state is CommandState.DONE, job
    places, way = tips(home.driven(), 1), home.belt(5)
    begins = int(np.argmax(np.abs(places[:, 1] + 0.1) < ROUNDED)) + 1
    goes = begins + int(np.argmax(np.abs(places[begins:, 1] + 0.1) > 1e-3))
    assert 0.45 - 0.005 < way[goes] < 0.47, "SYNC at 400 mm has set the counter to 30, and the part began at 80"


OF_SCARA = ("kinematic scara", "synchron B5", "linear pose 350 0 60 180 0 0")
FURTHER = "linear pose 350 20 60 180 0 0"
TURNS = ("kinematic scara", "synchron B6 at=50mm", "linear pose 350 0 60 180 0 0 belt=100mm", f"{FURTHER} belt=100mm")
MEANWHILE = "line 11: move: kinematic scara is on a belt or corrected and moves alone, arm cannot: write synchron_end first"
AN_INPUT = "Belt-sync. n.possible: SYNC of belt B5 inside its part waits for a belt value, not for an input (rho 3 20)"


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (
            ("kinematic arm", "synchron B8", "linear pose 350 -50 300 180 0 0"),
            "kinematic arm: belt B8: Inadmiss. Belt-No; this robot follows",
        ),
        (TURNS, "line 11: block 3: kinematic scara: kinematic 2: beltdistance is zero, belt B6 (rho 3 89)"),
        ((*OF_SCARA, "sync B5 input=464", FURTHER), AN_INPUT),
        ((*OF_SCARA, "move arm ptp joints 0 30 80 0 60 0"), MEANWHILE),
        (("kinematic scara", "alter frame -", FURTHER, "mach_pos joints 0 90 -200 0", FURTHER), "mach_pos is not allowed in synchronous"),
    ],
)
def test_what_has_no_place_in_a_part_is_refused_before_anything_moves(home: Pair, lines: tuple[str, ...], says: str) -> None:
    before = home.bench.set()
    job = home.bench.settle(home.both(OVER, *lines))
    assert (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT) and says in job.detail, job.detail
    assert home.bench.set() == before


def test_a_stop_on_the_belt_ends_the_program_and_the_next_one_begins_where_they_stand(home: Pair) -> None:
    home.started(5, SPEED)
    job = home.both(OVER, *PICK[:-2], "linear pose 350 -50 60 180 0 0 path=10", "synchron_end", BACK)
    home.until(lambda _: home.parts == 2)
    home.bench.run(0.3)
    home.done(Code.STOP)
    home.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.STOPPED_BY_SOURCE)
    assert home.finished(home.both(BACK)).state is CommandState.DONE


def test_check_and_plot_run_them_on_the_belts_of_the_cell(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell, program, page = tmp_path / "two.toml", tmp_path / "both.txt", tmp_path / "both.html"
    cell.write_text(with_belts(cell_text()))
    part = ("set_beltcnt 5 30", "kinematic arm", "alter frame - path=400", "linear pose 350 0 300 180 0 0", "alter_end", *PICK, BACK)
    program.write_text(HEAD + "\n".join((OVER, *part)) + "\n")
    assert motion(["check", str(program)]) == 2
    assert "belt B5 belongs to a cell: name it with --cell CELL" in capsys.readouterr().err
    assert motion(["check", str(program), "--cell", str(cell)]) == 0 and "5 blocks: all can be run" in capsys.readouterr().out
    assert motion(["plot", str(program), "--cell", str(cell), "--belt-speed", "100", "--out", str(page), "--json"]) == 0
    assert "B5" in page.read_text()
    figures = json.loads(capsys.readouterr().out)["kinematics"]
    loads = [each["loads"] for each in figures.values()]
    assert all(0.1 < round(each["speed"], 6) <= 1.0 and each["acceleration"] <= 1.02 for each in loads), loads
    program.write_text(program.read_text().replace("B5 at", "B6 at"))
    assert motion(["check", str(program), "--cell", str(cell)]) == 1
    assert "line 15: block 3: kinematic scara: kinematic 2: beltdistance is zero, belt B6 (rho 3 89)" in capsys.readouterr().out
