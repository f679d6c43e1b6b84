"""WC_FRAME, WC_SYSTEM and P313 in programs: words, paper, cells; judged by the emulator's own record.  AX-586."""

from dataclasses import replace

import numpy as np
import pytest

from gateway.assembly.programs import machine_of_cell
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.faults import CellFaults
from gateway.pure.cycle.path_outputs import CoreOutputs
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import CellState, Motion, get_bit
from gateway.pure.image.records.planner import pack_planner, unpack_planner
from gateway.pure.planning.planner import Programs
from gateway.tools.motion.dry_run import DryRun, sections_of
from gateway.tools.motion.dry_run_team import team_findings, team_traces
from hil_tests.lab.virtual.belt_bench import CELL, PORTAL
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot
from hil_tests.lab.virtual.planner_beside import PlannerBeside
from hil_tests.unit.gateway.pure.cycle.test_functions_in_programs import IOL, PLACES
from hil_tests.unit.motion.program.close import same_program
from motion.planner.team import Team
from motion.program.errors import TextFaults
from motion.program.text.reader import read
from motion.program.text.team import read_team, write_team
from motion.program.text.writer import write

HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\n"
FIX = "wc_frame FIX 20 30 10 0 0 90"
NEAR = 0.02


class Portal(Planned):
    """X, Y, Z, C with absolute encoders, at 100, 100, 50, 0."""

    def __init__(self) -> None:
        super().__init__(ServodynRobot(cell=CELL))
        assert self.run("ptp joints 100 100 50 0") is CommandState.DONE

    def run(self, *lines: str) -> CommandState:
        return self.bench.settle(self.order(HEAD + "\n".join(lines))).state

    def at(self, *lines: str) -> list[float]:
        """mm and deg where a program ends."""
        assert self.run(*lines) is CommandState.DONE
        return self.bench.set()

    @property
    def chosen(self) -> object:
        return self.programs.state.systems


@pytest.fixture
def cell() -> Portal:
    return Portal()


@pytest.mark.requirement("RHO-MOT-31", by="motion.program.systems:located")
@pytest.mark.requirement("RHO-MOT-34", by="motion.program.systems:located")
def test_poses_are_those_of_the_system_and_places_of_axes_stay(cell: Portal) -> None:
    assert cell.at("wc_frame UP 0 0 30 0 0 0", "wc_system UP", "linear pose 100 100 40 0 0 0") == pytest.approx([100, 100, 70, 0], abs=1e-6)
    assert cell.at("wc_frame UP 0 0 30 0 0 0", "wc_system UP", "ptp joints 100 100 40 5") == pytest.approx([100, 100, 40, 5], abs=1e-6)
    turned = cell.at(FIX, "wc_system FIX", "ptp pose 80 -100 40 0 0 -90", "linear rel pose 50 0 0 0 0 0")
    assert turned == pytest.approx([20 + 100, 30 + 80 + 50, 50, 0], abs=1e-6), "dc turns x to y; a relative way turns with it"
    framed = cell.at("frame F 5 0 0 0 0 0", FIX, "wc_system FIX", "linear pose 80 -100 40 0 0 -90 frame=F")
    assert framed == pytest.approx([20 + 100, 30 + 85, 50, 0], abs=1e-6), "a frame lies in the system"
    mirror = cell.at(FIX, "wc_system FIX", "linear pose 80 100 40 0 0 90 mirror=xz")
    assert mirror == pytest.approx([120, 110, 50, 0], abs=1e-6), "across a plane of the system"
    back = cell.at(FIX, "wc_system FIX", "linear pose 80 -80 40 0 0 -90", "wc_system WC_UR", "linear pose 100 100 50 0 0 0")
    assert back == pytest.approx([100, 100, 50, 0], abs=1e-6)


def test_the_working_range_lies_in_the_system_and_the_travel_of_axes_does_not(cell: Portal) -> None:
    lines = (FIX, "wc_system FIX", "set limitmax=90,0,100")
    assert cell.at(*lines, "linear pose 89 -80 40 0 0 -90") == pytest.approx([100, 119, 50, 0], abs=1e-6)
    job = cell.bench.settle(cell.order(HEAD + "\n".join([*lines, "linear pose 91 -80 40 0 0 -90"])))
    assert (job.state, "x 91 mm is outside" in job.detail) == (CommandState.REFUSED, True), job.detail
    far = next(axis for axis in CELL.axis if axis.name == "X").limits
    assert far is not None
    job = cell.bench.settle(cell.order(HEAD + f"{FIX}\nwc_system FIX\nptp pose 80 {-far.max + 19} 40 0 0 -90\n"))
    assert job.state is CommandState.REFUSED and "axis X" in job.detail and "531" in job.detail, job.detail


