"""Bits of a classic CAN frame: CRC-15, stuff bits, time on the wire.

Source: ISO 11898-1:2015, 10.4.2 (data and remote frames), 10.5 (bit stuffing), 10.4.2.6 (CRC sequence); figures: can.md C4.
A frame is SOF .. CRC sequence (stuffed), then CRC delimiter, ACK slot and delimiter, 7 bits EOF and 3 bits interframe space, unstuffed.
"""

from functools import cache

POLYNOMIAL = 0x4599  # x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1
TAIL = 13  # CRC delimiter 1, ACK 2, EOF 7, interframe space 3
BASE_HEAD, EXTENDED_HEAD = 19, 39  # SOF, identifier, RTR (SRR), IDE, reserved, DLC
CRC_BITS = 15
MOST_IN_A_ROW = 5  # equal bits; then a stuff bit of the other kind
START = 0  # stuffing state: nothing sent yet; 1..4 so many zeros in a row, 5..8 so many ones less 4


def _crc_step(crc: int, bit: int) -> int:
    return ((crc << 1) & 0x7FFF) ^ (POLYNOMIAL if (crc >> 14) ^ bit else 0)


def _crc_bits(crc: int, value: int, bits: int) -> int:
    for at in range(bits - 1, -1, -1):
        crc = _crc_step(crc, value >> at & 1)
    return crc


def _stuff_step(state: int, bit: int) -> tuple[int, int]:
    """Next state and whether a stuff bit follows this bit; the stuff bit begins the next run."""
    run = 1
    if state != START and (state > 4) == bool(bit):
        run = (state - 4 if state > 4 else state) + 1
    if run == MOST_IN_A_ROW:
        return (1 if bit else 5), 1
    return (run + 4 if bit else run), 0


def _stuff_bits(state: int, value: int, bits: int) -> tuple[int, int]:
    count = 0
    for at in range(bits - 1, -1, -1):
        state, more = _stuff_step(state, value >> at & 1)
        count += more
    return state, count


_CRC_BYTE = tuple(_crc_bits(0, value, 8) for value in range(256))
_STUFF_BYTE = tuple(_stuff_bits(state, value, 8) for state in range(9) for value in range(256))
_STUFF_SEVEN = tuple(_stuff_bits(state, value, 7) for state in range(9) for value in range(128))


@cache
def _head(identifier: int, dlc: int, extended: bool, remote: bool) -> tuple[int, int, int]:
    """CRC, stuffing state and stuff bits after the DLC."""
    if extended:
        base, rest = identifier >> 18, identifier & 0x3FFFF
        value, bits = (((base << 2 | 3) << 18 | rest) << 1 | remote) << 6 | dlc, EXTENDED_HEAD
    else:
        value, bits = (identifier << 1 | remote) << 6 | dlc, BASE_HEAD
    state, count = _stuff_bits(START, value, bits)
    return _crc_bits(0, value, bits), state, count


def stuff_bits(identifier: int, data: bytes = b"", *, extended: bool = False, remote: bool = False) -> int:
    """Number of stuff bits of this frame.

    identifier: 11 bits (29 when extended); data: 0..8 bytes, for a remote frame as many as it requests.  ValueError on anything else.
    """
    _check(identifier, len(data), extended)
    crc, state, count = _head(identifier, len(data), extended, remote)
    for byte in b"" if remote else data:
        crc = (crc << 8 & 0x7FFF) ^ _CRC_BYTE[(crc >> 7) ^ byte]
        state, more = _STUFF_BYTE[state << 8 | byte]
        count += more
    state, more = _STUFF_BYTE[state << 8 | crc >> 7]
    return count + more + _STUFF_SEVEN[state << 7 | crc & 0x7F][1]


def frame_bits(identifier: int, data: bytes = b"", *, extended: bool = False, remote: bool = False) -> int:
    """Length of this very frame in bits, stuff bits and interframe space included."""
    stuffed = stuff_bits(identifier, data, extended=extended, remote=remote)
    return plain_bits(0 if remote else len(data), extended=extended) + stuffed


def plain_bits(length: int, *, extended: bool = False) -> int:
    """Bits of a frame with `length` data bytes without stuffing: 47 + 8 n (67 + 8 n extended)."""
    return (EXTENDED_HEAD if extended else BASE_HEAD) + CRC_BITS + 8 * length + TAIL


def worst_bits(length: int, *, extended: bool = False) -> int:
    """The greatest length of a frame: a stuff bit after the first five bits and after each four more."""
    stuffable = plain_bits(length, extended=extended) - TAIL
    return stuffable + (stuffable - 1) // 4 + TAIL


def _check(identifier: int, length: int, extended: bool) -> None:
    most = 0x1FFFFFFF if extended else 0x7FF
    if not 0 <= identifier <= most:
        raise ValueError(f"CAN identifier {identifier:#x}: 0..{most:#x}")
    if length > 8:
        raise ValueError(f"CAN frame {identifier:#x}: {length} bytes, at most 8")
