"""Telegram forms of RK512: command headers, follow-on telegrams, reactions, error numbers.  All values high byte first.

Sources: SIMATIC CP 341 manual 09/2008 (RK512); error numbers: WinCC OA documentation (RK512 driver), WAGO library documentation
1.6.1.0; choices between them: AX-053; data types other than D: AX-223.
"""

from dataclasses import dataclass
from enum import IntEnum

from protocols.base.errors import DecodeError, EncodeError

HEADER_BYTES = 10
FOLLOW_ON_BYTES = 4
MOST_BYTES = 128  # data bytes in one telegram
MOST_WORDS = MOST_BYTES // 2
REACTION_BYTES = 4


class ErrorNumber(IntEnum):
    """Byte 4 of the reaction telegram."""

    NONE = 0x00
    NOT_ALLOWED = 0x0A  # access to the area not possible or not allowed
    TYPE_INVALID = 0x0C
    HEADER = 0x10  # byte 1 or 2 wrong; more than this station serves in follow-on telegrams
    TYPE_NOT_SERVED = 0x12
    BLOCK = 0x14  # data block missing or too short, number not allowed
    COMMAND = 0x16  # byte 3 wrong
    STOPPED = 0x2A  # partner in STOP
    LOCKED = 0x32  # locked by coordination flag
    LENGTH = 0x34
    SEQUENCE = 0x36  # follow-on without a first telegram, or a first one instead of a follow-on

    @classmethod
    def _missing_(cls, value: object) -> "ErrorNumber | None":
        """Any other byte: partners have numbers of their own, which are passed on unchanged."""
        if not isinstance(value, int) or not 0 <= value <= 0xFF:
            return None
        member = int.__new__(cls, value)
        member._name_, member._value_ = f"NUMBER_{value:02X}", value
        return member


class Command(IntEnum):
    """Byte 3."""

    SEND = 0x41  # 'A' to a data block
    SEND_EXTENDED = 0x4F  # 'O' to an extended data block
    FETCH = 0x45  # 'E'


class Kind(IntEnum):
    """Byte 4, meaning of the address; S7 writes I Q F C for E A M Z."""

    BLOCK = 0x44  # 'D' data block: number, word
    EXTENDED = 0x58  # 'X' extended data block: number, word
    INPUTS = 0x45  # 'E' byte
    OUTPUTS = 0x41  # 'A' byte
    FLAGS = 0x4D  # 'M' byte
    TIMERS = 0x54  # 'T' number
    COUNTERS = 0x5A  # 'Z' number

    @property
    def unit(self) -> int:
        """Bytes for one of the amount: words are 2."""
        return 1 if self in (Kind.INPUTS, Kind.OUTPUTS, Kind.FLAGS) else 2

    @property
    def in_blocks(self) -> bool:
        """Byte 5 is a block number, byte 6 a word; otherwise both are one address."""
        return self in (Kind.BLOCK, Kind.EXTENDED)


BLOCK_TYPE = int(Kind.BLOCK)
KINDS = bytes(Kind)
OTHER_TYPES = b"PBS"  # peripherals, memory, system: known to older stations only
FIRST, FOLLOW_ON = 0x00, 0xFF
NO_FLAG = 0xFF


@dataclass(frozen=True, slots=True)
class Flag:
    """Coordination flag: `M byte.bit` of the passive station; cpu 1..4, 0: without CPU."""

    byte: int
    bit: int
    cpu: int = 0


@dataclass(frozen=True, slots=True)
class Header:
    """A command telegram's first ten bytes; `db` byte 5, `address` byte 6, `amount` as they are there, `flag` None: FF FF."""

    command: int
    kind: int
    db: int
    address: int
    amount: int
    flag: Flag | None = None

    def encode(self) -> bytes:
        values = {"db": self.db, "address": self.address, "command": self.command, "kind": self.kind}
        for name, value in values.items():
            if not 0 <= value <= 0xFF:
                raise EncodeError(f"{name} = {value}, range 0..255")
        if not 0 <= self.amount <= 0xFFFF:
            raise EncodeError(f"amount = {self.amount}, range 0..65535")
        head = bytes((FIRST, 0, self.command, self.kind, self.db, self.address))
        return head + self.amount.to_bytes(2, "big") + _flag_bytes(self.flag)


def _flag_bytes(flag: Flag | None) -> bytes:
    if flag is None:
        return bytes((NO_FLAG, NO_FLAG))
    if not (0 <= flag.byte < NO_FLAG and 0 <= flag.bit <= 7 and 0 <= flag.cpu <= 4):
        raise EncodeError(f"{flag}: byte 0..254, bit 0..7, cpu 0..4")
    return bytes((flag.byte, flag.cpu << 4 | flag.bit))


def decode_header(data: bytes) -> Header:
    """The fields of a command telegram (the data after the header are ignored); DecodeError if it is too short."""
    if len(data) < HEADER_BYTES:
        raise DecodeError(f"{HEADER_BYTES} bytes expected, {len(data)} received: {data.hex(' ')}")
    flag = None if data[8] == NO_FLAG else Flag(data[8], data[9] & 0x0F, data[9] >> 4)
    return Header(data[2], data[3], data[4], data[5], int.from_bytes(data[6:8], "big"), flag)


def encode_follow_on(command: int, kind: int, data: bytes = b"") -> bytes:
    """The next piece of a SEND, or the wish for the next piece of a FETCH."""
    return bytes((FOLLOW_ON, 0, command, kind)) + data


def encode_reaction(number: int, data: bytes = b"", follow_on: bool = False) -> bytes:
    """Reaction telegram; data only of a FETCH without error."""
    return bytes((FOLLOW_ON if follow_on else FIRST, 0, 0, number)) + data


def is_reaction(data: bytes) -> bool:
    """00 or FF, 00, 00, number: the answer to a command, not a command."""
    return len(data) >= REACTION_BYTES and data[0] in (FIRST, FOLLOW_ON) and data[1] == 0 and data[2] == 0
