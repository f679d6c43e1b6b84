"""Requests of a PLC and answers of the old controller, paired by their transaction numbers, out of a capture of their Modbus TCP.  Pure.

Source: Modbus TCP guide, 3.1.3 (header), 4.2 (one transaction number for each open request of a connection).
"""

from dataclasses import dataclass, field
from typing import NamedTuple

from gateway.pure.shadow.packets import SYN, Flow, Packet, Segment, segment_of
from protocols.base.machine import Ns
from protocols.modbus.mbap import Closing, Framing, Request

OPEN = 64  # requests of one connection without an answer; older ones are forgotten
Endpoint = tuple[bytes, int]


class Asked(NamedTuple):
    """A request of the PLC."""

    client: Endpoint
    request: Request
    stamp: Ns


class Answered(NamedTuple):
    """The old controller's answer to it."""

    client: Endpoint
    request: Request
    pdu: bytes
    asked: Ns
    stamp: Ns


@dataclass(slots=True)
class _Side:
    """One direction: its bytes, and the frames in them."""

    flow: Flow = field(default_factory=Flow)
    framing: Framing = field(default_factory=Framing)
    lost: int = 0

    def frames(self, data: bytes, now: Ns) -> list[Request]:
        if self.flow.lost != self.lost:
            self.lost, self.framing = self.flow.lost, Framing()
        events = self.framing.receive(data, now)
        if any(isinstance(event, Closing) for event in events):
            self.framing = Framing()  # a capture may begin inside a frame; the next segment begins with one
        return [event for event in events if isinstance(event, Request)]


@dataclass(slots=True)
class _Connection:
    asks: _Side = field(default_factory=_Side)
    answers: _Side = field(default_factory=_Side)
    open: dict[int, tuple[Request, Ns]] = field(default_factory=dict)


class ModbusTalk:
    """All connections to one server.  `server`: address as bytes (empty: any) and port of the old controller."""

    def __init__(self, server: Endpoint) -> None:
        self._server = server
        self._connections: dict[Endpoint, _Connection] = {}
        self.characters = 0

    def take(self, packet: Packet, offset: Ns) -> list[Asked | Answered]:
        """`offset` is added to the stamp of the packet: wall clock of the capture -> our clock."""
        segment = segment_of(packet)
        if segment is None:
            return []
        stamp, mine = packet.stamp + offset, (self._is(segment.source), self._is(segment.target))
        if mine == (False, True):
            if segment.flags & SYN:
                self._connections[segment.source] = _Connection()
            return self._asked(segment.source, segment, stamp)
        return self._answered(segment.target, segment, stamp) if mine == (True, False) else []

    def _is(self, end: Endpoint) -> bool:
        address, port = self._server
        return end[1] == port and address in (b"", end[0])

    def _asked(self, client: Endpoint, segment: Segment, stamp: Ns) -> list[Asked | Answered]:
        connection = self._connections.setdefault(client, _Connection())
        found: list[Asked | Answered] = []
        for request in self._frames(connection.asks, segment, stamp):
            connection.open[request.transaction] = (request, stamp)
            while len(connection.open) > OPEN:
                del connection.open[next(iter(connection.open))]
            found.append(Asked(client, request, stamp))
        return found

    def _answered(self, client: Endpoint, segment: Segment, stamp: Ns) -> list[Asked | Answered]:
        connection = self._connections.setdefault(client, _Connection())
        found: list[Asked | Answered] = []
        for answer in self._frames(connection.answers, segment, stamp):
            request, asked = connection.open.pop(answer.transaction, (None, 0))
            if request is not None and request.unit == answer.unit and answer.pdu[0] & 0x7F == request.pdu[0]:
                found.append(Answered(client, request, answer.pdu, asked, stamp))
        return found

    def _frames(self, side: _Side, segment: Segment, stamp: Ns) -> list[Request]:
        data = side.flow.take(segment)
        self.characters += len(data)
        return side.frames(data, stamp) if data else []
