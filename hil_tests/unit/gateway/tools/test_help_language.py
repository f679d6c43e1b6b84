"""Help is in the user's language (AX-1796): every line of the commands below has its German in configs/texts/help.toml."""

import argparse
import contextlib
import pathlib
import re
from importlib.metadata import entry_points

import pytest

from gateway.__main__ import main
from gateway.commands.catalogue import GROUP, first_line
from gateway.files.texts import read_texts
from gateway.pure.reports.spoken import FIELD
from gateway.tools.help_language import actions, explained, paragraphs
from gateway.tools.usage_language import result_text

WORDS = (
    "assess",
    "check",
    "demo",
    "explain",
    "new",
    "record",
    "replay",
    "status",
    "stop",
    "var",
    "run",
    "line",
    "line export",
    "modbus",
    "program",
    "robotstar",
    "val3",
    "conformance",
    "doctor",
    "doctor serial",
    "doctor can",
)


def answer(words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> str:
    """What a German user sees."""
    monkeypatch.setenv("LC_ALL", "de_DE.UTF-8")
    monkeypatch.setenv("COLUMNS", "120")
    with contextlib.suppress(SystemExit):
        main(words.split())
    return capsys.readouterr().out


def test_help_of_a_command_is_german(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    said = answer("check -h", monkeypatch, capsys)
    assert said.startswith("Aufruf: axisgate check [-h] [--json] [--strict] [--language {en,de}] CELL\n")
    assert "\nPrueft eine Zellendatei: nennt alle Fehler, Warnungen und Hinweise in einem Lauf.\n\nAngaben:\n" in said
    assert "\nBeispiele:\n  axisgate check cell.toml            alle Fehler, Warnungen und Hinweise einer Datei\n" in said
    assert "  --strict            bei Warnungen mit Code 1 enden\n" in said
    assert main(["check", "no-such-cell-of-this-test"]) == 2  # the command works as ever behind its help


def test_a_tool_of_a_command_and_its_group_are_german(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert re.search(
        "^    list +die Prueffolgen oder die Faelle einer Prueffolge auflisten$", answer("conformance -h", monkeypatch, capsys), re.M
    )
    assert "\nSchattenbetrieb:\n  neben einer laufenden alten Steuerung: " in answer("run -h", monkeypatch, capsys)


def test_the_list_of_commands_is_german(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    said = answer("-h", monkeypatch, capsys)
    assert said.startswith("Aufruf: axisgate COMMAND ... ")
    assert re.search(r"^  check +Prueft eine Zellendatei: ", said, re.MULTILINE)


def test_in_english_help_is_as_it_is_written(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    answer("check -h", monkeypatch, capsys)
    monkeypatch.setenv("LC_ALL", "C")
    with pytest.raises(SystemExit):
        main(["check", "-h"])
    assert capsys.readouterr().out.startswith("usage: axisgate check [-h]")


def texts(parser: argparse.ArgumentParser) -> set[str]:
    """What a parser and those below it say."""
    said = {action.help for action in actions(parser) if action.help and action.help != argparse.SUPPRESS}
    for group in parser._action_groups:
        said |= {group.title or "", group.description or ""}
    said |= {explained(line) for line in (parser.epilog or "").splitlines()}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            said = said.union(*(texts(below) for below in action.choices.values()))
    return {each for each in {*said, *paragraphs(parser.description or "")} if each}


@pytest.mark.parametrize("words", WORDS)
def test_every_line_of_help_has_its_german(words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LC_ALL", "C")
    seen: list[argparse.ArgumentParser] = []
    monkeypatch.setattr(argparse.ArgumentParser, "print_help", lambda parser, file=None: seen.append(parser))
    with pytest.raises(SystemExit):
        main([*words.split(), "-h"])
    known = [re.compile(".+".join(map(re.escape, FIELD.split(english)[::2]))) for english, _ in read_texts("help").pairs()]
    missing = {said for said in texts(seen[0]) if not any(pattern.fullmatch(said) for pattern in known)}
    assert not missing, f"axisgate {words} -h: give them a line in configs/texts/help.toml"


def test_every_command_has_its_german_line() -> None:
    known = {english for english, _ in read_texts("help").pairs()}
    assert {first_line(entry) for entry in entry_points(group=GROUP)} <= known


def test_both_languages_name_the_same_things() -> None:
    for english, german in read_texts("help").pairs():
        assert set(FIELD.findall(german)) == set(FIELD.findall(english)) and german.isascii(), english
        assert english.count("%") == german.count("%"), english


def test_results_of_the_first_commands_are_german(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = tmp_path / "hall.toml"
    said = answer(f"new --from s5-rk512 {cell} --defaults --language de", monkeypatch, capsys)
    assert said == f"{cell} geschrieben.  weiter: axisgate check {cell}      dann: axisgate run {cell} --sim\n"
    assert (
        result_text("a.axrec: X, cell 2, 2026, 1316 cycles of 10 ms (13.2 s)") == "a.axrec: X, cell 2, 2026, 1316 Takte zu 10 ms (13.2 s)"
    )
    assert result_text("no difference in 1316 cycles") == "kein Unterschied in 1316 Takten"
    assert all(english.count("{") == german.count("{") and german.isascii() for english, german in read_texts("command-results").pairs())
