"""AX-591: what the demo does on a machine that is late: slower clocks, then a guest with a clock of its own; told each time."""

import argparse
import json
import pathlib
from collections.abc import Sequence

import pytest

from gateway.pure.image.reasons import Reason, text
from hil_tests import demo
from hil_tests.lab.judges.verdicts import run_says_late
from hil_tests.lab.running.scenario import Scenario
from hil_tests.rig.uml import guest

LATE = "9 ms without SYNC in the bus log"


class Machine:
    """Late below `enough` ms; what was played on it."""

    def __init__(self, enough: int) -> None:
        self._enough = enough
        self.played: list[tuple[int, bool]] = []

    def play(self, scenario: Scenario, arguments: argparse.Namespace, *, last: bool) -> tuple[int, str]:
        self.played.append((scenario.p5_ms, last))
        scenario.close()
        return (0, "") if scenario.p5_ms >= self._enough else (1, LATE)


@pytest.mark.parametrize(
    ("enough", "options", "played", "code"),
    [
        (10, ["--p5", "4"], [4], 1),
        (20, [], [10, 20], 0),
        (64, [], [10, 20, 32], demo.TOO_SLOW),
    ],
)
def test_slower_clocks_are_tried_as_long_as_the_machine_was_late(
    enough: int, options: list[str], played: list[int], code: int, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    machine = Machine(enough)
    monkeypatch.setattr(demo, "play", machine.play)
    monkeypatch.setattr(demo, "realtime_allowed", lambda: False)  # it begins at 10 ms then
    assert demo.main(["--json", *options]) == code
    assert [p5 for p5, _ in machine.played] == played
    assert [last for _, last in machine.played] == [p5 == played[-1] and (bool(options) or p5 == 32) for p5 in played]
    told = capfd.readouterr().err
    assert told.count(f"too slow for P5 = {played[0]} ms: {LATE}") == 1
    assert told.count("once more with P5 = ") == len(played) - 1
    assert (demo.TAKEN_AWAY in told) is (code != 0), "what to do about it"


def test_without_such_a_guest_it_says_what_is_missing(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: pathlib.Path
) -> None:
    monkeypatch.setattr(guest, "OWN_KERNEL", tmp_path / "none")
    monkeypatch.setattr(guest, "missing", lambda: None)
    assert demo.main(["--own-time", "--records", str(tmp_path)]) == 3
    assert "its kernel is not built (make kernel)" in capfd.readouterr().err


def test_its_records_come_out_of_the_guest(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ran: list[list[str]] = []

    def run(self: guest.Guest, command: Sequence[str], on_line: object) -> int:
        ran.append(list(command))
        return 0

    monkeypatch.setattr(guest, "own_time", lambda: True)
    monkeypatch.setattr(guest, "missing", lambda: None)
    monkeypatch.setattr(guest.Guest, "run", run)
    assert demo.main(["--own-time", "--seed", "7", "--records", str(tmp_path / "records")]) == 0
    (command,) = ran
    assert command[-2:] == ["--records", str(tmp_path / "records")] and (tmp_path / "records").is_dir()
    assert "--own-time" not in command and command.count("--seed") == 1


def test_drives_that_the_run_itself_says_stopped_for_a_late_machine_are_no_fault_of_the_demo(tmp_path: pathlib.Path) -> None:
    """The bus log has no gap where only the cycle came late to its telegrams."""
    path = tmp_path / "alarms.jsonl"
    words = text(Reason.MACHINE_LATE, detail="A1, A2")
    assert run_says_late(path, 0) == ""
    alarms = [{"what": "came", "code": int(Reason.LINK_LOST), "text": "silent", "ns": 50}]
    alarms += [{"what": "came", "code": int(Reason.MACHINE_LATE), "text": words, "ns": 100}, {"what": "gone", "text": "gone", "ns": 105}]
    path.write_text("".join(json.dumps(each) + "\n" for each in alarms))
    assert run_says_late(path, 60) == words
    assert run_says_late(path, 101) == "", "of an earlier run"
