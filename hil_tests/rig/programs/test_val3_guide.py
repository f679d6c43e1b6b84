"""docs/guide/val3-in-a-cell.md with real processes: check, start, a part, what it switches and where the arm ends (AX-930)."""

import contextlib
import io
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Callable

import pytest

import configs
from gateway.__main__ import main
from gateway.pure.image.records.cell import Motion
from gateway.tools.client import running
from hil_tests.lab.running.cell_running import COMES_UP_S, INPUT_LOST, LINK_LOST, STOLEN, CellRun, running_cell
from hil_tests.purity import ROOT

CELLS = pathlib.Path(configs.__file__).parent / "cells"
GUIDE = (ROOT / "docs" / "guide" / "val3-in-a-cell.md").read_text(encoding="utf-8").partition("## Inputs and outputs")[0]
COMMANDS = re.findall(r"^    (axisgate .*)$", GUIDE.partition("## Check")[2], re.MULTILINE)  # hil_tests/unit has the import of a card
STATUS = re.findall(r"^    ((?:program|task) .*)$", GUIDE, re.MULTILINE)
PATIENCE_S = 150.0
PLAYS = 3
LATE = (*STOLEN, LINK_LOST, INPUT_LOST)  # reasons of a stop of a machine that does not serve its processes in time
HOME = (0.0, 20.0, 100.0, 0.0, 60.0, 0.0)
pytestmark = pytest.mark.timeout(PLAYS * (COMES_UP_S + 3 * PATIENCE_S))


class Disturbed(Exception):
    """The machine was late, and the simulated drives have stopped: this play proves nothing."""


def words_of(run: CellRun, command: str) -> list[str]:
    tool, *words = shlex.split(command)[1:]
    if tool == "program":
        words = [*(run.cell if word == "cs8" else word for word in words), "--name", run.name]
    elif tool == "var":
        words = [run.name if word == "cs8" else word for word in words]
    return [tool, *words]


def types(run: CellRun, command: str) -> str:
    """What a command of the guide prints."""
    line = [sys.executable, "-m", "gateway", *words_of(run, command)]
    done = subprocess.run(line, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
    return done.stdout


def looks(run: CellRun, command: str) -> str:
    """The same without a process of its own: one each 0.5 s would take the processor from the cell that is waited for."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        code = main(words_of(run, command))
    assert code == 0, f"{command}: {said.getvalue()}"
    return said.getvalue()


def waits(run: CellRun, test: Callable[[str], bool], what: str) -> None:
    """For a state, `test` of what `program status` shows.  A task in error is named at once; where the cell was stopped because
    the machine was late, the play counts nothing."""
    end = time.monotonic() + PATIENCE_S
    while not test(shown := looks(run, "axisgate program status cs8")):
        with running(run.name) as client:
            if any(row["fault"] for row in client.axes()):
                raise Disturbed
        broken = re.search(r"line \d+: \d+ .*", shown) is not None
        if broken and run.state().stop_cause in LATE:
            raise Disturbed
        assert not broken, f"{what}: {shown}"
        assert time.monotonic() < end, f"{what}: {shown}"
        time.sleep(0.5)


def test_the_guide_word_for_word(tmp_path: pathlib.Path) -> None:
    shutil.copytree(CELLS / "cs8", tmp_path / "cs8")
    shutil.copy(CELLS / "cs8.toml", tmp_path)
    for play in range(PLAYS):
        with running_cell(str(tmp_path / "cs8.toml"), f"cs8-{play}", plc=False, p5_ms=None) as run:
            try:
                follow(run)
            except Disturbed:
                continue
            return
    raise AssertionError(f"the machine was late in each of {PLAYS} plays")


def follow(run: CellRun) -> None:
    check, go, start, status, part, again = COMMANDS[:6]
    assert "0 errors" in types(run, check)
    assert go == "axisgate run cs8 --sim", "the run that is there"
    assert types(run, start) == "cycle is started\n"
    waits(run, lambda shown: STATUS[1] in shown, "the application waits for its part")
    assert types(run, status).splitlines() == STATUS[:2]
    assert "= 1" in types(run, part)
    waits(run, lambda shown: "task" not in shown, "it has carried two parts, and ends")
    with running(run.name) as client:
        assert int(str(client.ask("axes")["motion"])) == Motion.IDLE
        assert [float(str(row["actual"])) for row in client.axes()] == pytest.approx(HOME, abs=0.1)
    assert types(run, start) == "cycle is started\n"
    waits(run, lambda shown: "cycle~" in shown, "it runs again")
    assert types(run, again) == "cycle is stopped\n"
    waits(run, lambda shown: "task" not in shown, "it is stopped")
