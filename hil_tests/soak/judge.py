"""The independent judge of the soak: reads what was sent and received on the line, and uses no receiver or sender of axisgate.

Written from serial-protocols 1.2 to 1.4; imports nothing of protocols.p3964r or protocols.rk512.  What it cannot trace to a fault that
framing, check and marks cannot show is a failure.
"""

from collections.abc import Sequence

from hil_tests.soak.faulted_line import SPOILED, Item, Record
from protocols.base.machine import Ns

STX, ETX, DLE, ETB = 0x02, 0x03, 0x10, 0x17
LOOK_BACK = 8  # openings of the listener that may belong to the block just taken
FIFO = 17  # characters that may have come in one burst behind the block


def payload_of(wire: bytes) -> bytes | None:
    """Return the data of a block as it was sent (data doubled, end, check); None: not a block."""
    data, at = bytearray(), 0
    while at + 1 < len(wire):
        if wire[at] == DLE and wire[at + 1] in (ETX, ETB):
            return bytes(data)
        at += 1 if wire[at] == DLE else 0
        data.append(wire[at])
        at += 1
    return None


def framed(heard: Sequence[Item], start: int, longest_gap: Ns, with_check: bool = True) -> tuple[bytes, int] | None:
    """Return the block whose first character is at `start`, if nothing in it is wrong: its data and the index after its end."""
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
            if not with_check:
                return bytes(data), at
            if at >= len(heard) or heard[at][1] != check or heard[at][0] - before >= longest_gap:
                return None
            return bytes(data), at + 1
        else:
            return None
    return None


def taken(speaker: Record, listener: Record, data: bytes, longest_gap: Ns, with_check: bool) -> tuple[int, int] | None:
    """Return start and end of this block in what the listener received, without a fault that framing, check or marks show.

    It begins where the listener sent DLE with the STX as the last character received: a block whose first character arrived before
    the DLE was sent did not wait for it, which is a fault of framing.
    """
    heard = speaker.heard
    openings = [said.heard_at for said in listener.said[-3 * LOOK_BACK :] if not said.is_block and DLE in said.data][-LOOK_BACK:]
    for start in reversed(openings):
        if start == 0 or heard[start - 1][1] != STX:
            continue
        found = framed(heard, start, longest_gap, with_check)
        if found is not None and found[0] == data and found[1] > len(heard) - FIFO:
            return start, found[1]
    return None


def answer_of(back: Record, since: Ns) -> int | None:
    """Return the index of the first DLE received from this moment on: the one that counted as the acknowledgement."""
    at = len(back.heard)
    while at > 0 and back.heard[at - 1][0] >= since:
        at -= 1
    return next((index for index in range(at, len(back.heard)) if back.heard[index][1] == DLE), None)


def why_acknowledged(mine: Record, back: Record, block: int, since: Ns) -> tuple[str, str]:
    """Return what counted as the acknowledgement of said[block], which was never delivered: class and bytes; class "" is a failure."""
    at = answer_of(back, since)
    if at is None:
        return "", "no DLE was heard"
    number, place = back.origins[at]
    said = back.said[number]
    heard = " ".join(f"{item:02X}" if isinstance(item, int) else item.name for _, item in back.heard[max(0, at - 3) : at + 4])
    words = f"said {said.data[:12].hex(' ')} ({said.fault or 'no fault'}), heard {heard}"
    if place == SPOILED:
        return "a spoiled character reads 10h", words
    if said.is_block:
        return ("a 10h of data out of its turn" if any(each.fault for each in (*mine.said, *back.said)) else ""), words
    if said.fault == "delay":
        return "a DLE said to a STX came late", words
    return "", words
