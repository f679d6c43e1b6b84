"""Texts of run-time errors in the languages of a controller, from the catalogue of errors."""

import functools
from collections.abc import Mapping

from gateway.files.error_catalogue import family

LANGUAGES = {"english": "en", "deutsch": "de"}  # as setLanguage names them -> as cells and the catalogue do


@functools.cache
def val3_texts() -> Mapping[str, Mapping[int, str]]:
    """Language -> code -> text."""
    entries = family("val3").entries
    return {name: {code: entry.text.text(short) for code, entry in entries.items()} for name, short in LANGUAGES.items()}


def val3_language(short: str) -> str:
    """That of a controller for `language` of a cell."""
    return next(name for name, own in LANGUAGES.items() if own == short)
