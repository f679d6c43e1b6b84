"""A program with real processes that talks to its host by 3964R over a paced line, and outlives a pulled plug (AX-1021)."""

import pathlib
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

import configs
from drivers.ports.open import open_bytes
from gateway.simulation.line.control import LineControl
from gateway.tools.client import Row, ToolClient
from hil_tests.lab.partners.sync_line import SyncLine
from hil_tests.lab.running.cell_running import COMES_UP_S, CellRun, running_cell
from protocols.p3964r.events import BlockReceived, Event
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, Priority

CELLS = pathlib.Path(configs.__file__).parent / "cells"
HOST = """;;KINEMATICS : (1 = PORTAL)
;;SER_IO_STOP -
PROGRAM HOST
INTEGER : ORDER, FAULTS
TEXT : NAME
OUTPUT : 1 = LAMP
BEGIN
FAULTS = 0
AGAIN:
READ V24_1, ORDER, NAME
IF CONDITION(V24_1) <> 0 THEN
  BEGIN
  FAULTS = FAULTS + 1
  WAIT 0.2
  JUMP AGAIN
  END
WRITE V24_1, ORDER + 1, NAME, FAULTS
IF ORDER < 99 THEN JUMP AGAIN
PROGRAM_END
"""
UNIT = '\n[[line]]\nname = "host"\nport = "sim"\nformat = "9600 8E1"\nlayer = "program"\n[[line.program]]\ndevice = "V24_1"\n'
LONG_S = 60.0
pytestmark = pytest.mark.timeout(COMES_UP_S + 6 * LONG_S)


class Partner:
    """The host at the other end."""

    def __init__(self, line: SyncLine[Event], link: Link) -> None:
        self.line, self.link = line, link

    def until(self, test: Callable[[], bool], what: str) -> None:
        assert self.line.run_until(test, LONG_S), (what, self.line.events[-8:])

    def blocks(self) -> list[bytes]:
        return [event.data for _, event in self.line.events if isinstance(event, BlockReceived)]

    def asks(self, order: int, name: str) -> bytes:
        """Sends an order; the answer."""
        before = len(self.blocks())
        self.link.send(order.to_bytes(4, "little") + name.encode().ljust(80, b"\0"), time.monotonic_ns())
        self.until(lambda: len(self.blocks()) > before, f"the answer to {order}")
        self.line.run_for(0.1)
        return self.blocks()[-1]


def a_cell(folder: pathlib.Path) -> str:
    shutil.copytree(CELLS / "palletiser", folder / "palletiser")
    (folder / "palletiser" / "HOST.QLL").write_text(HOST)
    (folder / "cell.toml").write_text((CELLS / "palletiser.toml").read_text() + UNIT)
    return str(folder / "cell.toml")


def asked(run: CellRun, op: str, **facts: object) -> Row:
    client = ToolClient(run.name)
    try:
        return client.ask(op, **facts)
    finally:
        client.close()


@contextmanager
def partner_of(run: CellRun) -> Iterator[Partner]:
    link = Link(PROFILES["rho3"], Priority.HIGH)
    port = "pty:" + LineControl.path(f"{run.name}-host", "a")
    with SyncLine[Event](lambda: open_bytes(port, "9600 8E1"), link) as line:
        yield Partner(line, link)


def test_a_host_orders_by_3964r_and_the_plug_is_pulled_between(tmp_path: pathlib.Path) -> None:
    with running_cell(a_cell(tmp_path), "units", plc=False, p5_ms=None) as run, partner_of(run) as host:
        host.until(lambda: bool(asked(run, "process", do="list")["programs"]), "programs are read")
        assert "error" not in asked(run, "process", do="start", name="HOST")
        host.until(lambda: bool(asked(run, "process", do="list")["processes"]), "it runs")
        assert host.asks(7, "PALLET") == (8).to_bytes(4, "little") + b"PALLET".ljust(80, b"\0") + bytes(4)
        cable = LineControl(f"{run.name}-host")
        cable.unplug()
        host.line.run_for(1.0)
        cable.plug()
        answer = host.asks(41, "BOX")
        assert (answer[:4], answer[4:7]) == ((42).to_bytes(4, "little"), b"BOX")
        host.asks(99, "")
        host.until(lambda: not asked(run, "process", do="list")["processes"], "it has ended")
        assert any("line host: is open" in str(entry["text"]) for entry in run.journal("program"))
