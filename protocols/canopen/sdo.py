"""Service data objects on the wire: command bytes, segments, blocks, abort codes.  Source: CiA 301, 7.2.4.

All messages have 8 bytes.  The functions build complete messages; client and server are up to the caller.
"""

import struct
from binascii import crc_hqx
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

from protocols.canopen.dictionary import Key

SEGMENT_BYTES = 7
MOST_BLOCK = 127  # segments of one block
_MULTIPLEXED = struct.Struct("<BHB4s")
_ABORT = struct.Struct("<BHBI")
_SIZED = struct.Struct("<BHBI")


class Abort(IntEnum):
    """Every code of CiA 301, table 22."""

    TOGGLE = 0x05030000
    TIMED_OUT = 0x05040000
    COMMAND = 0x05040001
    BLOCK_SIZE = 0x05040002
    SEQUENCE = 0x05040003
    CRC = 0x05040004
    MEMORY = 0x05040005
    ACCESS = 0x06010000
    WRITE_ONLY = 0x06010001
    READ_ONLY = 0x06010002
    NO_OBJECT = 0x06020000
    NOT_MAPPABLE = 0x06040041
    MAPPED_LENGTH = 0x06040042
    INCOMPATIBLE = 0x06040043
    INTERNAL = 0x06040047
    HARDWARE = 0x06060000
    LENGTH = 0x06070010
    TOO_LONG = 0x06070012
    TOO_SHORT = 0x06070013
    NO_SUB = 0x06090011
    VALUE = 0x06090030
    TOO_HIGH = 0x06090031
    TOO_LOW = 0x06090032
    LIMITS = 0x06090036
    NO_RESOURCE = 0x060A0023
    GENERAL = 0x08000000
    NO_STORE = 0x08000020
    LOCAL_CONTROL = 0x08000021
    DEVICE_STATE = 0x08000022
    NO_DICTIONARY = 0x08000023
    NO_DATA = 0x08000024


TEXTS: Mapping[int, str] = {
    Abort.TOGGLE: "toggle bit not alternated",
    Abort.TIMED_OUT: "SDO protocol timed out",
    Abort.COMMAND: "client/server command specifier not valid or unknown",
    Abort.BLOCK_SIZE: "invalid block size",
    Abort.SEQUENCE: "invalid sequence number",
    Abort.CRC: "CRC error",
    Abort.MEMORY: "out of memory",
    Abort.ACCESS: "unsupported access to an object",
    Abort.WRITE_ONLY: "attempt to read a write-only object",
    Abort.READ_ONLY: "attempt to write a read-only object",
    Abort.NO_OBJECT: "object does not exist in the object dictionary",
    Abort.NOT_MAPPABLE: "object cannot be mapped to the PDO",
    Abort.MAPPED_LENGTH: "number and length of the objects to be mapped would exceed the PDO's length",
    Abort.INCOMPATIBLE: "general parameter incompatibility",
    Abort.INTERNAL: "general internal incompatibility in the device",
    Abort.HARDWARE: "access failed because of a hardware error",
    Abort.LENGTH: "data type does not match, length of service parameter does not match",
    Abort.TOO_LONG: "data type does not match, length of service parameter too high",
    Abort.TOO_SHORT: "data type does not match, length of service parameter too low",
    Abort.NO_SUB: "sub-index does not exist",
    Abort.VALUE: "invalid value for parameter",
    Abort.TOO_HIGH: "value of parameter written too high",
    Abort.TOO_LOW: "value of parameter written too low",
    Abort.LIMITS: "maximum value is less than minimum value",
    Abort.NO_RESOURCE: "resource not available: SDO connection",
    Abort.GENERAL: "general error",
    Abort.NO_STORE: "data cannot be transferred or stored to the application",
    Abort.LOCAL_CONTROL: "data cannot be transferred or stored to the application because of local control",
    Abort.DEVICE_STATE: "data cannot be transferred or stored to the application because of the present device state",
    Abort.NO_DICTIONARY: "object dictionary dynamic generation fails or no object dictionary is present",
    Abort.NO_DATA: "no data available",
}


class Request(IntEnum):
    """Client command specifiers: bits 7..5 of the first byte."""

    DOWNLOAD_SEGMENT, INITIATE_DOWNLOAD, INITIATE_UPLOAD, UPLOAD_SEGMENT, ABORT, BLOCK_UPLOAD, BLOCK_DOWNLOAD = range(7)


