"""WAIT UNTIL of a high-speed input directly before a movement, in a cell and dry (rho 3 releases L1574-1655, L8196-8215)."""

from dataclasses import replace

import pytest

from gateway.pure.cell.belts import Measuring
from hil_tests.lab.virtual.baps2_bench import CELL, FIRST_INPUT, ProgramCell, one
from hil_tests.unit.languages.baps2.running import run

WIRE = FIRST_INPUT + 8  # RC input the high-speed input 611 comes to
FAST = replace(CELL, measuring=(Measuring(611, WIRE),))
INPUT = "INPUT : 611 = HS\nOUTPUT : 3 = LAMP"


def cell_of(body: str) -> ProgramCell:
    cell = ProgramCell(one(body, INPUT), FAST)
    cell.bench.permit(WIRE, value=False)
    return cell


def edge(cell: ProgramCell, wanted: float) -> int:
    """Cycles from the edge to the first set value that has left the place."""
    cell.until(lambda: abs(cell.at()[0] - wanted) < 0.001)
    cell.bench.run(0.5)
    assert cell.at()[0] == pytest.approx(wanted, abs=0.001), "it waits"
    cell.bench.permit(WIRE)
    began = len(cell.places)
    cell.until(lambda: abs(cell.places[-1][0] - wanted) > 1e-7)
    return len(cell.places) - began


def test_the_cycle_starts_the_block_at_the_edge_and_max_time_delays_it() -> None:
    cell = cell_of("MOVE LINEAR TO (100, 60, 40, 12)\nWAIT UNTIL HS = 1\nMOVE LINEAR TO (160, 60, 40, 12)")
    run = cell.start("P")
    assert edge(cell, 100) <= 3
    assert cell.ends(run)[:2] == ("ended", 0) and cell.at()[0] == 160
    cell = cell_of("MOVE LINEAR TO (100, 60, 40, 12)\nWAIT UNTIL HS = 1 MAX_TIME = 0.2\nMOVE LINEAR TO (160, 60, 40, 12)")
    run = cell.start("P")
    assert edge(cell, 100) == pytest.approx(50, abs=3), "200 ms in cycles of 4 ms"
    assert cell.ends(run)[:2] == ("ended", 0)


def test_an_output_between_wait_and_movement_acts_behind_the_condition() -> None:
    cell = cell_of("MOVE LINEAR TO (100, 60, 40, 12)\nWAIT UNTIL HS = 1\nLAMP = 1\nMOVE LINEAR TO (160, 60, 40, 12)")
    run = cell.start("P")
    edge(cell, 100)
    assert [channel for _, channel, _ in cell.outputs] == [3]
    assert cell.ends(run)[:2] == ("ended", 0)


TWO = """;;CONTROL = RHO3
;;KINEMATICS : (1 = ONE, 2 = TWO)
;;ONE.WC_NAMES = X
;;TWO.WC_NAMES = Y
PROGRAM P
INPUT : 611 = HS
;;KINEMATICS = ONE
;;INT = LINEAR
BEGIN
MOVE TWO TO (10)
{dummy}WAIT UNTIL HS = 1
MOVE ONE TO (20)
MOVE TWO TO (30)
PROGRAM_END
"""


@pytest.mark.requirement("RHO-MOT-18", by="gateway.pure.languages.baps2.control:Control._overtakes")
@pytest.mark.parametrize(("dummy", "held"), [("", "TWO"), ("MOVE_REL ONE (0)\n", "ONE")])
def test_without_the_dummy_movement_the_wait_holds_the_next_block_of_the_old_kinematic(dummy: str, held: str) -> None:
    feed = "until_s = 20\n[[input]]\nchannel = 611\nat = 9.0\n"
    events = run(TWO.format(dummy=dummy), feed)
    targets = {each["n"]: each["target"] for each in events if each["event"] == "move"}
    began = {str(targets[each["n"]]): each["t"] for each in events if each["event"] == "moving"}
    before = [place for place in ("[20.0]", "[30.0]") if float(str(began[place])) < 9]
    assert before == (["[20.0]"] if held == "TWO" else []), began


@pytest.mark.requirement("RHO-MOT-18", by="gateway.pure.languages.baps2.travel:wait")
def test_what_follows_a_fast_wait_comes_in_its_order_and_the_movement_two_p5_later() -> None:
    head = ";;KINEMATICS : (1 = ONE)\n;;ONE.WC_NAMES = X\nPROGRAM P\nINPUT : 631 = HS\nOUTPUT : 1 = OFF1, 2 = OFF2\nBEGIN\nMOVE TO (1)\n"
    text = head + "WAIT UNTIL HS = 1{0}\nOFF1 = 1\nOFF2 = 0\nWRITE PHG, 'HS_31 is set'\nMOVE TO (2)\nPROGRAM_END"
    for limit, after in (("", 0.0), (" MAX_TIME = 0.15", 0.15)):
        events = run(text.format(limit), "[[input]]\nchannel = 631\nat = 3")
        told = [(each["t"], each["event"]) for each in events if each["event"] in ("out", "write", "moving")]
        moved = round(3.02 + after, 2)
        assert told == [(0.0, "moving"), (3 + after, "out"), (3 + after, "out"), (3 + after, "write"), (moved, "moving")]


@pytest.mark.parametrize("between", ["", "AGAIN: ", ";;INT = LINEAR\n"])
def test_a_label_or_an_instruction_before_the_movement_delays_nothing(between: str) -> None:
    head = ";;KINEMATICS : (1 = ONE)\n;;ONE.WC_NAMES = X\nPROGRAM P\nINPUT : 631 = HS\nBEGIN\nMOVE TO (1)\nWAIT UNTIL HS = 1\n"
    events = run(f"{head}{between}MOVE TO (2)\nPROGRAM_END", "[[input]]\nchannel = 631\nat = 3")
    assert [each["t"] for each in events if each["event"] == "moving"] == [0.0, 3.0]
