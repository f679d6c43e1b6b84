"""One error of the catalogue, and how one is found: by family and number, or by words.  Tables come in as plain data (configs/errors)."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from gateway.pure.image.system_errors import MOST_SYSTEM, system_code

Table = Mapping[str, object]

RESETS: Mapping[str, tuple[str, str]] = {  # reset rule of a file -> English, German
    "itself": ("clears when its cause is removed", "entfaellt mit der Ursache"),
    "acknowledge": (
        "remove the cause, then error acknowledgement (RC input 62, fault reset)",
        "Ursache beseitigen, dann Fehler quittieren (RC-Eingang 62, Quittieren)",
    ),
    "control_reset": (
        "remove the cause, then Control reset (RC input 19, fault reset)",
        "Ursache beseitigen, dann Grundstellung (RC-Eingang 19, Quittieren)",
    ),
    "restart": ("only a restart of the control", "nur Neustart der Steuerung"),
    "task": ("the task is started again or ended", "die Task wird neu gestartet oder beendet"),
    "result": ("none: the result of one call", "keine: Ergebnis eines Aufrufs"),
}


class CatalogueError(ValueError):
    """A table that is none of the catalogue's; the message names family, number and key."""


@dataclass(frozen=True, slots=True)
class Words:
    """A sentence in both languages."""

    en: str
    de: str

    def text(self, language: str) -> str:
        """de | en."""
        return self.de if language == "de" else self.en

    def filled(self, number: int, index: int) -> "Words":
        """{n}: the number, {i}: which of its range, from 1."""
        return Words(*(each.replace("{n}", str(number)).replace("{i}", str(index)) for each in (self.en, self.de)))


@dataclass(frozen=True, slots=True)
class Entry:
    """Everything that is known of one number."""

    family: str
    number: int
    text: Words
    cause: Words
    todo: Words
    shown: Words  # what the partner sees: PLC, pendant, CP
    reset: str  # key of RESETS
    source: str
    ours: bool = False  # the manual has no such number

    def reset_words(self) -> Words:
        """The reset rule as a sentence."""
        return Words(*RESETS[self.reset])


@dataclass(frozen=True, slots=True)
class Family:
    """One number space."""

    name: str
    title: Words
    source: str
    aliases: tuple[str, ...]
    entries: Mapping[int, Entry]


def family_of(table: Table) -> Family:
    """Read a file of the catalogue.  Raise CatalogueError with its fault."""
    name, default = str(table.get("family", "")), _table(table.get("default"))
    entries: dict[int, Entry] = {}
    for row in _list(table.get("error")):
        for index, number in enumerate(_numbers(_table(row), name), 1):
            if number in entries:
                raise CatalogueError(f"{name} {number}: defined twice")
            entries[number] = _entry(name, number, index, {**default, "source": table.get("source"), **_table(row)})
    aliases = tuple(str(alias) for alias in _list(table.get("aliases")))
    return Family(name, _words(table, "title", name), str(table.get("source", "")), aliases, dict(sorted(entries.items())))


def matching(families: Iterable[Family], word: str) -> list[Family]:
    """Families a word means: their name or alias, else all whose name begins with it ("reis", "rho3")."""
    wanted = word.lower()
    exact = [family for family in families if wanted in (family.name, *family.aliases)]
    begins = [family for family in families if family.name.startswith(wanted + "-")]
    return [*exact, *(family for family in begins if family not in exact)]


def find(families: Iterable[Family], key: str) -> list[Entry]:
    """What `647`, `reis 647`, `rk512 14h`, `system error 133` or words of a text mean; [] when nothing does."""
    known = list(families)
    *before, last = key.lower().split() or [""]
    number = number_of(last)
    if number is None:
        wanted = " ".join(key.lower().split())
        hit = (entry for entry in _all(known) if wanted and any(wanted in each.lower() for each in (entry.text.en, entry.text.de)))
        return list(hit)
    if before in (["system", "error"], ["systemfehler"]):
        if not 1 <= number <= MOST_SYSTEM:
            return []
        before, number = ["rho3"], system_code(number)
    chosen = matching(known, "-".join(before)) if before else known
    return [family.entries[number] for family in chosen if number in family.entries]


def number_of(word: str) -> int | None:
    """`647`, `-3`, `14h`, `0x14`; None: no number."""
    try:
        return int(word[:-1], 16) if word[-1:] in ("h", "H") else int(word, 0)
    except ValueError:
        return None


def _all(families: Iterable[Family]) -> Iterator[Entry]:
    return (entry for family in families for entry in family.entries.values())


def _entry(family: str, number: int, index: int, row: Table) -> Entry:
    where = f"{family} {number}"
    text, cause, todo, shown = (_words(row, key, where).filled(number, index) for key in ("text", "cause", "todo", "shown"))
    reset = str(row.get("reset", ""))
    if reset not in RESETS:
        raise CatalogueError(f"{where}: reset = {reset!r}; {', '.join(RESETS)} are known")
    return Entry(family, number, text, cause, todo, shown, reset, str(row.get("source", "")), bool(row.get("ours", False)))


def _numbers(row: Table, family: str) -> list[int]:
    several = [int(str(number)) for number in _list(row.get("numbers"))]
    limits = [int(str(number)) for number in _list(row.get("range"))]
    if len(limits) == 2:
        return list(range(limits[0], limits[1] + 1))
    if several or "number" in row:
        return several or [int(str(row["number"]))]
    raise CatalogueError(f"{family}: an error without number, numbers or range")


def _words(row: Table, key: str, where: str) -> Words:
    both = [str(each) for each in _list(row.get(key))]
    if len(both) != 2 or not all(both):
        raise CatalogueError(f'{where}: {key} must be ["English", "German"]')
    return Words(*both)


def _table(value: object) -> Table:
    return {str(key): each for key, each in value.items()} if isinstance(value, Mapping) else {}


def _list(value: object) -> list[object]:
    return list(value) if isinstance(value, list) else []