class Answer(IntEnum):
    """Server command specifiers."""

    UPLOAD_SEGMENT, DOWNLOAD_SEGMENT, INITIATE_UPLOAD, INITIATE_DOWNLOAD, ABORT, BLOCK_DOWNLOAD, BLOCK_UPLOAD = range(7)


class BlockUpload(IntEnum):
    """Sub-commands of a client, bits 1..0."""

    INITIATE, END, RESPONSE, START = range(4)


EXPEDITED, SIZED, TOGGLE, LAST = 0x02, 0x01, 0x10, 0x01
CRC_SUPPORT, BLOCK_SIZED = 0x04, 0x02  # of messages that initiate a block transfer
BLOCK_END = 0x01  # BLOCK_DOWNLOAD of a client, BLOCK_UPLOAD of a server: end (else initiate)
FINAL_SEGMENT = 0x80  # of a block: no more segments


@dataclass(frozen=True, slots=True)
class Aborted:
    index: int
    sub: int
    code: int

    @property
    def text(self) -> str:
        return TEXTS.get(self.code, f"unknown abort code {self.code:08X}h")


def crc(data: bytes) -> int:
    """CRC of a block transfer: x^16 + x^12 + x^5 + 1, start 0."""
    return crc_hqx(data, 0)


def abort(key: Key, code: int) -> bytes:
    return _ABORT.pack(Request.ABORT << 5, *key, code)


def abort_of(data: bytes) -> Aborted:
    _, index, sub, code = _ABORT.unpack(data)
    return Aborted(index, sub, code)


def key_of(data: bytes) -> Key:
    """Index and sub-index of a message that carries them."""
    return int.from_bytes(data[1:3], "little"), data[3]


def size_of(data: bytes) -> int:
    """The size an initiating message names."""
    return int.from_bytes(data[4:8], "little")


def expedited(command: int, key: Key, data: bytes) -> bytes:
    """Initiating message that carries its 1..4 bytes itself; `command` of Request or Answer."""
    return _MULTIPLEXED.pack(command << 5 | (4 - len(data)) << 2 | EXPEDITED | SIZED, *key, data)


def expedited_data(data: bytes) -> bytes:
    """The bytes of an expedited message; all four when it names no size."""
    return data[4 : 8 - (data[0] >> 2 & 3)] if data[0] & SIZED else data[4:8]


def initiate(command: int, key: Key, size: int | None = None, flags: int = 0) -> bytes:
    """Initiating message of a longer transfer, or one without data."""
    return _SIZED.pack(command << 5 | flags | (SIZED if size is not None else 0), *key, size or 0)


def segment(command: int, toggle: bool, data: bytes, last: bool) -> bytes:
    """One segment of 0..7 bytes."""
    return bytes((command << 5 | TOGGLE * toggle | (SEGMENT_BYTES - len(data)) << 1 | last,)) + data.ljust(SEGMENT_BYTES, b"\0")


def segment_data(data: bytes) -> bytes:
    return data[1 : 8 - (data[0] >> 1 & 7)]


def short(command: int, flags: int = 0, *rest: int) -> bytes:
    """A message of command byte and few bytes: segment requests, confirmations, block acknowledgements."""
    return bytes((command << 5 | flags, *rest)).ljust(8, b"\0")


def initiate_block(command: int, key: Key, size: int | None, crc_support: bool, low_bits: int = 0) -> bytes:
    """Initiating message of a block transfer; a client's upload puts block size and protocol switch threshold into the last four bytes."""
    return _SIZED.pack(command << 5 | CRC_SUPPORT * crc_support | BLOCK_SIZED * (size is not None) | low_bits, *key, size or 0)


def block_segment(number: int, data: bytes, final: bool) -> bytes:
    return bytes((number | FINAL_SEGMENT * final,)) + data.ljust(SEGMENT_BYTES, b"\0")


def block_end(command: int, unused: int, checksum: int) -> bytes:
    """End of a block transfer: `unused` bytes of the last segment mean nothing."""
    return struct.pack("<BH5x", command << 5 | unused << 2 | BLOCK_END, checksum)
