"""A PLC that knows only the old controller's signals works a running cell over both command sources: rho 3 Releases part 2 to 8 (rho3 3.1
to 3.3)."""

import contextlib
import functools
import json
import pathlib
import socket
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest

from drivers.ports.base import runtime_dir
from drivers.ports.open import open_bytes
from gateway.pure.image.records.cell import AxisFlag, Motion
from hil_tests.lab.partners.rk512_active import Done, Refused
from hil_tests.lab.partners.signal_plc import PATIENCE_S, Net, Rack, SignalPlc, signal_cell
from hil_tests.lab.partners.sync_line import SyncLine
from hil_tests.lab.running.cell_running import COMES_UP_S, STOLEN, CellRun, Disturbed, running_cell

RESET, AUTO, CHAIN, PHG_STROBE, ACK, DRIVE_ON = 19, 23, 24, 49, 62, 66
PERMITS = (24, 25, 26, 27, 28)
ABORT, SELECT, PARITY, CODE = 80, 81, 83, 88
DRIVES, EMERGENCY, ABORTED, ABORT_ERROR, SELECTED, SELECT_ERROR = 66, 67, 116, 117, 120, 121
EMERGENCY_STOP, PHG_ERROR, IN_MANUAL = 528, 1278, 250
EXPROG = "02 = PICK ; to the fixture\r\n04 = FAR\r\n05 = NOWHERE\r\n0G = BAD\r\n\x1a"
PROGRAMS = """
kind = "rho3"
files = "dat"
remote = true
[[controller.process]]
name = "PICK"
steps = [ { to = { A1 = 40.0 } }, { output = 7 } ]
[[controller.process]]
name = "FAR"
steps = [ { to = { A1 = 1900.0 }, speed = "5 %" } ]
"""
COUPLED = "P14 = [5]\nP20 = 15\nP21 = [10, 54, 20, 64]"


@dataclass
class Plant:
    """The cell and its PLC."""

    run: CellRun
    plc: SignalPlc

    def actual(self) -> float:
        """Of A1, mm."""
        return self.run.state().axes[0].actual * 1000.0

    def drives(self) -> list[bool]:
        return [bool(axis.flags & AxisFlag.ENABLED) for axis in self.run.state().axes[:2]]

    def ready(self) -> None:
        """Permits, automatic, no errors, drives on by a fresh edge."""
        self.plc.put(*PERMITS, AUTO, off=(DRIVE_ON, RESET, SELECT, ABORT, ACK, PHG_STROBE))
        self.plc.until(lambda plc: not plc.output(DRIVES), "drives off")
        self.plc.put(RESET)
        self.plc.until(lambda plc: not plc.output(EMERGENCY), "no EMERGENCY STOP")
        self.plc.put(DRIVE_ON, off=(RESET,))
        self.plc.until(lambda plc: plc.output(DRIVES), "drives on")

    def select(self, code: int, strobe: int = SELECT, parity: bool | None = None) -> None:
        """Code and parity first, then the strobe."""
        odd = bool(code.bit_count() & 1) if parity is None else parity
        self.plc.put(*((PARITY,) if odd else ()), off=(SELECT, ABORT, *(() if odd else (PARITY,))), number=(CODE, code))
        self.plc.put(strobe)


@contextlib.contextmanager
def plant_over(source: str, folder: pathlib.Path) -> Iterator[Plant]:
    (folder / "dat").mkdir()
    (folder / "dat" / "exprog.dat").write_bytes(EXPROG.encode("cp437"))
    (folder / "dat" / "PHGCODE.DAT").write_text("4 = 7.1\n")
    with running_cell(signal_cell(folder, source, PROGRAMS, rho3=COUPLED), f"old-{source}", plc=False, p5_ms=None) as run:
        if source == "net":
            yield Plant(run, SignalPlc(Net(run.port)))
            return
        with SyncLine(lambda: open_bytes(Rack.port_of(run.name), "38400 8E1"), station := Rack.station()) as line:
            yield Plant(run, SignalPlc(Rack(line, station)))


PLAYS = 4  # of one test, where a busy machine let drives or cycle give up
pytestmark = pytest.mark.timeout(COMES_UP_S + PLAYS * (PATIENCE_S + 20.0))  # a play that is spoilt waits once in vain


def replayed(test: Callable[[Plant], None]) -> Callable[[Plant], None]:
    """Again where a drive was lost, the clock was late or a process was taken for hung: that repetition proves nothing."""

    @functools.wraps(test)
    def played(plant: Plant) -> None:
        for left in reversed(range(PLAYS)):
            before = lapses(plant.run)
            try:
                test(plant)
                return
            except (AssertionError, OSError, ValueError) as failed:
                disturbed = plant.run.state().stop_cause in STOLEN or lapses(plant.run) > before
                if not left or not disturbed:
                    raise
                print(f"played again: {Disturbed(str(failed))}")

    return played


