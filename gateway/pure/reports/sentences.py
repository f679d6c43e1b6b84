"""Sentences in English and German by their ids: an English string everywhere, which can be printed in German."""

from collections.abc import Iterable, Mapping, Sequence


class Sentence(str):
    """The English text as a string; `german` holds the German one."""

    german: str

    def __reduce__(self) -> tuple[object, tuple[str, str]]:
        return _sentence, (str(self), self.german)


def _sentence(english: str, german: str) -> Sentence:
    made = Sentence(english)
    made.german = german
    return made


class Texts:
    """A table id -> (English, German)."""

    def __init__(self, table: Mapping[str, tuple[str, str]]) -> None:
        self._table = table

    def ids(self) -> frozenset[str]:
        """All ids."""
        return frozenset(self._table)

    def pairs(self) -> Iterable[tuple[str, str]]:
        """Every sentence as it is written, English and German."""
        return self._table.values()

    def said(self, key: str, *values: object) -> Sentence:
        """The sentence; {0}, {1} are filled, in German with the German of values that have one."""
        english, german = self._table[key]
        return _sentence(english.format(*values), german.format(*(in_language(value, "de") for value in values)))


def in_language(text: object, language: str) -> str:
    """A sentence in that language; anything else as it is."""
    return text.german if language == "de" and isinstance(text, Sentence) else str(text)


def joined(sentences: Sequence[Sentence]) -> Sentence:
    """With commas."""
    return _sentence(", ".join(sentences), ", ".join(sentence.german for sentence in sentences))
