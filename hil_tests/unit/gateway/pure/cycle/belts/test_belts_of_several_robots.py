"""Two robots and eight belts in one cell with emulated CiA 402 drives: parts of all three types, inputs, corrections and outputs of the
robot whose axes lie behind those of the first one.  Judged by the emulator's own record of set values and mechanics, and by what the
encoders said (AX-552, AX-564)."""

import pathlib

import numpy as np
import pytest

from gateway.cell_file.load import load_cell
from gateway.commands.motion import main as motion
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import get_bit
from gateway.recording.replay import replay
from hil_tests.lab.cells.arm_and_scara import MACHINES, OWN, cell_text
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.carried_cell import ARM
from hil_tests.lab.cells.two_on_belts import CELL, HEAD, HEADS, IO, MASKS, PROBE, STATUS, OnBelts, belt_table, with_belts
from hil_tests.lab.running.belt_run import INCREMENT
from hil_tests.lab.virtual.planned_bench import Driven
from hil_tests.lab.virtual.recorded_belts import found_in
from motion.sync.cam import cam

ACTIVE = 2  # mode of the correction
NUMBER = {"arm": 0, "scara": 1}
SPEED = 0.1  # m/s of belts
NO = "Inadmiss. Belt-No"
ROUNDED = 25e-6  # m: half an increment of each axis
STANDS = 4e-6  # m, rad: an increment
BACK = {"arm": "ptp joints 0 30 90 0 60 0", "scara": "ptp joints 0 90 -200 0"}
OVER = {"arm": "ptp pose 350 -100 300 180 0 0", "scara": "linear pose 350 -100 100 180 0 0"}


@pytest.fixture(scope="module")
def both() -> OnBelts:
    return OnBelts()


@pytest.fixture
def home(both: OnBelts) -> OnBelts:
    return both.home()


def tips(made: Driven, robot: str, rows: Array | None = None) -> Array:
    """(SYNCs, 3) m: the flange by the set values, or by other rows."""
    n = NUMBER[robot]
    given = made.sets if rows is None else rows
    return np.array([MACHINES[n].forward(tuple(float(v) for v in row[OWN[n]])).position for row in given])


def done(home: OnBelts, robot: str, *lines: str) -> Driven:
    """A program through to its end; the other robot has not moved, and nobody was beyond a limit."""
    job = home.finished(home.begin(robot, *lines))
    assert job.state is CommandState.DONE, job
    made = home.driven()
    other = OWN[1 - NUMBER[robot]]
    assert float(np.ptp(made.sets[:, other], axis=0).max()) <= STANDS, "the other one stands"
    speed, accel = made.shares()
    assert 0.1 < speed <= 1.0 and accel <= 1.02, (speed, accel)
    return made


@pytest.mark.parametrize(("robot", "belt", "along"), [("scara", 5, 1), ("scara", 8, 1), ("scara", 4, 1), ("arm", 1, 1), ("arm", 4, 0)])
def test_each_robot_picks_from_its_belts_and_from_the_one_both_follow(home: OnBelts, robot: str, belt: int, along: int) -> None:
    """P503 is the robot's: belt 4 runs along x of the arm and along y of the SCARA."""
    there, down = ("350 -50 300", "350 -50 260") if robot == "arm" else ("350 -50 100", "350 -50 60")
    home.started(belt, SPEED)
    made = done(
        home,
        robot,
        OVER[robot],
        f"synchron B{belt} at=100mm",
        f"linear pose {there} 180 0 0 belt=100mm",
        f"linear pose {down} 180 0 0 belt=100mm path=60",
        "synchron_end",
        BACK[robot],
    )
    places, way = tips(made, robot), home.belt(belt)
    low = float(places[:, 2].min())
    on = (places[:, 2] > low + 0.003) & (places[:, 2] < low + 0.037) & (np.arange(len(way)) < np.argmin(places[:, 2]))
    off = places[:, along] - (0.35, -0.05)[along] - (way - 0.1)
    assert np.count_nonzero(on) > 40
    assert float(np.abs(off[on] - 0.5 * INCREMENT).max()) < ROUNDED, "at every SYNC where its belt is, between two increments"
    across = places[on][:, 1 - along] - (0.35, -0.05)[1 - along]
    assert float(np.abs(across).max()) < ROUNDED
    mechanics = tips(made, robot, made.actual)[on][:, along] - (0.35, -0.05)[along] - (way[on] - 0.1)
    assert float(np.abs(mechanics - np.median(mechanics)).max()) < 5e-4, "and so are the mechanics, behind by their lag"


