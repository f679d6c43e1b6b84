"""Dialogues as text: bytes received and sent and events reported by one station of a byte protocol, with times.  Test vectors and line
journals (AX-196).

One entry per line, separated by white space; `#` starts a comment line; empty lines mean nothing:

    dialogue NAME                    begins a dialogue; the name goes to the end of the line
    station KEY=VALUE ...            settings of the station, e.g. profile=rho3 priority=low
    TIME hears HEX HEX ...           bytes that came in
    TIME damaged PARITY              a spoiled character (FRAMING, OVERRUN, BREAK)
    TIME does WORD HEX ...           its owner asks for something, e.g. send 41 42
    TIME `says` HEX HEX ...          bytes that went out
    TIME reports NAME FIELD=VALUE    an event: bytes in hex without spaces (- when empty), enums by name, numbers in decimal

TIME is in milliseconds with up to six decimals (nanoseconds), from the start of the dialogue, never decreasing.  Entries of one moment are
in the order in which they happened.  All that is sent and reported is included: silence in between is part of the dialogue.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, fields, is_dataclass
from enum import Enum

from protocols.base.errors import DecodeError
from protocols.base.machine import Ns

VERBS = ("hears", "damaged", "does", "says", "reports")


@dataclass(frozen=True, slots=True)
class Entry:
    """One line; `what` is everything after the verb."""

    time: Ns
    verb: str
    what: str

    @property
    def data(self) -> bytes:
        return bytes.fromhex(self.what)


@dataclass(slots=True)
class Dialogue:
    """One dialogue; `station` as written in the file."""

    name: str
    station: dict[str, str] = field(default_factory=dict)
    entries: list[Entry] = field(default_factory=list)


def parse(text: str) -> list[Dialogue]:
    """All dialogues of a file; DecodeError names the line."""
    dialogues: list[Dialogue] = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        try:
            _take(dialogues, words)
        except (ValueError, IndexError) as error:
            raise DecodeError(f"line {number}: {line!r}: {error}") from error
    return dialogues


def _take(dialogues: list[Dialogue], words: list[str]) -> None:
    if words[0] == "dialogue":
        dialogues.append(Dialogue(" ".join(words[1:])))
    elif words[0] == "station":
        for word in words[1:]:
            key, value = word.split("=", 1)
            dialogues[-1].station[key] = value
    else:
        entry = Entry(round(float(words[0]) * 1e6), words[1], " ".join(words[2:]))
        if entry.verb not in VERBS:
            raise ValueError(f"verb {entry.verb}, known: {', '.join(VERBS)}")
        if dialogues[-1].entries and entry.time < dialogues[-1].entries[-1].time:
            raise ValueError("time runs backwards")
        dialogues[-1].entries.append(entry)


def line_of(entry: Entry) -> str:
    """The entry as written to a file."""
    return f"{entry.time / 1e6:14.6f}  {entry.verb:8}{entry.what}".rstrip()


def write(dialogues: Iterable[Dialogue]) -> str:
    """The file; `parse` reads the same back."""
    parts = []
    for dialogue in dialogues:
        settings = " ".join(f"{key}={value}" for key, value in dialogue.station.items())
        head = [f"dialogue {dialogue.name}".rstrip(), *([f"station {settings}"] if settings else [])]
        parts.append("\n".join([*head, *(line_of(entry) for entry in dialogue.entries)]) + "\n")
    return "\n".join(parts)


def describe(event: object) -> str:
    """An event as written after `reports`."""
    if not is_dataclass(event):
        return repr(event)
    parts = [type(event).__name__]
    for place in fields(event):
        value = getattr(event, place.name)
        parts.append(f"{place.name}={_text(value)}")
    return " ".join(parts)


def _text(value: object) -> str:
    if isinstance(value, bytes):
        return value.hex() or "-"
    return value.name if isinstance(value, Enum) else str(value)
