"""Values of a running program and the functions that translated programs call."""

import math
from collections.abc import Callable, Iterable
from typing import NoReturn, cast

from gateway.pure.languages.baps2.demands import Point
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.types import CODE_PAGE, TEXT_SIZE

LOWEST, HIGHEST, MOST_REAL = -(2**31), 2**31 - 1, 3.4028235e38
Scalar = int | float | str


class Array:
    """Elements from `low` to `high`."""

    __slots__ = ("high", "items", "low")

    def __init__(self, low: int, high: int, item: object) -> None:
        self.low, self.high = low, high
        self.items: list[object] = [item] * (high - low + 1)

    def get(self, index: int) -> object:
        """An element; runtime error outside the bounds."""
        if not self.low <= index <= self.high:
            raise fault(210, f"{index} is not in {self.low}..{self.high}")
        return self.items[index - self.low]

    def set(self, index: int, value: object) -> None:
        """Sets an element."""
        if not self.low <= index <= self.high:
            raise fault(210, f"{index} is not in {self.low}..{self.high}")
        self.items[index - self.low] = value

    def fill(self, value: "Array | list[object] | str") -> None:
        """Takes over all elements, or a text followed by blanks."""
        if isinstance(value, Array):
            self.items[:] = value.items
        elif isinstance(value, list):
            self.items[:] = value
        else:
            size = len(self.items)
            self.items[:] = list(value[:size].ljust(size))

    def copy(self) -> "Array":
        """The same elements again."""
        other = Array(self.low, self.high, None)
        other.items = list(self.items)
        return other

    def text(self) -> str:
        """The characters of an array of them."""
        return "".join(map(str, self.items))


class KeptArray(Array):
    """Teach points: each that is set goes into the point file."""

    __slots__ = ("_keep",)

    def __init__(self, low: int, items: "list[tuple[float, ...] | None]", keep: Callable[[int, tuple[float, ...]], None]) -> None:
        super().__init__(low, low + len(items) - 1, None)
        self.items[:] = items
        self._keep = keep

    def set(self, index: int, value: object) -> None:
        """Sets an element."""
        super().set(index, value)
        self._kept(index, value)

    def fill(self, value: "Array | list[object] | str") -> None:
        """Takes over all elements."""
        super().fill(value)
        for index, item in enumerate(self.items, self.low):
            self._kept(index, item)

    def _kept(self, index: int, value: object) -> None:
        if isinstance(value, tuple):
            self._keep(index, value)


class Ref:
    """A variable passed by reference."""

    __slots__ = ("get", "set")

    def __init__(self, get: Callable[[], object], set: Callable[[object], None]) -> None:
        self.get, self.set = get, set


def filled(low: int, high: int, value: str) -> Array:
    """An array of characters made of a text."""
    array = Array(low, high, " ")
    array.fill(value)
    return array


def element(array: Array, index: int) -> Ref:
    """An element passed by reference."""
    array.get(index)
    return Ref(lambda: array.get(index), lambda value: array.set(index, value))


def part(whole: Ref, index: int, size: int) -> Ref:
    """A component of a point passed by reference."""
    return Ref(lambda: component(whole.get(), index), lambda value: whole.set(with_component(whole.get(), index, size, value)))


def sign(whole: Ref, index: int) -> Ref:
    """A character of a TEXT passed by reference."""
    letter(str(whole.get()), index)
    return Ref(lambda: letter(str(whole.get()), index), lambda value: whole.set(lettered(str(whole.get()), index, str(value))))


class Shared:
    """The PUBLIC variables of a program; attributes are set by the translated program."""


def overflow() -> NoReturn:
    """Raise the error of a result beyond a 32-bit integer."""
    raise fault(208)


def quotient(a: int, b: int) -> int:
    """INTEGER division, truncated (L9582-9586)."""
    if b == 0:
        raise fault(209)
    value = abs(a) // abs(b)
    value = value if (a < 0) == (b < 0) else -value
    return value if value <= HIGHEST else overflow()


def modulo(a: int, b: int) -> int:
    """MOD, never negative: -1 MOD 65536 is 65535 (L9636-9639)."""
    if b == 0:
        raise fault(209)
    return a % abs(b)


def divide(a: float, b: float) -> float:
    """REAL division."""
    if b == 0:
        raise fault(209)
    return real(a / b)


def real_overflow() -> NoReturn:
    """Raise the error of a result beyond a 32-bit REAL."""
    raise fault(211)


def real(value: float) -> float:
    """A REAL in its range."""
    try:
        value = float(value)
    except OverflowError:
        raise fault(211) from None
    if not -MOST_REAL <= value <= MOST_REAL:
        raise fault(211)
    return value


def whole(value: float) -> int:
    """ROUND; halves away from zero."""
    found = math.floor(abs(value) + 0.5) if math.isfinite(value) else overflow()
    found = found if value >= 0 else -found
    return found if LOWEST <= found <= HIGHEST else overflow()


