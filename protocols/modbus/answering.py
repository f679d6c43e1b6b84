"""From a request PDU to its answer PDU.  Decisions are made here (validate, view); pymodbus' PDU classes decode and encode writes,
reads, which are nearly all of the traffic, by a struct: half the time of a request went into the objects.  Functions without a table (FC 7,
8, 11, 12, 17, 20, 21, 24, 43) are in protocols.modbus.special.
"""

import struct
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from pymodbus.pdu import ExceptionResponse, ModbusPDU
from pymodbus.pdu import bit_message as bit
from pymodbus.pdu import register_message as register

from protocols.modbus.special import SPECIAL, special
from protocols.modbus.station import Station
from protocols.modbus.validate import refusal
from protocols.modbus.view import ExceptionCode, Kind, View

REMEMBERED = 512  # read requests kept decoded: pollers repeat themselves byte for byte


class Read(NamedTuple):
    """A legal read request, decoded."""

    kind: Kind
    address: int
    quantity: int


READS = {1: Kind.COILS, 2: Kind.DISCRETE_INPUTS, 3: Kind.HOLDING_REGISTERS, 4: Kind.INPUT_REGISTERS}
WORDS = tuple(struct.Struct(f">BB{count}H") for count in range(126))  # answers to FC 3 and 4 by their quantity


def answer(pdu: bytes, view: View | None, may_write: bool = True, station: Station | None = None) -> bytes:
    """The answer PDU to `pdu`; never raises on what a partner sends (a view that raises is its owner's mistake and passes through).

    view: the addressed unit's tables, None if there is no such unit (0Bh, AX-012).  An exception answer carries the function code
    of the request with bit 7 set, whatever it was.  An empty PDU has nothing to answer and returns b"", and so does a diagnosis that
    switches to listening only (FC 8/4, serial lines).  station: data of FC 8, 11, 12, 17 and 43; without it they are answered with 01.
    """
    if not pdu:
        return b""
    if view is None:
        return exception(pdu[0], ExceptionCode.GATEWAY_TARGET_SILENT)
    if pdu[0] in READS:
        result = _read(pdu, view)
    elif pdu[0] in SPECIAL:
        result = special(pdu, view, may_write, station)
    else:
        result = _write(pdu, view, may_write)
    return exception(pdu[0], result) if isinstance(result, ExceptionCode) else result


def exception(function: int, code: ExceptionCode) -> bytes:
    """The exception answer to a request of this function code (V1.1b3, section 7)."""
    return _pdu(ExceptionResponse(function, code))


def _pdu(message: ModbusPDU) -> bytes:
    return bytes((message.function_code,)) + message.encode()


def _read(pdu: bytes, view: View) -> bytes | ExceptionCode:
    wanted = _decoded(pdu)
    if isinstance(wanted, ExceptionCode):
        return wanted
    kind, address, quantity = wanted
    if pdu[0] > 2:
        words = view.read_words(kind, address, quantity)
        return words if isinstance(words, ExceptionCode) else _words_answer(pdu[0], words, quantity)
    bits = view.read_bits(kind, address, quantity)
    if isinstance(bits, ExceptionCode):
        return bits
    return _bits_answer(pdu[0], bits) if len(bits) == quantity else ExceptionCode.SERVER_DEVICE_FAILURE


def _words_answer(function: int, words: Sequence[int], count: int) -> bytes | ExceptionCode:
    try:
        return WORDS[count].pack(function, 2 * count, *words)
    except struct.error:  # too few, too many, or a value beyond 16 bits: the view's mistake, and the partner must not get a wrong number
        return ExceptionCode.SERVER_DEVICE_FAILURE


def _bits_answer(function: int, bits: Sequence[bool]) -> bytes:
    """The first bit is the lowest of the first byte (V1.1b3, 6.1)."""
    size = (len(bits) + 7) // 8
    number = int("".join(["1" if value else "0" for value in reversed(bits)]), 2)
    return bytes((function, size)) + number.to_bytes(size, "little")


@lru_cache(maxsize=REMEMBERED)
def _decoded(pdu: bytes) -> Read | ExceptionCode:
    """Checks and decodes a read request; the same bytes always mean the same, so it is done once (the answer never is)."""
    why = refusal(pdu)
    if why is not None:
        return why
    return Read(READS[pdu[0]], pdu[1] << 8 | pdu[2], pdu[3] << 8 | pdu[4])


def _write(pdu: bytes, view: View, may_write: bool) -> bytes | ExceptionCode:
    why = refusal(pdu, may_write)
    if why is not None:
        return why
    match pdu[0]:
        case 5:
            return _write_coil(pdu, view)
        case 6:
            return _write_register(pdu, view)
        case 15:
            return _write_coils(pdu, view)
        case 16:
            return _write_registers(pdu, view)
        case 22:
            return _mask_write(pdu, view)
        case _:
            return _read_write(pdu, view)


def _write_coil(pdu: bytes, view: View) -> bytes | ExceptionCode:
    request = bit.WriteSingleCoilRequest()
    request.decode(pdu[1:])
    why = view.write_bits(request.address, request.bits)
    return why or _pdu(bit.WriteSingleCoilResponse(address=request.address, bits=request.bits))


def _write_register(pdu: bytes, view: View) -> bytes | ExceptionCode:
    request = register.WriteSingleRegisterRequest()
    request.decode(pdu[1:])
    why = view.write_words(request.address, request.registers)
    return why or _pdu(register.WriteSingleRegisterResponse(address=request.address, registers=request.registers))


def _write_coils(pdu: bytes, view: View) -> bytes | ExceptionCode:
    request = bit.WriteMultipleCoilsRequest()
    request.decode(pdu[1:])
    why = view.write_bits(request.address, request.bits)
    return why or _pdu(bit.WriteMultipleCoilsResponse(address=request.address, count=request.count))


def _write_registers(pdu: bytes, view: View) -> bytes | ExceptionCode:
    request = register.WriteMultipleRegistersRequest()
    request.decode(pdu[1:])
    why = view.write_words(request.address, request.registers)
    return why or _pdu(register.WriteMultipleRegistersResponse(address=request.address, count=request.count))


def _mask_write(pdu: bytes, view: View) -> bytes | ExceptionCode:
    """(current AND and-mask) OR (or-mask AND NOT and-mask), V1.1b3, 6.16."""
    address, and_mask, or_mask = struct.unpack(">HHH", pdu[1:])
    current = view.read_words(Kind.HOLDING_REGISTERS, address, 1)
    if isinstance(current, ExceptionCode):
        return current
    return view.write_words(address, [current[0] & and_mask | or_mask & ~and_mask & 0xFFFF]) or pdu


def _read_write(pdu: bytes, view: View) -> bytes | ExceptionCode:
    """The write before the read (V1.1b3, 6.17); unreadable addresses are found first, so that nothing is written."""
    request = register.ReadWriteMultipleRegistersRequest()
    request.decode(pdu[1:])
    before = view.read_words(Kind.HOLDING_REGISTERS, request.read_address, request.read_count)
    if isinstance(before, ExceptionCode):
        return before
    why = view.write_words(request.write_address, request.write_registers)
    if why is not None:
        return why
    words = view.read_words(Kind.HOLDING_REGISTERS, request.read_address, request.read_count)
    if isinstance(words, ExceptionCode) or len(words) != request.read_count:
        return ExceptionCode.SERVER_DEVICE_FAILURE
    return _pdu(register.ReadWriteMultipleRegistersResponse(registers=list(words)))
