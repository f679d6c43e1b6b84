"""The last line of the demo is one line, as the tutorial shows it, however narrow the terminal is."""

import pathlib

import pytest

from hil_tests.lab.judges.judge import Verdict
from hil_tests.lab.running.show import Show

TUTORIAL = pathlib.Path(__file__).resolve().parents[3] / "docs" / "guide" / "tutorial.md"


def test_the_summary_ends_with_the_line_of_the_tutorial(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    Show(quiet=False).summary([Verdict(f"figure {n}", 0.0, "0", True) for n in range(15)])
    last = capsys.readouterr().out.splitlines()[-1]
    assert last.startswith("15 of 15 checks passed; ") and f"    {last}\n" in TUTORIAL.read_text(encoding="utf-8")
