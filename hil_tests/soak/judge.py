"""The independent judge of the soak: reads what was said and heard on the line, never asks a receiver of ours.

Written from serial-protocols 1.2 to 1.4; imports nothing of protocols.p3964r or protocols.rk512.
"""

from collections.abc import Sequence

from hil_tests.soak.faulted_line import Item, Record
from protocols.base.machine import Ns

STX, ETX, DLE, ETB = 0x02, 0x03, 0x10, 0x17
LOOK_BACK = 8  # openings of the listener that may belong to the block just taken
FIFO = 17  # characters that may have come in one burst behind the block


def payload_of(wire: bytes) -> bytes | None:
    """The data of a block as it was said (data doubled, end, check); None: not a block."""
    data, at = bytearray(), 0
    while at + 1 < len(wire):
        if wire[at] == DLE and wire[at + 1] in (ETX, ETB):
            return bytes(data)
        at += 1 if wire[at] == DLE else 0
        data.append(wire[at])
        at += 1
    return None


def framed(heard: Sequence[Item], start: int, longest_gap: Ns) -> tuple[bytes, int] | None:
    """The block whose first character stands at `start`, when nothing about it is wrong: its data and the index behind its check."""
    data, check, at, before = bytearray(), 0, start, -1
    escaped = False
    while at < len(heard):
        moment, item = heard[at]
        if not isinstance(item, int) or (before >= 0 and moment - before >= longest_gap):
            return None
        before, at = moment, at + 1
        check ^= item
        if not escaped:
            escaped = item == DLE
            if not escaped:
                data.append(item)
        elif item == DLE:
            data.append(item)
            escaped = False
        elif item in (ETX, ETB):
            if at >= len(heard) or heard[at][1] != check or heard[at][0] - before >= longest_gap:
                return None
            return bytes(data), at + 1
        else:
            return None
    return None


def could_be_taken(speaker: Record, listener: Record, data: bytes, longest_gap: Ns) -> bool:
    """The listener opened somewhere before and heard exactly this block without a fault that framing, check or marks show."""
    heard = speaker.heard
    openings = [said.heard_at for said in listener.said[-3 * LOOK_BACK :] if len(said.data) <= 3 and DLE in said.data][-LOOK_BACK:]
    for opening in reversed(openings):
        for start in range(opening, max(0, opening - FIFO), -1):
            if heard[start - 1][1] != STX:
                continue
            found = framed(heard, start, longest_gap)
            if found is not None and found[0] == data and found[1] > len(heard) - FIFO:
                return True
    return False
