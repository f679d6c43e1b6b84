"""Special functions of BAPS2 programs in a cell of emulated drives: recorded paths, measuring in flight (AX-982)."""

from dataclasses import replace

import pytest

from gateway.pure.cell.rho3 import Rho3
from gateway.pure.languages.base.faults import Faults
from hil_tests.lab.virtual.baps2_bench import CELL, ProgramCell, one

RECORD = """SPC_FCT : 29 = REC_ON (VALUE INTEGER : K, MS VALUE REAL : DIST)
SPC_FCT : 30 = REC_OFF (VALUE INTEGER : K INTEGER : N)
SPC_FCT : 31 = REC_READ (VALUE INTEGER : K, I JC_POINT : J POINT : W)
DEF POINT : W1, W2
DEF JC_POINT : @J1
INTEGER : N"""


def test_a_recorded_path_is_read_backwards() -> None:
    body = """V = 200
REC_ON(1, 1, 20.0)
MOVE LINEAR TO (260, 60, 40, 12)
WAIT 0.1
REC_OFF(1, N)
REC_READ(1, 1, @J1, W1)
REC_READ(1, N, @J1, W2)
MOVE LINEAR TO (W1.X, W1.Y, 40, 12)"""
    cell = ProgramCell(one(body, RECORD))
    began = cell.at()
    assert cell.run("P") == ("ended", 0, "", "P.QLL line 20")
    points = cell.memory.points("P", Faults())
    assert points["W2"] == pytest.approx(began, abs=0.1), "the oldest entry"
    share = (points["W1"][0] - began[0]) / (260 - began[0])
    assert 0.9 < share <= 1 and points["W1"][1] == pytest.approx(began[1] + share * (60 - began[1]), abs=0.1), "the newest, on the line"
    assert cell.at()[0] == pytest.approx(points["W1"][0], abs=0.01)


MEASURE = """SPC_FCT : 43 = MEASURE_ON (VALUE INTEGER : K, EDGE INPUT : CH)
SPC_FCT : 44 = MEASURE_OFF (VALUE INTEGER : K INPUT : CH)
INPUT : 610 = PROBE
DEF JC_POINT : @HIT
OUTPUT : 3 = SEEN"""


def test_a_probe_measures_in_flight_and_the_movement_goes_on() -> None:
    assert CELL.controller is not None
    cell = replace(CELL, controller=replace(CELL.controller, boards=("modular-i",)), rho3=Rho3(others={"P11": (1, 9)}))
    body = """V = 100
MEASURE_ON(1, 1, PROBE)
MOVE LINEAR TO (260, 60, 40, 12)
IF PROBE = 1 THEN BEGIN @HIT = @MPOS SEEN = 1 END
MEASURE_OFF(1, PROBE)"""
    bench = ProgramCell(one(body, MEASURE), cell)
    run = bench.start("P")
    bench.until(lambda: bench.at()[0] > 150)
    bench.control.put("rho3.fast.610", 1.0)
    bench.until(lambda: bench.at()[0] > 160)
    bench.control.put("rho3.fast.610", 0.0)
    assert bench.ends(run)[0] == "ended" and bench.at()[0] == 260, "it is not stopped"
    assert bench.memory.points("P", Faults())["@HIT"][0] == pytest.approx(151, abs=3)
    assert bench.outputs[-1][1:] == (3, True)


def test_nothing_measured_is_an_error_and_so_is_a_probe_that_is_not_there() -> None:
    assert CELL.controller is not None
    cell = replace(CELL, controller=replace(CELL.controller, boards=("modular-i",)), rho3=Rho3(others={"P11": (1, 9)}))
    body = "MEASURE_ON(1, 1, PROBE)\nMOVE LINEAR TO (100, 60, 40, 12)\n@HIT = @MPOS"
    assert ProgramCell(one(body, MEASURE), cell).run("P")[1] == 200
    assert ProgramCell(one(body, MEASURE)).run("P")[1] == 206


def test_a_path_is_recorded_by_any_axis_of_the_cell_and_by_no_other() -> None:
    body = "V = 200\nREC_ON(1, 2, 20.0)\nMOVE LINEAR TO (260, 60, 40, 12)\nMOVE LINEAR TO (260, 160, 40, 12)\nWAIT 0.1\nREC_OFF(1, N)\n"
    cell = ProgramCell(one(f"{body}W1 = (N, 0, 0, 0)", RECORD))
    begin = cell.at()[1]
    assert cell.run("P")[:2] == ("ended", 0)
    ways = (abs(60 - begin) // 20) + 5
    assert cell.memory.points("P", Faults())["W1"][0] in (ways, ways + 1), "of the ways of A2 alone"
    assert ProgramCell(one("REC_ON(1, 5, 20.0)", RECORD)).run("P")[1] == 91, "the cell has four axes and no belt"
