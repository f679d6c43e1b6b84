"""TCP conversations out of a capture as tcpdump and dumpcap write it: packets, both directions put into their order.  Pure.

Formats: pcap (magic A1B2C3D4h in us, A1B23C4Dh in ns, either byte order), link types 1 Ethernet, 12 and 101 raw IP, 113 and 276 Linux
cooked; IPv4 (RFC 791), IPv6 without extension headers (RFC 8200), TCP (RFC 9293).  Fragments and packets cut by the capture are left out.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from protocols.base.errors import DecodeError
from protocols.base.machine import Ns

HEAD, RECORD = 24, 16
MAGICS = {0xA1B2C3D4: 1000, 0xA1B23C4D: 1}  # ns of the fraction's unit
ETHERNET, COOKED, COOKED2, RAW = 1, 113, 276, (12, 101)
LONGEST = 1 << 18
VLAN, IPV4, IPV6, TCP = (0x8100, 0x88A8), 0x0800, 0x86DD, 6
SYN, RST = 0x02, 0x04
HELD = 32  # segments held after a missing one; beyond, it was lost on the way to the capture, not to the partner
WRAP = 1 << 32


class Packet(NamedTuple):
    """One of the capture; stamp: wall clock of the machine that captured."""

    stamp: Ns
    link: int
    data: bytes


class Capture:
    """The stream of a capture, in pieces of any size.  DecodeError: it is none."""

    def __init__(self) -> None:
        self._rest = b""
        self._order, self._unit, self._link = "", 0, 0

    def feed(self, data: bytes) -> Iterator[Packet]:
        """Packets that are complete now."""
        self._rest += data
        if not self._order and not self._begun():
            return
        while len(self._rest) >= RECORD:
            seconds, fraction, size, whole = struct.unpack_from(f"{self._order}IIII", self._rest)
            if size > LONGEST:
                raise DecodeError(f"a packet of {size} bytes: no capture, or one that was cut")
            if len(self._rest) < RECORD + size:
                return
            packet, self._rest = self._rest[RECORD : RECORD + size], self._rest[RECORD + size :]
            if size == whole:
                yield Packet(seconds * 1_000_000_000 + fraction * self._unit, self._link, packet)

    def _begun(self) -> bool:
        if len(self._rest) < HEAD:
            return False
        for order in "<>":
            (magic,) = struct.unpack_from(f"{order}I", self._rest)
            if magic in MAGICS:
                self._order, self._unit = order, MAGICS[magic]
                self._link = struct.unpack_from(f"{order}I", self._rest, 20)[0] & 0xFFFF
                self._rest = self._rest[HEAD:]
                return True
        raise DecodeError(f"begins with {self._rest[:4].hex(' ')}: no pcap; tcpdump -w - writes one, dumpcap with -P")


class Segment(NamedTuple):
    """TCP: addresses as bytes."""

    source: tuple[bytes, int]
    target: tuple[bytes, int]
    sequence: int
    flags: int
    data: bytes


def segment_of(packet: Packet) -> Segment | None:
    """None: no TCP, or cut."""
    try:
        found = _ip(packet)
        return None if found is None else _tcp(*found)
    except (struct.error, IndexError):
        return None


def _ip(packet: Packet) -> tuple[bytes, bytes, bytes] | None:
    """Source, target, payload of TCP over IP."""
    data = _network(packet)
    if data[0] >> 4 == 4:
        head, whole = (data[0] & 15) * 4, int.from_bytes(data[2:4], "big")
        fragment = int.from_bytes(data[6:8], "big") & 0x3FFF
        return (data[12:16], data[16:20], data[head:whole]) if data[9] == TCP and not fragment else None
    if data[0] >> 4 == 6 and data[6] == TCP:
        return data[8:24], data[24:40], data[40 : 40 + int.from_bytes(data[4:6], "big")]
    return None


def _network(packet: Packet) -> bytes:
    data = packet.data
    if packet.link == ETHERNET:
        at = 12
        while int.from_bytes(data[at : at + 2], "big") in VLAN:
            at += 4
        return data[at + 2 :] if int.from_bytes(data[at : at + 2], "big") in (IPV4, IPV6) else b"\0"
    if packet.link == COOKED:
        return data[16:]
    if packet.link == COOKED2:
        return data[20:]
    return data if packet.link in RAW else b"\0"


def _tcp(source: bytes, target: bytes, data: bytes) -> Segment | None:
    ports = struct.unpack_from(">HHI", data)
    head, flags = (data[12] >> 4) * 4, data[13]
    return Segment((source, ports[0]), (target, ports[1]), ports[2], flags, data[head:])


@dataclass(slots=True)
class Flow:
    """One direction of one connection."""

    expected: int | None = None
    lost: int = 0  # times something was missing for good: what reads the bytes begins anew
    _held: dict[int, bytes] = field(default_factory=dict)

    def take(self, segment: Segment) -> bytes:
        """Bytes that are in order now."""
        if segment.flags & (SYN | RST):
            self._held.clear()
            self.expected = (segment.sequence + 1) % WRAP if segment.flags & SYN else None
            return b""
        if not segment.data:
            return b""
        if self.expected is None:  # it was under way before the capture began
            self.expected = segment.sequence
        if (segment.sequence - self.expected) % WRAP < WRAP // 2:
            self._held[segment.sequence] = segment.data
        elif (ahead := (segment.sequence + len(segment.data) - self.expected) % WRAP) < WRAP // 2:
            self._held[self.expected] = segment.data[len(segment.data) - ahead :]  # repeated, and more after it
        if len(self._held) > HELD:
            self.lost += 1
            self.expected = min(self._held, key=lambda at: (at - segment.sequence + WRAP // 2) % WRAP)
        return self._in_order()

    def _in_order(self) -> bytes:
        whole = b""
        while self.expected in self._held:
            data = self._held.pop(self.expected)
            whole += data
            self.expected = (self.expected + len(data)) % WRAP
        return whole
