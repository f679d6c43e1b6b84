"""A run that a signal ends leaves its report; reports that are none are named."""

import io
import json
import pathlib

import pytest

from gateway.commands.conformance import main
from gateway.conformance.reporting.folder import verify

STATION = """
import os, signal
from gateway.conformance.peers.stations import Built
class Killed(Built):
    def receive(self, data, now):
        os.kill(os.getpid(), getattr(signal, {name!r}))
        return super().receive(data, now)
def make():
    return Killed()
"""


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGINT"])
def test_a_signal_ends_the_run_with_a_report(name: str, tmp_path: pathlib.Path) -> None:
    (tmp_path / "killed.py").write_text(STATION.format(name=name))
    (tmp_path / "bench.toml").write_text('[port]\nurl = "machine:killed.py:make"\n')
    assert main(["run", "3964r", "--bench", str(tmp_path / "bench.toml"), "--report", str(tmp_path / "out")]) == 3
    assert json.loads((tmp_path / "out" / "report.json").read_text())["interrupted"] is True
    assert verify(tmp_path / "out") == []


@pytest.mark.parametrize("text", ["[" * 100_000, '{"kind": "axisgate conformance", "format": 1, "cases": [{"verdict": "FAIL"}]}'])
def test_a_broken_report_is_named(text: str, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.json").write_text(text)
    assert main(["run", "3964r", "--port", "sim", "--failed-from", str(tmp_path / "a.json")]) == 2
    assert main(["compare", str(tmp_path / "a.json"), str(tmp_path / "a.json")]) == 2
    assert "a.json: " in capsys.readouterr().err


class Typed(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_an_interview_asks_again_and_ends_with_its_input(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", Typed("rho3\nlow\nmaybe\nja\nabc\n138\n"))
    assert main(["new-pics", "3964r"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition("  #")[0] for line in lines[2:6]] == [
        'profile = "rho3"',
        'priority = "low"',
        "block_check = true",
        "most_received = 138",
    ]
    assert all(line.startswith("# ") for line in lines[6:])


def test_a_pics_names_a_profile_and_a_priority_there_are(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "p.toml").write_text('[pics]\npriority = "middle"\nprofile = "cp999"\n')
    assert main(["run", "3964r", "--port", "sim", "--pics", str(tmp_path / "p.toml"), "--dry-run"]) == 2
    said = capsys.readouterr().err
    assert "pics.priority: one of high, low expected, found 'middle'" in said
    assert "pics.profile: one of rho3" in said
