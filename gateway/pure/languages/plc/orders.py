"""What is done to a PLC in virtual time, as `N WHAT`: E0.6=1 M20=5 EA2=4.5 START [PROGRAM] STOP ACK POWER DRIVES OFF."""

import re
from dataclasses import dataclass

WORDS = ("START", "STOP", "ACK", "POWER", "DRIVES")
ASSIGNED = re.compile(r"(E|M|EA)(\d{1,6})(?:\.(\d{1,6}))?=([+-]?\d+(?:\.\d+)?)$", re.IGNORECASE)
LAST = {"E": 39, "M": 1967, "EA": 24}
VOLTS = 10.0


class OrderFault(ValueError):
    """An order that cannot be carried out; the text names what and where."""


@dataclass(frozen=True, slots=True)
class Order:
    """One order before scan `at`.  `what` is a word or E, M, EA; `bit` None: the entire byte, or an analog input."""

    at: int
    what: str
    number: int = 0
    bit: int | None = None
    value: float = 0
    name: str = ""


def orders_of(text: str) -> list[Order]:
    """The orders of one `--at`.  OrderFault."""
    number, _, rest = text.strip().partition(" ")
    if not number.isascii() or not number.isdigit() or len(number) > 9 or not rest.strip():
        raise OrderFault(f"{text!r}: write the number of a scan, a blank and what is done: '3 E0.6=1'")
    words = rest.replace(",", " ").split()
    found: list[Order] = []
    while words:
        found.append(_order(int(number), words, text))
    return found


def _order(at: int, words: list[str], text: str) -> Order:
    """Takes one order from the front of `words`."""
    word = words.pop(0)
    if match := ASSIGNED.match(word):
        return _assigned(at, match, text)
    match word.upper():
        case "START":
            named = words and words[0].upper() not in WORDS and not ASSIGNED.match(words[0])
            return Order(at, "START", name=words.pop(0) if named else "")
        case "DRIVES" if words and words[0].upper() in ("ON", "OFF"):
            return Order(at, "DRIVES", value=words.pop(0).upper() == "ON")
        case "STOP" | "ACK" | "POWER" as known:
            return Order(at, known)
    raise OrderFault(f"{text!r}: {word} is not one of E0.6=1, M20=5, EA2=4.5, START [PROGRAM], STOP, ACK, POWER, DRIVES ON, DRIVES OFF")


def _assigned(at: int, match: re.Match[str], text: str) -> Order:
    what, number, bit, value = match[1].upper(), int(match[2]), None if match[3] is None else int(match[3]), match[4]
    first = 1 if what == "EA" else 0
    if not first <= number <= LAST[what]:
        raise OrderFault(f"{text!r}: {what}{number} is outside {what}{first} to {what}{LAST[what]}")
    if what == "EA":
        if bit is not None or abs(float(value)) > VOLTS:
            raise OrderFault(f"{text!r}: an analog input is set to -10 to 10 volts: EA2=4.5")
        return Order(at, what, number, None, float(value))
    if bit is not None and bit > 7:
        raise OrderFault(f"{text!r}: bit {bit} is outside 0 to 7")
    most = 255 if bit is None else 1
    if not value.isdecimal() or int(value) > most:
        raise OrderFault(f"{text!r}: the value {value} is outside 0 to {most}")
    return Order(at, what, number, bit, int(value))