def test_the_second_robot_reaches_its_point_with_a_belt_of_type_2(home: OnBelts) -> None:
    home.started(6, SPEED)
    part = ("synchron B6 at=250mm", "linear pose 350 0 60 180 0 0 belt=400mm pathaccel=3000", "synchron_end")
    made = done(home, "scara", OVER["scara"], *part, BACK["scara"])
    places, way = tips(made, "scara"), home.belt(6)
    there = int(np.argmax(places[:, 2] < 0.06 + ROUNDED))
    assert abs(way[there] - 0.4) < 5 * 0.008 * SPEED, "5 interpolation cycles of belt way"
    waits = (way > 0.2) & (way < 0.249)
    assert np.count_nonzero(waits) > 20 and float(np.ptp(places[waits], axis=0).max()) < ROUNDED


def test_the_second_robot_follows_the_cam_of_a_belt_of_type_3(home: OnBelts) -> None:
    home.started(7, SPEED)
    part = ("synchron B7 at=250mm", "linear pose 350 0 60 180 0 0 belt=400mm camin=30mm camout=50mm", "synchron_end")
    made = done(home, "scara", OVER["scara"], *part, BACK["scara"])
    places, way, curve = tips(made, "scara"), home.belt(7), cam(0.15, 0.03, 0.05)
    acts = np.roll(places, -2, axis=0)  # set values of types 2 and 3 are made of the count of two SYNCs before
    inside = np.flatnonzero((way > 0.252) & (way < 0.398))
    shares = np.array([curve.at(float(way[n]) - 0.25)[0] for n in inside])
    assert len(inside) > 100
    assert float(np.abs(acts[inside, 1] - (-0.1 + 0.1 * shares)).max()) < ROUNDED
    assert float(np.abs(acts[inside, 2] - (0.1 - 0.04 * shares)).max()) < ROUNDED


def test_errors_of_a_belt_bear_the_number_of_the_kinematic(home: OnBelts) -> None:
    part = ("synchron B6 at=50mm", "linear pose 350 0 60 180 0 0 belt=100mm", "linear pose 350 20 60 180 0 0 belt=100mm")
    job = home.bench.settle(home.begin("scara", OVER["scara"], *part))
    assert job.state is CommandState.REFUSED and "block 3: kinematic 2: beltdistance is zero, belt B6 (rho 3 89)" in job.detail
    home.started(6, SPEED)
    job = home.begin("scara", OVER["scara"], "synchron B6 at=4000mm", "linear pose 350 0 60 180 0 0 belt=4100mm")
    home.until(lambda _: home.parts == 1)
    home.bench.run(0.2)
    home.drive(6, -SPEED)
    home.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.BELT_FAULT)
    assert job.detail == "block 2, kinematic 2: wrong belt direction (rho 3 929)"