def lapses(run: CellRun) -> int:
    """How often a process was ended because it showed no life."""
    return sum("showed no life" in entry["text"] for entry in run.journal("process"))


BOTH = pytest.mark.parametrize("plant", ["rack", pytest.param("net", marks=pytest.mark.mbpoll)], indirect=True)
RACK = pytest.mark.parametrize("plant", ["rack"], indirect=True)


@pytest.fixture(scope="module")
def plant(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Plant]:
    with plant_over(request.param, tmp_path_factory.mktemp("old")) as plant:
        yield plant


@RACK
@replayed
def test_drive_on_by_its_edge_for_all_and_for_single_axes(plant: Plant) -> None:
    plc = plant.plc
    plant.ready()
    assert plant.drives() == [True, True]
    plc.put(off=(DRIVE_ON,))
    plc.until(lambda plc: not plc.output(DRIVES) and plant.drives() == [False, False], "drives off")
    plc.put(193)
    plc.until(lambda plc: plant.drives() == [False, True], "A2 on alone")
    plc.put(off=(193,))
    plc.until(lambda plc: plant.drives() == [False, False], "A2 off")
    assert [plc.output(bit) for bit in (124, 125, 126, 127)] == [True, False, True, False], "P2 = 5"
    assert plc.output(107) and plc.output(96)


@BOTH
@replayed
def test_errors_are_shown_as_codes_and_acknowledged_by_their_own_signals(plant: Plant) -> None:
    plc = plant.plc
    plant.ready()
    plc.put(PHG_STROBE, number=(56, plc.image[7 - 2] & 0xF0 | 0x0B))
    plc.until(lambda plc: plc.code() == PHG_ERROR, "code 1278: PHGCODE.DAT has no line B")
    plc.put(off=(CHAIN,))
    plc.until(lambda plc: plc.output(EMERGENCY) and not plc.output(DRIVES), "EMERGENCY STOP")
    plc.until(lambda plc: plc.code() == PHG_ERROR, "all codes once more: 1278")
    plc.until(lambda plc: plc.code() == EMERGENCY_STOP, "and 528")
    plc.put(CHAIN, ACK)
    plc.until(lambda plc: not plc.output(118), "the strobe falls")
    assert plc.output(EMERGENCY), "62 acknowledges no EMERGENCY STOP"
    shown = [each["code"] for each in links(plant)["controller"]["errors"]]
    assert shown == [EMERGENCY_STOP], "1278 is acknowledged"
    plc.put(RESET, off=(ACK, PHG_STROBE))
    plc.until(lambda plc: not plc.output(EMERGENCY), "Control reset")
    time.sleep(0.3)
    assert not plc.look().output(DRIVES), "drive-on still stands: only a fresh edge switches on"
    assert links(plant)["controller"]["errors"] == []


@BOTH
@replayed
def test_a_program_is_selected_by_its_code_and_taken_off_again(plant: Plant) -> None:
    plc = plant.plc
    plant.ready()
    plant.select(2)
    plc.until(lambda plc: plc.output(SELECTED), "program selected")
    plc.until(lambda plc: abs(plant.actual() - 40.0) < 0.1, "PICK at its place")
    before = plant.actual()
    plant.select(2, parity=False)
    plc.until(lambda plc: plc.output(SELECT_ERROR), "wrong parity")
    plant.select(5)
    plc.until(lambda plc: plc.output(SELECT_ERROR), "a program nobody has")
    assert abs(plant.actual() - before) < 0.1
    plant.select(4)
    plc.until(lambda plc: plc.output(SELECTED), "FAR selected")
    plc.until(lambda plc: plant.actual() > 42.0, "FAR under way")
    plant.select(4, ABORT)
    plc.until(lambda plc: plc.output(ABORTED), "aborted")
    plc.until(lambda plc: plant.run.state().motion is Motion.IDLE, "at rest, the rest of the move is gone")
    assert plant.actual() < 1000.0
    plc.put(off=(AUTO, ABORT))
    plc.until(lambda plc: not plc.output(96) and plc.output(68), "manual")
    at = plant.actual()
    plant.select(2)
    plc.until(lambda plc: plc.code() == IN_MANUAL, "Inadmis. in manual op.")
    assert abs(plant.actual() - at) < 0.1
    plc.put(ACK, AUTO)
    plc.until(lambda plc: not plc.output(118), "acknowledged")


