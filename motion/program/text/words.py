"""Words of the text form: one, a name, KEY=VALUE, a number in its range, one of several, yes or no.  Each raises Fault."""

import re
from collections.abc import Callable, Iterable
from enum import Enum

from motion.errors import MotionError
from motion.program.errors import TextError

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
LONG = re.compile(r"\d{100}")  # digits: longer than any number of a program, and below Python's limit of 4,300


class Fault(Exception):
    """Inside: key, what."""

    def __init__(self, key: str, what: str) -> None:
        self.key, self.what = key, what


def statement(raw: str, number: int, line: Callable[[list[str], int], None]) -> None:
    """One line without its comment, for a reader of its words; raises TextError with its number."""
    words = raw.partition("#")[0].split()
    if not words:
        return
    if any(map(LONG.search, words)):
        raise TextError(number, words[0], "a number of 100 digits and more")
    try:
        line(words, number)
    except Fault as fault:
        raise TextError(number, fault.key, fault.what) from None
    except TextError:
        raise
    except MotionError as error:
        raise TextError(number, words[0], str(error)) from error


def one(head: str, rest: list[str]) -> str:
    if len(rest) != 1:
        raise Fault(head, f"one word is needed, found {len(rest)}")
    return rest[0]


def name(head: str, text: str) -> str:
    if not NAME.fullmatch(text):
        raise Fault(head, f"{text!r} is not a name: letters, digits, _ . - and a letter first")
    return text


def key(text: str) -> tuple[str, str]:
    found, sign, value = text.partition("=")
    if not sign or not value:
        raise Fault(found, f"{text!r}: KEY=VALUE without blanks is needed")
    return found, value


def keys(words: Iterable[str]) -> dict[str, str]:
    """KEY=VALUE of each; a key given twice is a slip: one of both would act on nothing."""
    found: dict[str, str] = {}
    for each in words:
        head, value = key(each)
        if head in found:
            raise Fault(head, f"is given twice: {head}={found[head]} and {head}={value}")
        found[head] = value
    return found


def number(where: str, text: str, low: float, high: float, unit: str) -> float:
    try:
        value = float(text.removesuffix(unit) if unit and text.endswith(unit) else text)
    except ValueError:
        raise Fault(where, f"{text!r} is not a number") from None
    if not low <= value <= high:  # a NaN fails here too
        suffix = f" {unit}" if unit else ""
        raise Fault(where, f"{value:g}{suffix} is outside {low:g} .. {high:g}{suffix}")
    return value


def word(where: str, text: str, words: type[Enum]) -> Enum:
    try:
        return words(text)
    except ValueError:
        raise Fault(where, f"{text!r}; one of {', '.join(str(word.value) for word in words)}") from None


def yes(where: str, text: str) -> bool:
    if text not in ("yes", "no"):
        raise Fault(where, f"{text!r}; yes or no")
    return text == "yes"
