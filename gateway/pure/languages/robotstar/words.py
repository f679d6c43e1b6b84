"""The words of the language: which word a spelling is.  Data: configs/languages/robotstar.toml."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

Table = Mapping[str, str]  # spelling -> word


class WordFault(ValueError):
    """The table of words is wrong."""


@dataclass(frozen=True, slots=True)
class Words:
    """All tables, each from spelling (upper case) to word."""

    words: Table
    equates: Table
    descriptors: Table
    integers: frozenset[str]
    units: frozenset[str]

    @classmethod
    def from_data(cls, data: Mapping[str, object]) -> "Words":
        """From the file's content; WordFault where it is not of that form."""
        if data.get("format") != 1:
            raise WordFault(f"format {data.get('format')}: 1 is known")
        integers = cast(Mapping[str, list[list[str]]], data["integers"])["names"]
        units = cast(Mapping[str, list[str]], data["units"])["names"]
        tables = [_table(cast(Mapping[str, list[list[str]]], data[name])) for name in ("words", "equates", "descriptors")]
        return cls(
            tables[0],
            tables[1],
            tables[2],
            frozenset(row[0] for row in integers),
            frozenset(units),
        )

    def descriptor(self, text: str) -> str:
        """Return the descriptor of a text before a colon, "" for none; element names such as X or A7 are returned unchanged."""
        plain = text.strip().upper().replace("-", "_").replace(" ", "_")
        return self.descriptors.get(plain, plain if _is_element(plain) else "")


def _table(rows: Mapping[str, list[list[str]]]) -> Table:
    table: dict[str, str] = {}
    for word, spellings in rows.items():
        for text, _, _ in spellings:
            if text in table:
                raise WordFault(f"{text} is {table[text]} and {word}; a spelling belongs to one word")
            table[text] = word
    return table


def _is_element(name: str) -> bool:
    """X Y Z A B C, RX RY RZ and A1..A24."""
    if name in ("X", "Y", "Z", "A", "B", "C", "RX", "RY", "RZ"):
        return True
    return name[:1] == "A" and name[1:].isdecimal() and 1 <= int(name[1:]) <= 24 and name[1] != "0"
