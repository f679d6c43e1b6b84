"""pcapng out of turns of a line, or of CAN frames: one section, one interface, one packet a turn, stamps in nanoseconds.

Format: draft-ietf-opsawg-pcapng (Section Header, Interface Description, Enhanced Packet Block).  Link type 147 (USER0): every packet
begins with our pseudo header of 8 bytes, which configs/wireshark/axisgate_3964r.lua reads (AX-197):

    byte 0     version, 1
    byte 1     direction: 0 = A to B, 1 = B to A
    byte 2     kind: 1 STX, 2 DLE, 3 NAK, 4 block, 5 broken block, 6 stray characters
    byte 3     flags: 01 parity, 02 framing, 04 overrun, 08 break, 10 did not arrive, 20 arrived altered, 40 no block check (3964)
    byte 4..7  microseconds from the first to the last character, high byte first
    byte 8..   the characters as they were on the line
"""

import struct
from collections.abc import Iterable

from gateway.pure.lines.turns import Turn
from protocols.base.machine import Frame, Ns

USER0, SOCKETCAN = 147, 227
VERSION = 1
_SHB, _IDB, _EPB = 0x0A0D0D0A, 1, 6
_COMMENT, _SHB_USERAPPL, _IF_NAME, _IF_TSRESOL = 1, 4, 2, 9
_NANOSECONDS = b"\x09"


def pcapng(packets: Iterable[Turn], line: str, comment: str = "", offset_ns: Ns = 0) -> bytes:
    """The file.  `offset_ns` is added to every stamp (monotonic clock -> Unix time)."""
    section = struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1)
    head = _block(_SHB, section, [(_COMMENT, comment.encode()), (_SHB_USERAPPL, b"axisgate")])
    interface = _block(_IDB, struct.pack("<HHI", USER0, 0, 0), [(_IF_NAME, line.encode()), (_IF_TSRESOL, _NANOSECONDS)])
    return head + interface + b"".join(_packet(turn, offset_ns) for turn in packets)


def payload(turn: Turn) -> bytes:
    """Pseudo header and characters."""
    spent_us = min((turn.last_ns - turn.first_ns) // 1000, 0xFFFF_FFFF)
    return struct.pack(">BBBBI", VERSION, turn.side == "B", turn.kind, turn.flags, spent_us) + bytes(turn.data)


def can_pcapng(frames: Iterable[Frame], interface: str, offset_ns: Ns = 0) -> bytes:
    """A recorded CAN bus: link type 227 (CAN_SOCKETCAN), identifier high byte first with bit 31 for extended frames."""
    head = _block(_SHB, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1), [(_SHB_USERAPPL, b"axisgate")])
    head += _block(_IDB, struct.pack("<HHI", SOCKETCAN, 0, 0), [(_IF_NAME, interface.encode()), (_IF_TSRESOL, _NANOSECONDS)])
    return head + b"".join(_can_packet(frame, offset_ns) for frame in frames)


def _can_packet(frame: Frame, offset_ns: Ns) -> bytes:
    data = struct.pack(">IB3x", frame.identifier, len(frame.data)) + frame.data
    stamp = max(frame.stamp_ns + offset_ns, 0)
    return _block(_EPB, struct.pack("<IIIII", 0, stamp >> 32, stamp & 0xFFFF_FFFF, len(data), len(data)) + _padded(data), [])


def _packet(turn: Turn, offset_ns: Ns) -> bytes:
    data = payload(turn)
    stamp = max(turn.first_ns + offset_ns, 0)
    fixed = struct.pack("<IIIII", 0, stamp >> 32, stamp & 0xFFFF_FFFF, len(data), len(data))
    return _block(_EPB, fixed + _padded(data), [(_COMMENT, "; ".join(turn.remarks).encode())])


def _block(kind: int, body: bytes, options: list[tuple[int, bytes]]) -> bytes:
    given = [(code, value) for code, value in options if value]
    for code, value in given:
        body += struct.pack("<HH", code, len(value)) + _padded(value)
    if given:
        body += struct.pack("<HH", 0, 0)
    length = struct.pack("<I", len(body) + 12)
    return struct.pack("<I", kind) + length + body + length


def _padded(data: bytes) -> bytes:
    return data + bytes(-len(data) % 4)
