"""`axisgate bus infer LOG`: from a candump recording to a DBC on disk."""

import json
import pathlib

import pytest

from gateway.commands.bus import main
from hil_tests.lab.virtual.bus_recording import record
from hil_tests.unit.gateway.pure.buses.inference.test_three_other_layouts import NARROW
from protocols.base.dbc import compile_dbc


@pytest.fixture
def recording(tmp_path: pathlib.Path) -> pathlib.Path:
    path = tmp_path / "living.log"
    lines = [
        f"({frame.stamp_ns // 10**9}.{frame.stamp_ns % 10**9 // 1000:06d}) can0 {frame.identifier:03X}#{frame.data.hex().upper()}"
        for frame in record(NARROW, axes=2).frames
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_the_log_of_our_own_broker_is_read_too(recording: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It has remarks, and sender, sequence and nanoseconds behind each frame (AX-095)."""
    text = "".join(f"{line} 3 4711 234\n" for line in recording.read_text().splitlines())
    recording.write_text("# axisgate broker:drives; stamps: CLOCK_MONOTONIC\n# (1.000000) client 1 connected, pid 7\n" + text)
    assert main(["infer", str(recording), "--json"]) == 0
    assert [axis["actual_id"] for axis in json.loads(capsys.readouterr().out)["axes"]] == [610, 620]


def test_a_candump_recording_becomes_a_dbc(recording: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    proposal = recording.with_suffix(".dbc")
    assert main(["infer", str(recording), "-o", str(proposal)]) == 0
    said = capsys.readouterr().out
    assert said.startswith("2 axes, cycle 4 ms, low byte first, SYNC 100\nSET_1 (identifier 210)\n")
    assert "position_inc       bits 12..35" in said and "to be confirmed on the living control" in said
    place = {signal.name: (signal.start, signal.bits) for signal in compile_dbc(proposal.read_text())["ACT_1"].signals}
    assert place["position_inc"] == (4, 24)


def test_for_a_program(recording: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["infer", str(recording), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["byte_order"] == "little" and [axis["actual_id"] for axis in found["axes"]] == [610, 620]


def test_exit_codes(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    empty = tmp_path / "empty.log"
    empty.write_text("(1.000000) can0 064#\n")
    assert main(["infer", str(empty)]) == 1 and "all of them without data" in capsys.readouterr().err
    assert main(["infer", str(tmp_path / "none.log")]) == 2
    assert main(["infer", str(tmp_path / "none.xyz")]) == 2
