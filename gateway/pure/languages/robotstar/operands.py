"""Operands of a step: numbers, texts, references to variables, equates.  Source: robotstar 2.1, L947-957, L3939-3977, L4156-4198."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from gateway.pure.languages.base.near import hint_with, meant

LOWEST, HIGHEST = -(2**31), 2**31 - 1
INDEX_SYNTAX, NESTED = "Syntax error in the index!", "Nesting not allowed!"


@dataclass(frozen=True, slots=True)
class Number:
    """A literal.  `bits`: hexadecimal or binary, a pattern of 32 bits."""

    value: int | float
    bits: bool = False


@dataclass(frozen=True, slots=True)
class Text:
    """A literal in quotes."""

    value: str


@dataclass(frozen=True, slots=True)
class Ref:
    """A name: variable, label or program.  Names are compared in upper case."""

    name: str
    index: int | str | None = None  # number, or the name of an integer variable
    element: str = ""
    length: int | None = None  # of a string, in its definition


@dataclass(frozen=True, slots=True)
class Equate:
    """#NAME; relations and conditions as written after the #."""

    name: str


@dataclass(frozen=True, slots=True)
class Blank:
    """<text>: a place of a printed listing that has no value."""

    text: str


Operand: TypeAlias = Number | Text | Ref | Equate | Blank


class OperandFault(ValueError):
    """The text is not an operand.  `hint`: the remedy."""

    def __init__(self, text: str, hint: str = "") -> None:
        super().__init__(text)
        self.hint = hint


_HEX = re.compile(r"[0-9A-F]+H", re.IGNORECASE)
_BINARY = re.compile(r"[01]+B", re.IGNORECASE)
_INTEGER = re.compile(r"[+-]?\d+")
_REAL = re.compile(r"[+-]?(\d+\.\d*|\.\d+|\d+)([eE][+-]?\d+)?")
_NAME = re.compile(r"[^\W\d][\w$-]*|[\w$][\w$-]*|\$[\w$-]*")
RELATIONS = ("<>", "<=", ">=", "<", ">", "=")


def operand(text: str, equates: Mapping[str, str] | None = None) -> Operand:
    """Reads one operand; OperandFault with a sentence."""
    text = text.strip()
    if text.startswith('"'):
        return _text(text)
    if text.startswith("<") and text.endswith(">"):
        return Blank(text[1:-1].strip())
    if text.startswith("#"):
        return _equate(text, equates or {})
    return _number(text) or _reference(text)


def _text(text: str) -> Text:
    if len(text) < 2 or not text.endswith('"') or '"' in text[1:-1]:
        raise OperandFault(f"{text}: the closing quotation mark is missing or there is one too many")
    return Text(text[1:-1])


def _equate(text: str, equates: Mapping[str, str]) -> Equate:
    name = text[1:].strip().upper()
    if name in RELATIONS or name in ("=0", "=1"):
        return Equate(name)
    if name not in equates:
        near = [name[::-1]] if name in ("=>", "=<") else [f"={name}"] if name in ("0", "1") else meant(name, equates)
        raise OperandFault(f"{text}: no such system equate", hint_with([f"#{each}" for each in near]))
    return Equate(equates[name])


def _number(text: str) -> Number | None:
    if _HEX.fullmatch(text):
        return _pattern(text, int(text[:-1], 16))
    if _BINARY.fullmatch(text):
        return _pattern(text, int(text[:-1], 2))
    if _INTEGER.fullmatch(text):
        if len(text) > 300:
            raise OperandFault(f"a number of {len(text)} digits is outside every range")
        return Number(int(text))
    if _REAL.fullmatch(text):
        value = float(text)
        if value in (float("inf"), float("-inf")):
            raise OperandFault(f"{text} is outside the range of a real number")
        return Number(value)
    return None


def _pattern(text: str, value: int) -> Number:
    if value > 0xFFFFFFFF:
        raise OperandFault(f"{text}: more than 32 bits")
    return Number(signed(value), bits=True)


def signed(value: int) -> int:
    """32 bits as a signed number."""
    value &= 0xFFFFFFFF
    return value - 2**32 if value > HIGHEST else value


def _reference(text: str) -> Ref:
    found = _NAME.match(text)
    if not found:
        hint = f"did you mean #{text}?" if text in RELATIONS else ""
        raise OperandFault(f"{text or 'nothing'}: neither a number, a name nor a text in quotation marks", hint)
    name, rest = found.group().upper(), text[found.end() :].strip()
    index: int | str | None = None
    length: int | None = None
    if rest.startswith("[") or "]" in rest:
        index, rest = _index(rest)
    if rest.startswith("("):
        inner, closed, rest = rest[1:].partition(")")
        if not closed or not inner.strip().isdecimal() or len(inner) > 9:
            raise OperandFault(f"{text}: the length of a string is a number in round brackets")
        length, rest = int(inner), rest.strip()
    element = ""
    if rest.startswith("."):
        element, rest = rest[1:].strip().upper(), ""
        if not re.fullmatch(r"\w+", element):
            raise OperandFault(f"{text}: the name of an element must follow the point")
    if rest:
        raise OperandFault(f"{text}: {rest} after the name is not understood")
    return Ref(name, index, element, length)


def _index(text: str) -> tuple[int | str, str]:
    """Return the index and the text after it; the texts of faults are COPY's."""
    inner, closed, rest = text[1:].partition("]")
    if "[" in inner and text.startswith("[") and re.match(r"\s*\w+\s*\[", inner):
        raise OperandFault(NESTED)
    inner = inner.strip()
    if not text.startswith("[") or not closed or "[" in inner or rest.strip().startswith(("[", "]")):
        raise OperandFault(INDEX_SYNTAX)
    if re.fullmatch(r"[+-]?\d{1,10}", inner):
        return int(inner), rest.strip()
    if not re.fullmatch(r"[^\W\d][\w$]*", inner):
        raise OperandFault(INDEX_SYNTAX)
    return inner.upper(), rest.strip()
