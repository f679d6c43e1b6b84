"""PDOs: mapping words, transmission types, where their parameters are.  Source: CiA 301, 7.5.2.35..7.5.2.38."""

from dataclasses import dataclass

MOST_BITS = 64
MOST_ENTRIES = 64  # sub-indexes 1..64 of a mapping object
RPDO_COMMUNICATION, RPDO_MAPPING = 0x1400, 0x1600
TPDO_COMMUNICATION, TPDO_MAPPING = 0x1800, 0x1A00

SYNC_ACYCLIC = 0  # with the next SYNC, when its event happened
SYNC_LAST = 240  # 1..240: with every n-th SYNC
RTR_SYNC, RTR_EVENT = 252, 253  # sampled with SYNC, at once; sent on request
EVENT_MANUFACTURER, EVENT_PROFILE = 254, 255


@dataclass(frozen=True, slots=True)
class Mapped:
    """One entry of a mapping object."""

    index: int
    sub: int
    bits: int

    @property
    def word(self) -> int:
        return self.index << 16 | self.sub << 8 | self.bits


def mapped(word: int) -> Mapped:
    return Mapped(word >> 16 & 0xFFFF, word >> 8 & 0xFF, word & 0xFF)


def reserved(transmission: int) -> bool:
    """Transmission types 241..251."""
    return SYNC_LAST < transmission < RTR_SYNC


def synchronous(transmission: int) -> bool:
    """Sampled with SYNC."""
    return transmission <= SYNC_LAST or transmission == RTR_SYNC
