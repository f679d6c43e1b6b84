"""The shipped palletiser with real processes: its PLC selects the program over 3964R and RK512, the emulator's record judges (AX-860)."""

import contextlib
import functools
import pathlib
import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest

import configs
from drivers.ports.open import open_bytes
from gateway.pure.image.records.cell import Motion
from gateway.tools.client import Row, ToolClient
from hil_tests.lab.partners.signal_plc import Rack, SignalPlc
from hil_tests.lab.partners.sync_line import SyncLine
from hil_tests.lab.running.cell_running import COMES_UP_S, STOLEN, CellRun, running_cell

CELLS = pathlib.Path(configs.__file__).parent / "cells"
RESET, AUTO, FEED_HOLD, DRIVE_ON, ABORT, SELECT, PARITY, CODE = 19, 23, 27, 66, 80, 81, 83, 88
PERMITS = (24, 25, 26, 27, 28)
DRIVES, ABORTED, SELECTED = 66, 116, 120
GONE = 1276
LOOP = """;;KINEMATICS : (1 = PORTAL)
PROGRAM LOOP
BEGIN
V = 200
AGAIN:
MOVE LINEAR TO @(300, 60, 100, 0)
MOVE LINEAR TO @(100, 60, 100, 0)
JUMP AGAIN
PROGRAM_END
"""
EXPROG = "01 = PALLET\r\n02 = LOOP\r\n"
MM = 100.0 / 5 / 16384  # of X and Y per increment; Z has half of it
LAWS_S = 60.0  # laws of path take the planner seconds on a busy machine
PLAYS = 3  # of one test, where a busy machine let drives or cycle give up
PLACES = {(400, 200), (400, 350), (520, 200), (520, 350)}
pytestmark = pytest.mark.timeout(2 * COMES_UP_S + PLAYS * (3 * LAWS_S + 180))


@dataclass
class Plant:
    """The cell and its PLC."""

    run: CellRun
    plc: SignalPlc

    def ready(self) -> None:
        """Programs read; permits, automatic, drives on by a fresh edge."""
        self.wait(lambda: bool(self.programs()), "programs")
        self.plc.put(*PERMITS, AUTO, off=(DRIVE_ON, RESET, SELECT, ABORT))
        self.plc.until(lambda plc: not plc.output(DRIVES), "drives off")
        self.plc.put(RESET)
        time.sleep(0.2)
        self.plc.put(DRIVE_ON, off=(RESET,))
        self.plc.until(lambda plc: plc.output(DRIVES), "drives on")

    def select(self, code: int, strobe: int = SELECT) -> None:
        odd = bool(code.bit_count() & 1)
        self.plc.put(*((PARITY,) if odd else ()), off=(SELECT, ABORT, *(() if odd else (PARITY,))), number=(CODE, code))
        self.plc.put(strobe)

    def x(self) -> float:
        """Set value of X, mm."""
        return self.run.state().axes[0].set * 1000.0

    def _listed(self, what: str) -> list[Row]:
        client = ToolClient(self.run.name)
        try:
            found = client.ask("process", do="list")[what]
        finally:
            client.close()
        assert isinstance(found, list)
        return found

    def processes(self) -> list[Row]:
        """As tools see them."""
        return self._listed("processes")

    def programs(self) -> list[Row]:
        """Those the interpreter has read."""
        return self._listed("programs")

    def wait(self, test: Callable[[], bool], what: str, seconds: float = LAWS_S) -> None:
        """The PLC goes on with its cycle meanwhile."""
        try:
            self.plc.until(lambda _: test(), what, seconds)
        except AssertionError as error:
            told = "\n".join(f"{entry['kind']} {entry['text']}" for entry in self.run.journal()[-20:])
            raise AssertionError(f"{error}\n{self.processes()} {self.run.state().motion.name}\n{told}") from error


@contextlib.contextmanager
def plant_in(folder: pathlib.Path, name: str) -> Iterator[Plant]:
    if not (folder / "palletiser").exists():
        shutil.copytree(CELLS / "palletiser", folder / "palletiser")
        shutil.copy(CELLS / "palletiser.toml", folder)
        (folder / "palletiser" / "LOOP.QLL").write_text(LOOP)
        (folder / "palletiser" / "EXPROG.DAT").write_text(EXPROG)
    with contextlib.ExitStack() as stack:
        run = stack.enter_context(running_cell(str(folder / "palletiser.toml"), name, plc=False, p5_ms=None))
        station = Rack.station()
        line = stack.enter_context(SyncLine(lambda: open_bytes(Rack.port_of(run.name), "38400 8E1"), station))
        yield Plant(run, SignalPlc(Rack(line, station)))


