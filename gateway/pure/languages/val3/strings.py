"""Instructions on strings: characters counted from 0, at most 128 bytes.  Source: VAL 3 reference 3.4, L2033-2288; doubts D06, D07."""

import functools
import math
import re

from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.values import cut

NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)", re.ASCII)
START = re.compile(r"[+-]?\.?\d", re.ASCII)
Place = tuple[list[object], int]


def join(first: str, second: str) -> str:
    """+: cut to 128 bytes."""
    return cut(first + second)


def f_to_string(form: str, value: float) -> str:
    """size.precision; zeros at the end of the fraction become blanks."""
    size, precision = _sizes(form)
    text = f"{value:.{precision}f}"
    if float(text) == 0 and text.startswith("-"):
        text = text[1:]
    if "." in text:
        kept = text.rstrip("0")
        kept = kept[:-1] if kept.endswith(".") else kept
        text = kept.ljust(len(text))  # blanks whatever the size (L2068)
    return cut(text.rjust(size))


@functools.lru_cache(maxsize=256)
def _sizes(form: str) -> tuple[int, int]:
    size, _, precision = form.strip().partition(".")
    if not all(part.isdecimal() or part == "" for part in (size, precision)):
        raise Rte(70, f"format {form!r}: size.precision expected")
    return min(int(size or 0), 128), min(int(precision or 0), 30)


def finite(text: str) -> float | None:
    """The number a text is; None: it is none, or none that a num holds."""
    try:
        value = float(text) if text.isascii() and "_" not in text else math.nan
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def f_to_num(text: str, value: Place, report: Place) -> str:
    """The rest of the text from the next number on; the text itself where no number is in front."""
    match = NUMBER.match(text)
    found = None if match is None else finite(match.group(1))
    report[0][report[1]] = found is not None
    if match is None or found is None:
        return text
    value[0][value[1]] = found
    rest = text[match.end() :]
    following = START.search(rest)
    return rest[following.start() :] if following else ""


def f_chr(code: float) -> str:
    """Return the character; "" for an invalid code."""
    whole = math.floor(code + 0.5)
    return chr(whole) if 0 <= whole < 0x110000 and not 0xD800 <= whole < 0xE000 else ""


def f_asc(text: str, position: float) -> float:
    """Return the code; -1 outside the text."""
    at = math.floor(position + 0.5)
    return float(ord(text[at])) if 0 <= at < len(text) else -1.0


def _whole(value: float, what: str) -> int:
    whole = math.floor(value + 0.5)
    if whole < 0:
        raise Rte(70, f"{what} {value:g}")
    return whole


def f_left(text: str, size: float) -> str:
    """70 below 0."""
    return text[: _whole(size, "size")]


def f_right(text: str, size: float) -> str:
    """70 below 0."""
    count = _whole(size, "size")
    return text[max(len(text) - count, 0) :]


def f_mid(text: str, size: float, position: float) -> str:
    """70 below 0."""
    start = _whole(position, "position")
    return text[start : start + _whole(size, "size")]


def f_insert_text(text: str, insertion: str, position: float) -> str:
    """Insert before a place; append past the end."""
    at = _whole(position, "position")
    return cut(text[:at] + insertion + text[at:])


def f_delete_text(text: str, size: float, position: float) -> str:
    """No effect past the end."""
    at, count = _whole(position, "position"), _whole(size, "size")
    return text[:at] + text[at + count :]


def f_replace(text: str, replacement: str, size: float, position: float) -> str:
    """No effect past the end."""
    at, count = _whole(position, "position"), _whole(size, "size")
    return text if at > len(text) else cut(text[:at] + replacement + text[at + count :])


def f_find(text: str, wanted: str) -> float:
    """-1: not there."""
    return float(text.find(wanted))


def f_len(text: str) -> float:
    """Characters."""
    return float(len(text))
