"""Constants of STEP 5 and STEP 7 as numbers; times in 1/100 s, counts and numbers as they are."""

import re
from dataclasses import dataclass
from enum import Enum

TIME = re.compile(r"KT\s*(\d{1,3})\s*\.\s*([0-3])\b")
TIME7 = re.compile(r"(?:S5T|S5TIME)#((?:\d+(?:H|MS|M|S)_?)+)", re.IGNORECASE)
UNITS = {"H": 3_600_000, "M": 60_000, "S": 1_000, "MS": 1}
FORMS = (
    (re.compile(r"KF\s*([+-]?\s*\d+)\b"), 10),
    (re.compile(r"(?:KH|DH|W#16#|B#16#|DW#16#|BYTE#16#|WORD#16#|DWORD#16#)\s*([0-9A-F_]+)\b"), 16),
    (re.compile(r"KM\s*([01 ]{1,20})"), 2),
    (re.compile(r"2#([01_]+)"), 2),
    (re.compile(r"KB\s*(\d+)\b"), 10),
    (re.compile(r"L#([+-]?\d+)\b"), 10),
    (re.compile(r"([+-]?\d+)(?![\d.#,E])"), 10),
)
COUNT = re.compile(r"(?:KZ|KC|C#)\s*(\d{1,3})\b")
PAIR = re.compile(r"(?:KY|B#\()\s*(\d{1,3})\s*,\s*(\d{1,3})")


NO_CONSTANT = "neither a constant nor a byte that the integrated PLC loads"
NO_TIME = "a time has up to three digits, a point and a time base from 0 to 3 (KT 050.1)"


class Kind(Enum):
    """What a constant is good for: a timer start needs a time, a counter a count."""

    NUMBER = "number"
    TIME = "time"
    COUNT = "count"


@dataclass(frozen=True, slots=True)
class Constant:
    """A constant as the integrated PLC loads it."""

    value: int
    kind: Kind = Kind.NUMBER


def kind_of(operand: str) -> Kind | None:
    """What a constant is meant for, also one that is wrong; None: for neither a timer nor a counter, or it is none."""
    if operand.startswith(("KT", "S5T")):
        return Kind.TIME
    return Kind.COUNT if operand.startswith(("KZ", "C#")) else None


def constant_of(operand: str, english: bool) -> Constant | None:
    """The constant; None: it is none, or has no counterpart (KG, characters)."""
    if found := TIME.match(operand):
        return Constant(int(found[1]) * 10 ** int(found[2]), Kind.TIME)
    if found := TIME7.match(operand):
        parts = re.findall(r"(\d+)(H|MS|M|S)", found[1].upper())
        return Constant(sum(int(number) * UNITS[unit] for number, unit in parts) // 10, Kind.TIME)
    if (found := COUNT.match(operand)) and (english or not operand.startswith("KC")):
        return Constant(int(found[1]), Kind.COUNT)
    if found := PAIR.match(operand):
        return Constant(_word(operand, int(found[1]) << 8 | int(found[2])))
    for form, base in FORMS:
        if found := form.match(operand):
            digits = re.sub(r"[\s_]", "", found[1])
            value = int(digits, base) if digits.strip("+-") else None
            return Constant(_word(operand, value)) if value is not None and -(2**31) <= value < 2**32 else None
    return None


def _word(operand: str, value: int) -> int:
    """A pattern of STEP 5 is a word of 16 bits with a sign: KH FFFF equals KF -1."""
    return value - 0x10000 if operand.startswith(("KH", "KM", "KY")) and 0x7FFF < value <= 0xFFFF else value