def truncated(value: float) -> int:
    """TRUNC."""
    found = int(value) if math.isfinite(value) else overflow()
    return found if LOWEST <= found <= HIGHEST else overflow()


def root(value: float) -> float:
    """SQRT."""
    if value < 0:
        raise fault(218, "root of a negative number")
    return math.sqrt(value)


def arc_tangent(value: float) -> float:
    """In degrees."""
    return math.degrees(math.atan(value))


def sine(value: float) -> float:
    """Of degrees."""
    return math.sin(math.radians(value))


def cosine(value: float) -> float:
    """Of degrees."""
    return math.cos(math.radians(value))


def code(text: str) -> int:
    """ORD: the octet of a character."""
    return text[0].encode(CODE_PAGE, "replace")[0] if text else 0


def character(number: int) -> str:
    """CHR: the character of an octet (L777)."""
    return bytes((number % 256,)).decode(CODE_PAGE)


def text(value: "str | Array") -> str:
    """A TEXT: 80 characters at most."""
    return (value.text() if isinstance(value, Array) else value)[:TEXT_SIZE]


def letter(value: str, index: int) -> str:
    """Return a character of a TEXT; NUL after its end."""
    if not 1 <= index <= TEXT_SIZE:
        raise fault(210, f"{index} is not in 1..{TEXT_SIZE}")
    return value[index - 1] if index <= len(value) else "\0"


def lettered(value: str, index: int, new: str) -> str:
    """The TEXT with one character replaced."""
    if not 1 <= index <= TEXT_SIZE:
        raise fault(210, f"{index} is not in 1..{TEXT_SIZE}")
    value = value.ljust(index - 1)
    return value[: index - 1] + new[:1] + value[index:]


def point(values: object) -> tuple[float, ...]:
    """A point that is defined."""
    if not isinstance(values, tuple) or any(value is None for value in values):
        raise fault(200)
    return values


def component(values: object, index: int) -> float:
    """One component of a point."""
    value = values[index] if isinstance(values, tuple) and index < len(values) else None
    if value is None:
        raise fault(200)
    return float(value)


def with_component(values: object, index: int, size: int, value: object) -> Point:
    """The point with one component replaced; the others of a point not defined stay so."""
    old: list[float | None] = list(values) if isinstance(values, tuple) else []
    old += [None] * (max(size, index + 1) - len(old))
    old[index] = cast(float, value)
    return tuple(old)


def joined(sign: str, a: object, b: object) -> tuple[float, ...]:
    """Sum or difference of points."""
    left, right = point(a), point(b)
    if len(left) != len(right):
        raise fault(221, f"{len(left)} and {len(right)}")
    return tuple(real(x + y if sign == "+" else x - y) for x, y in zip(left, right, strict=True))


def scaled(a: object, factor: float) -> tuple[float, ...]:
    """A point times a number."""
    return tuple(real(value * factor) for value in point(a))


def letters_of(target: object) -> tuple[str, int]:
    """Characters and last index of an array of them or a TEXT."""
    if isinstance(target, Array):
        return target.text(), target.high
    return str(target), TEXT_SIZE


def int_asc(number: int, target: object, index: int, length: int) -> tuple[object, int]:
    """INT_ASC (L2284-2348): right-aligned in blanks; (target, error), the target as it was on an error."""
    low = target.low if isinstance(target, Array) else 1
    _, high = letters_of(target)
    digits = str(number)
    error = _range_error(low, high, index, length)
    if error == 0 and abs(number) > HIGHEST:
        error = -4
    if error == 0 and len(digits) > length:
        error = -3
    if error:
        return target, error
    for offset, sign in enumerate(digits.rjust(length)):
        target = _set_letter(target, index + offset, sign)
    return target, 0


def _set_letter(target: object, index: int, sign: str) -> object:
    if isinstance(target, Array):
        target.set(index, sign)
        return target
    return lettered(str(target), index, sign)


def _range_error(low: int, high: int, index: int, length: int) -> int:
    if length <= 0:
        return -5 if length < 0 else -6
    if not low <= index <= high:
        return -1
    return -2 if index + length - 1 > high else 0


def asc_int(source: object, number: int, index: int, length: int) -> tuple[int, int]:
    """ASC_INT (L2352-2421): (number, error), the number as it was on an error."""
    low = source.low if isinstance(source, Array) else 1
    signs, high = letters_of(source)
    if error := _range_error(low, high, index, length):
        return number, error
    part = signs[index - low : index - low + length]
    sign, rest = (part[:1], part[1:]) if part[:1] in ("+", "-") and part else ("", part)
    digits = ""
    for each in rest:
        if each not in "0123456789":
            break
        digits += each
    if not digits:
        return number, -7
    value = int(digits[:12]) * (-1 if sign == "-" else 1)
    return (value, 0) if abs(value) <= HIGHEST else (number, -4)


def numbers_of(values: Iterable[object]) -> tuple[float, ...]:
    """Return a point of numbers; a number beyond REAL is a runtime error."""
    return tuple(real(value) if isinstance(value, int | float) else component((value,), 0) for value in values)
