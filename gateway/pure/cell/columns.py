"""The columns of a cell table as data: key, type, range, unit, default, read from the annotations of its dataclass.

Messages, `axisgate explain`, the reference of the cell file and the validator's key names come from here.
"""

import dataclasses
import functools
import types
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Literal, get_args, get_origin

import annotated_types as ranges

from gateway.pure.cell.marks import Loaded, Pattern, Unit, Why


@dataclass(frozen=True, slots=True)
class Column:
    """One key of a table."""

    name: str  # of the attribute
    annotation: object  # with None and containers, without the marks of the column itself
    marks: tuple[object, ...] = ()
    required: bool = True
    default: object = None

    @property
    def key(self) -> str:
        """As the file spells it."""
        return key_of(self.name)

    @property
    def unit(self) -> str:
        return next((mark.text for mark in self.marks if isinstance(mark, Unit)), "")

    @property
    def why(self) -> str:
        """Return the reason for the range."""
        return next((mark.text for mark in self.marks if isinstance(mark, Why)), "")

    @property
    def range(self) -> str:
        """The allowed values in words; empty: all of the type."""
        low = high = ""
        for mark in self.marks:
            match mark:
                case Pattern():
                    return mark.allowed
                case ranges.Ge():
                    low = f"{mark.ge}"
                case ranges.Gt():
                    low = f"> {mark.gt}"
                case ranges.Le():
                    high = f"{mark.le}"
        if low and high:
            return f"{low}..{high}"
        return low if low.startswith(">") else f">= {low}" if low else high and f"<= {high}"

    @property
    def loaded(self) -> bool:
        """Collected by the loader: no key of the file."""
        return any(isinstance(mark, Loaded) for mark in self.marks)

    @property
    def table(self) -> type | None:
        """The dataclass of a table in a table, a list of them or tables by name."""
        bare = bare_type(self.annotation)
        inner = get_args(bare) if get_origin(bare) in (tuple, Mapping) else (bare,)
        each = [each for each in inner if each is not Ellipsis]
        kind = bare_type(each[-1]) if each else None
        return kind if isinstance(kind, type) and dataclasses.is_dataclass(kind) else None


def key_of(name: str) -> str:
    """`from_` is the attribute of the key `from`: Python keeps the word."""
    return name.removesuffix("_")


@functools.cache
def columns(table: type) -> Mapping[str, Column]:
    """Columns of a table by their keys, in the order of the class."""
    hints = typing.get_type_hints(table, include_extras=True)
    return {column.key: column for column in _columns(table, hints)}


def column_of(table: type, key: str) -> Column | None:
    return columns(table).get(key)


def parts_of(annotation: object, name: str = "") -> Column:
    """Type and marks of an annotation inside of another: the number of a list, the value of a mapping."""
    if get_origin(annotation) is Annotated:
        bare, *marks = get_args(annotation)
        return Column(name, bare, tuple(marks))
    return Column(name, annotation)


def bare_type(annotation: object) -> object:
    """Without Optional and Annotated; None where nothing is inside: a choice of words."""
    if get_origin(annotation) is Annotated:
        return bare_type(get_args(annotation)[0])
    if get_origin(annotation) in (typing.Union, types.UnionType):
        return bare_type(next(each for each in get_args(annotation) if each is not types.NoneType))
    return None if get_origin(annotation) is Literal else annotation


def _columns(table: type, hints: Mapping[str, object]) -> Iterator[Column]:
    for field in dataclasses.fields(table):
        part = parts_of(hints[field.name], field.name)
        factory = field.default_factory
        default = field.default if factory is dataclasses.MISSING else factory()
        required = default is dataclasses.MISSING
        yield dataclasses.replace(part, required=required, default=None if required else default)
