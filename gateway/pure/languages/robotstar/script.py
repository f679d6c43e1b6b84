"""The script of a run in virtual time: `S WHAT`, an order at a time.  Pure."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from gateway.pure.languages.base.requests import Ns

NS = 1_000_000_000


class OrderFault(ValueError):
    """An order of the script is not understood."""


@dataclass(frozen=True, slots=True)
class Order:
    """One order of the script.  `what`: E, M, EA, START, STOP, F1, F2, ACK, POWER, DRIVES."""

    at: Ns
    what: str
    place: tuple[int, int | None] = (0, None)
    value: float = 0.0
    program: str = ""


_SET = re.compile(r"(EA|E|M)(\d{1,4})(?:\.(\d))?=([+-]?\d+(?:\.\d+)?)", re.IGNORECASE)
VALUES = ("E", "M", "EA")  # orders that set a value
WORDS = ("START", "STOP", "F1", "F2", "ACK", "POWER", "DRIVES", "EXEC")


def orders(texts: Iterable[str]) -> list[Order]:
    """`S WHAT` for each text, in the order of time; OrderFault with a sentence."""
    found = [order for text in texts for order in _orders_of(text)]
    return sorted(found, key=lambda order: order.at)


def _orders_of(text: str) -> list[Order]:
    when, *rest = text.split()[:1] + text.split()[1:] or [""]
    if not re.fullmatch(r"\d{1,7}(\.\d+)?", when) or not rest:
        raise OrderFault(f'--at {text!r}: a time in seconds, a space and what happens, as in "1.5 E0.6=1"')
    at = round(float(when) * NS)
    found: list[Order] = []
    while rest:
        word = rest.pop(0)
        upper = word.upper()
        if upper in ("START", "DRIVES"):
            following = rest.pop(0) if rest and not _SET.fullmatch(rest[0]) and rest[0].upper() not in WORDS else ""
            found.append(_named(text, at, upper, following))
        elif upper in WORDS:
            found.append(Order(at, upper))
        else:
            found.append(_value(text, at, word))
    return found


def _named(text: str, at: Ns, word: str, following: str) -> Order:
    if word == "START":
        return Order(at, "START", program=following.strip('"'))
    if following.upper() not in ("ON", "OFF"):
        raise OrderFault(f"--at {text!r}: DRIVES OFF or DRIVES ON")
    return Order(at, "DRIVES", value=float(following.upper() == "ON"))


def _value(text: str, at: Ns, word: str) -> Order:
    found = _SET.fullmatch(word)
    if not found:
        raise OrderFault(f"--at {text!r}: {word}: E0.6=1 E0=255 M20=5 M20.3=1 EA2=4.5 START [P] STOP F1 F2 ACK POWER DRIVES OFF are known")
    area, place, bit, value = found[1].upper(), int(found[2]), found[3], float(found[4])
    low, high = {"E": (0, 39), "M": (0, 2047), "EA": (1, 24)}[area]
    if not low <= place <= high:
        raise OrderFault(f"--at {text!r}: {area}{place}: {low} .. {high}")
    least, most = (-10.0, 10.0) if area == "EA" else (0.0, 1.0 if bit else 255.0)
    if not least <= value <= most or (area != "EA" and not value.is_integer()) or (bit is not None and (area == "EA" or int(bit) > 7)):
        raise OrderFault(f"--at {text!r}: {word}: values {least:g} .. {most:g}, bits 0 .. 7")
    return Order(at, area, (place, None if bit is None else int(bit)), value)
