"""Errors as the page tells them, out of the one catalogue (AX-422): number, words in both languages, and what to do about it."""

from gateway.errors_catalogue import catalogue as everything
from gateway.errors_catalogue import lookup

OURS = "axisgate"


def advice(code: int) -> tuple[str, str]:
    """What to do about a reason of the status block, in English and German; empty where there is no such number."""
    entry = lookup(OURS, code)
    return ("", "") if entry is None else (entry.todo.en, entry.todo.de)


def catalogue() -> list[dict[str, object]]:
    """Everything `axisgate explain` knows of errors: those of axisgate by their number, all others by world and number."""
    return [
        {
            "code": number if name == OURS else f"{name} {number}",
            "en": entry.text.en,
            "de": entry.text.de,
            "do_en": entry.todo.en,
            "do_de": entry.todo.de,
        }
        for name, each in everything().items()
        for number, entry in each.entries.items()
    ]