@pytest.mark.requirement("RHO-MOT-32", by="gateway.pure.planning.workpiece_systems:CellSystems.reached")
@pytest.mark.requirement("RHO-MOT-32", by="gateway.pure.planning.workpiece_systems:CellSystems.follows")
def test_it_stays_over_programs_aborts_and_planners_until_another_one_or_a_start_up(cell: Portal) -> None:
    there = "linear pose 100 100 50 0 0 0"
    assert cell.run("wc_frame UP 0 0 30 0 0 0", "wc_system UP") is CommandState.DONE, "a program without a block"
    assert cell.at(there) == pytest.approx([100, 100, 80, 0], abs=1e-6)
    slowly = ["linear pose 100 100 40 0 0 0 path=20", "wc_frame ON 0 0 10 0 0 0", "wc_system ON", "linear pose 300 100 50 0 0 0 path=20"]
    for through in (False, True):
        cell.order(HEAD + "\n".join(slowly))
        cell.until(on_the_second if through else on_the_first)
        for code in (Code.STOP, Code.ABANDON):
            cell.done(code)
        cell.until(lambda state: state.motion is Motion.IDLE)
        assert cell.at(there)[2] == pytest.approx(60 if through else 80, abs=1e-6), "what the program had not reached was never chosen"
    another = Programs(cell.programs.cell)
    another.follows(unpack_planner(pack_planner(cell.programs.state)))
    cell.programs, cell.planner = another, PlannerBeside(another, len(CELL.axis))
    assert cell.at(there)[2] == pytest.approx(60, abs=1e-6), "a planner that takes over"
    cell.bench.restart_cycle()
    cell.bench.run(0.3)
    for code in (Code.OVERRIDE, Code.ENABLE):
        assert cell.bench.settle(cell.bench.give(code, 0b1111)).state is CommandState.DONE
    assert cell.at(there)[2] == pytest.approx(50, abs=1e-6) and cell.chosen == ()


@pytest.mark.requirement("RHO-MOT-34", by="motion.outputs.rho3:PathOutputs.step")
def test_switching_positions_are_those_of_the_system(cell: Portal) -> None:
    cell.programs.cell.functions = PLACES
    machine = machine_of_cell(CELL)
    cell.bench.core.lanes[0].mover.functions = CoreOutputs(PLACES, {1: machine.kinematics}, cell.bench.period_ns / 1e9)
    for lines, place in (((FIX, "wc_system FIX"), 30 + 95), (("wc_system WC_UR",), 95 + 30)):
        assert cell.run("wc_system WC_UR", "iol -2 1 1 0 0 0", "linear pose 120 110 50 0 0 0") is CommandState.DONE
        inside = "iol 2 1 1 95 1 0" if len(lines) == 2 else "iol 2 1 2 125 1 0"
        end = "linear pose 120 -100 40 0 0 -90" if len(lines) == 2 else "linear pose 120 150 50 0 0 0"
        job, rows = cell.order(HEAD + "\n".join([*lines, inside, end])), []
        while job.open:
            cell.bench.cycle()
            rows.append((cell.bench.set()[1], get_bit(cell.bench.core.outputs, IOL)))
        assert job.state is CommandState.DONE and rows[-1][1], (job, rows[-1])
        assert all(on is (y >= place - 1e-6) for y, on in rows if abs(y - place) > 1e-3)


def on_the_first(state: CellState) -> bool:
    return 0.071 < state.axes[2].set < 0.079


def on_the_second(state: CellState) -> bool:
    return state.axes[0].set > 0.11


def corrected(rho3: str = "", robot: str = "") -> str:
    head = f"[rho3]\n{rho3}\n\n" if rho3 else ""
    return load_cell(str(PORTAL), PORTAL.read_text().replace("[robot]\n", f"{head}[robot]\n{robot}")).robot[0].corrects