@pytest.mark.parametrize(
    ("robot", "lines", "says"),
    [
        ("scara", ("synchron B1", "linear pose 350 -50 100 180 0 0"), f"belt B1: {NO}; this robot follows B4, B5, B6, B7, B8 (rho 3 93)"),
        ("arm", ("synchron B8", "linear pose 350 -50 300 180 0 0"), f"belt B8: {NO}; this robot follows B1, B2, B3, B4 (rho 3 93)"),
        ("arm", ("synchron none", "linear pose 350 -50 300 180 0 0"), f"belt none: {NO}; this cell has B1, B2, B3, B4 (rho 3 93)"),
        ("scara", ("linear pose 350 50 100 180 0 0 until=ch610",), "inadmissable input: channel 610; the robot has ch620 ([[measuring]])"),
        ("scara", ("set_latch fIn0", OVER["scara"]), "inadmissable input: set_latch fIn0; the robot has none ([[measuring]] latch)"),
        ("scara", ("ptp mpos",), "axis S1: point not defined: @MPOS is measured by until= or measure_on before it"),
        ("scara", ("iol 2 1 2 0 1 0", OVER["scara"]), "IOL 2: kinematic 1, coordinate 2; kinematic 2, 1..6: x y z a b c"),
        ("arm", ("iol 2 1 2 0 1 0", OVER["arm"]), "IOL 2: no such function; the robot has none ([[path_output]])"),
    ],
)  # fmt: skip
def test_what_belongs_to_the_other_robot_is_refused_before_anything_moves(
    home: OnBelts, robot: str, lines: tuple[str, ...], says: str
) -> None:
    before = home.bench.set()
    job = home.bench.settle(home.begin(robot, *lines))
    assert (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT) and says in job.detail, job.detail
    assert home.bench.set() == before


def test_a_robot_works_on_its_belt_while_the_drives_of_the_other_are_off(home: OnBelts) -> None:
    assert home.bench.settle(home.bench.give(Code.DISABLE, MASKS["arm"])).state is CommandState.DONE
    home.bench.run(0.5)
    home.started(5, SPEED)
    on = ("synchron B5 at=100mm", "linear pose 350 -50 100 180 0 0 belt=100mm", "linear pose 350 -50 60 180 0 0 path=20")
    job = home.finished(home.begin("scara", OVER["scara"], *on, "synchron_end", BACK["scara"]))
    assert job.state is CommandState.DONE, job
    assert float(np.ptp(tips(home.driven(), "scara")[:, 1])) > 0.1, "it went along"
    home.started(5, SPEED)
    job = home.begin("scara", OVER["scara"], *on)
    home.until(lambda _: home.parts == 2)
    home.bench.run(0.3)
    assert home.bench.settle(home.bench.give(Code.DISABLE, MASKS["scara"])).state is CommandState.DONE
    home.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.DRIVES_OFF)


def test_the_second_robot_measures_and_goes_back_to_where_it_was_at_the_edge(home: OnBelts) -> None:
    scara = OWN[1]
    job = home.begin("scara", OVER["scara"], "linear pose 350 100 100 180 0 0 path=80 until=ch620", BACK["scara"], "ptp mpos")
    home.until(lambda s: home.parts == 1 and MACHINES[1].forward([axis.set for axis in s.axes[scara]]).position[1] > -0.02)
    rows, stamp = len(home.robots.counted), home.bench.now - home.bench.period_ns // 4
    home.bench.permit(PROBE[1])
    home.bench.inputs.stamps[PROBE[1] >> 3] = stamp
    assert home.finished(home.bench.settle(job)).state is CommandState.DONE, job
    home.bench.permit(PROBE[1], value=False)
    made, state = home.driven(), home.state
    assert state.measured_mask == MASKS["scara"]
    measured = np.array([axis.measured for axis in state.axes[scara]])
    near = range(rows - 4, rows + 4)  # around the edge, a quarter of a cycle before the SYNC of row `rows`
    was = [np.polynomial.Polynomial.fit([n - rows + 0.25 for n in near], made.actual[near, n], 5)(0.0) for n in range(6, 10)]
    assert float(np.abs(measured - was).max()) < 1e-5, "where the mechanics were, by the record"
    assert float(np.abs(made.sets[-1][scara] - measured).max()) < STANDS, "@MPOS"


