"""Lines of a printed machine-parameter list: parameter, axis, bus or board, label and value.

The available manuals show the list by its entries ("A_2 MBewert : -16384.0", rho 3 Releases part 3, L3903-3923; "No. of input blocks
[8 Byte] : 2", part 5, L7399-7455; "SB1 No.of Probe Inp.: 1", L1242; "I.START : 0", L11141), never in full.  So a line is read as

    P103 any title                   a parameter begins; the text after a colon or an equals sign is its value
    CAN bus 2 / BUS 2                entries below belong to bus 2
    [ROBI_1] A_3 label : value       entry of axis 3
    SB1 label : value                entry of servo board 1
    label : value                    any other entry; several numbers in a row are one for each axis

Remarks after ; or <-- and marks of the typesetting (**, <b>) are ignored (AX-272).
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

Value = bool | int | float | str

_MARKS = re.compile(r"\*\*|</?b>|\\")
_REMARK = re.compile(r"\s*(;|<--).*$")
_HEADING = re.compile(r"^#*\s*P\s?(\d{1,3})(?!\d)\s*(.*)$")
_BUS = re.compile(r"^(?:.*\bCAN[ -]?)?bus\s*(?:no\.?\s*)?([12])\b\s*:?\s*$", re.IGNORECASE)
_AXIS = re.compile(r"^(?:[A-Z][A-Z0-9]*_\d+\s+)?A_(\d{1,2})\b\s*(.*)$")
_BOARD = re.compile(r"^SB\s?(\d)\b\s*'?(.*)$")
_NUMBER = re.compile(r"^[-+]?\d+(?:[.,]\d+)?$")
_WORDS = {"TRUE": True, "FALSE": False, "WAHR": True, "FALSCH": False, "JA": True, "NEIN": False}


@dataclass(frozen=True, slots=True)
class Entry:
    """One value of the list."""

    line: int
    parameter: int
    label: str
    values: tuple[Value, ...]
    axis: int = 0  # 1.., 0: none named
    bus: int = 0
    board: int = 0


@dataclass(frozen=True, slots=True)
class Unread:
    """A line that is not understood."""

    line: int
    text: str
    why: str


def read(text: str) -> Iterator[Entry | Unread]:
    """The list from top to bottom."""
    parameter = bus = axis = 0
    for number, raw in enumerate(text.splitlines(), 1):
        line = _REMARK.sub("", _MARKS.sub("", raw)).strip()
        if not line or set(line) <= set("-=_*# \t"):
            continue
        if heading := _HEADING.match(line):
            parameter, bus, axis = int(heading[1]), 0, 0
            line = heading[2].strip(" -\t:") if ":" not in heading[2] and "=" not in heading[2] else heading[2]
            label, values = _split(line)
            if values:
                yield Entry(number, parameter, label, values)
            continue
        if found := _BUS.match(line):
            bus = int(found[1])
            continue
        board, here = 0, axis
        if found := _AXIS.match(line):
            here, line = int(found[1]), found[2]
            if not line.strip():
                axis = here  # "ROBI_1  A_1" is above its entries
                continue
        elif found := _BOARD.match(line):
            board, line = int(found[1]), found[2]
        label, values = _split(line)
        if not parameter:
            yield Unread(number, raw.strip(), "comes before the first parameter")
        elif not values:
            yield Unread(number, raw.strip(), "no value in it")
        else:
            yield Entry(number, parameter, label, values, here, bus, board)


def _split(line: str) -> tuple[str, tuple[Value, ...]]:
    """Return label and values: those after the last colon or equals sign, else the numbers at the end."""
    head, sign, tail = line.rpartition(":") if ":" in line else line.rpartition("=")
    if sign:
        return head.strip(), _values(tail)
    words = line.split()
    count = 0
    while count < len(words) and _value(words[-1 - count]) is not None:
        count += 1
    return " ".join(words[: len(words) - count]), _values(" ".join(words[len(words) - count :]))


def _values(text: str) -> tuple[Value, ...]:
    """All values of a text; units in brackets are left out; () when a word is none."""
    words = re.sub(r"\[[^\]]*\]|\([^)]*\)", " ", text).replace(", ", " ").split()
    found = [_value(word) for word in words]
    if len(words) > 1 and _value(words[-1]) is None and all(value is not None for value in found[:-1]):
        found = found[:-1]  # a unit after the numbers
    values = tuple(value for value in found if value is not None)
    return values if len(values) == len(found) else ()


def _value(word: str) -> Value | None:
    word = word.strip(",")
    if word.upper() in _WORDS:
        return _WORDS[word.upper()]
    if _NUMBER.match(word):
        plain = word.replace(",", ".")
        return float(plain) if "." in plain else int(plain)
    return word if re.fullmatch(r"X\d{2}|all", word, re.IGNORECASE) else None
