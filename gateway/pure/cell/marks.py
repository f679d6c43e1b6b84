"""Marks of a cell table's columns: range, unit, pattern and spelling of a key, as annotations of the dataclass field.

Ranges are those of annotated_types; the marks here add what else a file needs.  A mark with a hook `__get_pydantic_core_schema__`
adds its part to the schema that `gateway.cell_file.validation` makes of the tables; nothing here imports the validator.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Literal, Protocol

from annotated_types import MaxLen


class Schema(Protocol):
    """The schema of a type, made by the validator."""

    def __call__(self, source: object, /) -> Mapping[str, object]: ...


@dataclass(frozen=True, slots=True)
class Unit:
    """The unit of a value; {u}: the unit of its axis."""

    text: str


@dataclass(frozen=True, slots=True)
class Why:
    """The reason for the range of a value: the hint of a fault beyond it."""

    text: str


@dataclass(frozen=True, slots=True)
class Pattern:
    """The form of a text, and the words that describe it."""

    regex: str
    allowed: str

    def __get_pydantic_core_schema__(self, source: object, handler: Schema) -> Mapping[str, object]:
        return {**handler(source), "pattern": self.regex}


@dataclass(frozen=True, slots=True)
class Spelled:
    """Another spelling of the same value, turned into the usual one before it is judged."""

    read: Callable[[object], object]

    def __get_pydantic_core_schema__(self, source: object, handler: Schema) -> Mapping[str, object]:
        return {"type": "function-before", "function": {"type": "no-info", "function": self.read}, "schema": handler(source)}


@dataclass(frozen=True, slots=True)
class Loaded:
    """Collected by the loader: no key of the file, and judged by the loader."""

    read: Callable[[object], object]

    def __get_pydantic_core_schema__(self, source: object, handler: Schema) -> Mapping[str, object]:
        return {"type": "function-plain", "function": {"type": "no-info", "function": self.read}}


@dataclass(frozen=True, slots=True)
class Registered:
    """One of the names the registry has in this table of its own (`gateway.registry`)."""

    table: str

    def __get_pydantic_core_schema__(self, source: object, handler: Schema) -> Mapping[str, object]:
        return {**handler(source), "metadata": {"registered": self.table}}


def listed(given: object) -> object:
    """One name is a list of one."""
    return [given] if isinstance(given, str) else given


def plain_number(value: object) -> object:
    """`true` and 3.0 are equal to legal numbers and none."""
    return repr(value) if isinstance(value, bool | float) else value


def frozen(value: object) -> object:
    """Lists, at any depth, as tuples."""
    if isinstance(value, Mapping):
        return {key: frozen(each) for key, each in value.items()}
    return tuple(frozen(each) for each in value) if isinstance(value, list | tuple) else value


BAUDS = "300|600|1200|2400|4800|9600|19200|38400|57600|115200"
OWN_NAME = r"[a-z]\w*(\.\w+)+"  # as gateway.pure.image.addresses reads it
OnLoss = Literal["hold", "finish_move", "stop_on_path", "quick_stop"]
Name = Annotated[str, Pattern(r"^[A-Za-z0-9][A-Za-z0-9_-]*$", "letters, digits, _ and -")]
Bind = Annotated[str, Pattern(r"^\S+:\d{1,5}$", "address:port")]
Percent = Annotated[str, Pattern(r"^(100|\d{1,2})(\.\d+)? %$", '"0 %".."100 %"')]
Robots = Annotated[tuple[str, ...], Spelled(listed)]
OneRobot = Annotated[tuple[str, ...], MaxLen(1), Spelled(listed)]
