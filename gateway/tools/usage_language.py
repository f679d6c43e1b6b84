"""Faults of a command line in the user's language (AX-1795): what argparse and the commands say in English has its German in
`configs/texts/usage.toml`.
"""

import argparse
import contextlib
import os
import sys
from collections.abc import Iterator, Mapping

from gateway.files.texts import spoken
from gateway.pure.lines.texts import language_of

INVALID = 2  # as argparse ends
USAGE = "usage: "


def usage_text(sentence: str, environment: Mapping[str, str] | None = None) -> str:
    """A sentence about the command line, in the user's language."""
    return spoken("usage").german(sentence) if _language(environment) == "de" else sentence


@contextlib.contextmanager
def usage_errors() -> Iterator[None]:
    """Every parser reports faults in the user's language.  `error` is the method that argparse lets others replace."""
    if _language() != "de":
        yield
        return
    before = argparse.ArgumentParser.error
    setattr(argparse.ArgumentParser, "error", _error)  # noqa: B010 a method cannot be assigned to
    try:
        yield
    finally:
        setattr(argparse.ArgumentParser, "error", before)  # noqa: B010


def _language(environment: Mapping[str, str] | None = None) -> str:
    return language_of(None, dict(os.environ) if environment is None else environment)


def _error(parser: argparse.ArgumentParser, message: str) -> None:
    usage = parser.format_usage().removeprefix(USAGE).replace("\n ", "\n  ")  # the prefix is longer by one
    sys.stderr.write(f"Aufruf: {usage}")
    parser.exit(INVALID, f"{parser.prog}: Fehler: {spoken('usage').german(message)}\n")
