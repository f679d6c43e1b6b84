"""Conditions of a PIC program as chains of the scan engine: brackets make AND before OR, NOT goes down to the operands."""

from collections.abc import Iterator
from dataclasses import dataclass

from gateway.pure.languages.plc.commands import Code, Command

INPUTS, OUTPUTS, FLAGS, FIXED, ERROR, SIZE = 0, 128, 256, 384, 385, 386  # bytes of the memory of the scan
ZERO, ONE = 1, 2  # bits of FIXED


@dataclass(frozen=True, slots=True)
class Operand:
    """A bit of the memory."""

    byte: int
    mask: int
    inverted: bool = False


@dataclass(frozen=True, slots=True)
class Linked:
    """All of the parts (AND), or any (OR)."""

    all: bool
    parts: "tuple[Operand | Linked, ...]"


Expression = Operand | Linked


def constant(value: int) -> Operand:
    """0 or 1."""
    return Operand(FIXED, ONE if value else ZERO)


def inverted(expression: Expression) -> Expression:
    """NOT of it."""
    if isinstance(expression, Operand):
        return Operand(expression.byte, expression.mask, not expression.inverted)
    return Linked(not expression.all, tuple(inverted(part) for part in expression.parts))


def joined(parts: list[Expression], *, every: bool) -> Expression:
    """AND or OR of them; of one it is itself."""
    return parts[0] if len(parts) == 1 else Linked(every, tuple(parts))


def chain(expression: Expression, line: int) -> Iterator[Command]:
    """Commands whose result is the expression."""
    yield Command(Code.BEGIN, line)
    yield from _links(expression, every=True, line=line)


def _links(expression: Expression, *, every: bool, line: int) -> Iterator[Command]:
    if isinstance(expression, Operand):
        codes = (Code.AND, Code.AND_NOT) if every else (Code.OR, Code.OR_NOT)
        yield Command(codes[expression.inverted], line, byte=expression.byte, mask=expression.mask)
        return
    yield Command(Code.OPEN_AND if every else Code.OPEN_OR, line)
    for part in expression.parts:
        yield from _links(part, every=expression.all, line=line)
    yield Command(Code.CLOSE, line)
