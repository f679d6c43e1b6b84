"""Initial values of data files: an invalid value of its type is reported at load, with its line.  Source: N01, L954-1000, L2041."""

import math
import re
from collections.abc import Iterator

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import Position
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.initial_values import BOOLS, number, word
from gateway.pure.languages.val3.model import MOST_TOGETHER, STRUCTURED, WORDS, Application, Declaration, Initial, Type, UserType
from gateway.pure.languages.val3.values import LONGEST

NUMBERS = re.compile(
    r"r?[xyz]|j\d+|[oc]time|open|close|ioOpen|ioClose|accel|vel|decel|[tr]vel|[tr]max|leave|reach"
)  # attributes of structured types


def check_values(app: Application, faults: Faults) -> None:
    """Of global data and of local variables."""
    own = [*app.data.values(), *(local for program in app.programs.values() for local in program.locals)]
    weights = dict[int, int]()
    for declared in own:
        if (count := weight(declared, weights)) > MOST_TOGETHER:
            text = f"'{declared.name}' : {count} values with those of its components, {MOST_TOGETHER} at most"
            faults.error("val3-value", declared.place, text)
        for place, text, error in _wrong(declared, declared.type):
            say = faults.error if error else faults.warning
            say("val3-value", Position(declared.file, place.line, place.column), f"'{declared.name}' : {text}")


def weight(declared: Declaration, known: dict[int, int]) -> int:
    """How many values it has at its start, with those of its components; known: of the user types so far, by identity."""
    kind, each = declared.type, 1
    if isinstance(kind, UserType):
        if id(kind) not in known:
            known[id(kind)] = sum(weight(field, known) for field in kind.fields.values())
        each = known[id(kind)]
    return each * (math.prod(declared.sizes) if declared.dims else len(declared.values))


def _wrong(declared: Declaration, kind: Type) -> Iterator[tuple[Initial | Declaration, str, bool]]:
    """Place, text, whether it is an error."""
    for value in declared.values:
        if isinstance(kind, UserType):
            yield from _wrong_fields(value, kind)
        elif kind == "string":
            if len(value.attributes.get("value", "").encode("utf-8", "replace")) > LONGEST:
                yield value, f"a string has at most {LONGEST} bytes, the rest is cut off", False
        else:
            yield from ((value, text, True) for text in _wrong_value(value, kind))


def _wrong_fields(value: Initial, kind: UserType) -> Iterator[tuple[Initial | Declaration, str, bool]]:
    for name, given in value.fields.items():
        wanted = kind.fields.get(name)
        if wanted is None:
            yield given, f"the type {kind} has no field '{name}', its value is not used", False
        elif (given.type_name, given.dims) != (wanted.type_name, wanted.dims) and not _same_type(given, wanted):
            yield given, f"field '{name}' : invalid type ({given.type_name}), {kind} has {wanted.type_name}", True
        else:
            yield from _wrong(given, wanted.type)


def _same_type(given: Declaration, wanted: Declaration) -> bool:
    """User types have a name in each application that uses them."""
    return given.dims == wanted.dims and isinstance(wanted.type, UserType)


def _wrong_value(value: Initial, kind: str) -> Iterator[str]:
    """What is wrong with it."""
    given = value.attributes
    if kind == "bool" and given.get("value", "false").lower() not in BOOLS:
        yield f"{given['value']!r} is neither true nor false"
    fields = {"value": given.get("value", "0")} if kind == "num" else given if kind in STRUCTURED else {}
    for name, text in fields.items():
        try:
            if name in WORDS:
                word(name, text)
            elif kind == "num" or NUMBERS.fullmatch(name):
                number(text)
        except Rte as fault:
            yield fault.detail
