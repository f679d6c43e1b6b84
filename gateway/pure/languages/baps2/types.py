"""The types of BAPS2 and what may be assigned to what (rho 3 releases L1948-1970, 2476-2494; AX-691)."""

from dataclasses import dataclass, replace

NUMBERS = ("INTEGER", "REAL")
LETTERS = ("CHAR", "TEXT")
POINTS = ("POINT", "JC_POINT")
SCALARS = ("INTEGER", "REAL", "BINARY", "CHAR", "TEXT", "POINT", "JC_POINT", "WC_FRAME")
TEXT_SIZE = 80
CODE_PAGE = "cp437"  # of the control: each octet is a character (AX-1748)


@dataclass(frozen=True, slots=True)
class Type:
    """`base` as the word table calls it.  `kinematic` of points; bounds of an array; `element` of a FILE."""

    base: str
    kinematic: str = ""
    low: int | None = None
    high: int | None = None
    element: str = ""

    def __eq__(self, other: object) -> bool:
        if self is other:  # most types of a program are the few below
            return True
        return isinstance(other, Type) and self.base == other.base and self._rest() == other._rest()

    def __hash__(self) -> int:
        return hash((self.base, *self._rest()))

    def _rest(self) -> tuple[object, ...]:
        return self.kinematic, self.low, self.high, self.element

    @property
    def is_array(self) -> bool:
        """Whether it has elements."""
        return self.low is not None

    @property
    def item(self) -> "Type":
        """Type of an element."""
        return replace(self, low=None, high=None)

    def __str__(self) -> str:
        bounds = f"ARRAY[{self.low}..{self.high}] " if self.is_array else ""
        return f"{bounds}{self.kinematic + '.' if self.kinematic else ''}{self.base}"


INTEGER, REAL, BINARY, CHAR, TEXT = (Type(base) for base in ("INTEGER", "REAL", "BINARY", "CHAR", "TEXT"))
FRAME, NONE = Type("WC_FRAME"), Type("")  # NONE: type of faulty parts; it fits everything
DEFAULTS = {"INTEGER": "0", "REAL": "0.0", "BINARY": "0", "CHAR": "' '", "TEXT": "''"}


def default_of(kind: Type) -> str:
    """What a variable has at the start: Python text.  A point is not defined."""
    item = DEFAULTS.get(kind.base, "None")
    return f"Array({kind.low}, {kind.high}, {item})" if kind.is_array else item


def fits(target: Type, value: Type, constant: object = None) -> bool:
    """Return whether a value can be assigned.  `constant`: the value, where it is known."""
    if not (target.base and value.base):  # NONE, the type without a base
        return True
    if target.is_array or value.is_array:
        if target.is_array and target.base == "CHAR" and value.base in LETTERS:
            return not value.is_array or (target.low, target.high) == (value.low, value.high)
        if not target.is_array and target.base == "TEXT":
            return value.base == "CHAR"
        return target == value
    if target.base == "REAL":
        return value.base in NUMBERS
    if target.base == "BINARY":
        return value.base == "BINARY" or (value.base == "INTEGER" and constant in (0, 1))
    if target.base == "CHAR":
        return value.base == "CHAR" or (value.base == "TEXT" and isinstance(constant, str) and len(constant) == 1)
    if target.base == "TEXT":
        return value.base in LETTERS
    if target.base in POINTS:
        return target.base == value.base and (not target.kinematic or not value.kinematic or target.kinematic == value.kinematic)
    return target.base == value.base


def same(parameter: Type, argument: Type) -> bool:
    """Whether a variable can be passed by reference."""
    if not (parameter.base and argument.base):
        return True
    if parameter.is_array or argument.is_array:
        return parameter.base == argument.base and (parameter.low, parameter.high) == (argument.low, argument.high)
    if parameter.base in POINTS:
        return fits(parameter, argument)
    return parameter.base == argument.base or {parameter.base, argument.base} <= {"FILE", "BNR_FILE"}
