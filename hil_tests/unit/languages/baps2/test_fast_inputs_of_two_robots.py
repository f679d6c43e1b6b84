"""High-speed inputs, SF 41 and 42 while two kinematics of a cell move (rho 3 releases part 2, L6756-6830; AX-1680, AX-920)."""

from dataclasses import replace

import pytest

from gateway.pure.cell.belts import Measuring
from gateway.pure.cell.cell import Cell
from gateway.pure.languages.base.faults import Faults
from hil_tests.lab.virtual.baps2_bench import FIRST_INPUT, ProgramCell
from hil_tests.unit.languages.baps2.test_two_robots_in_a_cell import memory, two_portals

FIRST, SECOND = FIRST_INPUT + 8, FIRST_INPUT + 9
FAST = FIRST_INPUT + 10
DECLARED = """SPC_FCT : 41 = POTI_MODIFY (VALUE INTEGER : K VALUE REAL : F)
SPC_FCT : 42 = MOVE_DIST (VALUE INTEGER : K VALUE REAL : D)
INPUT : 1 = MEASURE, 710 = PROBE1, 720 = PROBE2, 611 = HS
OUTPUT : 3 = FOUND, 4 = LOST
DEF PORTAL.JC_POINT : @HIT, @THERE
DEF LOADER.JC_POINT : @LHIT, @LTHERE"""


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    boards = (Measuring(610, FIRST, robot=("PORTAL",)), Measuring(620, SECOND, robot=("LOADER",)), Measuring(611, FAST, robot=("PORTAL",)))
    return replace(two_portals(tmp_path_factory.mktemp("fast")), measuring=boards)


def cell_of(two: Cell, body: str, more: dict[str, str] | None = None) -> ProgramCell:
    cell = ProgramCell(memory(body, DECLARED) | (more or {}), two)
    for wire in (FIRST, SECOND, FAST):
        cell.bench.permit(wire, value=False)
    return cell


def speed(cell: ProgramCell, axis: int) -> float:
    return abs(cell.places[-1][axis] - cell.places[-2][axis]) / 0.004


BOTH = """MOVE PORTAL PTP TO @(20, 60, 40, 12)
MOVE LOADER PTP TO @(20, 60)
PORTAL.V_PTP = 0.5
LOADER.V_PTP = 0.5
MOVE_DIST(1, 45.0)
MOVE_DIST(2, 20.0)
PARALLEL
MOVE PORTAL PTP UNTIL PROBE1 = 1 ERROR LOST = 1 TO @(700, 60, 40, 12)
@HIT = PORTAL.@MPOS
@THERE = PORTAL.@POS
ALSO
MOVE LOADER PTP UNTIL PROBE2 = 1 ERROR LOST = 1 TO @(480, 60)
@LHIT = LOADER.@MPOS
@LTHERE = LOADER.@POS
ALSO
WAIT UNTIL MEASURE = 1
POTI_MODIFY(1, 0.2)
PARALLEL_END
FOUND = 1
MOVE_REL PORTAL PTP @(0, 5, 0, 0)"""


def test_each_robot_runs_on_by_its_own_distance_and_is_slowed_down_alone(two: Cell) -> None:
    cell = cell_of(two, BOTH)
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 150)
    assert (speed(cell, 0), speed(cell, 4)) == pytest.approx((400.0, 400.0), abs=0.1)
    cell.give(1)
    cell.bench.run(0.35)
    assert (speed(cell, 0), speed(cell, 4)) == pytest.approx((80.0, 400.0), abs=0.1)
    cell.bench.permit(SECOND)
    cell.bench.run(0.3)
    assert speed(cell, 4) == 0.0 and speed(cell, 0) == pytest.approx(80.0, abs=0.1), "the other one goes on"
    cell.bench.permit(FIRST)
    assert cell.ends(run)[:2] == ("ended", 0)
    points = cell.memory.points("P", Faults())
    assert points["@THERE"][0] - points["@HIT"][0] == pytest.approx(45.0, abs=1e-3)
    assert points["@LTHERE"][0] - points["@LHIT"][0] == pytest.approx(20.0, abs=1e-3)
    assert [channel for _, channel, _ in cell.outputs] == [3]


def test_another_program_sets_distance_and_speed_of_the_robot_it_does_not_move(two: Cell) -> None:
    other = memory("MOVE LOADER PTP TO @(50, 60)\nPOTI_MODIFY(1, 0.25)\nMOVE_DIST(1, 33.0)", DECLARED, "Q")
    body = "MOVE PORTAL PTP TO @(20, 60, 40, 12)\nPORTAL.V_PTP = 0.5\nSTART Q\n"
    body += "MOVE PORTAL PTP UNTIL PROBE1 = 1 TO @(700, 60, 40, 12)\n@HIT = PORTAL.@MPOS\n@THERE = PORTAL.@POS"
    cell = cell_of(two, body, other)
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 180)
    assert speed(cell, 0) == pytest.approx(100.0, abs=0.1)
    cell.bench.permit(FIRST)
    assert cell.ends(run)[:2] == ("ended", 0)
    points = cell.memory.points("P", Faults())
    assert points["@THERE"][0] - points["@HIT"][0] == pytest.approx(33.0, abs=1e-3)


def test_a_fast_wait_of_one_robot_does_not_hold_the_other_one(two: Cell) -> None:
    body = "PARALLEL\nMOVE PORTAL LINEAR TO (100, 60, 40, 12)\nWAIT UNTIL HS = 1\nMOVE PORTAL LINEAR TO (200, 60, 40, 12)\nALSO\n"
    cell = cell_of(two, f"{body}MOVE LOADER LINEAR TO (100, 60)\nMOVE LOADER LINEAR TO (200, 60)\nLOST = 1\nPARALLEL_END")
    run = cell.start("P")
    cell.until(lambda: cell.outputs != [])
    assert (cell.at()[0], cell.at()[4]) == pytest.approx((100, 200), abs=0.01)
    cell.bench.permit(FAST)
    began = len(cell.places)
    cell.until(lambda: cell.places[-1][0] > 100.0001)
    assert len(cell.places) - began <= 3, "the cycle starts it"
    assert cell.ends(run)[:2] == ("ended", 0) and cell.at()[0] == 200


def test_a_program_that_is_stopped_in_such_a_block_leaves_nothing_behind(two: Cell) -> None:
    stopper = memory("WAIT UNTIL MEASURE = 1\nSTOP P\nMOVE PORTAL PTP TO @(10, 60, 40, 12)", f"{DECLARED}\nEXTERNAL : P", "Q")
    body = "PORTAL.V_PTP = 0.3\nMOVE_DIST(1, 30.0)\nMOVE PORTAL PTP UNTIL PROBE1 = 1 ERROR LOST = 1 TO @(250, 60, 40, 12)"
    cell = cell_of(two, body, stopper)
    first, second = cell.start("P"), cell.start("Q")
    cell.until(lambda: cell.at()[0] > 100)
    cell.give(1)
    assert cell.ends(second)[:2] == ("ended", 0) and cell.hosted.results[first][0] == "stopped"
    assert cell.at()[0] == 10
    cell.bench.permit(FIRST)
    assert cell.run("P")[:2] == ("ended", 0)
    assert cell.at()[0] == 250 and cell.outputs[-1][1:] == (4, True), "a probe has to change while the block runs"


def test_the_probe_of_another_robots_board_is_refused(two: Cell) -> None:
    ended = cell_of(two, "MOVE PORTAL PTP UNTIL PROBE2 = 1 TO @(100, 60, 40, 12)").run("P")
    assert ended[:2] == ("aborted", 253) and "channel 720" in ended[2]
