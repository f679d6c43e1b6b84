"""Layer setting services on the wire.  Source: CiA 305 (version 3.0).  Requests on 7E5h, answers on 7E4h, always 8 bytes."""

import struct
from enum import IntEnum
from typing import NamedTuple

from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid


class Service(IntEnum):
    """Command specifiers."""

    SWITCH_GLOBAL = 0x04
    CONFIGURE_NODE = 0x11
    CONFIGURE_BIT_TIMING = 0x13
    ACTIVATE_BIT_TIMING = 0x15
    STORE = 0x17
    SELECT_VENDOR = 0x40
    SELECT_PRODUCT = 0x41
    SELECT_REVISION = 0x42
    SELECT_SERIAL = 0x43
    SELECTED = 0x44  # answer to the four above
    IDENTIFY_VENDOR = 0x46
    IDENTIFY_PRODUCT = 0x47
    IDENTIFY_REVISION_LOW = 0x48
    IDENTIFY_REVISION_HIGH = 0x49
    IDENTIFY_SERIAL_LOW = 0x4A
    IDENTIFY_SERIAL_HIGH = 0x4B
    IDENTIFY_UNCONFIGURED = 0x4C
    IDENTIFIED = 0x4F  # answer to the six above and to FASTSCAN
    UNCONFIGURED = 0x50  # answer to IDENTIFY_UNCONFIGURED
    FASTSCAN = 0x51
    INQUIRE_VENDOR = 0x5A
    INQUIRE_PRODUCT = 0x5B
    INQUIRE_REVISION = 0x5C
    INQUIRE_SERIAL = 0x5D
    INQUIRE_NODE = 0x5E


class Mode(IntEnum):
    WAITING, CONFIGURATION = 0, 1


UNCONFIGURED_NODE = 255
CONFIRM_SCAN = 128  # bit check of a FASTSCAN that only checks whether any slave is there
BIT_RATES = (1_000_000, 800_000, 500_000, 250_000, 125_000, None, 50_000, 20_000, 10_000)  # by table index, bit/s; 5 is reserved
OK, OUT_OF_RANGE, STORE_UNSUPPORTED, STORE_FAILED = 0, 1, 1, 2


class Identity(NamedTuple):
    """The LSS address: object 1018h, sub-indexes 1..4."""

    vendor: int
    product: int
    revision: int
    serial: int


def request(service: Service, number: int = 0) -> Frame:
    """A request with one 32-bit number (or a byte in its lowest place)."""
    return Frame(cobid.LSS_MASTER, struct.pack("<BI3x", service, number))


def fastscan(number: int, bit_check: int, sub: int, following: int) -> Frame:
    return Frame(cobid.LSS_MASTER, struct.pack("<BIBBB", Service.FASTSCAN, number, bit_check, sub, following))


def configure_bit_timing(table_index: int, selector: int = 0) -> Frame:
    return Frame(cobid.LSS_MASTER, struct.pack("<BBB5x", Service.CONFIGURE_BIT_TIMING, selector, table_index))


def activate_bit_timing(switch_delay_ms: int) -> Frame:
    return Frame(cobid.LSS_MASTER, struct.pack("<BH5x", Service.ACTIVATE_BIT_TIMING, switch_delay_ms))


def answer(service: Service, number: int = 0) -> Frame:
    """Answer of a slave; configuration errors are in the lowest byte of the number."""
    return Frame(cobid.LSS_SLAVE, struct.pack("<BI3x", service, number))


def number_of(data: bytes) -> int:
    """The 32-bit number of an 8-byte message."""
    return int.from_bytes(data[1:5], "little")
