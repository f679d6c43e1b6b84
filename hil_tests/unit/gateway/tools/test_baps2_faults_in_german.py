"""`axisgate program check` reports faults of BAPS2 and PIC programs in the user's language."""

import ast
import pathlib
from types import ModuleType

import pytest

from gateway.__main__ import main
from gateway.files.texts import read_texts, spoken
from gateway.pure.languages import baps2, pic
from gateway.pure.reports.spoken import FIELD
from gateway.tools.usage_language import RHO3
from hil_tests.house.sentences import written

PROGRAM = """PROGRAMM P
GANZ : I, J, I
TEXT : T
ANFANG
WDHH 3 MAL
 I = T
WDH_ENDE
WENN I = 1 DAN I = 2
SPRUNG L9
FOO
WENN I DANN I = 2
PROGRAMM_ENDE
"""
REPORTS = {"error": 2, "warning": 2, "fault": 2, "fail": 2, "wrong": 0}  # method -> place of the text among its arguments


def templates(language: ModuleType) -> set[str]:
    """Every sentence that the reader and the checker report, with X for what it names."""
    found = set()
    for path in pathlib.Path(str(language.__file__)).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr.lstrip("_") in REPORTS:
                place = REPORTS[node.func.attr.lstrip("_")]
                found |= {written(each) for each in node.args[place : place + 1]}
    return {text for text in found if " " in text.replace("X", "").strip() and not text.endswith(" = X")}


@pytest.mark.parametrize(("language", "least"), [(baps2, 80), (pic, 20)])
def test_each_sentence_of_the_checker_has_its_german(language: ModuleType, least: int) -> None:
    sentences = templates(language)
    assert len(sentences) >= least
    german = spoken(*RHO3).german
    assert sorted(each for each in sentences if german(each) == each) == [], "give them a line in configs/texts"


@pytest.mark.parametrize("name", RHO3)
def test_both_languages_name_the_same_things(name: str) -> None:
    for english, german in read_texts(name).pairs():
        assert set(FIELD.findall(german)) == set(FIELD.findall(english)), english


def test_faults_are_reported_in_german(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "P.QLL"
    file.write_text(PROGRAM)
    monkeypatch.setenv("LC_ALL", "de_DE.UTF-8")
    assert main(["program", "check", str(file)]) == 1
    assert capsys.readouterr().out.splitlines() == [
        f"{file}:2:14: Fehler: I ist doppelt vereinbart [declared-twice]",
        f"{file}:5:1: Fehler: WDHH ist kein Unterprogramm; gemeint ist wohl WDH [name-unknown]",
        f"{file}:6:2: Fehler: TEXT kann nicht an INTEGER zugewiesen werden [type]",
        f"{file}:8:12: Fehler: THEN wird erwartet hinter der Bedingung, nicht 'DAN' [syntax]",
        f"{file}:9:1: Fehler: Marke L9 gibt es nicht; ein Sprung bleibt in seinem Programm, Unterprogramm oder Zweig von PARALLEL "
        "[label-missing]",
        f"{file}:10:1: Fehler: FOO ist kein Unterprogramm; vereinbaren, oder hinter eine Marke einen Doppelpunkt setzen [name-unknown]",
        f"{file}:11:6: Fehler: die Bedingung muss BINARY sein, nicht INTEGER [type]",
    ]
    assert main(["program", "check", str(file), "--json"]) == 1
    assert "I is declared twice" in capsys.readouterr().out
    monkeypatch.setenv("LC_ALL", "en_GB.UTF-8")
    main(["program", "check", str(file)])
    assert "error: I is declared twice" in capsys.readouterr().out
