"""Bytes of the local bus and of SocketCAN: struct can_frame, the 32-byte record, control records, error frames.

Source: linux/can.h (struct can_frame), linux/can/error.h; AX-092 (record and control records of the local bus).

A record is struct can_frame (16 bytes), stamp ns (u64), sequence (u64), native byte order.  Byte 5 of struct can_frame (its padding) holds
the number of the sender, 1..255, on the way from the broker; 0 on the way to it and in the broker's own messages.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from protocols.base.machine import Frame, FrameFault, Ns

EFF_FLAG, RTR_FLAG, ERR_FLAG = 0x80000000, 0x40000000, 0x20000000
ID_BITS = 0x1FFFFFFF
CONTROL = EFF_FLAG | RTR_FLAG | ERR_FLAG  # no CAN frame has all three
MAX_ID, MAX_DATA = 0x7FF, 8

RECORD = struct.Struct("=IBB2x8sQQ")  # id and flags, length, sender, data, stamp ns, sequence
CAN_FRAME = struct.Struct("=IB3x8s")
RECORD_BYTES, MAX_RECORDS = RECORD.size, 64  # of one message
MAX_MESSAGE = RECORD_BYTES * MAX_RECORDS
COUNT = struct.Struct("=Q")
_MESSAGES = tuple(struct.Struct("=" + "IBx2x8s16x" * count) for count in range(MAX_RECORDS + 1))  # on the way to the broker: no stamps yet


class Control(IntEnum):
    """Low bits of a control record's identifier."""

    GAP = (
        1  # first of every connection: sequence = the next frame's, data = the broker's start stamp; in the log's pipe: data = frames lost
    )
    STATS = 2  # to the broker: report your counters
    STATS_REPLY = 3  # data = length of the JSON text that follows, padded to full records
    TEXT = 4  # to the log writer only: data = length of the text that follows, padded to full records


@dataclass(slots=True)
class CanCounters:
    """Counters of a CAN port; it never drops a frame silently."""

    sent: int = 0
    received: int = 0
    refused: int = 0  # frames that send() did not accept because the output was full (EAGAIN, ENOBUFS)
    ignored: int = 0  # extended, remote or malformed frames that came in
    faults: int = 0  # error frames that came in
    gaps: int = 0  # frames known to be missed (sequence numbers)


def control_record(kind: Control, data: bytes, sequence: int = 0, stamp_ns: Ns = 0) -> bytes:
    """One control record; data has at most 8 bytes."""
    return RECORD.pack(CONTROL | kind, len(data), 0, data, stamp_ns, sequence)


def text_record(kind: Control, text: bytes, stamp_ns: Ns = 0) -> bytes:
    """A control record followed by a text of any length, padded to full records."""
    padded = text + bytes(-len(text) % RECORD_BYTES)
    return control_record(kind, COUNT.pack(len(text)), 0, stamp_ns) + padded


def check_frame(frame: Frame) -> None:
    """ValueError on a frame impossible in classic CAN: the caller's mistake."""
    if not 0 <= frame.identifier <= MAX_ID:
        raise ValueError(f"CAN identifier {frame.identifier:#x}: 0..{MAX_ID:#x}")
    if len(frame.data) > MAX_DATA:
        raise ValueError(f"CAN frame {frame.identifier}: {len(frame.data)} bytes ({frame.data.hex(' ')}), at most {MAX_DATA}")


def pack_records(frames: Sequence[Frame]) -> list[bytes]:
    """Messages of at most 64 records; ValueError on an impossible frame, before anything is sent."""
    fields: list[int | bytes] = []
    for frame in frames:
        identifier, data, _ = frame
        if not 0 <= identifier <= MAX_ID or len(data) > MAX_DATA:
            check_frame(frame)
        fields += (identifier, len(data), data)
    if len(frames) <= MAX_RECORDS:
        return [_MESSAGES[len(frames)].pack(*fields)] if frames else []
    ends = range(0, len(fields), 3 * MAX_RECORDS)
    return [_MESSAGES[len(part) // 3].pack(*part) for part in (fields[at : at + 3 * MAX_RECORDS] for at in ends)]


def fault_of(can_id: int, data: bytes) -> FrameFault:
    """The meaning of an error frame.  Source: linux/can/error.h (CAN_ERR_BUSOFF 40h, CAN_ERR_ACK 20h, CAN_ERR_CRTL 04h, data[1] 30h)."""
    if can_id & 0x40:
        return FrameFault.BUS_OFF
    if can_id & 0x04 and len(data) > 1 and data[1] & 0x30:
        return FrameFault.ERROR_PASSIVE
    return FrameFault.NO_ACK if can_id & 0x20 else FrameFault.OTHER