@pytest.mark.requirement("RHO-MOT-33", by="motion.program.systems:_moved")
def test_components_the_machine_has_none_for_are_not_corrected(cell: Portal) -> None:
    assert corrected() == "xyzabc" and corrected(robot='corrects = "xyz"\n') == "xyz" == corrected("P313 = [[4, 1, 2, 0, 0, 0]]")
    lines = ("wc_frame FIX 20 30 10 0 5 90", "wc_system FIX", "linear pose 80 -100 40 0 0 0")
    assert cell.run(*lines) is CommandState.REFUSED, "C alone cannot turn about y"
    machine = cell.machine
    cell.machine = replace(machine, corrects="xyz")
    cosine, sine = np.cos(np.radians(5)), np.sin(np.radians(5))
    x, z = 80 * cosine + 40 * sine, 40 * cosine - 80 * sine
    assert cell.at(*lines) == pytest.approx([20 + 100, 30 + x, 10 + z, 0], abs=1e-5), "the position wholly, the orientation not at all"
    for rho3, robot, words in (
        ("P313 = [[1, 1, 2, 0, 0, 0]]", "", "each at most once"),
        ("P313 = [[1, 2, 7, 0, 0, 0]]", "", "belt values of blocks are not corrected"),
        (
            "P313 = [[5, 1, 2, 0, 0, 0]]",
            "",
            "rho3.P313[1] = [5, 1, 2, 0, 0, 0]: allowed 0..4: component 5 is a belt's, robot portal has 4 axes",
        ),
        ("P313 = [[1, 2, 3]]", "", "P313"),
        ("P313 = 3", "", "P313"),
        ("P313 = [[1, 2, 3, 0, 0, 0], [1, 2, 3, 0, 0, 0]]", "", "1 [[robot]] tables"),
        ("P313 = [[1, 2, 3, 0, 0, 0]]", 'corrects = "xyz"\n', "sets the same"),
        ("", 'corrects = "yx"\n', "letters of xyzabc in this order"),
    ):
        with pytest.raises(CellFaults) as caught:
            corrected(rho3, robot)
        assert words in str(caught.value), str(caught.value)


def test_in_the_dry_run_as_in_the_cell_and_written_again() -> None:
    text = HEAD + "linear pose 100 100 60 0 0 0\n" + FIX + "\nwc_system FIX\nlinear pose 80 -80 40 0 0 -90\nwc_system WC_UR\n"
    program = read(text)
    assert same_program(read(write(program, "rho3")), program) and program.system is not None
    sections, faults = sections_of(program, machine_of_cell(CELL), ())
    assert not faults
    made = DryRun(machine_of_cell(CELL), (), ()).run(sections)
    assert made.q[-1] * (1e3, 1e3, 1e3, 180 / np.pi) == pytest.approx([100, 110, 50, 0], abs=1e-6)


def test_each_of_several_kinematics_has_its_own() -> None:
    own = "kinematic {0} portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\n"
    both = own.format("a") + FIX + "\nwc_system FIX\n" + own.format("b")
    program = read_team(both + "move a linear pose 80 -80 40 0 0 -90 and b linear pose 80 80 40 0 0 0\n")
    assert read_team(write_team(program)).blocks[0].moves[0] is not None
    again = read_team(write_team(program)).blocks[0].moves
    assert again[0] is not None and again[0].system is not None and again[0].system.values == (20, 30, 10, 0, 0, 90)
    machine = machine_of_cell(CELL)
    other = replace(machine, limits=tuple(replace(axis, name=f"b.{axis.name}") for axis in machine.limits))
    team = Team(("a", "b"), (machine, other))
    ends = [made.q[-1] * 1e3 for made in team_traces(team_findings(program, team), team)]
    assert ends[0][:3] == pytest.approx([100, 110, 50], abs=1e-6) and ends[1][:3] == pytest.approx([80, 80, 40], abs=1e-6)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("wc_frame FIX 1 2 3", "wc_frame: six numbers are needed (dx dy dz mm, da db dc deg), found 3"),
        ("wc_frame WC_UR 0 0 0 0 0 0", "wc_frame: WC_UR exists already"),
        ("wc_frame THIRTEEN_CHAR 0 0 0 0 0 0", "a name has at most 12 characters"),
        ("wc_frame FIX 0 0 0 0 0 nan", "wc_frame: nan is outside"),
        ("wc_system FIX", "wc_system: 'FIX' is unknown; WC_UR are known"),
    ],
)
def test_faults_are_reported_with_line_and_key(line: str, words: str) -> None:
    with pytest.raises(TextFaults) as caught:
        read(HEAD + line + "\n")
    assert f"line 5: {words}" in str(caught.value) or words in str(caught.value), str(caught.value)
