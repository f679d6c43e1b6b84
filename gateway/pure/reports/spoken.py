"""German translations of English sentences: the journal, whose lines other programs read, always keeps one language.

A table id -> (English, German) as of configs/texts; {0}, {1} are the values in the sentence.  A sentence is found by its fixed words: as a
whole, or by its clauses between "; " and the text before ": ".
"""

import functools
import re
from collections.abc import Callable, Iterable

Words = tuple[str, str]
FIELD = re.compile(r"\{(\d)\}")
CLAUSES = r";\ "  # as re.escape writes it
DEEPEST = 6  # sentences in sentences


class Spoken:
    """Finds the German of a sentence; `more`: other tables of complete sentences, used where no pattern fits ("": not known there)."""

    def __init__(self, table: Iterable[Words], more: Callable[[str], str] = lambda sentence: "") -> None:
        both = sorted(table, key=lambda words: -len(FIELD.sub("", words[0])))  # the one with the most fixed words first
        self._whole = {english: german for english, german in both if not FIELD.search(english)}
        patterns = [(_longest(en), re.compile(_pattern(en), re.DOTALL), de) for en, de in both if FIELD.search(en)]
        self._of_clauses = [each for each in patterns if CLAUSES in each[1].pattern]
        self._patterns = [each for each in patterns if CLAUSES not in each[1].pattern]
        self._more = more
        self.german = functools.lru_cache(maxsize=4096)(self._german)

    def _german(self, sentence: str) -> str:
        """The German; the sentence itself where it has none."""
        return self._said(sentence, 0) or sentence

    def _said(self, sentence: str, depth: int) -> str:
        """ "": no word of it is known."""
        if depth > DEEPEST or not sentence:
            return ""
        return (
            self._whole.get(sentence)
            or self._filled(sentence, self._of_clauses, depth)
            or self._joined(sentence, "; ", depth)
            or self._filled(sentence, self._patterns, depth)
            or self._more(sentence)
            or self._joined(sentence, ": ", depth)
            or self._joined(sentence, ", ", depth)
        )

    def _filled(self, sentence: str, patterns: "list[tuple[str, re.Pattern[str], str]]", depth: int) -> str:
        for part, pattern, german in patterns:
            if part in sentence and (found := pattern.fullmatch(sentence)):
                said = {name[1:]: self._said(value, depth + 1) or value for name, value in found.groupdict().items()}
                return FIELD.sub(lambda field, said=said: said[field[1]], german)  # type: ignore[misc]  # bound where it is made
        return ""

    def _joined(self, sentence: str, mark: str, depth: int) -> str:
        """Clause by clause, where one of them is known."""
        head, found, tail = sentence.partition(mark)
        if not found:
            return ""
        known, more = self._said(head, depth + 1), self._said(tail, depth + 1)
        return f"{known or head}{mark}{more or tail}" if known or more else ""


def _pattern(english: str) -> str:
    parts = FIELD.split(english)
    seen: set[str] = set()
    made = ""
    for n, part in enumerate(parts):
        if n % 2 == 0:
            made += re.escape(part)
        else:
            made += f"(?P=p{part})" if part in seen else f"(?P<p{part}>.+?)"
            seen.add(part)
    return made


def _longest(english: str) -> str:
    """Return fixed words that the sentence must contain: a search for them is faster than the complete pattern."""
    return max(FIELD.split(english)[::2], key=len)
