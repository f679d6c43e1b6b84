"""A running cell is recorded, its recorder killed and started again; the file played on the core gives what the cycle published."""

import contextlib
import io
import json
import pathlib
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import pytest

from gateway.commands.replay import main as replay
from gateway.files.find import find_config
from gateway.pure.recording.blocks import MAGIC, Kind, encode
from gateway.recording.file import FORMAT, Found, read
from hil_tests.lab.partners.plc2 import PTP
from hil_tests.lab.running.cell_running import ALL, HOME, TARGET, CellRun, running_cell

PATIENCE_S = 90.0


@dataclass
class Recorded:
    """A file and what its two recorders said."""

    file: pathlib.Path
    second: dict[str, object]
    refused: "subprocess.CompletedProcess[str]"


def until(true: Callable[[], object]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not true():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.05)


def command(file: pathlib.Path) -> list[str]:
    return [sys.executable, "-m", "gateway", "record", "--slug", "recorded", "-o", str(file), "--json"]


def recorder(file: pathlib.Path) -> "subprocess.Popen[str]":
    return subprocess.Popen(command(file), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def cycles(file: pathlib.Path) -> int:
    return read(file).cycles if file.exists() and file.stat().st_size > 8 else 0


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    file = tmp_path_factory.mktemp("recorded") / "run.axrec"
    with running_cell("demo", "recorded") as run:
        run.ready()
        first = recorder(file)
        until(lambda: cycles(file))
        _move(run, TARGET)
        until(lambda: cycles(file) > 100)
        first.kill()
        first.communicate()
        before = cycles(file)
        second = recorder(file)
        _move(run, HOME)
        until(lambda: cycles(file) > before + 100)
        third = subprocess.run(command(file.with_name("other.axrec")), check=False, capture_output=True, text=True, timeout=PATIENCE_S)
        second.send_signal(signal.SIGTERM)
        said, wrong = second.communicate(timeout=PATIENCE_S)
        assert second.returncode == 0, wrong
    return Recorded(file, json.loads(said), third)


def _move(run: CellRun, target: tuple[float, ...]) -> None:
    """Whatever becomes of it on a busy machine: all of it is recorded."""
    run.plc.send(PTP, ALL, 0.5, target)
    time.sleep(0.5)


def replayed(*arguments: object) -> tuple[int, str]:
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        code = replay([str(argument) for argument in arguments])
    return code, out.getvalue() + err.getvalue()


def test_the_file_of_two_recorders_has_no_gap_and_plays_without_a_difference(recorded: Recorded) -> None:
    assert recorded.second["resumed"] is True and recorded.second["lost"] == []
    code, words = replayed(recorded.file, "--diff", "--json")
    verdict = json.loads(words)
    assert (code, verdict["equal"], verdict["first"]) == (0, True, None), words
    assert verdict["segments"] == 1 and verdict["lost"] == [] and verdict["ended"] and verdict["without_outputs"] == 0
    assert verdict["played"] == verdict["cycles"] > 200


def test_what_moved_is_in_the_recording(recorded: Recorded) -> None:
    """Equal alone would also hold for a cell that slept."""
    from gateway.pure.image.records.cell import RC_BYTES, unpack_cell_state
    from gateway.pure.recording.messages import What, unpack_service_event

    (segment,) = read(recorded.file).segments
    messages = [message for _, script in segment.played() for message in script]
    places = [unpack_cell_state(payload[:-RC_BYTES]).axes[0].set for what, payload in messages if what is What.OUTPUTS]
    assert max(places) - min(places) > 0.03, "A1 moved by 60 mm"
    sources = {unpack_service_event(payload).source.name for what, payload in messages if what is What.SERVICE_EVENT}
    assert "COMMAND" in sources and "WRITTEN" in sources
    assert any(what is What.ORDER for what, _ in messages)


def test_a_second_recorder_of_the_same_run_is_refused(recorded: Recorded) -> None:
    assert recorded.refused.returncode == 3 and "has a living writer" in recorded.refused.stderr


def test_a_changed_cell_shows_its_first_difference(recorded: Recorded, tmp_path: pathlib.Path) -> None:
    text = pathlib.Path(find_config("demo", "cells")).read_text()
    changed = tmp_path / "changed.toml"
    changed.write_text(text.replace("following_error = { warn = 12.5, trip = 16.0 }", "following_error = { warn = 0.05, trip = 30.0 }"))
    code, words = replayed(recorded.file, "--diff", "--cell", changed, "--json")
    first = json.loads(words)["first"]
    assert code == 1 and first["name"] in ("axis.A1.flags", "axis.A2.flags"), words
    assert "WARNING" in first["got"] and "WARNING" not in first["expected"]
    assert first["cycle"] > read(recorded.file).segments[0].start["cycle"]
    said = first["events"]
    assert said and all(re.match(r"[+-]\d+\.\d ms command source 2 (inputs|command): ", each) for each in said), "PLC 2 is number 2"
    code, words = replayed(recorded.file, "--diff", "--cell", changed)
    assert code == 1 and f"first difference: cycle {first['cycle']}" in words and "expected" in words


def test_a_cut_file_is_played_as_far_as_it_goes_and_a_spoiled_one_names_its_place(recorded: Recorded, tmp_path: pathlib.Path) -> None:
    octets = recorded.file.read_bytes()
    cut = tmp_path / "cut.axrec"
    cut.write_bytes(octets[:-400])
    code, words = replayed(cut, "--diff", "--json")
    verdict = json.loads(words)
    assert (code, verdict["equal"], verdict["ended"]) == (0, True, False) and verdict["cut_bytes"] > 0
    found: Found = read(recorded.file)
    place = octets.rindex(b"AXB1\x04", 0, octets.rindex(b"AXB1\x04"))  # the block of cycles before the last
    spoiled = tmp_path / "spoiled.axrec"
    spoiled.write_bytes(octets[: place + 40] + bytes((octets[place + 40] ^ 1,)) + octets[place + 41 :])
    code, words = replayed(spoiled, "--diff", "--json")
    verdict = json.loads(words)
    assert code == 0 and verdict["cycles"] < found.cycles
    assert {"at_byte": place, "why": "a block of the file is spoiled"} in verdict["lost"]


def test_what_is_no_recording_is_named(tmp_path: pathlib.Path) -> None:
    (tmp_path / "x.axrec").write_text("hello")
    code, words = replayed(tmp_path / "x.axrec", "--diff")
    assert code == 2 and "no recording; axisgate record CELL" in words
    code, words = replayed(tmp_path / "nothing.axrec")
    assert code == 3 and "No such file" in words


def test_a_recording_of_another_version_names_it(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "old.axrec"
    head = {"format": FORMAT, "version": "0.0.9", "state": "cell-state/1 otherwise"}
    file.write_bytes(MAGIC + encode(Kind.HEAD, json.dumps(head).encode()))
    code, words = replayed(file)
    assert code == 2 and "recorded by axisgate 0.0.9" in words and "record it again" in words
