"""BNR files for MOVE_FILE: a header of 80 bytes, then REAL32 positions, cycle by cycle, without separators.

Source: rho 3 Releases part 2 (TO05), section 5.1 (L6968-7076); data format 4.3 (L6942-6944).  Low byte first (doubt D-53).  The manual's
figure prints its addresses in hex; 80, 400, 500 in it are decimal field values (L6983-7005).
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

from motion.errors import MotionError

HEADER = 80  # bytes of a file made by the control
RESERVE = 14
TO05 = 500
INTERPOLATION, POSITION_LOOP = 1, 2  # IP/PL base
_FIELDS = struct.Struct(f"<{6 + RESERVE}i")


class BnrError(MotionError):
    """Bytes or values that make no such file."""


@dataclass(frozen=True, slots=True)
class Header:
    """The fields in their order.  time_base_us: P5 x 1000, divided by the servo divider for base 2."""

    length: int = HEADER
    base: int = INTERPOLATION
    time_base_us: int = 0
    axes: int = 1
    version: int = TO05
    base_check_off: int = 0  # 1: neither base nor time base is compared; every other value: both are
    reserve: tuple[int, ...] = (0,) * RESERVE


def encode(header: Header, points: Sequence[Sequence[float]]) -> bytes:
    """Header and points (axes,) in mm or deg -> the file.  A longer header is filled up with zeros."""
    if header.length < HEADER or len(header.reserve) != RESERVE:
        raise BnrError(f"header of {header.length} bytes with {len(header.reserve)} reserves: {HEADER} and {RESERVE} are the least")
    numbers = (header.length, header.base, header.time_base_us, header.axes, header.version, header.base_check_off, *header.reserve)
    wrong = next((n for n, point in enumerate(points, 1) if len(point) != header.axes), 0)
    if wrong:
        raise BnrError(f"point {wrong} has {len(points[wrong - 1])} components, the header announces {header.axes}")
    flat = [value for point in points for value in point]
    try:
        return _FIELDS.pack(*numbers) + bytes(header.length - HEADER) + struct.pack(f"<{len(flat)}f", *flat)
    except (struct.error, OverflowError) as error:
        raise BnrError(f"a value does not fit its four bytes: {error}") from error


def decode_header(data: bytes) -> Header:
    """First 80 bytes -> Header; of a file cut shorter nothing is guessed."""
    if len(data) < HEADER:
        raise BnrError(f"{len(data)} bytes: the header has {HEADER}")
    numbers = _FIELDS.unpack_from(data)
    return Header(numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5], numbers[6:])


def points(data: bytes, axes: int, offset: int) -> tuple[tuple[float, ...], ...]:
    """Positions from this byte to the end, (cycles,) of (axes,), as they are in the file."""
    size = 4 * axes
    if axes < 1 or not 0 <= offset <= len(data) or (len(data) - offset) % size:
        raise BnrError(f"{len(data) - offset} bytes from byte {offset} are not a whole number of points of {axes} axes")
    return tuple(struct.iter_unpack(f"<{axes}f", data[offset:]))
