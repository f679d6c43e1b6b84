"""The words of the language: which token a spelling is.  Data: configs/languages/baps2.toml."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Spelling:
    """One spelling of a word.  `source`: a line or doubt of the manual, or "axisgate"."""

    text: str
    language: str
    source: str


class Words:
    """All spellings, compared without case."""

    def __init__(self, table: Mapping[str, Iterable[Spelling]]) -> None:
        """`table`: token -> its spellings.  ValueError: one spelling of two tokens."""
        self.spellings = {token: tuple(spellings) for token, spellings in table.items()}
        self._tokens: dict[str, str] = {}
        self._languages = {each.text.upper(): each.language for row in self.spellings.values() for each in row}
        for token, spellings in self.spellings.items():
            for spelling in spellings:
                other = self._tokens.setdefault(spelling.text.upper(), token)
                if other != token:
                    raise ValueError(f"{spelling.text} spells {other} and {token}")

    def token(self, text: str) -> str | None:
        """The token of a word in any case; None: it is a name."""
        return self._tokens.get(text.upper())

    def language(self, text: str) -> str:
        """The language of a spelling; "": it is none."""
        return self._languages.get(text.upper(), "")

    def __contains__(self, text: str) -> bool:
        return text.upper() in self._tokens


def words_of(raw: Mapping[str, Iterable[Iterable[str]]]) -> Words:
    """From the plain lists of the file: token -> [[text, language, source], ...].  ValueError: a spelling without three parts."""
    return Words({token: [Spelling(*parts) for parts in map(_three, spellings)] for token, spellings in raw.items()})


def _three(parts: Iterable[str]) -> tuple[str, str, str]:
    found = tuple(parts)
    if len(found) != 3:
        raise ValueError(f"a spelling is [text, language, source]: {found}")
    return found
