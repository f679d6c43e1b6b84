"""The integrated PLC of a Reis in a running cell: robotstar 5.2, 5.4, 5.5, L2263, L2314-2396, L2749-2791; AX-900."""

import contextlib
import functools
import json
import pathlib
import shutil
import time
from collections.abc import Callable, Iterator

import pytest
from pymodbus.client import ModbusTcpClient

from gateway.commands.plc import main as plc_command
from gateway.files.find import find_config
from gateway.pure.image.records.cell import AxisFlag
from gateway.tools.client import ToolClient, ToolError
from hil_tests.lab.running.cell_running import CellRun, running_cell
from hil_tests.lab.running.joined_running import cell_copy

FIRST = 704  # RC input and output of E0.0 and A0.0
PERMITS = (24, 25, 26, 28)
PATIENCE_S = 20.0
MANY = 400  # programs to read before the first scan: time for a look at the outputs
PROCESS = "gateway.processes.plc:PlcProcess."
HEAVY = """I 7, 3, "Light barrier at the stop is broken"
I 9, 7, "Guard was opened"
END
"""


def until(look: Callable[[], bool], what: str) -> None:
    """Waits for it."""
    end = time.monotonic() + PATIENCE_S
    while not look():
        assert time.monotonic() < end, f"not within {PATIENCE_S:.0f} s: {what}"
        time.sleep(0.01)


class Plant:
    """The cell PLC over Modbus, the commissioning tool and the journal of one run."""

    def __init__(self, run: CellRun, client: ModbusTcpClient, tool: ToolClient, file: pathlib.Path) -> None:
        self.run, self.client, self.tool, self.file = run, client, tool, file

    def inputs(self, *set_bits: int) -> None:
        """E0.0 to E0.7; the bits that are set."""
        assert not self.client.write_coils(FIRST, [bit in set_bits for bit in range(8)]).isError()

    def outputs(self) -> list[int]:
        """Bits of A0 that are set."""
        bits = self.client.read_discrete_inputs(FIRST, count=8).bits
        return [bit for bit in range(8) if bits[bit]]

    def marker(self, byte: int) -> object:
        """M `byte`."""
        return self.tool.ask("get", address=f"MB {byte}")["value"]

    def plc(self, *words: str) -> int:
        """`axisgate plc WORD`."""
        return plc_command([words[0], str(self.file), *words[1:], "--name", self.run.name])

    def state(self) -> object:
        """RUN, STOP or GONE."""
        return self.tool.ask("plc", do="status")["state"]


@pytest.fixture(scope="module")
def plant(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Plant]:
    folder = tmp_path_factory.mktemp("reis")
    file = cell_copy("reis-plc", folder)
    shutil.copytree(pathlib.Path(find_config("reis-plc", "cells")).parent / "reis-plc", folder / "reis-plc")
    file.write_text(file.read_text().replace("owner  = { ", 'owner  = { "2" = "plc", '))  # RC input 23 is AUTO
    programs = folder / "reis-plc" / "PLC"
    (programs / "PLCMSG_CNF.PLC").write_text(HEAVY)
    (programs / "BAD.PLC").write_text("U E0.0\nV E1.1\nEND\n")
    (programs / "OFF.PLC").write_text("U E0.5\nSP GOOD,0\nL 80000009H\nTD M948\nM GOOD\nEND\n")
    (programs / "TOGGLE.PLC").write_text("L M10\nZV ACCU,1\nT M10\nU E0.0\n= A0.7\nEND\n")
    (programs / "LONG.PLC").write_text("U E0.0\nM AGAIN\nSP AGAIN\nEND\n")
    with (
        running_cell(str(file), "reisplc", plc=False, p5_ms=None) as run,
        ModbusTcpClient("127.0.0.1", port=run.port) as client,
        contextlib.closing(ToolClient(run.name)) as tool,
    ):
        made = Plant(run, client, tool, file)
        until(lambda: made.state() == "RUN", "the start program runs")
        yield made


@pytest.fixture(autouse=True)
def runs(plant: Plant) -> None:
    """Each test begins with MAIN running and no input set."""
    plant.inputs()
    assert plant.plc("ack") == 0 and plant.plc("start") == 0
    until(lambda: plant.state() == "RUN" and plant.outputs() == [], "MAIN runs, all outputs 0")


