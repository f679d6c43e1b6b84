"""Which requests are legal: a table on the raw PDU, asked in the order of the flow charts of V1.1b3, sections 6.1 to 6.12.

First the function (01), then structure, quantity, byte count and value (03), then the address range (02); only after these a view
is asked, which may answer 02 for a range it does not have or 04 when doing it failed.
"""

from collections.abc import Container
from dataclasses import dataclass

from protocols.modbus.view import ExceptionCode

ADDRESSES = 0x10000  # of each table (V1.1b3, 4.4)
ADDRESS_END, FIXED_END, DATA_START = 3, 5, 6  # function | address, 2 | quantity or value, 2 | byte count | data


@dataclass(frozen=True, slots=True)
class Rule:
    """One function code: what may stand in the word after the address, and what follows it."""

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


def refusal(pdu: bytes, may_write: bool = True) -> ExceptionCode | None:
    """Why this request (1 byte or more) must not be done, None when it may; a partner who may only read is refused by 01 (AX-070)."""
    rule = RULES.get(pdu[0])
    if rule is None or (rule.writes and not may_write):
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
