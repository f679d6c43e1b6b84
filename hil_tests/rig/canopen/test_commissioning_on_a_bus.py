"""Commissioning commands against emulated and foreign drives without a cycle: scan, commission, the guide, and what is refused."""

import datetime
import pathlib
import subprocess
import sys

import pytest

from gateway.__main__ import main as axisgate
from gateway.cell_file import stop_test_date as stopdate
from gateway.cell_file.load import load_cell
from gateway.commands import drive as drive_command
from gateway.files.find import find_config
from gateway.tools.client import ToolError
from gateway.tools.drives import loss_test as losstest
from gateway.tools.drives import loss_test_on_bus as losstest_bus
from hil_tests.lab.cells.on_a_machine import on_a_machine
from hil_tests.lab.partners.durand_drive import DurandDrive
from hil_tests.lab.running.bus_running import running_bus


def find_page(name: str) -> str:
    """A page of the guide, as it is shipped in the repository."""
    return (pathlib.Path(__file__).parents[3] / "docs" / "guide" / name).read_text()


def test_a_date_is_written_where_it_is_and_a_shipped_file_is_nobodys_to_write(tmp_path: pathlib.Path) -> None:
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


def test_a_servodyn_cell_has_no_heartbeat_to_lose() -> None:
    assert losstest.losses_of(load_cell("demo")) == ["sync", "gateway"]
    assert drive_command.main(["loss-test", "demo", "--lose", "heartbeat"]) == 2
    with pytest.raises(ToolError, match=r"axes A1, .*: a SERVODYN drive is silent without SYNC"):
        losstest_bus.drives_of(load_cell("demo"))
    assert drive_command.main(["loss-test", "demo-402", "--running", "--lose", "sync"]) == 2


def test_the_guide_works_word_for_word_without_metal(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The commands of the page in their order; those that run until they are ended, beside the others."""
    page = find_page("commissioning-drives.md")
    commands = [line.split() for line in page.splitlines() if line.startswith("    ")]
    assert len(commands) == 7
    monkeypatch.setenv("AXISGATE_RUNTIME", str(tmp_path / "run"))
    running: list[subprocess.Popen[str]] = []
    told: list[str] = []
    try:
        for words in commands:
            if words[0] == "python" or words[1] == "emulate":
                command = [sys.executable, *(words[1:] if words[0] == "python" else ["-m", "gateway", *words[1:]])]
                running.append(subprocess.Popen(command, stdout=subprocess.PIPE, text=True))
                output = running[-1].stdout
                assert output is not None and "ready\n" in iter(output.readline, "")
            else:
                code = axisgate(words[1:])
                told.append("".join(capsys.readouterr()))
                assert code == 0, (words, told[-1])
    finally:
        for process in reversed(running):
            process.terminate()
            process.communicate(timeout=10)
    assert len(running) == 2
    assert "6 nodes answer on broker:lab" in told[0] and "pin it in the cell" in told[2] and "PP moved it by" in told[3]
    assert "pin it in the cell" in told[4]


def test_the_cells_own_port_named_by_hand_is_still_the_machine(capsys: pytest.CaptureFixture[str]) -> None:
    """The confirmation counts on every port with metal behind it."""
    cell = load_cell("demo-402")
    for url in ("socketcan:can0", "slcan:/dev/ttyACM0@500000"):
        assert not drive_command._may_move(cell, url)
        assert "not confirmed for A1, A2" in capsys.readouterr().err
    assert drive_command._may_move(cell, "broker:lab")
