"""What a German report says of its cases is German: reasons, what was expected, what was got."""

import ast
import html
import pathlib
import re
from collections.abc import Iterator

import pytest

from gateway.commands.conformance import main
from gateway.conformance import suites
from gateway.conformance.reporting.german import text_files, verdict_text
from gateway.files.texts import read_texts
from gateway.pure.reports.spoken import FIELD
from hil_tests.house.sentences import written

FOLDER = pathlib.Path(suites.__file__).parent
ENDS = {"Fail": 2, "Warn": 2, "Inconclusive": 1, "NotApplicable": 1}  # how many of its arguments are sentences of their own
ALIKE = re.compile(
    r"X|\b[0-9A-F]+h?\b|\b[A-Z]{3,}\b|_ON\b|within|it sends|is\b|in\b"
)  # the same in both languages, or with what is filled in
WITH_VALUES = (  # their German stands with what is filled in
    *("X, expected X (X)", "X cannot send X", "X reads differentlyX", "it X in X conflicts, then it X", "X is executed"),
    *("state X (X)", "X (xxXh)", "X was not answered", "X was sent again at once"),
)


def sentences() -> Iterator[tuple[str, str]]:
    """(file:line, what a case may end with), X for what is filled in."""
    for path in sorted(FOLDER.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ENDS:
                for argument in node.args[: ENDS[node.func.id]]:
                    text = written(argument)
                    if " " in text.strip() and re.search("[a-z]{2}", ALIKE.sub("", text)) and text not in WITH_VALUES:
                        yield f"{path.name}:{node.lineno}", text


def test_each_sentence_that_ends_a_case_has_its_german() -> None:
    found = list(sentences())
    assert len(found) >= 600
    english = [f"{place}: {text}" for place, text in found if verdict_text(text, "de") == text]
    assert english == [], "give them a line in configs/texts/conformance-*.toml"


@pytest.mark.parametrize("name", text_files())
def test_both_languages_name_the_same_things(name: str) -> None:
    for english, german in read_texts(name).pairs():
        assert set(FIELD.findall(german)) == set(FIELD.findall(english)), english


def test_no_english_pattern_occurs_twice() -> None:
    patterns = [english for name in text_files() for english, _ in read_texts(name).pairs()]
    assert sorted({each for each in patterns if patterns.count(each) > 1}) == []


def test_page_and_progress_are_german_and_json_is_english(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench = str(pathlib.Path(suites.__file__).parents[3] / "configs/conformance/no-nak.toml")
    assert main(["run", "3964r", "--bench", bench, "--only", "3964R_RCV_BI_01", "--language", "de", "--report", str(tmp_path)]) == 1
    said = capsys.readouterr().out
    page = html.unescape((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert "nach Blockprüfzeichen mit falschem Bit 0: nichts, erwartet NAK (15h)" in said
    assert "Erwartet: NAK (15h)" in page and "Erhalten: nichts" in page
    assert "Quellen der Fundstellen" in page and "1.4 Empfänger" in page and "Siemens CP 340 (A5E00369892)" in page
    assert '"got": "nothing"' in (tmp_path / "report.json").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("english", "german"),
    [
        ("Make the station send now", "Teilnehmer jetzt zum Senden veranlassen"),
        (
            "Switch the device: OFF, then press Enter (at most 60 s)",
            "Switch the device: AUS, dann die Eingabetaste drücken (höchstens 60 s)",
        ),
        (
            "not run: the device was lost (serial port COM9: cannot be opened (No such file or directory))",
            "nicht ausgeführt: das Gerät ist ausgefallen (serial port COM9: lässt sich nicht öffnen (Datei oder Ordner fehlt))",
        ),
    ],
)
def test_prompts_for_an_operator_and_faults_of_ports_are_german(english: str, german: str) -> None:
    assert verdict_text(english, "de") == german


def test_compare_and_verify_answer_in_german(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench = str(pathlib.Path(suites.__file__).parents[3] / "configs/conformance/good.toml")
    report = tmp_path / "report"
    assert main(["run", "3964r", "--bench", bench, "--only", "3964R_RCV_BV_01", "--report", str(report)]) == 0
    capsys.readouterr()
    assert main(["verify", str(report), "--language", "de"]) == 0
    assert main(["compare", str(report), str(report), "--language", "de"]) == 0
    assert capsys.readouterr().out == f"{report}: kein Byte wurde verändert\nalle Urteile sind gleich\n"
    (report / "more.txt").write_text("x")
    assert main(["verify", str(report), "--language", "de"]) == 1
    assert capsys.readouterr().out == f"{report}: more.txt: wurde hinzugefügt\n"
