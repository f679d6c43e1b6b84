"""MOVE UNTIL with an input 7x0, special functions 41 and 42 in a cell of emulated drives (rho 3 releases part 2, L6756-6870; AX-1680)."""

from dataclasses import replace

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.cell.belts import Measuring
from gateway.pure.languages.base.faults import Faults
from hil_tests.lab.virtual.baps2_bench import CELL, FIRST_INPUT, ProgramCell, one

WIRE = FIRST_INPUT + 8  # RC input the probe comes to
DECLARED = """SPC_FCT : 41 = POTI_MODIFY (VALUE INTEGER : KIN_NO VALUE REAL : KIN_POTI)
SPC_FCT : 42 = MOVE_DIST (VALUE INTEGER : KIN_NO VALUE REAL : DIST)
INPUT : 1 = MEASURE, 710 = PROBE
OUTPUT : 3 = FOUND, 4 = LOST
DEF JC_POINT : @HIT, @THERE"""
BALANCE = """MOVE PTP TO @(20, 60, 40, 12)
V_PTP = 0.5
PARALLEL
MOVE PTP UNTIL PROBE = 1 ERROR LOST = 1 TO @(700, 60, 40, 12)
ALSO
WAIT UNTIL MEASURE = 1
POTI_MODIFY(1, 0.2)
MOVE_DIST(1, 45.0)
PARALLEL_END
@HIT = @MPOS
@THERE = @POS
FOUND = 1
MOVE_REL PTP @(0, 5, 0, 0)"""


def cell_of(body: str, declared: str = DECLARED) -> ProgramCell:
    cell = ProgramCell(one(body, declared), replace(CELL, measuring=(Measuring(610, WIRE),)))
    cell.bench.permit(WIRE, value=False)
    return cell


def speed(cell: ProgramCell) -> float:
    """mm/s of axis 1 in the last cycle."""
    return abs(cell.places[-1][0] - cell.places[-2][0]) / 0.004


@pytest.mark.requirement("RHO-MOT-14", by="gateway.pure.languages.baps2.cell_asynchronous:CellAsynchronous.call")
@pytest.mark.requirement("RHO-MOT-15", by="gateway.pure.languages.baps2.cell_asynchronous:CellAsynchronous.turn")
def test_the_balancing_machine_of_the_manual_slows_down_and_runs_on_by_the_angle_of_a_parallel_branch() -> None:
    cell = cell_of(BALANCE)
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 180)
    assert speed(cell) == pytest.approx(400.0, abs=0.1), "V_PTP = 0.5 of 800 mm/s"
    cell.give(1)
    cell.bench.run(0.8)
    assert speed(cell) == pytest.approx(80.0, abs=0.1), "POTI_MODIFY acts on the block under way"
    cell.bench.permit(WIRE)
    assert cell.ends(run)[:2] == ("ended", 0)
    points = cell.memory.points("P", Faults())
    assert points["@THERE"][0] - points["@HIT"][0] == pytest.approx(45.0, abs=1e-3), "POS is where the axes came to rest"
    assert cell.at()[:2] == (round(points["@THERE"][0], 3), 65.0), "the next block begins there"
    assert [channel for _, channel, _ in cell.outputs] == [3], "no ERROR part"


def test_a_distance_stays_for_the_next_edge_and_without_an_edge_the_error_part_runs() -> None:
    cell = cell_of(
        "MOVE_DIST(1, 30.0)\nMOVE PTP UNTIL PROBE = 1 ERROR LOST = 1 TO @(60, 60, 40, 12)\nV = 100\n"
        "MOVE LINEAR UNTIL PROBE = 1 ERROR LOST = 0 TO (600, 60, 40, 12)\n@THERE = @POS\n@HIT = @MPOS"
    )
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 100)
    cell.bench.permit(WIRE)
    assert cell.ends(run)[:2] == ("ended", 0)
    points = cell.memory.points("P", Faults())
    assert points["@THERE"][0] - points["@HIT"][0] == pytest.approx(30.0, abs=1e-3)
    assert [(channel, value) for _, channel, value in cell.outputs] == [(4, True)]


def test_poti_modify_replaces_the_factor_of_all_that_is_prepared_and_what_a_program_sets_then_counts_again() -> None:
    cell = cell_of(
        "V_PTP = 0.5\nMOVE PTP TO @(20, 60, 40, 12)\nPARALLEL\nMOVE PTP VIA @(200, 60, 40, 12)\nMOVE PTP TO @(300, 60, 40, 12)\nALSO\n"
        "WAIT UNTIL MEASURE = 1\nPOTI_MODIFY(1, 0.1)\nPARALLEL_END\nVFACTOR = 0.5\nMOVE PTP TO @(500, 60, 40, 12)"
    )
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 100)
    cell.give(1)
    cell.until(lambda: cell.at()[0] > 250)
    assert speed(cell) == pytest.approx(40.0, abs=0.1), "the second block, too"
    cell.until(lambda: cell.at()[0] > 400)
    assert speed(cell) == pytest.approx(200.0, abs=0.1)
    assert cell.ends(run)[:2] == ("ended", 0)


@pytest.mark.parametrize(
    ("body", "code", "words"),
    [("POTI_MODIFY(1, 0.0)", 218, "VFACTOR = 0"), ("MOVE_DIST(2, 1.0)", 220, "2"), ("MOVE UNTIL BAD = 1 TO @(60, 60, 40, 12)", 206, "720")],
)
def test_what_makes_no_sense_is_an_error_of_its_line(body: str, code: int, words: str) -> None:
    ended = cell_of(body, f"{DECLARED}\nINPUT : 720 = BAD").run("P")
    assert ended[1] == code and words in ended[2] and ended[3].startswith("P.QLL line 1")


def test_a_distance_out_of_the_travel_ends_the_program_and_names_the_axis() -> None:
    cell = cell_of("MOVE_DIST(1, 5000.0)\nMOVE PTP UNTIL PROBE = 1 TO @(700, 60, 40, 12)\nFOUND = 1")
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 100)
    cell.bench.permit(WIRE)
    how, code, text, _ = cell.ends(run)
    assert (how, code) == ("aborted", 253) and CELL.axis[0].name in text and not cell.outputs


def test_a_line_of_an_arm_has_no_such_way() -> None:
    scara = load_cell("scara")
    axes = tuple(replace(axis, name=its.name, unit=its.unit, limits=its.limits) for axis, its in zip(CELL.axis, scara.axis, strict=True))
    cell = ProgramCell(
        {
            "P.QLL": ";;CONTROL = RHO3\n;;KINEMATICS : (1 = SCARA)\n;;SCARA.WC_NAMES = X, Y, Z, C\nPROGRAM P\nINPUT : 710 = PROBE\nBEGIN\n"
            "MOVE LINEAR UNTIL PROBE = 1 TO (300, 60, 40, 12)\nPROGRAM_END\n"
        },
        replace(CELL, axis=axes, robot=scara.robot, plant=None, measuring=(Measuring(610, WIRE),)),
    )
    assert cell.run("P")[1:3] == (222, "not possible in a cell: input 710 ends a linear movement of an arm; use PTP")