def test_inputs_of_the_image_are_linked_to_outputs_and_parts_are_counted(plant: Plant) -> None:
    before = plant.marker(100)
    plant.inputs(0)
    assert plant.outputs() == [], "the guard is open"
    plant.inputs(0, 1, 2, 3)
    until(lambda: 0 in plant.outputs(), "conveyor")
    assert 2 not in plant.outputs(), "the part waits 2 s"
    until(lambda: 2 in plant.outputs(), "let it go on")
    assert plant.marker(100) == int(str(before)) + 1
    timer = plant.tool.ask("get", address="M1021.2")
    assert timer["value"] == 1, "markers of the system are filled in: initialised"


def test_a_command_source_writes_markers_between_two_scans_and_no_outputs(plant: Plant) -> None:
    assert plant.tool.ask("set", address="MB 100", value="41")["value"] == 41
    plant.inputs(3)
    until(lambda: plant.marker(100) == 42, "counted on from what was written")
    with pytest.raises(ToolError, match="the system writes it"):
        plant.tool.ask("set", address="M2008.0", value="1")
    assert plant.outputs() == []


@pytest.mark.requirement("RSV-PLC-39", by=PROCESS + "_show")
def test_the_test_display_shows_each_step_of_a_program_that_runs(plant: Plant, capsys: pytest.CaptureFixture[str]) -> None:
    plant.inputs(0)
    until(lambda: plant.marker(1968) == 1, "the input is read")
    capsys.readouterr()
    assert plant.plc("show", "MAIN", "--json") == 0
    rows = {row[0]: row[1:] for row in json.loads(capsys.readouterr().out)["rows"]}
    assert rows[2][:2] == [True, True] and rows[3][:2] == [False, False], "U E0.0, U E0.1"
    assert rows[7][2] == 200 and 16 not in rows, "L 200 is in ACCU1; behind the jump nothing was executed"
    assert plant.tool.ask("get", address="M1021.6")["value"] == 1
    source = plant.file.parent / "reis-plc" / "PLC" / "MAIN.PLC"
    text = source.read_text()
    try:
        source.write_text(text.replace("U E0.0", "U E0.7"))
        assert plant.plc("show", "MAIN") == 1
        assert "differs from the program that runs" in capsys.readouterr().out
    finally:
        source.write_text(text)
    until(lambda: plant.tool.ask("get", address="M1021.6")["value"] == 0, "nobody looks: the display is off")


def test_a_marker_is_written_by_hand_and_one_of_the_robot_is_not(plant: Plant, capsys: pytest.CaptureFixture[str]) -> None:
    assert plant.plc("set", "M300.4", "1") == 0 and plant.plc("set", "MD304", "12H") == 0
    until(lambda: plant.marker(300) == 16 and plant.marker(304) == 18, "both are there")
    assert plant.plc("set", "M1021.2", "0") != 0
    assert "the robot writes it" in capsys.readouterr().err


def test_killed_it_comes_back_with_the_copy_that_ran_its_markers_and_outputs_0_meanwhile(plant: Plant) -> None:
    plant.tool.ask("set", address="MB 100", value="7")
    plant.inputs(0, 1)
    until(lambda: plant.outputs() == [0], "conveyor")
    source = plant.file.parent / "reis-plc" / "PLC" / "MAIN.PLC"
    text, more = source.read_text(), source.parent / "MORE"
    more.mkdir()
    for number in range(MANY):
        (more / f"N{number}.PLC").write_text("END\n")
    try:
        source.write_text("NOTHING THAT STARTS\n")
        dead, _ = plant.run.kill("plc")
        seen = time.monotonic() + PATIENCE_S
        while plant.outputs():  # without a rest: they come back with the first scan
            assert time.monotonic() < seen, "outputs 0 until its first scan"
        plant.run.back("plc", dead)
        plant.inputs(0, 1)  # a command source that was silent meanwhile has lost its inputs
        until(lambda: plant.outputs() == [0], "the copy runs on")
        assert plant.marker(100) == 7
    finally:
        source.write_text(text)
        shutil.rmtree(more)
    assert any("continues with the program that ran" in entry["text"] for entry in plant.run.journal("plc"))


