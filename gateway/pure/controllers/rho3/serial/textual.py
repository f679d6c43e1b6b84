"""BAPS values as text, for protocols 2, 5 and 6: "the previous protocols" convert (7), described only in part (AX-164).

WRITE: items follow one another without separators, as in the PHG 2000 subroutines of part 3 (CHR, TEXT, REAL in 8 characters).
READ: numbers end with a comma or carriage return, TEXT with a carriage return, CHARACTER is the next character.
"""

import re

from gateway.pure.controllers.rho3.serial.baps import (
    INTEGERS,
    TEXT_BYTES,
    BapsType,
    ItemError,
    Kind,
    Value,
    as_text,
    components,
    real,
    text_bytes,
    whole,
)
from gateway.pure.controllers.rho3.serial.setup import Condition
from gateway.pure.languages.baps2.forms import real_text

CR, LF, COMMA, BLANK = 0x0D, 0x0A, 0x2C, 0x20
LONGEST_NUMBER = 20
NUMBER = re.compile(rb"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
WHOLE = re.compile(rb"[+-]?\d+")


def to_text(kind: BapsType, value: Value) -> bytes:
    """Raises ItemError."""
    if kind.length:
        between = b"" if kind.kind is Kind.CHARACTER else b","
        values = value if isinstance(value, tuple) and len(value) == kind.length else None
        if values is None:
            raise ItemError(Condition.PROTOCOL, f"FIELD {value!r}: {kind.length} values expected")
        return between.join(to_text(kind.element, one) for one in values)
    match kind.kind:
        case Kind.BINARY:
            return b"%d" % whole(value, range(2), "BINARY")
        case Kind.CHARACTER:
            return bytes((whole(value, range(256), "CHARACTER"),))
        case Kind.INTEGER:
            return b"%d" % whole(value, INTEGERS, "INTEGER")
        case Kind.REAL:
            return real_text(real(value)).encode()
        case Kind.TEXT:
            return as_text(text_bytes(value))
        case Kind.POINT | Kind.JC_POINT:
            return b",".join(real_text(one).encode() for one in components(kind, value))


class ItemReader:
    """Takes the characters of one variable; `feed` reports when it is complete."""

    def __init__(self, kind: BapsType) -> None:
        self._kind = kind
        self._needed = max(1, kind.length) * max(1, kind.components)
        self._word = bytearray()
        self._parts: list[Value] = []

    @property
    def value(self) -> Value:
        """Return the value once it is complete."""
        if not self._kind.components:
            return tuple(self._parts) if self._kind.length else self._parts[0]
        step = self._kind.components
        points = tuple(tuple(self._parts[at : at + step]) for at in range(0, len(self._parts), step))
        return points if self._kind.length else points[0]

    def feed(self, byte: int) -> bool:
        """Raises ItemError with -8, -9, -10 or -11."""
        match self._kind.kind:
            case Kind.CHARACTER:
                self._parts.append(byte)
            case Kind.TEXT:
                self._letter(byte)
            case _:
                self._digit(byte)
        return len(self._parts) == self._needed

    def _letter(self, byte: int) -> None:
        if byte == CR:
            self._parts.append(bytes(self._word))
        elif byte != LF or self._word:  # the line feed after the last carriage return
            self._word.append(byte)
            if len(self._word) > TEXT_BYTES:
                raise ItemError(Condition.LENGTH, f"TEXT of more than {TEXT_BYTES} characters: {self._word.hex(' ')}")

    def _digit(self, byte: int) -> None:
        if byte in (CR, COMMA):
            self._parts.append(self._number())
            self._word.clear()
            if byte == CR and len(self._parts) < self._needed:
                code = Condition.POINT if self._kind.components else Condition.PROTOCOL
                raise ItemError(code, f"{self._kind.kind.name}: {len(self._parts)} numbers, {self._needed} needed")
        elif byte not in (LF, BLANK) or self._word:
            self._word.append(byte)
            if len(self._word) > LONGEST_NUMBER:
                raise ItemError(Condition.LENGTH, f"number of more than {LONGEST_NUMBER} characters: {self._word.hex(' ')}")

    def _number(self) -> Value:
        word = bytes(self._word).rstrip(b" ")
        if self._kind.kind not in (Kind.BINARY, Kind.INTEGER):
            if not NUMBER.fullmatch(word):
                raise ItemError(Condition.DEC_VALUE, f"{word!r}: no decimal number")
            return real(float(word))
        legal = range(2) if self._kind.kind is Kind.BINARY else INTEGERS
        if not WHOLE.fullmatch(word) or int(word) not in legal:
            raise ItemError(Condition.PROTOCOL, f"{word!r}: no {self._kind.kind.name}")
        return bool(int(word)) if self._kind.kind is Kind.BINARY else int(word)
