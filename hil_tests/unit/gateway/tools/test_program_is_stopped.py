"""Ctrl-C at `axisgate program run`: whenever it comes the command ends, with the program; a stop that was lost is ordered again."""

import contextlib
import signal
from collections.abc import Iterator

import pytest

from gateway.__main__ import main
from gateway.commands import program_cell
from gateway.commands.program_cell import _stopped
from gateway.runtime.exit_codes import Exit
from gateway.tools.client import ToolClient, ToolError, heeded
from gateway.tools.command_support import INTERRUPTED


class Deaf(ToolClient):
    """The cell loses the first orders; it refuses one of them."""

    def __init__(self, lost: int) -> None:
        self.lost, self.stops = lost, 0

    def ask(self, op: str, **request: object) -> dict[str, object]:
        if request["do"] == "stop":
            self.stops += 1
            if self.stops == 1:
                raise ToolError("no such process")
            return {"ok": True}
        return {"over": self.stops > self.lost, "rows": []}


def test_a_stop_that_stopped_nothing_is_ordered_again() -> None:
    client = Deaf(lost=2)
    before, program_cell.STOP_AGAIN_S = program_cell.STOP_AGAIN_S, 0.0
    try:
        assert _stopped(client, 7, "LOOP")["over"] and client.stops == 3
    finally:
        program_cell.STOP_AGAIN_S = before


class Cell(ToolClient):
    """A program that ends when it is stopped.  `interrupted`: the request in which the signal comes, once."""

    def __init__(self, interrupted: str, number: signal.Signals = signal.SIGINT, lost: str = "") -> None:
        self.interrupted, self.number, self.lost = interrupted, number, lost
        self.asked: list[str] = []

    def ask(self, op: str, **request: object) -> dict[str, object]:
        what = str(request.get("do") or request.get("code") or op)
        self.asked.append(what)
        if what == self.interrupted:
            self.interrupted = ""
            signal.raise_signal(self.number)
        match what:
            case "list":
                return {"id": 1}
            case "start":
                return {"run": 1}
            case "state":
                over = "stop" in self.asked or bool(self.lost)
                how = "stopped" if "stop" in self.asked else "ended"
                rest = {"how": how, "code": 0, "text": "", "place": "", "kept": True, "lost": [self.lost] if self.lost else []}
                return {"over": over, "rows": [], **(rest if over else {})}
        return {"state": "DONE", "open": False, "simulated": False, "motion": 0, "axes": [], "cycle": 1, "ok": True}


@contextlib.contextmanager
def in_background() -> Iterator[None]:
    """As a shell without job control starts a program with `&`: SIGINT is ignored, and Python leaves it so."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def ran(cell: Cell, monkeypatch: pytest.MonkeyPatch) -> int:
    """The exit code of the command."""
    monkeypatch.setattr(program_cell, "running", lambda name: contextlib.nullcontext(cell))
    monkeypatch.setattr(program_cell, "POLL_S", 0.0)
    return main(["program", "run", "palletiser", "PALLET", "--ready"])


@pytest.mark.parametrize("moment", ["state", "start"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_program_that_has_begun_is_stopped(moment: str, number: signal.Signals, monkeypatch: pytest.MonkeyPatch) -> None:
    cell = Cell(moment, number)
    with in_background():
        assert ran(cell, monkeypatch) == Exit.FINDING
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    assert cell.asked.count("stop") == 1 and cell.asked[-1] == "axes" and "release_control" in cell.asked


@pytest.mark.parametrize("moment", ["request_control", "enable", "list"])
def test_a_program_that_has_not_begun_is_not_started(
    moment: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = Cell(moment)
    monkeypatch.setenv("LC_ALL", "de_DE.UTF-8")
    assert ran(cell, monkeypatch) == INTERRUPTED
    assert "start" not in cell.asked
    assert capsys.readouterr().err.startswith("axisgate program: ")


def test_control_is_given_back_where_the_program_has_not_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    cell = Cell("enable")
    assert ran(cell, monkeypatch) == INTERRUPTED
    assert cell.asked[-1] == "release_control"


def test_any_other_command_ends_without_a_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(argv: list[str]) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr("gateway.__main__.load", lambda entry: interrupted)
    assert main(["status"]) == INTERRUPTED


def test_handlers_are_as_before_behind_the_command() -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with pytest.raises(KeyboardInterrupt), heeded():
        signal.raise_signal(signal.SIGTERM)
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_a_file_that_is_lost_is_no_good_end(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    lost = "/cell/memory/LOG.DAT: No space left on device; what programs have written there is lost when this run ends"
    assert ran(Cell("", lost=lost), monkeypatch) == Exit.FINDING
    told = capsys.readouterr()
    assert "PALLET ended" in told.out and told.err == f"axisgate program: {lost}\n"
    monkeypatch.setenv("LC_ALL", "de_DE.UTF-8")
    assert ran(Cell("", lost=lost), monkeypatch) == Exit.FINDING
    assert "Datentraeger voll" in capsys.readouterr().err
