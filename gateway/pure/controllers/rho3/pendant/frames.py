"""Transparent output to a PHG 2000: commands as bytes and back.  Source: rho 3 Releases L9474-9886; rho3 3.9.

A command is two bytes (number, length of what follows) and its parameters; words go low byte first.  An output begins with the
number of the mask it is meant for (-1: any) and ends with SC_ENDE; nothing leaves before that.
"""

from dataclasses import dataclass
from enum import IntEnum

EVERY_MASK = -1
WIDTH, HEIGHT = 256, 128  # pixels; origin upper left
TEXT_LENGTH = 80
REAL_LENGTH = 9  # with the closing NUL


class Command(IntEnum):
    """Low byte of a command word."""

    CLS = 1
    GOTOXY = 2
    ATTRIB = 3
    TEXT = 5
    REFRESH = 7
    ENDE = 8
    LINIE = 12
    N_MASKE = 15
    CHARSET = 18
    ZEI_REL = 22


class FrameError(Exception):
    """A parameter that no pendant accepts, or bytes that are not an output."""


@dataclass(frozen=True, slots=True)
class Part:
    """One command of an output as it was sent."""

    command: Command
    data: bytes


def _word(value: int) -> bytes:
    return (value % 65536).to_bytes(2, "little")


def _command(command: Command, data: bytes = b"") -> bytes:
    return bytes((command, len(data))) + data


def sc_fuer_mask(mask: int) -> bytes:
    """Mask the output is meant for; another active mask drops it."""
    return _word(mask)


def sc_neue_mask(mask: int) -> bytes:
    """Show a mask."""
    return _command(Command.N_MASKE, _word(mask))


def sc_cls() -> bytes:
    """Clear the display."""
    return _command(Command.CLS)


def sc_attrib(attributes: int) -> bytes:
    """Sum of 1 blink, 2 inverse, 4 double width, 8 double height; 0 normal."""
    if not 0 <= attributes <= 15:
        raise FrameError(f"attributes {attributes}: 0 to 15")
    return _command(Command.ATTRIB, bytes((attributes,)))


def sc_charset(characters: int) -> bytes:
    """0: 6 x 8, 42 x 16 characters; 1: 9 x 11, 28 x 11."""
    if characters not in (0, 1):
        raise FrameError(f"character set {characters}: 0 or 1")
    return _command(Command.CHARSET, bytes((characters,)))


def sc_gotoxy(x: int, y: int) -> bytes:
    """Write position in pixels."""
    return _command(Command.GOTOXY, _word(_pixel("x", x, WIDTH)) + _word(_pixel("y", y, HEIGHT)))


def sc_linie(from_x: int, from_y: int, to_x: int, to_y: int) -> bytes:
    """A line in pixels."""
    pixels = (_pixel("x", from_x, WIDTH), _pixel("y", from_y, HEIGHT), _pixel("x", to_x, WIDTH), _pixel("y", to_y, HEIGHT))
    return _command(Command.LINIE, b"".join(map(_word, pixels)))


def sc_text(text: str) -> bytes:
    """Text of up to 80 characters; the length byte is always 81, a NUL ends it sooner (L9786-9790, AX-487)."""
    return bytes((Command.TEXT, TEXT_LENGTH + 1)) + _characters(text, TEXT_LENGTH) + b"\0"


def sc_zeichen(character: str) -> bytes:
    """One character."""
    if len(character) != 1:
        raise FrameError(f"{character!r}: one character")
    return bytes((Command.TEXT, 2)) + _characters(character, 1) + b"\0"


def sc_dez(value: float) -> bytes:
    """A real number in eight characters; hyphens where it does not fit (L9853-9857)."""
    return bytes((Command.TEXT, REAL_LENGTH)) + _characters(real_text(value, REAL_LENGTH - 1), REAL_LENGTH - 1) + b"\0"


def sc_ganz(value: int, length: int) -> bytes:
    """Return an integer, right-aligned in `length` places; hyphens where INT_ASC reports an error (L9863-9886)."""
    return sc_text(int_asc(value, length) or "-" * length)


def sc_refresh(variable: int, line: int) -> bytes:
    """Show a variable list anew with the line cursor in `line`."""
    return _command(Command.REFRESH, _word(variable) + _word(line))


def sc_zei_rel(columns: int, lines: int) -> bytes:
    """Move the write position by characters, -128..127."""
    if not (-128 <= columns <= 127 and -128 <= lines <= 127):
        raise FrameError(f"{columns}, {lines}: -128 to 127 each")
    return _command(Command.ZEI_REL, bytes((columns % 256, lines % 256)))


def sc_ende() -> bytes:
    """Ends the output: now it is sent."""
    return _command(Command.ENDE)


def int_asc(value: int, length: int) -> str | None:
    """INT_ASC: right-aligned in `length` places, None where it does not fit (W_ERR <> 0)."""
    if not 1 <= length <= TEXT_LENGTH:
        raise FrameError(f"length {length}: 1 to {TEXT_LENGTH}")
    text = str(value)
    return text.rjust(length) if len(text) <= length else None


def real_text(value: float, length: int) -> str:
    """Return as many decimals as `length` places hold; hyphens where the integer part does not fit or the value is not a number."""
    for decimals in range(length - 2, -1, -1):
        text = f"{value:.{decimals}f}"
        if len(text) <= length and text.lstrip("-")[0].isdigit():
            return text.rjust(length)
    return "-" * length


def parse(output: bytes) -> tuple[int, list[Part]]:
    """(mask, commands) of one output up to and with SC_ENDE; FrameError where it stops before.

    The length byte of a text is an upper limit: its NUL ends it.
    """
    if len(output) < 2:
        raise FrameError(f"{len(output)} bytes: an output begins with a mask number of two")
    mask = int.from_bytes(output[:2], "little", signed=True)
    parts: list[Part] = []
    place = 2
    while not parts or parts[-1].command is not Command.ENDE:
        part, place = _part(output, place)
        parts.append(part)
    if place != len(output):
        raise FrameError(f"{len(output) - place} bytes after SC_ENDE")
    return mask, parts


def _part(output: bytes, place: int) -> tuple[Part, int]:
    head = output[place : place + 2]
    if len(head) < 2:
        raise FrameError(f"byte {place}: the output ends before SC_ENDE")
    try:
        command = Command(head[0])
    except ValueError as error:
        raise FrameError(f"byte {place}: {head[0]} is not a command") from error
    end = place + 2 + head[1]
    if command is Command.TEXT:
        end = output.find(b"\0", place + 2, end) + 1
    if end < place + 2 or end > len(output):
        raise FrameError(f"byte {place}: {command.name} ends before its {head[1]} bytes")
    return Part(command, output[place + 2 : end]), end


def _pixel(name: str, value: int, size: int) -> int:
    if not 0 <= value < size:
        raise FrameError(f"{name} = {value}: 0 to {size - 1} pixels")
    return value


def _characters(text: str, most: int) -> bytes:
    data = text.encode("cp437", "replace")
    if len(data) > most or b"\0" in data:
        raise FrameError(f"{len(data)} characters: at most {most}, and no NUL")
    return data
