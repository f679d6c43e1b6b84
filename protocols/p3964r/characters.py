"""Control characters, block check and block form of 3964R.  Source: rho 3 Releases part 1, section 7.1 (below: 7.1)."""

from enum import IntEnum


class Char(IntEnum):
    """Control characters; 7.1 names them, the values are those of ASCII."""

    STX = 0x02
    ETX = 0x03
    DLE = 0x10
    NAK = 0x15
    ETB = 0x17  # ends follow-on telegrams of some process computers in place of ETX (Bosch R500 interface manual, BUEP64)


STX, ETX, DLE, NAK, ETB = map(int, Char)  # plain numbers for comparisons at every character: Char.DLE costs a search in its class
DLE_BYTE, DLE_PAIR = bytes((DLE,)), bytes((DLE, DLE))


def check_of(data: bytes) -> int:
    """Exclusive or of all bytes, 0..255; start value 0, not complemented (7.1)."""
    folded, shift, bits = int.from_bytes(data, "little"), 8, 8 * len(data)
    while shift < bits:  # afterwards the lowest byte holds twice as many as before
        folded ^= folded >> shift
        shift += shift
    return folded & 0xFF


def wire_block(data: bytes, block_check: bool = True, end: Char = Char.ETX) -> bytes:
    """All that follows STX and the partner's DLE: data with every DLE doubled, DLE ETX and the check.

    The check covers every character after STX, both of a doubled DLE included; it is sent once, even when it equals DLE.
    """
    body = data.replace(DLE_BYTE, DLE_PAIR) + bytes((DLE, end))
    return body + bytes((check_of(body),)) if block_check else body