@pytest.mark.parametrize("robot", ["scara", "arm"])
def test_a_correction_moves_the_robot_whose_program_runs(home: OnBelts, robot: str) -> None:
    drift = 0.0

    def correct() -> tuple[float, ...]:
        nonlocal drift
        drift = min(drift + 0.1, 6.0) if home.bench.core.outputs[(STATUS >> 3) + 1] == ACTIVE else drift
        return (drift, 0.0, 0.0, 0.0, 0.0, 0.0)

    home.correct = correct
    line = "linear pose 350 100" + (" 300" if robot == "arm" else " 100") + " 180 0 0 path=60"
    made = done(home, robot, OVER[robot], "alter frame - path=400 turn=60", line, "alter_end", BACK[robot])
    places = tips(made, robot)
    begin = int(np.argmin(places[:, 1]))
    moved = places[begin : begin + int(np.argmax(places[begin:, 1] > 0.1 - ROUNDED))]
    moved = moved[moved[:, 1] > 0.0]
    assert len(moved) > 150
    assert float(np.abs(moved[:, 0] - 0.356).max()) < ROUNDED, "6 mm in x beside the line"


def test_io_logic_is_led_by_the_second_robots_coordinate(home: OnBelts) -> None:
    switched: list[bool] = []
    home.bench.core.outputs[IO >> 3] = 0
    job = home.begin("scara", OVER["scara"], "iol 2 2 2 20 1 0", "linear pose 350 100 100 180 0 0 path=80", BACK["scara"])
    while job.open:
        home.bench.cycle()
        switched.append(get_bit(home.bench.core.outputs, IO))
    home.finished(job)
    assert job.state is CommandState.DONE, job
    y = tips(home.driven(), "scara")[:, 1]
    first = switched.index(True)
    assert y[first + 1] < 0.02 + ROUNDED < y[first + 3], "with the set value of its cycle, which acts two SYNCs later"


def test_a_recording_of_such_a_cell_plays(home: OnBelts) -> None:
    home.robots.messages.clear()
    home.robots.record()
    home.until(lambda _: home.robots.tap.on, 1.0)  # it looks every so many cycles
    home.started(5, SPEED)
    on = ("synchron B5 at=100mm", "linear pose 350 -50 100 180 0 0 belt=100mm", "linear pose 350 -50 60 180 0 0 path=40", "synchron_end")
    done(home, "scara", OVER["scara"], *on, "alter frame - path=400", f"{OVER['scara']} path=60", "alter_end", BACK["scara"])
    verdict = replay(found_in(home.robots.messages, HEAD), CELL, CELL)
    assert (verdict.first, verdict.without_outputs) == (None, 0) and verdict.cycles > 200


TEXT = with_belts(cell_text())
OWNER = 'robot = "scara"\nfactors = [0.0, 1.0, 0.0]\n\n[plant.belt.B5]'
NONE = "allowed S1, S2, S3, S4: is not an axis of scara"
SHARED = '[[shared_output]]\nname = "FU1"\noutput = 720\nselect = 736\nrobot = "scara"\naxes = ["S3", "S4"]\n\n'


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        (OWNER, OWNER.replace('robot = "scara"\n', ""), "belt.B5.robot: allowed arm, scara: name its robot; this cell has several robots"),
        (OWNER, OWNER.replace("scara", "nobody"), "belt.B5.robot = nobody: no .*robot.* has this name; this cell has arm, scara"),
        ('robot = ["arm", "scara"]\nfactors', 'robot = ["arm", "arm"]\nfactors', "belt.B4.robot = arm: is listed twice"),
        ("factors_of = { scara", "factors_of = { other", "belt.B4.factors_of = other: allowed arm, scara: not a robot of this belt"),
        ("{ scara = [0.0, 1.0, 0.0] }", "{ scara = [0.0, 0.0, 0.0] }", "a belt with factors 0 moves nothing"),
        ("# ---- drives", belt_table(8).replace("B8", "B9").replace("504", "505") + "# ---- drives", "belts of one cell"),
        ('every_ms = 4\nrobot    = ["arm", "scara"]', "every_ms = 4", "alter.robot: allowed arm, scara: name its robot"),
        (f'input   = {PROBE[1]}\nrobot   = "scara"', f"input   = {PROBE[1]}", "measuring.620.robot: allowed arm, scara: name its robot"),
        (f'input   = {PROBE[1]}\n', f'input   = {PROBE[1]}\naxes = ["J1"]\n', f"measuring.620.axes = J1: {NONE}"),
        ('function = 2\noutput   = 700\nrobot    = "scara"', "function = 2\noutput   = 700", "path_output.iol 2.robot: allowed arm, scara"),
        ("# ---- drives", SHARED.replace("S3", "J3") + "# ---- drives", f"shared_output.FU1.axes = J3: {NONE}"),
    ],
)  # fmt: skip
def test_tables_that_name_no_robot_or_a_wrong_one_are_refused_in_words(before: str, after: str, says: str) -> None:
    assert before in TEXT
    with pytest.raises(CellFaults, match=says):
        load_cell(str(ARM), TEXT.replace(before, after, 1))


