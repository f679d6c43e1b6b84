"""Faults of a command line are reported in the user's language (AX-1795)."""

import argparse
import ast
import contextlib
import inspect
import pathlib
import re
import zlib
from collections.abc import Iterator
from typing import Any

import pytest

import gateway
from gateway.__main__ import main
from gateway.commands import plc
from gateway.files.texts import read_texts
from gateway.pure.reports.spoken import FIELD
from gateway.tools.client import ToolError
from gateway.tools.command_support import ENVIRONMENT
from gateway.tools.usage_language import report_text, usage_text
from hil_tests.unit.gateway.web.test_spoken_robotstar import sentences

GERMAN = {"LC_ALL": "de_DE.UTF-8"}
NOT_OF_A_USER = (  # headings of -h, and mistakes of who builds a parser
    "usage: ", "options", "positional arguments", "show this help message and exit", "%(prog)s: error", "conflicting",
    "is an invalid argument", "mutually exclusive", "is not callable", "cannot merge", "must start with", "dest=",
    "invalid conflict_resolution", "multiple subparser", 'argument "-"', "__call__", "unexpected option string",
)  # fmt: skip


@pytest.mark.parametrize(
    ("words", "german"),
    [
        ("check", "axisgate check: Fehler: es fehlt: CELL"),
        ("check cell --nothing", "axisgate check: Fehler: unbekannte Angabe: --nothing"),
        ("check cell --language fr", "axisgate check: Fehler: --language: 'fr' gibt es nicht; erlaubt: 'en', 'de'"),
        ("check cell --language", "axisgate check: Fehler: --language: ein Wert fehlt"),
        ("record --for x", "axisgate record: Fehler: --for: 'x' ist keine Zahl"),
        ("record -o x", "axisgate record: Fehler: den Lauf mit CELL oder --name NAME angeben"),
        ("nonsense-word-of-no-command", "axisgate: unbekannter Befehl 'nonsense-word-of-no-command'; axisgate -h nennt die Befehle"),
        ("chekc", "axisgate: unbekannter Befehl 'chekc', gemeint ist vielleicht 'check'; axisgate -h nennt die Befehle"),
    ],
)
def test_a_wrong_command_line_is_named_in_german(
    words: str, german: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("LC_ALL", GERMAN["LC_ALL"])
    try:
        code = main(words.split())
    except SystemExit as left:
        code = int(str(left.code))
    said = capsys.readouterr().err
    assert code == 2 and said.splitlines()[-1] == german
    assert said.startswith(("Aufruf: axisgate", "axisgate: unbekannter Befehl")) and "usage" not in said


@pytest.mark.parametrize(
    ("words", "german"),
    [
        ("check nocell", "axisgate check: nocell: keine solche Datei; gesucht: "),
        ("run demo --p5 99", "axisgate run: --p5 99: der Takt ist 2..32 ms (Antriebe am CAN, P5 der rho 3)\n"),
        ("line fetch /dev/ttyNONE DB1.DW0", "axisgate line fetch: serieller Anschluss /dev/ttyNONE: fehlt; Adapter einstecken oder Pfad"),
        ("line monitor --record /none", "axisgate line monitor: /none: Datei oder Ordner fehlt\n"),
        (
            "modbus probe 127.0.0.1:1 --wait 0.2",
            "axisgate modbus: Modbus-Server 127.0.0.1:1: keine Verbindung (Verbindung abgelehnt); Adresse",
        ),
        ("program trace /none X", "axisgate program: /none: Datei oder Ordner fehlt\n"),
        ("program put demo x.qll", "axisgate program: demo: [controller] nennt keinen Speicher (memory)\n"),
        ("robotstar check /none", "axisgate robotstar: /none ist kein Ordner; den Ordner der Programme nennen"),
        ("val3 check /none", "axisgate val3: /none: kein solcher Ordner, keine solche Datei; den Ordner einer Anwendung"),
        ("conformance run 3964", "axisgate conformance: Prueffolge 3964 gibt es nicht; vorhanden: 3964r, "),
        ("conformance verify /none", "axisgate conformance: /none/SHA256SUMS: nicht lesbar (Datei oder Ordner fehlt); ist das der Ordner"),
        ("doctor serial pty:/x --count 0", "axisgate doctor: --count 0: 1..1000000\n"),
        ("doctor can socketcan:can0", "axisgate doctor: sendet Telegramme mit Identifier 7FFh auf einen echten Bus; erst die Antriebe"),
        ("doctor serial /dev/ttyNONE", "axisgate doctor: serieller Anschluss /dev/ttyNONE: fehlt; Adapter einstecken oder Pfad"),
        ("restore /none --to /tmp/x", "axisgate restore: /none: Datei oder Ordner fehlt\n"),
    ],
)
def test_why_a_command_cannot_run_is_reported_in_german(
    words: str, german: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("LC_ALL", GERMAN["LC_ALL"])
    assert main(words.split()) in (2, 3)
    assert capsys.readouterr().err.startswith(german)


def test_in_english_argparse_reports_as_it_always_does(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("LC_ALL", "C")
    with pytest.raises(SystemExit):
        main(["check"])
    assert capsys.readouterr().err.endswith("axisgate check: error: the following arguments are required: CELL\n")


def test_a_file_that_does_not_exist_is_named_with_those_that_do() -> None:
    said = usage_text("x: no such file; looked for /x, /y/x.toml; available: arm6, demo", GERMAN)
    assert said == "x: keine solche Datei; gesucht: /x, /y/x.toml; vorhanden: arm6, demo"


def templates() -> Iterator[str]:
    """What argparse of this Python reports."""
    for node in ast.walk(ast.parse(inspect.getsource(argparse))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("_", "ngettext"):
            yield from (str(ast.literal_eval(each)) for each in node.args if isinstance(each, ast.Constant))


def test_every_fault_that_argparse_reports_has_its_german() -> None:
    known = {re.sub(r"'?\{\d\}'?", "?", english) for english, _ in read_texts("usage").pairs()}
    of_a_user = [each for each in templates() if not any(word in each for word in NOT_OF_A_USER)]
    assert len(of_a_user) > 12
    assert {re.sub(r"'?%(\(\w+\))?[sr]'?", "?", each) for each in of_a_user} <= known, "give them a line in configs/texts/usage.toml"


def test_both_languages_name_the_same_things() -> None:
    for english, german in [pair for name in ("usage", "command-faults") for pair in read_texts(name).pairs()]:
        assert set(FIELD.findall(german)) <= set(FIELD.findall(english)) and german.isascii(), english


def test_faults_of_reis_programs_are_reported_in_german(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of `robotstar check`, `plc check` and `robotstar import`; --json keeps English."""
    program = 'MPR "P"\nVAR I1[0]\nPTP_GESCHW 200\nWRITE_BIT #AUSGANG, 2, 1, 0\nBRANCH "X"\nPOSITION #N, X:1\nEND\n'
    (tmp_path / "P.MPR").write_text(program)
    (tmp_path / "M.PLC").write_text("PLC 'M'\nU E0.9\nFOO\nEND\n")
    (tmp_path.parent / "list.txt").write_text("1 MPR Q\n2 WA1T 2\n4 STOP\n")
    monkeypatch.setenv("LC_ALL", GERMAN["LC_ALL"])
    assert main(["robotstar", "check", str(tmp_path)]) == 1
    said = capsys.readouterr().out
    for sentence in (
        "P.MPR:2:1: Fehler: Schritt 2: I1[0]: die Zahl der Elemente liegt ausserhalb 1 .. 100000 [rsv.definition]",
        "Schritt 3: PTP_GESCHW: Wert 200 muss groesser als 0 und hoechstens 100 sein",
        "Schritt 4: WRITE_BIT: Pegel 2 liegt ausserhalb 0 .. 1",
        "Schritt 5: Marke X gibt es in diesem Programm nicht",
        "Schritt 6: POSITION: Y, Z, A, B, C fehlt; robotstar import --points setzt benannte Positionen ein",
        "M.PLC:2:1: Fehler: Schritt 2: Bit 9: ausserhalb 0..7; E0.0 bis E0.7",
    ):
        assert sentence in said
    assert main(["plc", "check", str(tmp_path)]) == 1
    assert "Kein SPS-Befehl; 'FOO' ist kein Befehl der integrierten SPS" in capsys.readouterr().out
    main(["robotstar", "import", str(tmp_path.parent / "list.txt"), "--to", str(tmp_path / "to")])
    said, notes = capsys.readouterr()
    assert said == f"Q.MPR: geschrieben nach {tmp_path / 'to'}\n"
    assert notes.splitlines() == [
        f"{tmp_path.parent / 'list.txt'}:2: WA1T wird gelesen als WAIT",
        f"{tmp_path.parent / 'list.txt'}:3: Schritt 3 ist nicht gedruckt",
        f"{tmp_path.parent / 'list.txt'}:3: Q: END ist nicht gedruckt; wird ergaenzt",
    ]
    assert main(["robotstar", "check", str(tmp_path), "--json"]) == 1
    assert "step 5: label X is not in this program" in capsys.readouterr().out


NO_SENTENCE = re.compile(r"\\[sbd]|[|]|NOT_TRANSLATED")  # patterns, and a step of the program
IMPORT = pathlib.Path(gateway.__file__).parent / "pure/languages/plc/awl"
NARROW = "numbers are calculated with 32 bits; STEP 5 has 16: check lines"
UNFED = "7: uses what line 7 would have loaded, which is not translated"
PUT_TOGETHER = {NARROW: f"PB1: {NARROW} 7", UNFED: f"line 7 (PB1): T MB 1{UNFED[1:]}"}


@pytest.mark.parametrize("name", ["translator", "reader", "reasons", "report", "unfed"])
def test_each_reason_of_an_import_has_its_german(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LC_ALL", GERMAN["LC_ALL"])
    found = [(line, PUT_TOGETHER.get(words, words)) for line, words in sentences(IMPORT / f"{name}.py") if not NO_SENTENCE.search(words)]
    missing = [f"{name}.py:{line}: {words}" for line, words in found if report_text(words) == words]
    assert not missing, "give them a line in configs/texts/plc-import.toml"


def test_each_missing_echo_has_its_german() -> None:
    found = [words for _, words in sentences(pathlib.Path(gateway.__file__).parent / "tools/doctor/measure.py") if ": " in words]
    assert len(found) == 3 and not [words for words in found if "echo " in usage_text(words, GERMAN) or words == usage_text(words, GERMAN)]


def test_an_import_and_a_plc_are_reported_in_german(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What the list itself says stays as it is; --json keeps English."""
    (tmp_path / "list.txt").write_text("OB 1\n:U E 0.0: no\n:SS T 1\n:L DW 3\n:BE\n")
    command = ["plc", "import", str(tmp_path / "list.txt"), "--to"]
    monkeypatch.setenv("LC_ALL", GERMAN["LC_ALL"])
    assert main([*command, str(tmp_path / "to")]) == 1
    assert capsys.readouterr().out.splitlines() == [
        f"geschrieben: {tmp_path / 'to' / 'OB1.PLC'}",
        "4 Anweisungen, 2 nicht uebersetzt",
        "Zeile 3 (OB1): :SS T 1: die integrierte SPS hat keine speichernde Einschaltverzoegerung; "
        "einen Merker benutzen, der den Start haelt",
        "Zeile 4 (OB1): :L DW 3: DW3 hat keinen Merker; mit --words einen geben: DW3 = M200",
    ]
    assert main([*command, str(tmp_path / "to")]) == 2
    assert capsys.readouterr().err.endswith("gibt es schon; einen leeren Ordner nennen oder die Datei entfernen\n")
    assert main([*command, str(tmp_path / "more"), "--json"]) == 1
    assert "the integrated PLC has no latching switch-on delay" in capsys.readouterr().out
    assert plc.sentence({"state": "RUN", "scans": 7, "message": {"text": "door"}}) == "SPS RUN, 7 Zyklen; Meldung: door"
    (tmp_path / "M.PLC").write_text("PLC M\nFOO\nEND\n")
    assert main(["plc", "run", str(tmp_path), "--start", "M", "--virtual"]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "     0  Fehler: Kein SPS-Befehl (M Schritt 2)",
        f"START abgelehnt: M berichtigen; alle Fehler mit ihren Zeilen: axisgate plc check {tmp_path}",
        "Ende: Fehler, M Schritt 1, 100 Zyklen in 1.0 s",
    ]


def test_what_a_plc_refuses_is_reported_in_german(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    @contextlib.contextmanager
    def refusing(name: str) -> Iterator[None]:
        raise ToolError("M944: the robot writes it (error number of the control)")
        yield

    monkeypatch.setenv("LC_ALL", GERMAN["LC_ALL"])
    monkeypatch.setattr(plc, "running", refusing)
    assert main("plc set reis-plc M944 1".split()) == ENVIRONMENT
    assert capsys.readouterr().err == "axisgate plc: M944: ihn schreibt der Roboter (Fehlernummer der Steuerung)\n"


class Shown:
    """A tool's connection to a cell whose PLC shows a program."""

    def __init__(self, *answers: dict[str, object]) -> None:
        self._answers = list(answers)

    def ask(self, *words: object, **fields: object) -> dict[str, object]:
        return self._answers.pop(0) if len(self._answers) > 1 else self._answers[0]


def test_the_test_display_is_headed_in_german(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "M.PLC").write_text("PLC M\nU E0.0\nEND\n")
    monkeypatch.setenv("LC_ALL", GERMAN["LC_ALL"])
    monkeypatch.setattr(plc, "plc_folder", lambda cell: tmp_path)
    monkeypatch.setattr(plc, "SHOWN_S", 0.0)
    off = {"on": False, "why": "the PLC does not run", "rows": []}
    options = argparse.Namespace(program="M", json=False)
    stand_ins: tuple[Any, Any] = (None, Shown(off))
    assert plc.show(stand_ins[0], options, stand_ins[1]) == 1
    assert capsys.readouterr().out.splitlines()[::4] == [
        "Schritt                                        Status VKE      ACCU1      ACCU2",
        "die Testanzeige ist aus: die SPS laeuft nicht",
    ]


def test_the_test_display_has_nop_where_a_command_was_not_executed_alone(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Head, comment, label, invalid step and END are no commands."""
    (tmp_path / "M.PLC").write_text(text := "PLC M\nSP L\nU E0.0\n; note\n\\U E0.1\nM L\n= A0.0\nEND\n")
    monkeypatch.setattr(plc, "plc_folder", lambda cell: tmp_path)
    on = {"on": True, "why": "", "text": zlib.crc32(text.encode()), "rows": [[2, 0, 1, 0, 0], [7, 0, 1, 0, 0]]}
    stand_ins: tuple[Any, Any] = (None, Shown(on))
    assert plc.show(stand_ins[0], argparse.Namespace(program="M", json=False), stand_ins[1]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines() if line.endswith("NOP")] == ["3"]


@pytest.mark.parametrize(("message", "code"), [({"text": "Start program doesn't exist", "number": 0, "reaction": 3}, 1), (None, 0)])
def test_a_refused_start_in_a_cell_is_a_finding(message: object, code: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plc, "running", lambda name: contextlib.nullcontext(Shown({"state": "RUN", "scans": 7, "message": message})))
    assert main("plc start reis-plc NONE".split()) == code
