"""Variables: cells, structures, arrays, and their validity.  Source: robotstar 2.2, 2.3, 2.6.

Validity is kept for each element.  A structure of which some element has been written counts as written; its other elements read as unset
individually and as 0 where the entire structure is used.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TypeAlias

from gateway.pure.languages.robotstar.faults import INDEX_RANGE, NO_READING, NO_VARIABLE, NO_WRITING, UNSET, WRONG_TYPES, StepFault
from gateway.pure.languages.robotstar.operands import HIGHEST, LOWEST
from motion.geometry.conventions import angles_zyx, rotation_zyx

Scalar: TypeAlias = int | float | str
NO_REAL = "value is outside the range of a real variable"
AXES = tuple(f"A{n}" for n in range(1, 25))
ELEMENTS: Mapping[str, tuple[str, ...]] = {
    "V": ("FRAME", "X", "Y", "Z", "A", "B", "C", *AXES),
    "P": ("MA", "AA", "PT", "FRAME", "X", "Y", "Z", "A", "B", "C", *AXES),
    "T": ("X", "Y", "Z", "RX", "RY", "RZ"),
}
INTEGERS = frozenset(("FRAME", "MA", "AA", "PT"))
GROUPS = {**dict.fromkeys("XYZ", "translation"), **dict.fromkeys("ABC", "orientation"), **dict.fromkeys(AXES, "axis"), "FRAME": "frame"}
TOOL_RAW = 16  # 4 x 4, row by row: 4, 8 and 12 are X, Y, Z (L795)


class Cell:
    """A number or a text; None: never written."""

    __slots__ = ("constant", "kind", "length", "value")

    def __init__(self, kind: str, value: Scalar | None = None, constant: bool = False, length: int = 0) -> None:
        self.kind, self.value, self.constant, self.length = kind, value, constant, length

    def read(self) -> Scalar:
        """The value; StepFault where it was never written."""
        if self.value is None:
            raise StepFault(UNSET)
        return self.value

    def write(self, value: Scalar) -> None:
        """COPY into it, with conversion."""
        if self.constant:
            raise StepFault(NO_VARIABLE)
        self.value = converted(value, self.kind, self.length)


class SystemCell(Cell):
    """A system variable: its value is asked for and handed on.  None for `get` or `put`: not readable, not writable."""

    __slots__ = ("get", "put")

    def __init__(self, kind: str, get: Callable[[], Scalar] | None, put: Callable[[Scalar], None] | None, length: int = 128) -> None:
        super().__init__(kind, None, False, length)
        self.get, self.put = get, put

    def read(self) -> Scalar:
        """StepFault where reading is not allowed."""
        if self.get is None:
            raise StepFault(NO_READING)
        return self.get()

    def write(self, value: Scalar) -> None:
        """StepFault where writing is not allowed."""
        if self.put is None:
            raise StepFault(NO_WRITING)
        self.put(converted(value, self.kind, self.length))


class Structure:
    """A vector, position or tool.  `parts` by element; None: never written."""

    __slots__ = ("constant", "kind", "parts", "raw", "readable", "writable")

    def __init__(self, kind: str, values: Mapping[str, float] | None = None, constant: bool = False, writable: bool = True) -> None:
        self.kind, self.constant, self.writable, self.readable = kind, constant, writable, True
        self.parts: dict[str, int | float | None] = dict.fromkeys(ELEMENTS[kind])
        self.raw: list[float | None] = [None] * (TOOL_RAW if kind == "T" else 0)
        for name, value in (values or {}).items():
            self.put(name, value)

    @property
    def valid(self) -> bool:
        """Whether any element has been written."""
        return any(value is not None for value in self.parts.values()) or any(value is not None for value in self.raw)

    def number(self, name: str) -> float:
        """Return an element of an entire structure: 0 where it was never written."""
        return self.parts[name] or 0

    def get(self, name: str) -> int | float:
        """One element; StepFault where it was never written."""
        if not self.readable:
            raise StepFault(NO_READING)
        value = self.parts[name]
        if value is None:
            raise StepFault(UNSET)
        return value

    def put(self, name: str, value: int | float) -> None:
        """Writes one element, with conversion."""
        number = converted(value, "I" if name in INTEGERS else "R", 0)
        assert not isinstance(number, str)
        self.parts[name] = number
        if self.kind == "T":
            self._to_raw(name)

    def check_writable(self) -> None:
        """StepFault for a constant or a system structure."""
        if self.constant:
            raise StepFault(NO_VARIABLE)
        if not self.writable:
            raise StepFault(NO_WRITING)

    def copy_from(self, other: "Structure") -> None:
        """All elements with their validity."""
        self.check_writable()
        if not other.readable:
            raise StepFault(NO_READING)
        if other.kind != self.kind:
            raise StepFault(WRONG_TYPES)
        if not other.valid:
            raise StepFault(UNSET)
        self.parts, self.raw = dict(other.parts), list(other.raw)

    # ---- components by number (COPY_OFFSETS) ---------------------------------------------------------------------------
    def components(self) -> int:
        """How many components there are by number."""
        return TOOL_RAW if self.kind == "T" else len(self.parts)

    def component(self, number: int) -> int | float:
        """Component 1..n; StepFault: unset or no such component."""
        self._check(number)
        if self.kind != "T":
            return self.get(ELEMENTS[self.kind][number - 1])
        value = self.raw[number - 1]
        if value is None:
            raise StepFault(UNSET)
        return value

    def set_component(self, number: int, value: int | float) -> None:
        """Writes component 1..n."""
        self._check(number)
        if self.kind != "T":
            self.put(ELEMENTS[self.kind][number - 1], value)
            return
        self.raw[number - 1] = float(value)
        if number in (4, 8, 12):
            self.parts["XYZ"[number // 4 - 1]] = float(value)
        else:
            self._angles_from_raw()

    def _check(self, number: int) -> None:
        if not 1 <= number <= self.components():
            raise StepFault(INDEX_RANGE)

    def _to_raw(self, name: str) -> None:
        if name in ("X", "Y", "Z"):
            self.raw["XYZ".index(name) * 4 + 3] = self.parts[name]
        else:
            rows = rotation_zyx(*(math.radians(self.number(each)) for each in ("RX", "RY", "RZ")))
            for at, value in zip((0, 1, 2, 4, 5, 6, 8, 9, 10), rows, strict=True):
                self.raw[at] = value
        for at, value in zip((12, 13, 14, 15), (0.0, 0.0, 0.0, 1.0), strict=True):
            self.raw[at] = value

    def _angles_from_raw(self) -> None:
        rows = [self.raw[at] for at in (0, 1, 2, 4, 5, 6, 8, 9, 10)]
        known = [value for value in rows if value is not None]
        if len(known) == 9:
            for name, angle in zip(
                ("RX", "RY", "RZ"),
                angles_zyx((known[0], known[1], known[2], known[3], known[4], known[5], known[6], known[7], known[8])),
                strict=True,
            ):
                self.parts[name] = math.degrees(angle)


class Array:
    """Elements 1..n of one type."""

    __slots__ = ("items",)

    def __init__(self, items: Sequence[Cell | Structure]) -> None:
        self.items = items

    def at(self, index: int) -> Cell | Structure:
        """Element 1..n; StepFault outside."""
        if not 1 <= index <= len(self.items):
            raise StepFault(INDEX_RANGE)
        return self.items[index - 1]


Variable: TypeAlias = Cell | Structure | Array
Names: TypeAlias = Mapping[str, Variable]


def converted(value: Scalar, kind: str, length: int) -> Scalar:
    """Return a value converted to another type.  Raise StepFault without a conversion.  Fractions are rounded to the nearest integer,
    halves away from 0."""
    if kind == "S":
        if not isinstance(value, str):
            raise StepFault(WRONG_TYPES)
        if length and len(value) > length:
            raise StepFault(f"the text has {len(value)} characters, the variable holds {length}")
        return value
    if isinstance(value, str):
        raise StepFault(WRONG_TYPES)
    if kind == "R":
        try:
            real = float(value)
        except OverflowError as error:
            raise StepFault(NO_REAL) from error
        if not math.isfinite(real):
            raise StepFault(NO_REAL)
        return real
    if isinstance(value, float):
        if not math.isfinite(value):
            raise StepFault("value is outside the range of an integer variable")
        value = math.floor(value + 0.5) if value >= 0 else math.ceil(value - 0.5)
    if not LOWEST <= value <= HIGHEST:
        raise StepFault(f"value {value} is outside the range of an integer variable")
    return value


def made(name: str, size: int | None, length: int, kind: str) -> Variable:
    """A fresh variable of a definition."""
    del name

    def one() -> Cell | Structure:
        return Structure(kind) if kind in ELEMENTS else Cell(kind, length=length)

    return one() if size is None else Array([one() for _ in range(size)])


def flat(name: str, variable: Variable) -> Iterable[tuple[str, Scalar | None]]:
    """Name and value of all that is in a variable, as `run --json` prints it.  Of structures the elements that matter."""
    if isinstance(variable, Array):
        for number, item in enumerate(variable.items, 1):
            yield from flat(f"{name}[{number}]", item)
    elif isinstance(variable, Structure):
        for element, value in variable.parts.items():
            if value is not None or element not in AXES:
                yield f"{name}.{element if element != 'FRAME' else 'Frame'}", value
    else:
        yield name, variable.value