def test_two_axes_of_the_second_robot_share_a_set_point_output() -> None:
    bench = OnBelts(load_cell(str(ARM), TEXT.replace("# ---- drives", SHARED + "# ---- drives", 1))).home()
    job, points = bench.begin("scara", "ptp joints 0 90 -150 0", "ptp joints 0 90 -150 20"), []
    while job.open:
        bench.bench.cycle()
        outputs = bench.bench.core.outputs
        points.append((int.from_bytes(outputs[90:92], "big", signed=True), get_bit(outputs, 736), get_bit(outputs, 737)))
    assert job.state is CommandState.DONE, job
    bench.bench.run(0.3)
    assert {each[1:] for each in points if abs(each[0]) > 3000} == {(True, False), (False, True)}, "one after the other"
    job = bench.finished(bench.begin("scara", "ptp joints 0 90 -200 0"))
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.SERVO_ERROR) and "S4" in job.detail, job


def test_a_cell_of_one_robot_may_name_it() -> None:
    one = ARM.read_text().replace("# ---- drives", '[[measuring]]\nchannel = 610\ninput = 200\nrobot = "ARM"\n\n# ---- drives', 1)
    assert load_cell(str(ARM), one).measuring[0].robot == ("ARM",)
    with pytest.raises(CellFaults, match=r"measuring.610.robot = scara: no .*robot.* has this name; this cell has ARM"):
        load_cell(str(ARM), one.replace('"ARM"\n\n# ---- d', '"scara"\n\n# ---- d'))


def test_check_and_plot_look_at_the_program_with_the_belts_of_its_robot(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell, program = tmp_path / "two.toml", tmp_path / "pick.txt"
    cell.write_text(TEXT)
    part = ("synchron B5 at=100mm", "linear pose 350 -50 100 180 0 0 belt=100mm", "synchron_end")
    program.write_text(HEADS["scara"] + "\n".join((OVER["scara"], *part, BACK["scara"])) + "\n")
    assert motion(["check", str(program), "--cell", str(cell)]) == 0 and "3 blocks: all can be run" in capsys.readouterr().out
    page = tmp_path / "pick.html"
    assert motion(["plot", str(program), "--cell", str(cell), "--belt-speed", "100", "--out", str(page)]) == 0
    assert "B5" in page.read_text()
    capsys.readouterr()
    program.write_text(program.read_text().replace("B5", "B6").replace("belt=100mm", "belt=50mm\nlinear pose 350 0 100 180 0 0 belt=70mm"))
    assert motion(["check", str(program), "--cell", str(cell)]) == 1
    program.write_text(program.read_text().replace("B6", "B2"))
    assert motion(["check", str(program), "--cell", str(cell)]) == 1
    said = capsys.readouterr().out
    assert "kinematic 2: wrong belt direction, belt B6 (rho 3 929)" in said
    assert f"belt B2: {NO}; this robot follows B4, B5, B6, B7, B8 (rho 3 93)" in said
