"""A PIC program with real processes: a cell without any PLC, started by a button, held by a door; its interpreter dies (AX-981)."""

import pathlib
import shutil
import time
from collections.abc import Callable

import pytest

import configs
from gateway.pure.image.records.cell import Motion
from gateway.tools.client import Row, ToolClient
from hil_tests.lab.running.cell_running import COMES_UP_S, CellRun, running_cell

CELLS = pathlib.Path(configs.__file__).parent / "cells"
LOCK = """
EMSTOP_OK_RCI = 1   CTRL_ALLOW_RCI = 1   FEED_ALLOW_RCI = 1   TRAVEL_ALLOW_RCI = 1   AUTO_MN_RCI = 1
FEED_HOLD_N_RCI = DOOR_DI
O8.2 = DRIVES_DI                        ; drive on
EXTPRG_1_RCI = START_DI   PTY_EXTP_RCI = START_DI
M2.0 = START_DI   O10.1 = M3.0          ; code 02, its strobe by timer 0
M40.0 = 1
"""
SYMBOLS = "DRIVES_DI = I88.0\nDOOR_DI = I88.1\nSTART_DI = I88.2\n"
LOOP = ";;KINEMATICS : (1 = PORTAL)\nPROGRAM LOOP\nBEGIN\nV = 60\nMOVE LINEAR TO @(1000, 60, 100, 0)\nPROGRAM_END\n"
LONG_S = 60.0
pytestmark = pytest.mark.timeout(COMES_UP_S + 6 * LONG_S)


def a_cell(folder: pathlib.Path) -> str:
    shutil.copytree(CELLS / "palletiser", folder / "palletiser")
    memory = folder / "palletiser"
    for name, text in (("LOCK.QLS", LOCK), ("LOCK.SYM", SYMBOLS), ("LOOP.QLL", LOOP), ("EXPROG.DAT", "02 = LOOP\r\n")):
        (memory / name).write_text(text)
    text = (CELLS / "palletiser.toml").read_text().replace('= "rack"', '= "pic"').replace('name     = "pic"', 'name     = "rack"')
    text = text.replace('kind   = "rho3"', 'kind   = "rho3"\npic    = "LOCK"').replace("[[line]]", "[rho3]\nP13 = [25]\n\n[[line]]", 1)
    (folder / "cell.toml").write_text(text)
    return str(folder / "cell.toml")


def until(holds: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + LONG_S
    while not holds():
        assert time.monotonic() < deadline, what
        time.sleep(0.02)


class Buttons:
    """Its digital inputs and what it shows."""

    def __init__(self, run: CellRun) -> None:
        self.run = run

    def ask(self, op: str, **facts: object) -> Row:
        client = ToolClient(self.run.name)
        try:
            return client.ask(op, **facts)
        finally:
            client.close()

    def wire(self, bit: int, value: bool = True) -> None:
        self.ask("set", address=f"rho3.pic.input.88.{bit}", value=str(int(value)))

    def alive(self) -> bool:
        return self.reads("O3.1")

    def reads(self, address: str) -> bool:
        return str(self.ask("get", address=address)["value"]) in ("1", "True")

    def programs(self) -> bool:
        return bool(self.ask("process", do="list")["programs"])

    def running(self) -> bool:
        return bool(self.ask("process", do="list")["processes"])

    def on(self) -> bool:
        return all(axis.flags & 1 for axis in self.run.state().axes)


def test_a_cell_that_its_pic_runs_alone(tmp_path: pathlib.Path) -> None:
    with running_cell(a_cell(tmp_path), "pic", plc=False, p5_ms=None) as run:
        buttons = Buttons(run)
        until(lambda: buttons.programs() and buttons.alive(), "the PIC enables")
        buttons.wire(1)
        buttons.wire(0)
        until(buttons.on, "drives on")
        buttons.wire(2)
        until(lambda: run.state().axes[0].set > 0.1, "the button starts the program")
        buttons.wire(1, value=False)
        until(lambda: run.state().axes[0].speed == 0.0, "an open door holds it")
        assert run.state().axes[0].set < 0.9 and run.state().motion is not Motion.IDLE
        dead, _ = run.kill("interpreter")
        until(lambda: not buttons.on(), "without a PIC nothing is enabled")
        until(lambda: run.processes()["interpreter"]["pid"] not in (None, dead) and buttons.alive(), "it is back")
        assert buttons.reads("M 40.0")
        time.sleep(1.0)
        assert not buttons.on() and not buttons.running(), "wired inputs that are still 1 switch nothing on and start nothing"
        run.forgive("interpreter")
