"""The blocks a recording file is made of (AX-483): docs/guide/record.md has the table.

File: MAGIC (8 bytes), then blocks.  Block: mark "AXB1", kind u8, three zero bytes, length of the payload u32, CRC-32 u32 over kind to
length and payload, payload.  Little endian.  An incomplete block of a killed writer is ignored; a corrupted block is counted and reported
with its place, and the search continues at the next mark with a correct CRC.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import IntEnum

MAGIC = b"AXREC1\r\n"
MARK = b"AXB1"
HEAD = struct.Struct("<4sBxxxII")
LARGEST = 64 << 20


class Kind(IntEnum):
    """Blocks."""

    HEAD = 1  # JSON: what was recorded
    CELL = 2  # ZIP: the backup of the cell at the beginning
    START = 3  # JSON: a state at rest; cycles that follow continue it
    CYCLES = 4  # messages of cycles
    LOST = 5  # JSON: the missing records, and the reason
    END = 6  # JSON: the recording was ended on purpose


@dataclass(slots=True)
class Scan:
    """Findings of the reading other than blocks."""

    spoiled: list[int] = field(default_factory=list)  # places in the file at which a block should have been
    cut: int = 0  # bytes of a half block at the end


def encode(kind: Kind, payload: bytes) -> bytes:
    """One block."""
    covered = struct.pack("<BxxxI", kind, len(payload))
    return MARK + covered + struct.pack("<I", zlib.crc32(payload, zlib.crc32(covered))) + payload


def decode(octets: bytes, scan: Scan) -> Iterator[tuple[int, Kind, bytes]]:
    """Yield (place, kind, payload) of all complete blocks after MAGIC, in order."""
    at = len(MAGIC)
    while at < len(octets):
        found = _block(octets, at)
        if found is not None:
            yield at, *found
            at += HEAD.size + len(found[1])
            continue
        following = _next(octets, at + 1)
        if following is None:
            scan.cut = len(octets) - at
            if scan.cut >= HEAD.size and _length(octets, at) <= scan.cut - HEAD.size:
                scan.spoiled.append(at)  # it is all there, and wrong
            return
        scan.spoiled.append(at)
        at = following


def whole_length(octets: bytes) -> int:
    """Return the bytes up to the end of the last complete block, where a returning writer continues."""
    end = len(MAGIC)
    for at, _, payload in decode(octets, Scan()):
        end = at + HEAD.size + len(payload)
    return end


def _length(octets: bytes, at: int) -> int:
    return int.from_bytes(octets[at + 8 : at + 12], "little")


def _block(octets: bytes, at: int) -> tuple[Kind, bytes] | None:
    if len(octets) - at < HEAD.size:
        return None
    mark, kind, size, check = HEAD.unpack_from(octets, at)
    if mark != MARK or size > LARGEST or at + HEAD.size + size > len(octets) or kind not in set(Kind):
        return None
    payload = octets[at + HEAD.size : at + HEAD.size + size]
    return (Kind(kind), payload) if zlib.crc32(payload, zlib.crc32(octets[at + 4 : at + 12])) == check else None


def _next(octets: bytes, at: int) -> int | None:
    """Return the next place with a complete block."""
    while (at := octets.find(MARK, at)) >= 0:
        if _block(octets, at) is not None:
            return at
        at += 1
    return None
