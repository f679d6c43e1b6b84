"""Commissioning commands whose moves are timed: try, loss-test and positions at running cells, a move in every mode without one."""

import json
import pathlib
import subprocess
import sys

import pytest

from gateway.cell_file.load import load_cell
from gateway.commands import axis as axis_command
from gateway.commands import drive as drive_command
from gateway.commands import positions
from gateway.tools.client import ToolError, simulated
from gateway.tools.drives import loss_test as losstest
from hil_tests.lab.running.bus_running import running_bus


def test_try_both_ways_then_stop_times_at_a_lost_heartbeat(tmp_path: pathlib.Path) -> None:
    cell = load_cell("demo-402")
    with simulated("demo-402") as (client, folder):
        client.wait_ready()
        limit = client.sdo("A2", 0x6072)
        found = axis_command._try(client, cell, cell.axis_named("A2"))
        assert found["good"], found["sentence"]
        assert "direction as asked, 819.20 increments per mm" in str(found["sentence"]) and "torque limited to 20 %" in str(
            found["sentence"]
        )
        assert client.sdo("A2", 0x6072) == limit, "the torque limit of the test is taken back"
        with pytest.raises(ToolError, match=r"axis B9: no such axis; there is A1, A2"):
            client.axis("B9")
        stops = losstest.measure(client, cell, folder, "heartbeat", 0.5)
    assert [stop.axis for stop in stops] == ["A1", "A2", "A3", "A4", "A5", "A6"]
    assert all(stop.good and stop.way > 0 and stop.reaction_ms <= 150 + 2 * 8 for stop in stops), stops
    assert all(60 < stop.reaction_ms < stop.stop_ms for stop in stops), "not before the drive's patience with us is over"
    data, page = losstest.write(cell, stops, tmp_path)
    assert json.loads(data.read_text())["good"] and len(json.loads(data.read_text())["stops"]) == 6
    assert "evidence: emulator" in page.read_text() and "not a safety device" in page.read_text()


def test_old_positions_are_walked_and_reported_as_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    cell = load_cell("s5-rk512")
    near = cell.check_position[0]
    object.__setattr__(near, "at", {"X": 60.0, "Y": 40.0, "Z": 30.0})
    with simulated("s5-rk512") as (client, _):
        client.wait_ready()
        rows = positions.walk(client, cell, go=True)
    assert [(row["axis"], row["old"], row["good"]) for row in rows] == [("X", 60.0, True), ("Y", 40.0, True), ("Z", 30.0, True)]
    rows[1] |= {"new": 41.0, "difference": 1.0, "good": False}
    assert "BEYOND" in positions.table(rows) and "3 values, 1 beyond their tolerance" in positions.table(rows)


def test_commission_moves_an_emulated_drive_in_every_mode_without_a_cycle(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with running_bus(tmp_path, name="modes", log=False):
        command = [sys.executable, "-m", "gateway", "emulate", "demo-402", "--bus", "broker:modes"]
        drives = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            assert drives.stdout is not None
            while drives.stdout.readline() != "ready\n":
                assert drives.poll() is None
            for mode in ("pp", "pv", "ip"):
                assert drive_command.main(["commission", "demo-402", "A2", "--port", "broker:modes", "--mode", mode, "--way", "5"]) == 0
                told = capsys.readouterr().err
                moved = float(told.split("moved it by ")[1].split(" mm")[0])
                assert f"{mode.upper()} moved it" in told and moved == pytest.approx(5.0, abs=0.8), told
            assert drive_command.main(["commission", "demo-402", "A2", "--port", "broker:modes", "--mode", "hm"]) == 0
            told = capsys.readouterr().err
            assert "HM found its home; it reads -0.000 mm" in told.replace(" 0.000 mm", " -0.000 mm"), told
            before = float(told.split("before it read ")[1].split(";")[0])
            assert before == pytest.approx(15.0, abs=1.5), "where the three moves had brought it"
        finally:
            drives.terminate()
            drives.communicate(timeout=10)