@RACK
@replayed
def test_services_that_come_back_to_set_bits_start_nothing(plant: Plant) -> None:
    plc, run = plant.plc, plant.run
    plant.ready()
    plant.select(2)
    plc.until(lambda plc: abs(plant.actual() - 40.0) < 0.1, "PICK at its place")
    plc.put(off=(CHAIN,))
    plc.until(lambda plc: plc.output(EMERGENCY) and plant.drives() == [False, False], "EMERGENCY STOP")
    plc.put(CHAIN)
    plc.put(RESET)
    plc.until(lambda plc: not plc.output(EMERGENCY), "acknowledged; drive-on, reset and select strobe stand")
    dead, _ = run.kill("services")
    run.back("services", dead)
    since = time.monotonic() + 1.0
    plc.until(lambda plc: plc.output(107) and time.monotonic() > since, "services with the image of the PLC")
    assert plant.drives() == [False, False]
    assert links(plant)["controller"]["processes"] == []
    plc.put(off=(DRIVE_ON, SELECT, RESET))
    plc.put(DRIVE_ON)
    plc.until(lambda plc: plc.output(DRIVES), "the fresh edge is taken")
    run.forgive("services")


@RACK
@replayed
def test_the_plc_finds_its_own_addresses_flags_and_counters(plant: Plant) -> None:
    """P20 = 15, P21 = 10, 54, 20, 64: I10.0 is RC output 16, O20.0 RC input 8; the board stands behind (rho3 3.6)."""
    plant.ready()
    rack = plant.plc.way
    assert isinstance(rack, Rack)
    inputs = rack.area("E", 0, 64)
    assert inputs[10 + 15 - 2] >> 4 == 5, "MA_TYP at RC outputs 124..127"
    assert rack.area("A", 20 + 2 - 1, 2) == bytes(plant.plc.image[:2]), "RC input bytes 2 and 3"
    blocks = rack.fetch(0, 50, block=23)
    assert [blocks[:2], blocks[50:52]] == [b"\x00\x02", b"\x01\x02"] and blocks[2:50] == rack.area("E", 10, 48)
    frame = bytes((0, *plant.plc.image)).ljust(50, b"\0")  # from RC input byte 1 on, which nobody owns
    assert isinstance(rack.send(0, b"\x00\x02" + frame[:48], block=22), Done)
    assert isinstance(rack.send(0, b"\x01\x02" + frame[48:].ljust(48, b"\0"), block=22), Refused), "taken whole or not at all"
    assert rack.area("Z", 0, 2) == b"\x00\x05\x00\x00", "P14"
    for level in (b"\x01\x00", b"\x00\x00"):
        assert isinstance(rack.send(0, level + bytes(14), block=30), Done)
        assert rack.area("M", 0, 2) == level[:1] + b"\xfe", "counters 1..7 have nothing to count"
        time.sleep(0.1)  # the control looks every 5 ms
    plant.plc.until(lambda plc: rack.area("Z", 0, 1) == b"\x00\x04", "counter 0 counted down once by M 0.0")
    assert isinstance(rack.send(4, b"\xff\xff\xff\xfe", block=30), Done)
    assert rack.fetch(0, 4, block=31) == b"\x00\x04" + bytes((0, 1)) + b"\xff\xff\xff\xfe", "the counter, READY, a double word of flags"


@RACK
@replayed
def test_tools_read_the_same_values_and_work_the_panel(plant: Plant) -> None:
    plant.ready()
    for address, value in (("EB 8", plant.plc.look().seen[0]), ("M 0.0", 0), ("MD 40", -2), ("T 0", 0), ("K01_A_MN_RCI", 0), ("RC 1.8", 1)):
        assert asked(plant, {"op": "get", "address": address})["value"] == value, address
    assert asked(plant, {"op": "set", "address": "MB 60", "value": "91"})["value"] == 91
    assert "error" in asked(plant, {"op": "set", "address": "MB 60", "value": "256"})
    assert "error" in asked(plant, {"op": "get", "address": "Z 8"}), "P3 = 8"
    shown = asked(plant, {"op": "panel", "mode": "7.12.1"})
    assert shown["mode"] == "7.12.1"
    plant.plc.until(lambda plc: plc.output(115) and not plc.output(104), "the panel shows machine statuses")
    assert asked(plant, {"op": "panel"})["screen"] == ["Machine statuses    ", "MSD.DAT not found   ", " " * 20, " " * 20]
    asked(plant, {"op": "panel", "mode": "0", "key": "ENTER"})
    plant.plc.until(lambda plc: plc.output(104), "the basic level")
    assert "control" in str(asked(plant, {"op": "panel", "mode": "11.1"})["error"]), "the PLC has it"


def links(plant: Plant) -> dict[str, dict[str, list[dict[str, object]]]]:
    """What services tell tools."""
    found: dict[str, dict[str, list[dict[str, object]]]] = asked(plant, {"op": "status"})
    return found


def asked(plant: Plant, request: dict[str, str]) -> dict[str, Any]:
    """One question of a tool."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as link:
        link.connect(str(runtime_dir() / f"{plant.run.name}-services.sock"))
        link.sendall(json.dumps(request).encode() + b"\n")
        found: dict[str, Any] = json.loads(link.makefile().readline())
        return found
