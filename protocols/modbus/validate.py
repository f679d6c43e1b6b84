"""Rules for legal requests: tables on the raw PDU, applied in the order of the flow charts of V1.1b3, sections 6.1 to 6.21.

First the function (01), then structure, quantity, byte count and value (03), then the address range (02); only after these the view is
called, which may answer 02 for a missing range or 04 for a failed execution.  Sub-functions come with the function (01).
"""

from collections.abc import Callable, Container
from dataclasses import dataclass

from protocols.modbus.view import ExceptionCode

ADDRESSES = 0x10000  # of each table (V1.1b3, 4.4)
ADDRESS_END, FIXED_END, DATA_START = 3, 5, 6  # function | address, 2 | quantity or value, 2 | byte count | data


@dataclass(frozen=True, slots=True)
class Rule:
    """One function code: permitted values of the word after the address, and the data after it."""

    section: str  # of V1.1b3: its flow chart
    legal: Container[int]  # values of the word after the address
    counts: bool  # that word is a quantity; else it is the value of one coil or register
    writes: bool = False
    data_bits: int = 0  # bits of each value after the byte count; 0: the request ends before a byte count


RULES = {
    1: Rule("6.1", legal=range(1, 0x07D0 + 1), counts=True),
    2: Rule("6.2", legal=range(1, 0x07D0 + 1), counts=True),
    3: Rule("6.3", legal=range(1, 0x007D + 1), counts=True),
    4: Rule("6.4", legal=range(1, 0x007D + 1), counts=True),
    5: Rule("6.5", legal=frozenset({0x0000, 0xFF00}), counts=False, writes=True),
    6: Rule("6.6", legal=range(0x10000), counts=False, writes=True),
    15: Rule("6.11", legal=range(1, 0x07B0 + 1), counts=True, writes=True, data_bits=1),
    16: Rule("6.12", legal=range(1, 0x007B + 1), counts=True, writes=True, data_bits=16),
}


# FC 8: sub-functions and the data words each accepts (V1.1b3, 6.8.1); None: any, echoed
ZERO = frozenset({0x0000})
DIAGNOSES: dict[int, Container[int] | None] = {
    0: None,  # return query data
    1: frozenset({0x0000, 0xFF00}),  # restart communications
    2: ZERO,  # diagnostic register
    4: ZERO,  # force listen only
    **dict.fromkeys((10, 11, 12, 13, 14, 15, 16, 17, 18, 20), ZERO),
}
CHANGING = (1, 4, 10, 20)  # sub-functions of FC 8 that change something
LISTEN_ONLY = 4  # serial lines only: a TCP server that stops answering could not be reached again (AX-342)
IDENTIFICATION = 0x0E  # MEI type of FC 43


def refusal(pdu: bytes, may_write: bool = True, serial: bool = False) -> ExceptionCode | None:
    """Why this request (1 byte or more) must not be done, None when it may; a partner who may only read is refused by 01 (AX-070)."""
    rule = RULES.get(pdu[0])
    if rule is None:
        return _other(pdu, may_write, serial)
    if rule.writes and not may_write:
        return ExceptionCode.ILLEGAL_FUNCTION
    if not _well_built(rule, pdu):
        return ExceptionCode.ILLEGAL_DATA_VALUE
    if not _inside(rule, pdu):
        return ExceptionCode.ILLEGAL_DATA_ADDRESS
    return None


def _word(pdu: bytes, end: int) -> int:
    return pdu[end - 2] << 8 | pdu[end - 1]


def _well_built(rule: Rule, pdu: bytes) -> bool:
    """A byte too few or too many is 03: "the implied length is incorrect" (V1.1b3, section 7); so is all beyond 253 bytes."""
    if len(pdu) < FIXED_END or _word(pdu, FIXED_END) not in rule.legal:
        return False
    if not rule.data_bits:
        return len(pdu) == FIXED_END
    data_bytes = (_word(pdu, FIXED_END) * rule.data_bits + 7) // 8
    return len(pdu) == DATA_START + data_bytes and pdu[FIXED_END] == data_bytes


def _inside(rule: Rule, pdu: bytes) -> bool:
    count = _word(pdu, FIXED_END) if rule.counts else 1
    return _word(pdu, ADDRESS_END) + count <= ADDRESSES


# ---- functions whose requests are built otherwise
MOST_PDU = 253
FIRST_FILE_RECORD, LAST_FILE_RECORD = 0, 0x270F  # V1.1b3, 6.14
REFERENCE_TYPE = 6
WRITING = frozenset({21, 22, 23})


