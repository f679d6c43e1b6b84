"""Commissioning commands against emulated and foreign drives: try, loss-test, positions, scan, commission."""

import datetime
import json
import os
import pathlib
import subprocess
import sys

import pytest

from gateway.cell_file import stop_test_date as stopdate
from gateway.cell_file.load import load_cell
from gateway.commands import axis as axis_command
from gateway.commands import drive as drive_command
from gateway.commands import positions
from gateway.files.find import find_config
from gateway.tools.client import ToolError, simulated
from gateway.tools.drives import loss_test as losstest
from gateway.tools.drives import loss_test_on_bus as losstest_bus
from hil_tests.lab.cells.on_a_machine import on_a_machine
from hil_tests.lab.partners.durand_drive import DurandDrive
from hil_tests.lab.running.bus_running import running_bus


def find_page(name: str) -> str:
    """A page of the guide, as it is shipped in the repository."""
    return (pathlib.Path(__file__).parents[3] / "docs" / "guide" / name).read_text()


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


def test_a_date_is_written_where_it_stands_and_a_shipped_file_is_nobodys_to_write(tmp_path: pathlib.Path) -> None:
    shipped = find_config("s5-rk512", "cells")
    day = datetime.date(2027, 2, 3)
    with pytest.raises(stopdate.NotWritten, match=r"is shipped with axisgate; .* last_stop_test = 2027-02-03"):
        stopdate.write(shipped, day)
    own = tmp_path / "own.toml"
    text = on_a_machine(shipped.read_text())
    own.write_text(text)
    line = stopdate.write(own, day)
    changed = [(a, b) for a, b in zip(text.splitlines(), own.read_text().splitlines(), strict=True) if a != b]
    assert len(changed) == 1 and own.read_text().splitlines()[line - 1] == changed[0][1]
    assert changed[0][1].startswith("last_stop_test  = 2027-02-03") and changed[0][1].endswith("# written by `axisgate drive loss-test`")
    assert load_cell(str(own)).safety is not None
    own.write_text("format = 1\n[safety]\nguard = true\n")
    assert stopdate.write(own, day) == 3 and own.read_text() == "format = 1\n[safety]\nlast_stop_test = 2027-02-03\nguard = true\n"
    own.write_text("format = 1\n")
    with pytest.raises(stopdate.NotWritten, match=r"has no \[safety\]"):
        stopdate.write(own, day)


def test_old_positions_are_walked_and_told_as_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    cell = load_cell("s5-rk512")
    near = cell.check_position[0]
    object.__setattr__(near, "at", {"X": 60.0, "Y": 40.0, "Z": 30.0})
    with simulated("s5-rk512") as (client, _):
        client.wait_ready()
        rows = positions.walk(client, cell, go=True)
    assert [(row["axis"], row["old"], row["good"]) for row in rows] == [("X", 60.0, True), ("Y", 40.0, True), ("Z", 30.0, True)]
    rows[1] |= {"new": 41.0, "difference": 1.0, "good": False}
    assert "BEYOND" in positions.table(rows) and "3 values, 1 beyond their tolerance" in positions.table(rows)


def test_scan_finds_a_foreign_drive_and_commission_starts_it_and_pins_it(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with running_bus(tmp_path, name="scan", log=False):
        device = DurandDrive("scan", 5)
        try:
            assert drive_command.main(["scan", "broker:scan"]) == 0
            told = capsys.readouterr().out
            assert "node   5: drive, vendor 0x00001234 product 0x00000402" in told and "1 nodes answer" in told
            assert drive_command.main(["commission", "demo-402", "A5", "--port", "broker:scan"]) == 0
            told = capsys.readouterr().out
            assert 'serial = "99"' in told and "mode 8 (CSP)" in told
            assert device.node.nmt.state.name == "PRE_OPERATIONAL", "nobody watches it afterwards"
            assert drive_command.main(["commission", "demo-402", "A4", "--port", "broker:scan"]) == 1
            assert "does not answer" in capsys.readouterr().err
            assert drive_command.main(["commission", "demo-402"]) == 2
        finally:
            device.stop()


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


def test_a_servodyn_cell_has_no_heartbeat_to_lose() -> None:
    assert losstest.losses_of(load_cell("demo")) == ["sync", "gateway"]
    assert drive_command.main(["loss-test", "demo", "--lose", "heartbeat"]) == 2
    with pytest.raises(ToolError, match=r"axes A1, .*: a SERVODYN drive is silent without SYNC"):
        losstest_bus.drives_of(load_cell("demo"))
    assert drive_command.main(["loss-test", "demo-402", "--running", "--lose", "sync"]) == 2


def test_the_guide_works_word_for_word_without_metal(tmp_path: pathlib.Path) -> None:
    """The commands of the page in their order; those that run until they are ended, beside the others."""
    page = find_page("commissioning-drives.md")
    commands = [line.split() for line in page.splitlines() if line.startswith("    ")]
    assert len(commands) == 7
    environment = {**os.environ, "AXISGATE_RUNTIME": str(tmp_path / "run")}
    running: list[subprocess.Popen[str]] = []
    told: list[str] = []
    try:
        for words in commands:
            command = [sys.executable, *(words[1:] if words[0] == "python" else ["-m", "gateway", *words[1:]])]
            if "broker" in command[2] or "emulate" in command:
                running.append(subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment))
                output = running[-1].stdout
                assert output is not None and "ready\n" in iter(output.readline, "")
            else:
                done = subprocess.run(command, check=False, capture_output=True, text=True, env=environment, timeout=60)
                assert done.returncode == 0, (words, done)
                told.append(done.stdout + done.stderr)
    finally:
        for process in reversed(running):
            process.terminate()
            process.communicate(timeout=10)
    assert "6 nodes answer on broker:lab" in told[0] and "pin it in the cell" in told[2] and "PP moved it by" in told[3]
    assert "pin it in the cell" in told[4]


def test_the_cells_own_port_named_by_hand_is_still_the_machine(capsys: pytest.CaptureFixture[str]) -> None:
    """The confirmation counts on every port with metal behind it."""
    cell = load_cell("demo-402")
    for url in ("socketcan:can0", "slcan:/dev/ttyACM0@500000"):
        assert not drive_command._may_move(cell, url)
        assert "not confirmed for A1, A2" in capsys.readouterr().err
    assert drive_command._may_move(cell, "broker:lab")
