"""Messages of the commands about the command line and their faults, in the user's language (AX-1795): English messages of argparse and the
commands have their German in `configs/texts/usage.toml`, their help in `help.toml`.
"""

import argparse
import contextlib
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping

from gateway.files.texts import spoken
from gateway.pure.languages.base.faults import Severity, SourceFault
from gateway.pure.lines.texts import language_of
from gateway.tools.command_support import of_file
from gateway.tools.help_language import german_help, in_german_usage

INVALID = 2  # as argparse ends
FAULTS = ("usage", "command-faults")  # of configs/texts
REPORTS = ("robotstar-words", "robotstar-check", "plc-import", "robotstar", "refusals")
RHO3 = ("baps2-check", "pic-check")
PLACE = re.compile(r"(?:step (\d+)|([A-Z]\w*(?:\[\w*\])?(?:\(\w*\))?)): ")  # step, command or operand before a sentence
CARD_FAULT = re.compile(r"(.+?) line (\d+): (.+?)(; the file is left out)?")  # a file of a flash card
WRITTEN_OUT = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss"})  # for every code page (AX-253)


def usage_text(sentence: str, environment: Mapping[str, str] | None = None) -> str:
    """A sentence about the command line or a fault of a command, in the user's language."""
    return spoken(*FAULTS).german(sentence) if _language(environment) == "de" else sentence


def help_text(sentence: str) -> str:
    """A sentence of the help, in the user's language."""
    return spoken("help").german(sentence) if _language() == "de" else sentence


def report_text(sentence: str) -> str:
    """A sentence about a program of an old controller, as a command prints it, in the user's language."""
    if _language() != "de":
        return sentence
    if place := PLACE.match(sentence):
        said = report_text(sentence[place.end() :])
        if place[1] or said != sentence[place.end() :]:
            return (f"Schritt {place[1]}: " if place[1] else place[0]) + said
    return spoken(*REPORTS).german(sentence).translate(WRITTEN_OUT)


def baps2_text(sentence: str) -> str:
    """A sentence about a BAPS2 or PIC program, in the user's language."""
    return spoken(*RHO3).german(sentence).translate(WRITTEN_OUT) if _language() == "de" else sentence


def result_text(sentence: str) -> str:
    """The result of a command in one sentence, in the user's language."""
    return spoken("command-results").german(sentence).translate(WRITTEN_OUT) if _language() == "de" else sentence


def val3_text(sentence: str) -> str:
    """What `axisgate val3` reports around the words of the controller, in the user's language."""
    return spoken("val3").german(sentence).translate(WRITTEN_OUT) if _language() == "de" else sentence


def val3_fault_text(sentence: str) -> str:
    """A fault in the files of an application, in the user's language; the words of a controller stay as they are."""
    return spoken("val3-files").german(sentence).translate(WRITTEN_OUT) if _language() == "de" else sentence


def val3_card_text(sentence: str) -> str:
    """An open point of a flash card, in the user's language: a fault of XML in it is a sentence of its own."""
    if _language() != "de" or (read := CARD_FAULT.fullmatch(sentence)) is None:
        return val3_text(sentence)
    name, line, fault, left_out = read.groups()
    said = val3_fault_text(fault)
    if left_out:
        return val3_text(f"{name} line {line}: {said}{left_out}")
    return val3_text(sentence) if said == fault else f"{name} Zeile {line}: {said}"


def fault_text(fault: SourceFault, said: Callable[[str], str] = report_text) -> str:
    """A fault of a program with its place and id, in the user's language.  `said`: knows the German of its controller."""
    if _language() != "de":
        return str(fault)
    level = {Severity.ERROR: "Fehler", Severity.WARNING: "Warnung"}[fault.severity]
    hint = f"; {said(fault.hint)}" if fault.hint else ""
    return f"{fault.position}: {level}: {said(fault.text)}{hint} [{fault.id}]"


def complain(command: str, fault: object) -> None:
    """Report on standard error why a command cannot do its task."""
    words = of_file(fault) if isinstance(fault, Exception) else str(fault)
    print(f"axisgate {command}: {usage_text(words)}", file=sys.stderr)


@contextlib.contextmanager
def users_language() -> Iterator[None]:
    """Every parser reports faults and prints its help in the user's language, by the two methods that argparse lets others replace."""
    if _language() != "de":
        yield
        return
    parser = argparse.ArgumentParser
    before = parser.error, parser.format_help
    setattr(parser, "error", _error)  # noqa: B010 a method cannot be assigned to
    setattr(parser, "format_help", german_help(parser.format_help))  # noqa: B010
    try:
        yield
    finally:
        setattr(parser, "error", before[0])  # noqa: B010
        setattr(parser, "format_help", before[1])  # noqa: B010


def _language(environment: Mapping[str, str] | None = None) -> str:
    return language_of(None, dict(os.environ) if environment is None else environment)


def _error(parser: argparse.ArgumentParser, message: str) -> None:
    sys.stderr.write(in_german_usage(parser.format_usage()))
    parser.exit(INVALID, f"{parser.prog}: Fehler: {spoken('usage').german(message)}\n")
