"""Errors as the page tells them, out of the one catalogue (AX-422): number, words in both languages, and what to do about it."""

from gateway.errors_catalogue import family, lookup


def advice(code: int) -> tuple[str, str]:
    """What to do about a reason of the status block, in English and German; empty where there is no such number."""
    entry = lookup("axisgate", code)
    return ("", "") if entry is None else (entry.todo.en, entry.todo.de)


def catalogue() -> list[dict[str, object]]:
    """Every number word 1 of a status block may hold."""
    return [
        {
            "code": number,
            "family": entry.family,
            "en": entry.text.en,
            "de": entry.text.de,
            "do_en": entry.todo.en,
            "do_de": entry.todo.de,
        }
        for number, entry in family("axisgate").entries.items()
    ]
