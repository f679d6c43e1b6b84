"""`axisgate new` and `axisgate assess` as somebody types them."""

import json
import os
import pathlib
import subprocess
import sys

import pytest

from gateway.cell_file.load import load_cell
from gateway.tools.new_cell.questions import QUESTIONS


def axisgate(*arguments: str, typed: str = "") -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-m", "gateway", *arguments], input=typed, capture_output=True, text=True, timeout=60, check=False
    )


@pytest.mark.parametrize("kind", QUESTIONS)
def test_every_kind_of_new_cell_passes_check_as_it_is(kind: str, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "cell.toml"
    made = axisgate("new", "--from", kind, str(file), "--defaults", "--json")
    assert (made.returncode, json.loads(made.stdout)["file"]) == (0, str(file)), made.stderr
    checked = axisgate("check", str(file))
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert ": 0 errors" in checked.stdout and "not playable" not in checked.stdout


def test_five_answers_from_the_keyboard_are_in_the_cell(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "hall3.toml"
    made = axisgate("new", "--from", "s5-rk512", str(file), typed="Hall 3\n\nsiemens-cp340\n5\n20\n")
    assert made.returncode == 0, made.stderr
    cell = load_cell(str(file))
    assert (cell.cell.name, cell.line[0].profile, len(cell.axis), [block.number for block in cell.db]) == (
        "Hall 3",
        "siemens-cp340",
        5,
        [20, 21],
    )
    assert cell.line[0].port == "sim", "an empty line takes the value in brackets"
    assert f"next: axisgate check {file}" in made.stdout


def test_a_file_that_is_there_is_never_written_over(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "cell.toml"
    file.write_text("mine\n")
    made = axisgate("new", "--from", "modbus", str(file), "--defaults")
    assert (made.returncode, file.read_text()) == (2, "mine\n")
    assert "exists already and is not changed" in made.stderr


@pytest.mark.parametrize(
    "answer, words",
    [
        ("axes=7", "a number from 1 to 6"),
        ("bind=1502", "HOST:PORT"),
        ("colour=red", "not asked for modbus"),
        ("bind=10.0.0.20:502", "the address of the PLC that may write is needed"),
        ("plc=hall", "the address of the PLC, 10.0.0.5"),
    ],
)
def test_an_answer_no_cell_can_be_made_of_writes_nothing(answer: str, words: str, tmp_path: pathlib.Path) -> None:
    made = axisgate("new", "--from", "modbus", str(tmp_path / "cell.toml"), "--defaults", "--answer", answer)
    assert made.returncode == 2 and words in made.stderr
    assert not (tmp_path / "cell.toml").exists()


@pytest.mark.parametrize("kind", [kind for kind in QUESTIONS if kind != "s5-rk512"])
def test_a_server_in_the_hall_asks_for_the_plc_that_may_write(kind: str, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "cell.toml"
    typed = {"rho3": "Hall\n\n\n3\n", "reis": "Hall\n\n3\n\n", "modbus": "Hall\n"}[kind] + "0.0.0.0:502\n"
    typed += "\n\n\n" * (kind == "modbus") + "10.0.0.5\n"
    made = axisgate("new", "--from", kind, str(file), typed=typed)
    assert made.returncode == 0 and "Address of the PLC" in made.stdout, made.stderr
    assert (server := load_cell(str(file)).modbus[0]).bind == "0.0.0.0:502" and server.allow == ("10.0.0.5",)
    file.write_text(file.read_text().replace("allow          = ", "# allow = "))
    checked = axisgate("check", str(file))
    assert checked.returncode == 2 and "modbus.plc2.bind" in checked.stdout + checked.stderr


def test_no_help_shows_an_open_address() -> None:
    for command in ("new", "run", "check", "web", "modbus", "map"):
        assert "0.0.0.0" not in axisgate(command, "--help").stdout, command


def test_assess_asks_ten_questions_and_leaves_a_page_to_print(tmp_path: pathlib.Path) -> None:
    page = tmp_path / "assessment.html"
    typed = "rho3\n3\n6\nservodyn\nrk512\nno\nyes\nprinted\nyes\nJ. <Muster>\n"
    done = axisgate("assess", "--json", "--html", str(page), typed=typed)
    found = json.loads(done.stdout)
    assert (done.returncode, found["verdict"], len(found["reasons"])) == (0, "with", 10), done.stderr
    assert "J. &lt;Muster&gt;" in page.read_text(encoding="utf-8")


def test_an_answer_that_is_none_is_asked_again_at_once() -> None:
    done = axisgate("assess", typed="\nrho\nrho3\nall\n3\n0\n6\nnew\nrk512\nno\nno\nyes\nyes\nJ. Muster\n")
    assert done.returncode == 0, done.stderr
    for words in (
        "control = (nothing): one of rho3",
        "control = rho: one of rho3",
        "p15 = all: numbers with commas",
        "axes = 0: a number from",
    ):
        assert words in done.stderr


def test_a_no_is_exit_1_and_a_missing_answer_is_named() -> None:
    refused = axisgate("assess", typed="rho3\n3\n6\nanalog\nrk512\nno\nno\nyes\nyes\nJ. Muster\n")
    assert refused.returncode == 1 and "new drives on CAN first" in refused.stdout
    missing = axisgate("assess", typed="rho3\n")
    assert missing.returncode == 2 and "p15: numbers with commas, or - is needed" in missing.stderr


def test_assess_and_check_speak_the_language_of_the_system(tmp_path: pathlib.Path) -> None:
    answers = "control=reis p15=- axes=6 drives=new plc=rk512 pic=yes baps=no backups=yes sister=yes risk=Muster".split()
    given = [part for answer in answers for part in ("--answer", answer)]
    page = tmp_path / "page.html"
    command = [sys.executable, "-m", "gateway"]

    def said(language: str, *words: str) -> str:
        environment = {**os.environ, "LANG": language, "LC_ALL": language}
        return subprocess.run([*command, *words], check=False, capture_output=True, text=True, timeout=60, env=environment).stdout

    german = said("de_DE.UTF-8", "assess", *given, "--html", str(page))
    assert "das Programm ihrer SPS" in german and "Bedingt: axisgate kann die Steuerung ersetzen" in german
    assert "its PLC" not in german and '<html lang="de">' in page.read_text() and "Unterschrift" in page.read_text()
    assert "the program of its PLC" in said("en_GB.UTF-8", "assess", *given)
    assert "Bedingt: axisgate" in said("en_GB.UTF-8", "assess", "--language", "de", *given)
    cell = tmp_path / "own.toml"
    cell.write_text('format = 1\n[cell]\nname = "own"\n[rho3]\nP402 = 1\n')
    assert "Warnung  rho3.P402: wirkungslos: Referenzieren ein oder aus" in said("de_AT", "check", str(cell))
    assert "warning  rho3.P402: has no effect: referencing on or off" in said("C", "check", str(cell))
    cell.write_text("format = 1\n[cell]\nnane = 1\n")
    assert "Fehler" in said("de_DE", "check", str(cell)) and "weiter: beheben, dann: axisgate check" in said("de_DE", "check", str(cell))
