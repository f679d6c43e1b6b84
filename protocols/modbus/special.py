"""Answers to the functions without tables: diagnosis, event log, names, files, queues.  Source: V1.1b3, sections 6.7 to 6.10, 6.13 to
6.15, 6.18, 6.21.  Requests are checked by protocols.modbus.validate before."""

import struct

from protocols.modbus.station import Station
from protocols.modbus.validate import REFERENCE_TYPE, refusal
from protocols.modbus.view import ExceptionCode, HasFiles, HasQueue, HasStatus, View

SPECIAL = frozenset({7, 8, 11, 12, 17, 20, 21, 24, 43})
LONGEST_QUEUE = 31  # V1.1b3, 6.18
UNKNOWN = ExceptionCode.ILLEGAL_FUNCTION


def special(pdu: bytes, view: View, may_write: bool, station: Station | None) -> bytes | ExceptionCode:
    """The answer PDU or the exception; b"" where none is to be sent."""
    why = refusal(pdu, may_write, station is not None and station.serial)
    if why is not None:
        return why
    match pdu[0]:
        case 7:
            return bytes((7, view.exception_status() & 0xFF)) if isinstance(view, HasStatus) else UNKNOWN
        case 20:
            return _read_files(pdu, view) if isinstance(view, HasFiles) else UNKNOWN
        case 21:
            return _write_files(pdu, view) if isinstance(view, HasFiles) else UNKNOWN
        case 24:
            return _read_queue(pdu, view) if isinstance(view, HasQueue) else UNKNOWN
    return UNKNOWN if station is None else _of_station(pdu, station)


def _of_station(pdu: bytes, station: Station) -> bytes | ExceptionCode:
    match pdu[0]:
        case 8:
            return station.diagnose(pdu)
        case 11:
            return station.event_counter()
        case 12:
            return station.event_log()
        case 17:
            return station.server_id()
    return station.identify(pdu)


def _read_files(pdu: bytes, view: HasFiles) -> bytes | ExceptionCode:
    answer = b""
    for at in range(2, len(pdu), 7):
        _, file, record, count = struct.unpack_from(">BHHH", pdu, at)
        words = view.read_record(file, record, count)
        if isinstance(words, ExceptionCode):
            return words
        if len(words) != count:
            return ExceptionCode.SERVER_DEVICE_FAILURE
        answer += struct.pack(f">BB{count}H", 1 + 2 * count, REFERENCE_TYPE, *words)
    return bytes((20, len(answer))) + answer


def _write_files(pdu: bytes, view: HasFiles) -> bytes | ExceptionCode:
    """All records are checked first, so that a refused request writes nothing."""
    at, groups = 2, []
    while at < len(pdu):
        _, file, record, count = struct.unpack_from(">BHHH", pdu, at)
        groups.append((file, record, struct.unpack_from(f">{count}H", pdu, at + 7)))
        at += 7 + 2 * count
    for file, record, values in groups:
        why = view.refuses_record(file, record, len(values))
        if why is not None:
            return why
    for file, record, values in groups:
        why = view.write_record(file, record, values)
        if why is not None:
            return why
    return pdu


def _read_queue(pdu: bytes, view: HasQueue) -> bytes | ExceptionCode:
    words = view.read_queue(pdu[1] << 8 | pdu[2])
    if isinstance(words, ExceptionCode):
        return words
    if len(words) > LONGEST_QUEUE:
        return ExceptionCode.ILLEGAL_DATA_VALUE
    return struct.pack(f">BHH{len(words)}H", 24, 2 + 2 * len(words), len(words), *words)
