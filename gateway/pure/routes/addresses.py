"""Where a route begins and ends: an address of any kind and its number format.

Source of the addresses: gateway.pure.image.addresses.  RC inputs are what a PLC writes (A, O, Q; RCI), RC outputs what it reads (E, I;
RCO).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from gateway.pure.cell.modbus import ModbusForm
from gateway.pure.image.addresses import (
    AddressFault,
    CellName,
    DataBit,
    DataWord,
    Direction,
    Kind,
    Operand,
    Part,
    RcBit,
    Register,
    Table,
    bits_of,
    parse_operand,
)
from gateway.pure.routes.forms import BIT, FORMS, bytes_of, number_of, size_of
from gateway.pure.routes.judge import Span
from protocols.base.errors import ProtocolError


class World(Enum):
    """What kind of thing holds the value."""

    BLOCK = "data block"
    RC_INPUT = "RC input"
    RC_OUTPUT = "RC output"
    NAME = "value"
    CONTACT = "contact"
    REGISTER = "register"  # or coil, of a device a Modbus client asks
    PARAMETER = "drive parameter"  # object of a CANopen drive


REGISTER_TYPES: Mapping[str, ModbusForm] = {  # number form -> type of a Modbus client's value; the order is the device's
    BIT: "bit", "u16": "UINT16", "KH": "UINT16", "KM": "UINT16", "s16": "INT16", "KF": "INT16",
    "u32": "UINT32", "s32": "INT32", "DH": "INT32", "REAL": "REAL",
}  # fmt: skip

PARAMETER_TYPES = ("u8", "s8", "u16", "s16", "u32", "s32", "REAL")
_PARAMETER = re.compile(r"(?:([^:]*):)?\s*([0-9A-Fa-f]{4})h(?::([0-9A-Fa-f]{2}))?")


@dataclass(frozen=True, slots=True)
class Place:
    """One end.  `byte`, `bit`, `form`, `order` define the place in a block or image; `name` is the value or contact, or a block's line.

    A register: `name` is CLIENT.DEVICE, `db` the table (0 coils, 1 discrete inputs, 3 input, 4 holding registers), `byte` its address.
    A drive parameter: `name` is the axis, `db` the object, `byte` its sub-index.
    """

    world: World
    name: str = ""
    db: int = 0
    byte: int = 0
    bit: int = 0  # of `byte`, 0 lowest; only for bits
    form: str = BIT
    order: str = "ABCD"

    @property
    def size(self) -> int:
        """Bytes it covers."""
        return size_of(self.form) or 1

    @property
    def span(self) -> Span:
        """What it covers, to be held against others."""
        width = 1 if self.form == BIT else 8 * self.size
        match self.world:
            case World.BLOCK:
                return Span(f"DB {self.db} of line {self.name}", 8 * self.byte + (7 - self.bit if self.form == BIT else 0), width)
            case World.RC_INPUT | World.RC_OUTPUT:
                return Span(self.world.value, 8 * self.byte + (self.bit if self.form == BIT else 0), width)
            case World.REGISTER:
                return Span(f"table {self.db} of {self.name}", 16 * self.byte, 16 if self.form == BIT else width)
            case World.PARAMETER:
                return Span(f"{self.world.value} {self.name} {self.db:04X}h:{self.byte:02X}")
        return Span(f"{self.world.value} {self.name}")


NO_DEVICES: Mapping[str, str] = {}


def place_of(
    text: str, form: str, order: str, symbols: Mapping[str, RcBit], line_of: Mapping[int, str], devices: Mapping[str, str] = NO_DEVICES
) -> Place:
    """`form` "" is a bit or a name; `line_of`: data block -> the one line it is served on; `devices`: the part before the colon of a
    register -> CLIENT.DEVICE.  Raises AddressFault."""
    if form and form not in FORMS:
        raise AddressFault(f"{form!r} is not a number form; {' '.join(FORMS)} are")
    if parameter := _PARAMETER.fullmatch(text.strip()):
        return _parameter(text, parameter, form, order)
    line, colon, rest = text.partition(":")
    where = parse_operand(rest if colon else text, symbols)
    if colon and not isinstance(where, Register | DataBit | DataWord):
        raise AddressFault(
            f"{text!r}: name before the colon the line of a data block (LINE:DB30.DW0), the Modbus device of a register (DEVICE:40001) "
            "or the axis of a drive parameter (AXIS:6081h:00); no other address has one"
        )
    match where:
        case Register(table, address) if colon:
            return _register(text, devices.get(line.strip(), ""), table, address, form, order)
        case CellName(name):
            return Place(World.CONTACT, name[3:]) if name.startswith("io.") else Place(World.NAME, name)
        case DataBit(db, word, bit):
            _need(text, form, 0)
            return Place(World.BLOCK, line if colon else _line(db, line_of), db, 2 * word + (bit < 8), bit & 7)
        case DataWord(db, word, part):
            _need(text, form, {Part.LEFT: 1, Part.RIGHT: 1, Part.WORD: 2, Part.DOUBLE: 4}[part])
            byte = bits_of(where).start // 8 + (part is Part.RIGHT) - (part is Part.LEFT)
            return Place(World.BLOCK, line if colon else _line(db, line_of), db, byte, 0, form, order)
        case RcBit(direction, number):
            _need(text, form, 0)
            return Place(_world(direction), byte=number >> 3, bit=number & 7)
        case Operand(Kind.INPUT | Kind.OUTPUT, number, None, size):
            _need(text, form, size)
            return Place(World.RC_INPUT if where.kind is Kind.OUTPUT else World.RC_OUTPUT, "", 0, number, 0, form, order)
    raise AddressFault(
        f"{text!r}: a route joins data blocks (DB30.DW0), RC inputs and outputs (AW 92, E 8.0), values, contacts (io.lamp) and "
        "registers of Modbus devices (DEVICE:40001); it ends in parameters of CANopen drives too (AXIS:6081h:00)"
    )


def _parameter(text: str, found: re.Match[str], form: str, order: str) -> Place:
    axis, index, sub = (found[1] or "").strip(), int(found[2], 16), found[3]
    if not axis or sub is None:
        raise AddressFault(f"{text!r}: a drive parameter is written AXIS:6081h:00 (axis, object, sub-index)")
    if form not in PARAMETER_TYPES:
        raise AddressFault(f"{text!r}: which type has the object? to_type = one of {' '.join(PARAMETER_TYPES)}")
    if order != "ABCD":
        raise AddressFault(f"{text!r}: CANopen defines the byte order of an object: leave the order out")
    return Place(World.PARAMETER, axis, index, int(sub, 16), 0, form)


def octets_of(place: Place, value: float) -> bytes:
    """As SDO carries it, lowest byte first; raises EncodeError when it does not fit."""
    return bytes_of(place.form, "DCBA", value)


def _register(text: str, device: str, table: Table, address: int, form: str, order: str) -> Place:
    if not device:
        raise AddressFault(f"{text!r}: name before the colon a [[modbus.device]] of a client (or CLIENT.DEVICE, where two have the name)")
    bits = table in (Table.COIL, Table.DISCRETE)
    if bits:
        _need(text, form, 0)
    elif form not in REGISTER_TYPES or form == BIT:
        raise AddressFault(f"{text!r}: registers hold {' '.join(each for each in REGISTER_TYPES if each != BIT)}: type = one of them")
    if order != "ABCD":
        raise AddressFault(f"{text!r}: the device sets the word order: give order at the [[modbus.device]]")
    kind = BIT if bits else form
    if address + max(1, size_of(kind) // 2) > 0x10000:
        raise AddressFault(f"{text!r}: {kind} goes beyond register 65535")
    return Place(World.REGISTER, device, table.value, address, 0, kind)


def number_at(place: Place, data: bytes | bytearray) -> float | None:
    """Return the value in the block or image; None: the bytes are not a number of that form."""
    if place.form == BIT:
        return float(data[place.byte] >> place.bit & 1)
    try:
        return number_of(place.form, place.order, bytes(data[place.byte : place.byte + place.size]))
    except ProtocolError:
        return None


def put_at(place: Place, data: bytearray, value: float) -> None:
    """Into the block or image; raises EncodeError when it does not fit (a route's settings keep such values out)."""
    if place.form == BIT:
        old = data[place.byte]
        data[place.byte] = old | 1 << place.bit if value else old & ~(1 << place.bit)
    else:
        data[place.byte : place.byte + place.size] = bytes_of(place.form, place.order, value)


def _need(text: str, form: str, size: int) -> None:
    if size == 0 and form not in ("", BIT):
        raise AddressFault(f"{text!r} is a bit: type = {form!r} does not fit")
    if size and not form:
        raise AddressFault(f"{text!r}: the number format is missing: type = one of {' '.join(f for f in FORMS if size_of(f) == size)}")
    if size and size_of(form) != size:
        raise AddressFault(f"{text!r} has {size} bytes, {form} needs {size_of(form) or 'a bit'}")


def _line(db: int, line_of: Mapping[int, str]) -> str:
    if db not in line_of:
        raise AddressFault(f"DB {db}: no [[db]] of this cell, or one on several lines (then LINE:DB{db}.DW0)")
    return line_of[db]


def _world(direction: Direction) -> World:
    return World.RC_INPUT if direction is Direction.INPUT else World.RC_OUTPUT