@pytest.mark.requirement("RSV-PLC-29", by=PROCESS + "_start")
def test_a_refused_start_leaves_the_program_that_runs(plant: Plant, capsys: pytest.CaptureFixture[str]) -> None:
    plant.inputs(0, 1)
    until(lambda: plant.outputs() == [0], "conveyor")
    plant.plc("start", "BAD")
    until(lambda: any("BAD step 2" in entry["text"] for entry in plant.run.journal("plc")), "program and step of the fault")
    assert plant.state() == "RUN" and plant.outputs() == [0]


@pytest.mark.requirement("RSV-PLC-30", by=PROCESS + "_read_sources")
def test_an_edited_source_counts_from_the_next_start_on(plant: Plant) -> None:
    plant.plc("start", "TOGGLE")
    plant.inputs(0)
    until(lambda: plant.outputs() == [7], "the program of before the edit runs")
    source = plant.file.parent / "reis-plc" / "PLC" / "TOGGLE.PLC"
    source.write_text("U E0.0\n= A0.6\nUN E0.0\n= A0.7\nEND\n")
    scans = plant.tool.ask("plc", do="status")["scans"]
    until(lambda: plant.tool.ask("plc", do="status")["scans"] != scans, "scans since the edit")
    assert plant.outputs() == [7]
    plant.plc("start", "TOGGLE")
    until(lambda: plant.outputs() == [6], "the edited program runs")
    assert plant.plc("stop") == 0
    until(lambda: plant.outputs() == [], "stopped")


@pytest.mark.requirement("RSV-PLC-01", by=PROCESS + "turn")
def test_it_runs_in_hand_and_in_auto(plant: Plant) -> None:
    (plant.file.parent / "reis-plc" / "PLC" / "TOGGLE.PLC").write_text("L M10\nZV ACCU,1\nT M10\nEND\n")
    plant.plc("start", "TOGGLE")
    for auto, mode in ((False, 0x01), (True, 0x03)):
        assert not plant.client.write_coil(23, auto).isError()
        until(functools.partial(lambda mode: plant.marker(1022) == mode, mode), f"main mode {mode:02X}")
        before = plant.marker(10)
        until(functools.partial(lambda before: plant.marker(10) != before, before), "M10 keeps changing")


@pytest.mark.requirement("RSV-PLC-05", by=PROCESS + "_more")
def test_a_scan_without_an_end_stops_the_plc_with_7000_and_outputs_0(plant: Plant) -> None:
    plant.inputs(0, 1)
    until(lambda: plant.outputs() == [0], "conveyor")
    pid = plant.run.processes()["plc"]["pid"]
    plant.plc("start", "LONG")
    until(lambda: plant.state() == "STOP" and plant.outputs() == [], "stopped")
    message = plant.tool.ask("plc", do="status")["message"]
    assert isinstance(message, dict) and (message["number"], message["reaction"]) == (7000, 7)
    assert plant.run.processes()["plc"]["pid"] == pid, "the watchdog of the PLC ended the scan, not the supervisor's"


@pytest.mark.requirement("RSV-PLC-33", by="gateway.pure.controllers.reis.control:ReisControl._react")
def test_a_message_of_class_7_switches_the_drives_off(plant: Plant) -> None:
    tool = plant.tool
    tool.take_over()
    tool.command("enable", 3)
    until(lambda: all(axis.flags & AxisFlag.ENABLED for axis in plant.run.state().axes[:2]), "drives on")
    tool.ask("plc", do="start", name="OFF")
    plant.inputs(5)
    until(lambda: not any(axis.flags & AxisFlag.ENABLED for axis in plant.run.state().axes[:2]), "drives off")
    assert any("Guard was opened" in entry["text"] for entry in plant.run.journal("plc"))
    tool.command("release_control")


def test_markers_outlive_the_run(plant: Plant) -> None:
    plant.tool.ask("set", address="MB 200", value="77")
    kept = pathlib.Path(plant.run.status()["folder"], "plc.kept")
    until(lambda: kept.exists() and kept.read_bytes()[200] == 77, "kept on the disk")
