"""Fault information of a requesting Bosch PLC (RST): class and code, hexadecimal.

Source: R500 interface manual 1070 072 131-102, chapter 9.
"""

from dataclasses import dataclass
from enum import Enum, auto


class Cause(Enum):
    """Cause of the fault, as seen by the RST."""

    TIME = auto()
    ATTEMPTS = auto()
    OPENING = auto()
    NOT_READABLE = auto()
    DM_NUMBER = auto()
    DM_MISSING = auto()
    DM_TOO_SMALL = auto()
    PARTNER_DM = auto()
    PARTNER_ADDRESS = auto()
    AMOUNT = auto()


@dataclass(frozen=True, slots=True)
class Fault:
    """As a Bosch programming unit shows it: class 34 is the line, class 33 the job."""

    klass: int
    code: int
    words: str

    def __str__(self) -> str:
        return f"{self.klass:02X}/{self.code:02X} {self.words}"


REDUCED_LENGTH = 0x20  # not a fault: less than requested was transferred
FAULTS = {
    Cause.TIME: Fault(0x34, 0xF7, "time monitoring"),
    Cause.ATTEMPTS: Fault(0x34, 0xF9, "attempts exceeded"),
    Cause.OPENING: Fault(0x34, 0xFE, "line opening: character other than STX"),
    Cause.NOT_READABLE: Fault(0x34, 0xFF, "nothing interpretable received"),
    Cause.DM_NUMBER: Fault(0x33, 0xD6, "DM number too large"),
    Cause.DM_MISSING: Fault(0x33, 0xD7, "DM missing"),
    Cause.DM_TOO_SMALL: Fault(0x33, 0xD8, "DM too small"),
    Cause.PARTNER_DM: Fault(0x33, 0xED, "wrong partner DM number"),
    Cause.PARTNER_ADDRESS: Fault(0x33, 0xEC, "wrong partner address"),
    Cause.AMOUNT: Fault(0x33, 0xF3, "amount wrong"),
}


def fault_of(cause: Cause) -> Fault:
    """Class, code and words."""
    return FAULTS[cause]
