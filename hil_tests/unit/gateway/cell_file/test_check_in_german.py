"""`axisgate check` where the user's language is German: head, notices, places, and the hints of faults."""

import pathlib

import pytest

import configs
from gateway.cell_file.load import load_cell
from gateway.commands.check import fault_lines, main, valid
from gateway.files.texts import read_texts, spoken
from gateway.pure.cell.faults import CellFaults, Fault
from gateway.pure.reports.sentences import in_language

CELLS = sorted(pathlib.Path(configs.__file__).parent.joinpath("cells").glob("*.toml"))
ENGLISH = [" worst case", "expect ", "assumed as", " have no writer", "no following_error: only", "words ", "largest value", "data sheet; "]
ENGLISH += ["profile QVZ", " on hardware", "not playable", "with second", "warning ", "allowed ", "did you mean"]


@pytest.mark.parametrize("path", CELLS, ids=lambda path: path.stem)
def test_every_notice_of_a_shipped_cell_is_german(path: pathlib.Path) -> None:
    cell = load_cell(str(path))
    rows = valid(str(path), cell, "de")
    for row in rows:
        assert not [words for words in ENGLISH if words in row], row
    for notice in cell.notices:
        if in_language(notice.text, "de") == notice.text:  # not made in both languages
            assert spoken("check-notices").german(notice.text) != notice.text, notice


@pytest.mark.parametrize(
    "english, expected",
    [
        ("1675 us of 4000 us worst case (42 %)", "1675 us von 4000 us im unguenstigsten Fall (42 %)"),
        (
            "745 us of 4000 us worst case (19 %); + 1 SDO pair 25 %; node 20 I/O event-driven",
            "745 us von 4000 us im unguenstigsten Fall (19 %); + 1 SDO-Paar 25 %; Knoten 20 E/A ereignisgesteuert",
        ),
        (
            "SEND 32 words 103 ms + FETCH 32 words 103 ms at 9600 Bd: your 100 ms polling is not reachable; expect 210..260 ms",
            "SEND 32 Woerter 103 ms + FETCH 32 Woerter 103 ms bei 9600 Bd: eine Abfrage alle 100 ms ist nicht zu erreichen; "
            "mit 210..260 ms rechnen",
        ),
        (
            "times.QVZ = 900 ms instead of 550 ms: CP 524 has fixed times, so the partner expects 550 ms; both ends need the same",
            "times.QVZ = 900 ms statt 550 ms: CP 524 hat feste Zeiten, der Partner erwartet also 550 ms; beide Enden brauchen dieselbe",
        ),
        (
            'layer = "telegrams" and no [[telegram]]: every block is counted and dropped',
            'layer = "telegrams" und kein [[telegram]]: jeder Block wird gezaehlt und verworfen',
        ),
        ("line plc1", "Leitung plc1"),
        ("axis X, Y, Z", "Achse X, Y, Z"),
    ],
)
def test_a_notice(english: str, expected: str) -> None:
    assert spoken("check-notices").german(english) == expected


def test_faults_keep_file_key_and_value_and_say_range_and_hint_in_german(tmp_path: pathlib.Path) -> None:
    demo = next(path for path in CELLS if path.stem == "demo").read_text()
    file = tmp_path / "cell.toml"
    file.write_text(demo.replace('target           = "simulation"', 'target = "maschine"').replace("cycle_ms = 4", "cycle_ms = 99"))
    with pytest.raises(CellFaults) as found:
        load_cell(str(file))
    rows = fault_lines(str(file), found.value.faults, "de")
    target = next(row for row in rows if "maschine" in row)
    assert 'cell.target = "maschine": erlaubt machine | simulation: gemeint ist wohl machine?' in target and target.startswith("Fehler")
    assert "allowed" not in "\n".join(rows) and "weiter: beheben" in rows[-1]
    assert "allowed machine | simulation: did you mean machine?" in "\n".join(fault_lines(str(file), found.value.faults, "en"))


def test_a_syntax_error_says_what_to_write_instead() -> None:
    fault = Fault("cell.toml", "TOML", hint="Expected newline; TOML has no semicolons: one key on each line", line=3, kind="syntax")
    assert "TOML erlaubt keine Semikolons: ein Schluessel je Zeile" in fault_lines("cell.toml", (fault,), "de")[1]


def test_the_language_is_the_users(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("LC_ALL", "LC_MESSAGES", "LANGUAGE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("LANG", "de_DE.UTF-8")
    assert main(["demo"]) == 0
    german = capsys.readouterr().out
    monkeypatch.setenv("LANG", "C.UTF-8")
    assert main(["demo"]) == 0
    english = capsys.readouterr().out
    assert "im unguenstigsten Fall" in german and "worst case" not in german and "Leitung plc1: QVZ des Profils" in german
    assert "worst case" in english and "Fall" not in english


def test_the_table_is_of_ascii_and_keeps_its_fields() -> None:
    for english, german in read_texts("check-notices").pairs():
        assert german.isascii() and english.isascii()
        assert {part for part in "0123" if "{" + part + "}" in english} == {part for part in "0123" if "{" + part + "}" in german}, english
