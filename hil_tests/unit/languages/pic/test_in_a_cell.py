"""PIC programs beside BAPS2 programs in a cell of emulated drives, in virtual time: interlocks, a plant without a PLC, deaths (AX-981)."""

from dataclasses import replace

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.rho3 import Rho3
from hil_tests.lab.virtual.baps2_bench import ProgramCell, one

BASE = load_cell("palletiser")
MINE = (*range(2, 32), 58, 59)
STANDARD = """
; the enabling inputs of the control, drives by a switch, automatic
EMSTOP_OK_RCI = 1   CTRL_ALLOW_RCI = 1   FEED_ALLOW_RCI = 1   TRAVEL_ALLOW_RCI = 1   FEED_HOLD_N_RCI = 1
AUTO_MN_RCI = 1
O8.2 = I88.0
"""
SWITCH, START, GUARD, FULL = (f"rho3.pic.input.88.{bit}" for bit in range(4))


def cell_of(p13: tuple[int, ...] = (), p14: tuple[int, ...] = ()) -> Cell:
    """The palletiser with a PIC instead of its PLC."""
    assert BASE.controller is not None
    owner = {**BASE.rc_inputs.owner, **dict.fromkeys(MINE, "pic")}
    rho3 = Rho3(others={"P13": p13, "P14": p14})
    return replace(BASE, controller=replace(BASE.controller, pic="LOCK"), rc_inputs=replace(BASE.rc_inputs, owner=owner), rho3=rho3)


def with_pic(program: dict[str, str], lock: str, cell: Cell | None = None, symbols: str = "") -> ProgramCell:
    return ProgramCell(program | {"LOCK.QLS": STANDARD + lock, "LOCK.SYM": symbols}, cell or cell_of())


def wire(cell: ProgramCell, name: str, value: bool = True) -> None:
    cell.control.put(name, value)


def ready(cell: ProgramCell) -> None:
    """The switch of the drives."""
    wire(cell, SWITCH)
    cell.until(lambda: all(axis.flags & 1 for axis in cell.bench.core.state.axes), 10)


BACK_AND_FORTH = "V = 200\nMOVE LINEAR TO (400, 60, 40, 12)\nMOVE LINEAR TO (60, 60, 40, 12)"


def test_an_open_door_holds_the_robot_on_its_path() -> None:
    cell = with_pic(one(BACK_AND_FORTH), "IF NOT DOOR_DI THEN FEED_HOLD_N_RCI = 0", symbols="DOOR_DI = I88.2")
    wire(cell, GUARD)
    ready(cell)
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 200)
    wire(cell, GUARD, value=False)
    cell.bench.run(1.0)
    held = cell.at()
    cell.bench.run(1.0)
    assert cell.at() == held and held[0] < 400, "it rests on its path"
    wire(cell, GUARD)
    assert cell.ends(run)[0] == "ended"


SELECT = """
; a start button selects program 01 with the strobe half a second later, an odd parity bit
EXTPRG_0_RCI = START_DI   PTY_EXTP_RCI = START_DI
M2.0 = START_DI                      ; timer 0
O10.1 = M3.0
"""


def test_a_start_button_selects_the_program_without_any_plc() -> None:
    cell = with_pic(one(BACK_AND_FORTH, name="PALLET"), SELECT, cell_of(p13=(125,)), "START_DI = I88.1")
    ready(cell)
    pressed = cell.bench.now
    wire(cell, START)
    cell.until(lambda: bool(cell.language.rows()), 5)
    assert 0.5 <= (cell.bench.now - pressed) / 1e9 < 0.6, "P13: 125 clocks of 4 ms"
    cell.until(lambda: cell.at()[0] > 399)
    cell.until(lambda: not cell.language.rows())
    assert cell.at()[0] == 60 and cell.bench.dispatcher.owner == 2, "it moves as the command source pic"


COUNTED = "M0.0 = USER_1_RCO M5.0 = EMPTIED_DI USER_1_RCI = M1.0"


def test_a_full_pallet_holds_the_program_until_it_is_emptied() -> None:
    body = "AGAIN:\nPUT = 1\nWAIT 0.1\nPUT = 0\nWAIT 0.1\nIF FULL = 0 THEN JUMP AGAIN\nDONE = 1\nWAIT UNTIL FULL = 0\nDONE = 0"
    program = one(body, "OUTPUT : 1 = PUT, 2 = DONE\nINPUT : 1 = FULL")
    cell = with_pic(program, COUNTED, cell_of(p14=(3,)), "EMPTIED_DI = I88.3")
    ready(cell)
    run = cell.start("P")
    cell.until(lambda: any(channel == 2 for _, channel, _ in cell.outputs))
    assert [channel for _, channel, value in cell.outputs if value] == [1, 1, 1, 2], "three parts: P14"
    assert cell.control.counter(0) == 0 and cell.control.counter(1) == 0
    wire(cell, FULL)
    assert cell.ends(run)[0] == "ended" and cell.control.counter(0) == 3


def test_a_pic_that_comes_back_has_its_flags_and_counters() -> None:
    cell = with_pic(one("WAIT 1"), "M0.0 = I88.1 IF I88.2 THEN M50.1 = 1 O58.0 = M50.1", cell_of(p14=(9,)))
    wire(cell, START)
    wire(cell, GUARD)
    cell.bench.run(0.1)
    wire(cell, GUARD, value=False)
    cell.dies()
    cell.bench.run(0.1)
    cell.born(2)
    cell.bench.run(0.1)
    assert cell.control.counter(0) == 8 and cell.control.flag_bytes()[50] == 2 and cell.control.image.input(464)
    assert cell.control.write_flags(50, b"\0")
    cell.bench.run(0.1)
    assert cell.control.flag_bytes()[50] == 0 and not cell.control.image.input(464), "flags that others write reach the program"


@pytest.mark.requirement("RHO-PLC-38", by="gateway.pure.controllers.rho3.signals.pic:PicLink.fails")
def test_a_scan_without_an_end_stops_the_pic_and_opens_ready() -> None:
    cell = with_pic(one("WAIT 1"), "USER_1_RCI = 1 AGAIN: IF I88.1 THEN JUMP AGAIN")
    ready(cell)
    assert cell.control.image.input(464)
    wire(cell, START)
    cell.bench.run(0.2)
    assert not any(cell.control.image.inputs) and cell.control.halted
    assert sum("(1275)" in told for told in cell.told) == 1, cell.told
    cell.until(lambda: not any(axis.flags & 1 for axis in cell.bench.core.state.axes), 5)
    assert cell.port is not None and "the PIC stops" in cell.port.words[-1]