def _other(pdu: bytes, may_write: bool, serial: bool) -> ExceptionCode | None:
    check = OTHERS.get(pdu[0])
    if check is None or (pdu[0] in WRITING and not may_write):
        return ExceptionCode.ILLEGAL_FUNCTION
    if pdu[0] == 8 and len(pdu) >= 3:
        changing = _word(pdu, 3) in CHANGING and not may_write
        if changing or (_word(pdu, 3) == LISTEN_ONLY and not serial):
            return ExceptionCode.ILLEGAL_FUNCTION
    return check(pdu)


def _bare(pdu: bytes) -> ExceptionCode | None:
    """FC 7, 11, 12, 17: nothing but the function code."""
    return None if len(pdu) == 1 else ExceptionCode.ILLEGAL_DATA_VALUE


def _diagnosis(pdu: bytes) -> ExceptionCode | None:
    if len(pdu) < 3:
        return ExceptionCode.ILLEGAL_DATA_VALUE
    sub = _word(pdu, 3)
    if sub not in DIAGNOSES:
        return ExceptionCode.ILLEGAL_FUNCTION
    legal = DIAGNOSES[sub]
    if legal is None:
        return None if 5 <= len(pdu) <= MOST_PDU and len(pdu) % 2 else ExceptionCode.ILLEGAL_DATA_VALUE
    return None if len(pdu) == 5 and _word(pdu, 5) in legal else ExceptionCode.ILLEGAL_DATA_VALUE


def _read_files(pdu: bytes) -> ExceptionCode | None:
    if len(pdu) < 2 or not 0x07 <= pdu[1] <= 0xF5 or pdu[1] % 7 or len(pdu) != 2 + pdu[1]:
        return ExceptionCode.ILLEGAL_DATA_VALUE
    groups = [pdu[at : at + 7] for at in range(2, len(pdu), 7)]
    if sum(2 + 2 * _word(group, 7) for group in groups) > 0xF5:  # the answer's data would not fit (V1.1b3, 6.14)
        return ExceptionCode.ILLEGAL_DATA_VALUE
    return None if all(map(_record_exists, groups)) else ExceptionCode.ILLEGAL_DATA_ADDRESS


def _write_files(pdu: bytes) -> ExceptionCode | None:
    if len(pdu) < 2 or not 0x09 <= pdu[1] <= 0xFB or len(pdu) != 2 + pdu[1]:
        return ExceptionCode.ILLEGAL_DATA_VALUE
    at, groups = 2, []
    while at < len(pdu):
        group = pdu[at : at + 7]
        at += 7 + 2 * _word(group, 7) if len(group) == 7 else len(pdu)
        groups.append(group)
    if at != len(pdu):
        return ExceptionCode.ILLEGAL_DATA_VALUE
    return None if all(map(_record_exists, groups)) else ExceptionCode.ILLEGAL_DATA_ADDRESS


def _record_exists(group: bytes) -> bool:
    """Reference type, file and record numbers of one sub-request."""
    first, count = _word(group, 5), _word(group, 7)
    return group[0] == REFERENCE_TYPE and _word(group, 3) > 0 and count > 0 and first + count - 1 <= LAST_FILE_RECORD


def _mask_write(pdu: bytes) -> ExceptionCode | None:
    return None if len(pdu) == 7 else ExceptionCode.ILLEGAL_DATA_VALUE


def _read_write(pdu: bytes) -> ExceptionCode | None:
    if len(pdu) < 10 or not 1 <= _word(pdu, 5) <= 0x7D or not 1 <= _word(pdu, 9) <= 0x79:
        return ExceptionCode.ILLEGAL_DATA_VALUE
    if pdu[9] != 2 * _word(pdu, 9) or len(pdu) != 10 + pdu[9]:
        return ExceptionCode.ILLEGAL_DATA_VALUE
    inside = _word(pdu, 3) + _word(pdu, 5) <= ADDRESSES and _word(pdu, 7) + _word(pdu, 9) <= ADDRESSES
    return None if inside else ExceptionCode.ILLEGAL_DATA_ADDRESS


def _queue(pdu: bytes) -> ExceptionCode | None:
    return None if len(pdu) == 3 else ExceptionCode.ILLEGAL_DATA_VALUE


def _interface(pdu: bytes) -> ExceptionCode | None:
    """FC 43: the type of interface belongs to the function; then the code of the objects to read (V1.1b3, 6.21)."""
    if len(pdu) >= 2 and pdu[1] != IDENTIFICATION:
        return ExceptionCode.ILLEGAL_FUNCTION
    return None if len(pdu) == 4 and 1 <= pdu[2] <= 4 else ExceptionCode.ILLEGAL_DATA_VALUE


OTHERS: dict[int, Callable[[bytes], ExceptionCode | None]] = {
    7: _bare,
    8: _diagnosis,
    11: _bare,
    12: _bare,
    17: _bare,
    20: _read_files,
    21: _write_files,
    22: _mask_write,
    23: _read_write,
    24: _queue,
    43: _interface,
}
