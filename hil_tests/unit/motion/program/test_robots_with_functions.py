"""IO logic and PPO in programs of several kinematics (rho 3 SF 1, SF 2): an arm and a SCARA of one cell.  AX-392, AX-604."""

import pytest

from gateway.assembly.path_outputs import functions_of
from gateway.cell_file.load import load_cell
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import get_bit
from gateway.tools.motion.dry_run_team import team_findings
from hil_tests.lab.cells.arm_and_scara import HEAD, MACHINES, OWN, cell_text
from hil_tests.lab.cells.carried_cell import ARM
from hil_tests.lab.cells.teams import pair
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Planned
from hil_tests.unit.motion.program.close import same
from hil_tests.unit.motion.program.test_robots_and_inputs import AWAY, HOME, run
from motion.program.text.team import read_team, write_team

TABLES = "".join(
    f'[[path_output]]\nkind = "iol"\nfunction = {function}\noutput = {output}\nrobot = "{robot}"\n\n'
    for function, output, robot in ((2, 416, "scara"), (3, 417, "arm"))
)
BITS = (417, 416)  # of arm, SCARA
RESET = ["kinematic arm", "iol -3 1 1 0 0 0", "kinematic scara", "iol -2 2 3 0 0 0", HOME]


@pytest.fixture(scope="module")
def cell() -> Planned:
    planned = Planned(Cell402Bench(8, cell=load_cell(str(ARM), cell_text(TABLES))))
    planned.bench.core.lanes[0].mover.functions = functions_of(planned.cell, planned.bench.p5_ms)
    return planned


@pytest.fixture
def home(cell: Planned) -> Planned:
    assert run(cell, HOME, *RESET, "move arm ptp rel joints 1 0 0 0 0 0 and scara ptp rel joints 1 0 0 0", HOME) is CommandState.DONE
    return cell


def tips(cell: Planned) -> tuple[float, float]:
    """Arm: x of its flange, SCARA: z; mm of the set values."""
    q = [axis.set for axis in cell.state.axes]
    arm, scara = (MACHINES[n].forward(tuple(q[OWN[n]])).position for n in range(2))
    return arm[0] * 1e3, scara[2] * 1e3


@pytest.mark.requirement("RHO-MOT-35", by="motion.planner.team_route:_source")
def test_each_is_led_by_the_coordinate_of_its_own_robot_while_both_move(home: Planned) -> None:
    x, z = tips(home)
    lines = ["kinematic scara", f"iol 2 2 3 {z + 25} 1 0", "kinematic arm", f"iol 3 1 1 {x - 60} 1 0", f"move {AWAY[0]} and {AWAY[1]}"]
    job = home.order(HEAD + "\n".join(lines))
    rows: list[tuple[float, ...]] = []
    while job.open and len(rows) < 5000:
        home.bench.cycle()
        rows.append((*tips(home), *(get_bit(home.bench.core.outputs, bit) for bit in BITS)))
    assert job.state is CommandState.DONE, job
    for place, bit in ((0, 2), (1, 3)):
        first = next(row for row in rows if row[bit])
        edge, way = (x - 60, x - first[place]) if place == 0 else (z + 25, first[place] - z)
        assert way > 0 and abs(first[place] - edge) < 0.5 and rows[-1][bit], (place, first)
        assert not any(row[bit] for row in rows[: rows.index(first)])


def test_it_begins_with_the_next_block_of_its_kinematic(home: Planned) -> None:
    job = home.order(HEAD + "\n".join(["kinematic arm", "iol -3 1 1 0 1 0", f"move {AWAY[1]}", "move arm ptp rel joints 9 0 0 0 0 0"]))
    began = None
    for _ in range(5000):
        home.bench.cycle()
        if began is None and get_bit(home.bench.core.outputs, BITS[0]):
            began = home.bench.set()[6]
        if not job.open:
            break
    assert job.state is CommandState.DONE and began == pytest.approx(40.0, abs=1e-3), "the SCARA has gone its way by then"


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("kinematic arm\niol 2 2 3 0 1 0", "IOL 2: no such function; the robot has IOL 3 ([[path_output]])"),
        ("kinematic scara\niol 2 1 3 0 1 0", "IOL 2: kinematic 1, coordinate 3; kinematic 2, 1..6: x y z a b c"),
    ],
)
def test_what_a_robot_does_not_have_is_reported_before_anything_moves(home: Planned, line: str, words: str) -> None:
    job = home.bench.settle(home.order(f"{HEAD}{line}\nmove {AWAY[0]} and {AWAY[1]}"))
    assert job.state is CommandState.REFUSED and words in job.detail, job.detail


def test_in_the_dry_run_and_written_again() -> None:
    program = read_team(HEAD + "\n".join([*RESET, "kinematic arm", "ppo 3 1 2 10 7 -20", HOME]))
    assert same(read_team(write_team(program)), program) and not team_findings(program, pair()).faults
