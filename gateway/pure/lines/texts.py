"""Sentences of the line tools in German and English.

A sentence is a `Text`: the English string, which also keeps its pattern and values, so that the same sentence can be printed in
German.  A sentence without German is printed in English; a test finds it.
"""

from collections.abc import Mapping

from gateway.pure.lines.texts_de import GERMAN

LANGUAGES = ("en", "de")


class Text(str):
    """`said("after {}: {}", ..)`; a string wherever one is wanted."""

    pattern: str
    values: tuple[object, ...]

    def __add__(self, other: str) -> "Text":
        return said("{}{}", self, other)


def said(pattern: str, *values: object) -> Text:
    """The sentence; {} are filled as str.format does."""
    text = Text(pattern.format(*values))
    text.pattern, text.values = pattern, values
    return text


def in_language(text: object, language: str) -> str:
    """A sentence, or a word of the table, in that language; anything else as it is."""
    if language != "de" or not isinstance(text, str):
        return str(text)
    if not isinstance(text, Text):
        return GERMAN.get(text, text)
    values = [in_language(value, language) if isinstance(value, str) else value for value in text.values]
    return GERMAN.get(text.pattern, text.pattern).format(*values)


def language_of(wanted: str | None, environment: Mapping[str, str]) -> str:
    """--language, else what the system speaks (LC_ALL before LC_MESSAGES before LANG), else English."""
    if wanted in LANGUAGES:
        return wanted
    spoken = next((environment[name] for name in ("LC_ALL", "LC_MESSAGES", "LANG") if environment.get(name)), "")
    return "de" if spoken.lower().startswith("de") else "en"