@pytest.fixture(scope="module")
def plant(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Plant]:
    with plant_in(tmp_path_factory.mktemp("pallet"), "pallet") as plant:
        yield plant


def replayed(test: Callable[[Plant], None]) -> Callable[[Plant], None]:
    """Again where a drive was lost or the clock was late: that repetition proves nothing."""

    @functools.wraps(test)
    def played(plant: Plant) -> None:
        for left in reversed(range(PLAYS)):
            try:
                test(plant)
                return
            except AssertionError:
                if not left or plant.run.state().stop_cause not in STOLEN:
                    raise

    return played


@replayed
def test_the_plc_starts_the_palletiser_and_its_parts_lie_where_they_should(plant: Plant) -> None:
    plant.ready()
    plant.select(1)
    plant.plc.until(lambda plc: plc.output(SELECTED), "selected")
    plant.wait(lambda: plant.x() > 150, "on the way to a place")
    plant.plc.put(off=(FEED_HOLD,))
    time.sleep(1.0)
    held = plant.x()
    time.sleep(0.5)
    assert plant.x() == held, "feed hold holds it on its path"
    assert [row["program"] for row in plant.processes()] == ["PALLET"]
    plant.plc.put(FEED_HOLD)
    plant.wait(lambda: not plant.processes(), "the program is over", 180.0)
    rows = plant.run.record().rows
    low = [row.axes for row in rows if abs(row.axes[2].position_inc * MM / 2 - 60.0) < 0.1 and row.axes[0].position_inc * MM > 300]
    assert {(round(axes[0].position_inc * MM), round(axes[1].position_inc * MM)) for axes in low} == PLACES
    assert [round(rows[-1].axes[n].position_inc * MM) for n in (0, 1)] == [60, 60]


@replayed
def test_an_abort_of_the_plc_stops_it_on_the_path(plant: Plant) -> None:
    plant.ready()
    plant.select(2)
    plant.wait(lambda: plant.x() > 120, "LOOP moves")
    plant.select(2, ABORT)
    plant.plc.until(lambda plc: plc.output(ABORTED), "aborted")
    plant.wait(lambda: plant.run.state().motion is Motion.IDLE, "at rest")
    assert 100 < plant.x() < 300 and not plant.processes()


@replayed
def test_a_killed_interpreter_takes_its_processes_along_and_nothing_restarts(plant: Plant) -> None:
    plant.ready()
    plant.select(2)
    plant.wait(lambda: 120 < plant.x() < 250, "LOOP moves")
    dead, _ = plant.run.kill("interpreter")
    plant.wait(lambda: plant.run.processes()["interpreter"]["pid"] not in (None, dead), "a new one")
    plant.wait(lambda: plant.plc.code() == GONE, "its code at the interface")
    plant.wait(lambda: plant.run.state().motion is Motion.IDLE, "at rest where what was handed on ends")
    here = plant.x()
    assert min(abs(here - 100), abs(here - 300)) < 0.01
    time.sleep(1.0)
    assert plant.x() == here and not plant.processes(), "the strobe still stands: nothing starts by itself"
    plant.ready()
    plant.select(2)
    plant.wait(lambda: abs(plant.x() - here) > 5, "a fresh selection runs it again")
    plant.select(2, ABORT)
    plant.run.forgive("interpreter")


def test_points_outlast_a_power_off_and_no_program_starts_with_the_cell(tmp_path: pathlib.Path) -> None:
    with plant_in(tmp_path, "power") as plant:
        plant.ready()
        plant.select(1)
        points = tmp_path / "palletiser" / "PALLET.PKT"
        plant.wait(lambda: "LAST = (400, 200, 60, 90)" in points.read_text(), "the first place is kept")
        plant.run.stop()
    with plant_in(tmp_path, "power") as plant:
        plant.ready()
        time.sleep(0.5)
        assert not plant.processes() and plant.run.state().motion is Motion.IDLE
        assert "LAST = (400, 200, 60, 90)" in points.read_text()
