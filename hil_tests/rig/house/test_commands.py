"""`axisgate NAME`: what the command finder says and how it ends."""

import pathlib
import subprocess
import sys
import tomllib
from importlib.metadata import EntryPoint

import pytest

from gateway import __main__ as finder
from gateway.commands import catalogue
from hil_tests.purity import ROOT

COMMANDS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]["axisgate.commands"]


def axisgate(*words: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([sys.executable, "-m", "gateway", *words], capture_output=True, text=True, check=False)


def entry(name: str, value: str) -> EntryPoint:
    return EntryPoint(name, value, catalogue.GROUP)


def test_help_lists_every_command_in_one_line_each() -> None:
    result = axisgate("-h")
    listed = [line.split()[0] for line in result.stdout.splitlines()[2:]]
    assert (result.returncode, listed) == (0, sorted(COMMANDS))


def test_without_a_command_the_list_is_shown_and_the_exit_code_says_so() -> None:
    result = axisgate()
    assert result.returncode == 2 and "usage: axisgate" in result.stdout


def test_an_unknown_command_is_refused_with_the_nearest_name() -> None:
    result = axisgate("chekc", "x.toml")
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.count("\n") == 1 and "did you mean 'check'" in result.stderr


def test_a_command_that_is_not_written_yet_is_one_line_and_exit_3(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(finder, "entry_points", lambda group: [entry("later", "gateway.commands.later:main")])
    assert finder.main(["later"]) == 3
    assert capsys.readouterr().err == "axisgate later: not in this version (module gateway.commands.later does not exist yet)\n"


def test_a_missing_library_is_named_and_exit_3(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: pathlib.Path
) -> None:
    (tmp_path / "needs_it.py").write_text("import a_library_nobody_has\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(finder, "entry_points", lambda group: [entry("early", "needs_it:main")])
    assert finder.main(["early"]) == 3
    error = capsys.readouterr().err
    assert "a_library_nobody_has" in error and error.count("\n") == 1


def test_the_command_gets_the_rest_and_its_code_is_handed_back(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    (tmp_path / "a_command.py").write_text('"""Says what it does.\n\nMore."""\ndef main(argv): return len(argv)\n')
    monkeypatch.syspath_prepend(str(tmp_path))
    found = entry("here", "a_command:main")
    monkeypatch.setattr(finder, "entry_points", lambda group: [found])
    assert finder.main(["here", "a", "-h", "c"]) == 3
    assert catalogue.first_line(found) == "Says what it does."
