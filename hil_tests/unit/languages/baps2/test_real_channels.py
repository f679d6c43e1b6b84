"""REAL and INTEGER channels of BAPS2 programs in a cell: values that routes and tools know by name (rho 3 releases L7953-7967, AX-1120)."""

import pytest

from gateway.checks.controller import names_of, wired
from gateway.pure.languages.baps2.errors import TEXTS
from hil_tests.lab.virtual.baps2_bench import CELL, ProgramCell, one

DECLARED = "INPUT : 201 = PRESSURE, 1224 = LAST\nOUTPUT : 3 = FOUND, 202 = VALVE, 401 = COUNT"


def test_a_program_reads_what_is_wired_and_sets_what_a_route_reads() -> None:
    cell = ProgramCell(one("WAIT UNTIL PRESSURE >= 2.5\nVALVE = PRESSURE * 2 + LAST\nCOUNT = -70000\nFOUND = 1", DECLARED))
    cell.control.put("rho3.real.input.201", 1.25)
    cell.control.put("rho3.real.input.224", -0.5)
    run = cell.start("P")
    cell.bench.run(0.3)
    assert not cell.hosted.results, "the pressure is too low"
    cell.control.put("rho3.real.input.201", 3.5)
    assert cell.ends(run)[0] == "ended"
    assert cell.control.value("rho3.real.output.202") == 6.5
    assert cell.control.value("rho3.integer.output.401") == -70000
    assert [channel for _, channel, _ in cell.outputs] == [3], "no binary output is switched by the others"


def test_an_input_that_nothing_is_wired_to_ends_the_program() -> None:
    cell = ProgramCell(one("VALVE = PRESSURE", DECLARED))
    how, code, text, place = cell.run("P")
    assert (how, code, place) == ("aborted", 206, "P.QLL line 9")
    assert text == f"{TEXTS[206]}: 201"


def test_a_program_may_read_its_outputs_back() -> None:
    cell = ProgramCell(one("VALVE = 1.5\nVALVE = VALVE * 3\nCOUNT = 5\nCOUNT = COUNT + 1", DECLARED))
    assert cell.run("P")[0] == "ended"
    assert (cell.control.value("rho3.real.output.202"), cell.control.value("rho3.integer.output.401")) == (4.5, 6)


def test_a_route_may_lead_to_an_input_and_to_no_output() -> None:
    assert wired(CELL, "rho3.real.input.201") and not wired(CELL, "rho3.real.output.201")
    assert {"rho3.real.output.224", "rho3.integer.output.408"} <= names_of(CELL)
    assert not {"rho3.real.input.200", "rho3.real.input.225"} & names_of(CELL)
    control = ProgramCell(one("HALT")).control
    with pytest.raises(ValueError, match="a number is expected"):
        control.put("rho3.real.input.201", float("nan"))
    with pytest.raises(KeyError):
        control.put("rho3.real.output.201", 1.0)
