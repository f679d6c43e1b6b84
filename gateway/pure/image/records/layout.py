"""Layouts of records made of their classes: every field carries its struct code, and packer, unpacker and hash come from that.

All plain structs in native byte order: both sides run on one machine, and the layout's text goes into the hash of a region.
"""

import struct
import typing
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate
from operator import attrgetter
from typing import Annotated, Generic, Protocol, TypeVar, cast, get_args, get_origin

R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)


Convert = Callable[[object], object]


class _Maker(Protocol[R_co]):
    def __call__(self, *fields: object) -> R_co: ...


@dataclass(frozen=True, slots=True)
class Code:
    """Struct code of a field, following padding included; a code of several numbers ("12d") is a tuple.  read, write: conversions of a
    value that is not a plain number.
    """

    text: str
    read: object = None
    write: object = None

    @property
    def count(self) -> int:
        """How many numbers."""
        form = struct.Struct(f"={self.text}")
        return len(form.unpack(bytes(form.size)))


U8 = Annotated[int, Code("B")]
U16 = Annotated[int, Code("H")]
U32 = Annotated[int, Code("I")]
U64 = Annotated[int, Code("Q")]
I32 = Annotated[int, Code("i")]
I64 = Annotated[int, Code("q")]
F64 = Annotated[float, Code("d")]
Yes = Annotated[bool, Code("?")]


class Layout(Generic[R]):
    """The packed form of a class: its first fields, which carry a Code, in the order of the class."""

    def __init__(self, kind: type[R], title: str = "") -> None:
        hints = typing.get_type_hints(kind, include_extras=True)
        codes = [(name, code) for name, hint in hints.items() if (code := _code(hint)) is not None]
        if [name for name, _ in codes] != [*hints][: len(codes)]:
            raise TypeError(f"{kind.__name__}: packed fields come before those that are not")
        self.names = tuple(name for name, _ in codes)
        self.struct = struct.Struct("=" + "".join(code.text for _, code in codes))
        self.size, self.text = self.struct.size, f"{title} {self.struct.format}"
        self._codes = dict(codes)
        self._make = cast(_Maker[R], kind)
        values = attrgetter(*self.names)  # of a single name: the value itself
        self._values: Callable[[R], Sequence[object]] = values if len(self.names) > 1 else lambda record: (values(record),)
        self._reads = [(place, cast(Convert, code.read)) for place, (_, code) in enumerate(codes) if code.read is not None]
        self._writes = [(place, cast(Convert, code.write)) for place, (_, code) in enumerate(codes) if code.write is not None]
        ends = [*accumulate(code.count for _, code in codes)]
        self._spans = [slice(end - code.count, end) for end, (_, code) in zip(ends, codes, strict=True)]
        self._single = ends[-1] == len(codes)  # one number each

    @property
    def codes(self) -> str:
        """Without the mark of the byte order."""
        return self.struct.format[1:]

    def offset(self, name: str) -> int:
        """Where a field begins."""
        return struct.calcsize("=" + "".join(self._codes[before].text for before in self.names[: self.names.index(name)]))

    def code(self, name: str) -> str:
        """Struct code of a field."""
        return self._codes[name].text

    def pack(self, record: R) -> bytes:
        """A record as `size` bytes; struct.error for a number beyond its code."""
        values = [*self._values(record)]
        for place, write in self._writes:
            values[place] = write(values[place])
        if self._single:
            return self.struct.pack(*values)
        numbers: list[object] = []
        for value, span in zip(values, self._spans, strict=True):
            numbers += cast(Sequence[object], value) if span.stop - span.start > 1 else (value,)
        return self.struct.pack(*numbers)

    def unpack(self, data: bytes | memoryview, *others: object) -> R:
        """The reverse of `pack`; others: the fields that are not packed."""
        values = [*self.struct.unpack_from(data)]
        if not self._single:
            values = [values[span.start] if span.stop - span.start == 1 else tuple(values[span]) for span in self._spans]
        for place, read in self._reads:
            values[place] = read(values[place])
        return self._make(*values, *others)


def _code(hint: object) -> Code | None:
    marks = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
    return next((mark for mark in marks if isinstance(mark, Code)), None)
