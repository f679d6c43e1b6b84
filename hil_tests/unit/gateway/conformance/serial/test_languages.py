"""The tools' sentences in German: none is missing, numbers stay what they are, and English stays as it was."""

import ast
import inspect
import string
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import pytest

from gateway.conformance import report
from gateway.conformance.report import as_dict, to_html
from gateway.conformance.serial import bench, cases_active, cases_receive, cases_rk512, cases_send
from gateway.conformance.serial import run as probe
from gateway.conformance.serial.run import Settings, all_cases
from gateway.conformance.serial.run import probe as run_probe
from gateway.pure.lines import diagnosis as line_diagnosis
from gateway.pure.lines.diagnosis import anzw, cp341, judge, pafe
from gateway.pure.lines.texts import Text, in_language, language_of, said
from gateway.pure.lines.texts_de import GERMAN
from gateway.tools.line import client as line_job
from gateway.tools.line.diagnose import gather
from gateway.tools.line.ports import open_wire
from protocols.p3964r.profiles import RHO3, Priority

SPEAKING = {"said", "Fail", "Warn", "NotRun", "Inconclusive", "Finding", "remark", "measured", "give_good", "expect", "expect_at"}
SPEAKING |= {"silence", "make_it_send", "case", "add", "word", "_refused", "_expect_count", "_answered_with", "_block_answered"}
CODES = {"fault", "warn", "ok", "note"}


def spoken(module: ModuleType) -> Iterator[str]:
    """Texts handed to whatever speaks: constants with a blank in them."""
    for node in ast.walk(ast.parse(inspect.getsource(module))):
        if not isinstance(node, ast.Call):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        for argument in node.args if name in SPEAKING else ():
            if isinstance(argument, ast.Constant) and isinstance(argument.value, str) and " " in argument.value:
                yield argument.value
            assert not isinstance(argument, ast.JoinedStr) or name in ("add",), f"{module.__name__}: {ast.unparse(node)}: use said(..)"


@pytest.mark.parametrize("module", [bench, cases_active, cases_receive, cases_rk512, cases_send, probe, report, line_diagnosis, line_job])
def test_everything_that_is_said_has_its_german(module: ModuleType) -> None:
    found = set(spoken(module))
    assert found or module is probe
    assert sorted(text for text in found if text not in GERMAN) == []


def test_tables_and_titles_have_their_german() -> None:
    tables: tuple[dict[Any, str], ...] = (line_job.SEEN, line_job.MEANS, line_job.NOT_TAKEN)
    assert [text for table in tables for text in table.values() if text not in GERMAN] == []
    titles = [case.title for case in all_cases(Settings(RHO3, Priority.LOW, active=True))]
    patterns = [title.pattern if isinstance(title, Text) else title for title in titles]
    texts = [*line_diagnosis.PAFE.values(), *line_diagnosis.ANZW_BITS.values(), *line_diagnosis.ANZW_ERRORS.values()]
    texts += [*line_diagnosis.CP341_CLASSES.values(), *line_diagnosis.CP341_EVENTS.values(), *cases_rk512.ERROR_WORDS.values()]
    texts += [
        report.TEXT,
        report.BANNER,
        report.UNCERTAINTY,
        *report.LABELS.values(),
        *line_diagnosis.SET_OURS.values(),
        *CODES,
        "nothing",
        "a damaged character",
    ]
    assert sorted(text for text in {*patterns, *texts} if text not in GERMAN) == []


def fields(pattern: str) -> list[tuple[str, str]]:
    return sorted((name or "", spec or "") for _, name, spec, _ in string.Formatter().parse(pattern) if name is not None)


@pytest.mark.parametrize("english", sorted(GERMAN))
def test_german_has_the_same_numbers_in_the_same_form(english: str) -> None:
    german = GERMAN[english]
    assert sorted(spec for _, spec in fields(german)) == sorted(spec for _, spec in fields(english))
    assert german.isascii() == english.isascii(), "umlauts are written out"


def test_a_sentence_is_its_english_and_can_be_said_in_german() -> None:
    text = said("after {}: {}, expected {}", "a good block", "nothing", "DLE") + said(" within {:.0f} ms", 550.4)
    assert text == "after a good block: nothing, expected DLE within 550 ms"
    assert in_language(text, "de") == "nach einem guten Block: nichts, erwartet DLE innerhalb von 550 ms"
    assert in_language(text, "en") == text
    assert in_language("no such sentence", "de") == "no such sentence"


@pytest.mark.parametrize(
    ("wanted", "environment", "language"),
    [
        ("de", {"LANG": "en_GB.UTF-8"}, "de"),
        (None, {"LANG": "de_DE.UTF-8"}, "de"),
        (None, {"LC_ALL": "C", "LANG": "de_DE.UTF-8"}, "en"),
        (None, {"LC_MESSAGES": "de_AT", "LANG": "fr_FR"}, "de"),
        (None, {}, "en"),
    ],
)
def test_the_language_is_the_option_else_the_system_s(wanted: str | None, environment: dict[str, str], language: str) -> None:
    assert language_of(wanted, environment) == language


def test_a_report_in_german() -> None:
    settings = Settings(RHO3, Priority.HIGH, only=("receive.doubled-dle", "send.silent", "idle.stray", "rk512.fetch"))
    results = run_probe(open_wire("sim:bad-partner"), settings)
    made = as_dict(results, settings, "sim:bad-partner", "9600 8E1", "2026-11-21", True, {"name": "Waage"}, "de")
    tests = made["tests"]
    assert isinstance(tests, list)
    reasons = {test["name"]: (test["verdict"], test["reason"]) for test in tests}
    assert reasons["send.silent"] == ("FAIL", "2 Verbindungsversuche, erwartet 6")
    wanted = "nach einem Block mit einem verdoppelten DLE und richtigem Pruefzeichen: NAK, erwartet DLE"
    assert reasons["receive.doubled-dle"] == ("FAIL", wanted)
    page = to_html(made)
    for words in (
        '<html lang="de">',
        "3964R-Pruefung",
        "FEHLER",
        "BESTANDEN",
        "Anschluss",
        "erwartet 550 ±",
        "keine Sicherheits",
    ):
        assert words in page, words
    for words in ("expected", "Verdict", "after ", "characters from us", "FAIL"):
        assert words not in page, words
    english = to_html(as_dict(results, settings, "sim:bad-partner", "9600 8E1", "2026-11-21", True, {}, "en"))
    assert "2 connection attempts, expected 6" in english and '<html lang="en">' in english


PARTNERS = ("echo", "cross-talk", "inverted", "latency-16ms", "speed-4800", "includes-stx", "silent", "good,rho3,low")


@pytest.mark.parametrize("partner", PARTNERS)
def test_a_diagnosis_in_german(partner: str) -> None:
    seen = gather(lambda line_format: open_wire(f"sim:{partner}", line_format), "9600 8E1", RHO3, "low")
    for finding in judge(seen):
        text = in_language(finding.text, "de")
        assert text != finding.text, finding
        assert "hoch" not in in_language(finding.todo, "de"), "what is typed into a cell is not a German"
        assert not {"the", "is", "every", "answers", "partner's"} & set(text.split()), text


def test_what_a_partner_shows_in_german() -> None:
    assert in_language(pafe(0x81).text, "de").startswith("Schnittstelle nicht bereit")
    assert in_language(anzw(0x0308)[1].text, "de") == "Bereich zu klein"
    assert in_language(cp341(8, 6).text, "de") == "Empfangsfehler: ZVZ/CDT ueberschritten"
