"""The scope on a running cell: nothing lost, the trigger at its place, values as the emulator's own record has them; files reopened."""

import contextlib
import io
import json
import pathlib
import threading
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from asammdf import MDF

from gateway.cell_file.load import load_cell
from gateway.commands.scope import main
from gateway.scope.live import attached, capture, named_channels, named_trigger, recording_of
from gateway.scope.recording import Recording, load, save
from hil_tests.lab.partners.plc2 import PTP
from hil_tests.lab.running.cell_running import ALL, TARGET, CellRun, running_cell

NAMES = [f"axis.A{n}.{value}" for n in range(1, 6) for value in ("set", "actual", "lag")] + ["cell.job"]  # 16 channels
SPEED = 0.2


@pytest.fixture(scope="module")
def run() -> Iterator[CellRun]:
    with running_cell("demo", "scope") as made:
        made.ready()
        yield made


@pytest.fixture(scope="module")
def recording(run: CellRun) -> Recording:
    """16 channels over one move, with 0.2 s before it."""
    cell = load_cell("demo")
    channels = named_channels(NAMES, cell)
    period = run.status()["p5_ms"] / 1000
    with attached("scope") as ring:
        mover = threading.Timer(0.5, lambda: run.plc.send(PTP, ALL, SPEED, TARGET))
        mover.start()
        kept = capture(ring, channels, seconds=3.0, pre_s=0.2, period_s=period, trigger=named_trigger("cell.job changes", cell))
        mover.join()
    run.plc.wait(lambda status: status.in_position == ALL, 20)
    return recording_of(kept, channels, cell, period, "cell.job changes")


def test_sixteen_channels_at_the_rate_of_the_cycle_and_no_record_lost(recording: Recording) -> None:
    assert recording.values.shape[1] == 16 and recording.lost == 0
    steps = np.diff(recording.time) / recording.period_s
    assert np.abs(steps - np.round(steps)).max() < 0.5, "stamps are those of SYNC"
    assert np.median(steps) == pytest.approx(1.0, abs=0.02)


def test_the_trigger_is_time_zero_with_what_was_before_it(recording: Recording) -> None:
    assert recording.time[0] == pytest.approx(-0.2, abs=0.05)
    jobs, before = recording.column("cell.job"), recording.time < 0
    assert len(set(jobs[before])) == 1 and jobs[~before][0] != jobs[before][0]
    assert np.ptp(recording.column("axis.A1.set")[before]) == 0.0 < np.ptp(recording.column("axis.A1.set"))


def test_the_lag_is_what_stands_between_set_and_actual_position_at_steady_speed(recording: Recording) -> None:
    moved = recording.column("axis.A1.set")
    speed = np.gradient(moved, recording.time)
    steady = np.abs(speed) > 0.95 * np.abs(speed).max()
    lag = np.abs(recording.column("axis.A1.lag")[steady])
    expected = np.abs(speed[steady]) / 80.0  # speed / Kv of the plant
    assert np.median(lag) == pytest.approx(np.median(expected), rel=0.1)


@dataclass
class Done:
    returncode: int
    stdout: str
    stderr: str


def axisgate(*arguments: object) -> Done:
    """The command in this process: starting Python and its libraries a dozen times would take most of the time here."""
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        code = main([str(argument) for argument in arguments])
    return Done(code, out.getvalue(), err.getvalue())


def test_a_recording_is_reopened_drawn_and_exported(recording: Recording, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "move.scope"
    save(recording, file)
    again = load(file)
    assert (again.names, again.units, again.trigger) == (list(recording.names), list(recording.units), recording.trigger)
    assert np.array_equal(again.values, recording.values) and np.array_equal(again.time, recording.time)
    for suffix, start in ((".png", b"\x89PNG"), (".html", b"<!doctype html>")):
        done = axisgate("plot", file, "-o", tmp_path / f"move{suffix}", "--cursor", 0.5, "--cursor", 1.0, "--json")
        assert done.returncode == 0, done.stderr
        assert (tmp_path / f"move{suffix}").read_bytes().startswith(start)
        assert [round(row["t"], 1) for row in json.loads(done.stdout)["cursors"]] == [0.5, 1.0]
    assert axisgate("export", file, "-o", tmp_path / "move.mf4").returncode == 0
    with MDF(tmp_path / "move.mf4") as exported:
        signal = exported.get("axis.A1.actual")
    assert signal.unit == "mm" and np.allclose(signal.samples, recording.column("axis.A1.actual"))
    assert axisgate("export", file, "-o", tmp_path / "move.csv").returncode == 0
    rows = (tmp_path / "move.csv").read_text(encoding="utf-8-sig").splitlines()
    assert rows[0].startswith("t [s];axis.A1.set [mm];") and len(rows) == len(recording.time) + 1


def test_the_command_records_a_run_and_names_what_it_cannot(run: CellRun, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "a.scope"
    done = axisgate("record", "demo", "--name", "scope", "--channels", "axis.A1.actual,CTRL_ALLOW_RCI", "--for", 0.5, "-o", file, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["lost"] == 0 and load(file).column("CTRL_ALLOW_RCI").min() == 1.0
    for more, code, words in (
        (("--channels", "axis.Q.lag"), 2, "no axis Q; A1, A2"),
        (("--channels", "axis.A1.lag", "--trigger", "A1 jumps"), 2, "NAME > LEVEL"),
        (("--channels", "axis.A1.lag", "--name", "nobody"), 3, "no run 'nobody' answers"),
    ):
        refused = axisgate("record", "demo", "--name", "scope", "-o", tmp_path / "b.scope", *more)
        assert (refused.returncode, words in refused.stderr) == (code, True), refused.stderr
    assert not (tmp_path / "b.scope").exists()


def test_a_file_that_is_none_is_named(tmp_path: pathlib.Path) -> None:
    (tmp_path / "x.scope").write_text("hello")
    done = axisgate("plot", tmp_path / "x.scope", "-o", tmp_path / "x.html")
    assert done.returncode == 2 and "no scope recording" in done.stderr
