"""The error catalogue (AX-422) for the page."""

from typing import Any

from gateway.files.error_catalogue import explain, family, lookup
from gateway.pure.image.error_entries import Entry, Words
from gateway.pure.image.reasons import Reason, text
from gateway.web.german import umlauts

MOST = 120
OURS = "axisgate"


def advice(code: int) -> dict[str, list[str]]:
    """Cause, remedy and reset of an error of the cell, each in English and German; {} for none.  Own ones are below 256."""
    entry = lookup(OURS, code) or lookup("rho3", code) or lookup("reis-servo", code)
    if entry is None:
        return {}
    return {"cause": _both(entry.cause), "do": _both(entry.todo), "reset": _both(entry.reset_words())}


def said(answer: dict[str, Any]) -> dict[str, Any]:
    """A command's answer; a refused one with its sentence in English and German: fault, place, remedy."""
    code = int(answer.get("reason", 0))
    if "say" in answer or answer.get("state") not in ("REFUSED", "ABORTED") or code not in Reason.__members__.values():
        return answer
    words = [text(Reason(code), language, str(answer.get("detail", ""))) for language in ("en", "de")]
    entry = lookup(OURS, code)
    if entry is not None:
        words = [f"{what}. {do[:1].upper()}{do[1:]}" for what, do in zip(words, _both(entry.todo), strict=True)]
    return {**answer, "say": [words[0], umlauts(words[1])]}


def found(words: str) -> list[dict[str, object]]:
    """Entries of a number, a family and number, or words; without any: axisgate's own."""
    entries = explain(words) if words.strip() else list(family(OURS).entries.values())
    return [_row(entry) for entry in entries[:MOST]]


def _row(entry: Entry) -> dict[str, object]:
    return {
        "family": entry.family,
        "code": entry.number,
        "text": _both(entry.text),
        "cause": _both(entry.cause),
        "do": _both(entry.todo),
        "shown": [entry.shown.en, entry.shown.de],  # as the partner shows it
        "reset": _both(entry.reset_words()),
        "source": entry.source,
    }


def _both(words: Words) -> list[str]:
    return [words.en, umlauts(words.de)]
