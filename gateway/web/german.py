"""German for the page: umlauts where the catalogue writes them out for displays of every code page, sentences of errors in both
languages (AX-253).
"""

import functools
import re

from gateway.files.texts import read_texts
from gateway.pure.image.reasons import Reason, text
from gateway.pure.reports.spoken import Spoken

TABLES = ("journal", "decoded", "refusals", "evidence", "robotstar", "robotstar-check")  # of configs/texts
MARK = "\x01detail\x01"
LETTERS = {"ae": "ä", "oe": "ö", "ue": "ü", "Ae": "Ä", "Oe": "Ö", "Ue": "Ü"}
TWO_SOUNDS = re.compile(
    r"zuerst|aktue|manue|virtue|eventue|individue|koeffizient|soeben|value|true|blue|due\b|does|goes|israel", re.IGNORECASE
)
SHARP = re.compile(  # after these, and before these, ss is a sharp s
    r"(?<![a-zäöü])(Ma)ss(?=st[aä]b)|([Gg]r(?:o|ö))ss|([sS]chlie)ss|([hH]ei)ss(?=[te]|en)|([aA]u)ss(?=er)|([lL]ie)ss|([mM]ä)ss(?=ig)"
    r"|([fF]lie)ss|([sS]t(?:o|ö))ss|([sS]tra)ss(?=e)|([gG]emä)ss|([wW]ei)ss|([dD]rau)ss"
)


def umlauts(words: str) -> str:
    """`pruefen` becomes `prüfen`; `Steuerung` and `Quelle` stay unchanged."""
    return re.sub(r"[^\W\d_]+", lambda found: _word(found[0]), words)


def _word(word: str) -> str:
    if TWO_SOUNDS.search(word):
        return word
    word = re.sub(r"(?<![aeqAEQ])[uU]e|[aA]e|[oO]e", lambda found: LETTERS[found[0]], word)
    return SHARP.sub(lambda found: next(part for part in found.groups() if part) + "ß", word)


@functools.cache
def _spoken() -> Spoken:
    pairs = [pair for name in TABLES for pair in read_texts(name).pairs()]
    pairs += [(text(reason, "en", "{0}"), umlauts(text(reason, "de", "{0}"))) for reason in Reason if reason]
    return Spoken(pairs)


def german(sentence: str) -> str:
    """German of a sentence of the journal, of a decoder or of a refusal; a sentence without German stays as it is."""
    return _spoken().german(sentence)


def says(sentence: str) -> list[str]:
    """English and German."""
    return [sentence, german(sentence)]


def both(code: int, words: str) -> list[str]:
    """An error's sentence, English and German, from either of them; a text that is not in the list stays as it is."""
    if code not in Reason.__members__.values():
        return says(words)
    templates = [text(Reason(code), language, MARK) for language in ("en", "de")]
    for template in templates:
        head, mark, tail = template.partition(MARK)
        if mark and words == head.rstrip(": ") + tail:
            return [_filled(templates[0], ""), umlauts(_filled(templates[1], ""))]
        if mark and words.startswith(head) and words.endswith(tail) and len(words) >= len(head) + len(tail):
            detail = words[len(head) : len(words) - len(tail)]
            return [_filled(templates[0], detail), umlauts(_filled(templates[1], detail))]
        if not mark and words == template:
            return [templates[0], umlauts(templates[1])]
    return says(words)


def _filled(template: str, detail: str) -> str:
    return template.replace(MARK, detail).rstrip(": ")
