"""Framing of Modbus TCP, the server's side: bytes in, requests out, answers framed.  Source: TCP guide, section 3.1.3 (MBAP header).

The stream has no mark to find a lost beginning again, so a length that cannot be is the end of the connection (AX-071).
"""

import struct
from enum import Enum, auto
from typing import NamedTuple

from protocols.base.machine import Damage, Ns, ms

HEADER = struct.Struct(">HHH")  # transaction, protocol, length of all that follows
ANSWER = struct.Struct(">HHHB")  # the same with the unit, which length counts
MIN_LENGTH, MAX_LENGTH = 2, 254  # unit and function code; unit and a PDU of 253 bytes (V1.1b3, 4.1)
MODBUS = 0  # protocol identifier
RECEIVE_LIMIT = ms(2000)  # from the first byte of a frame to its last (AX-072)


class Request(NamedTuple):
    """A complete request: its transaction number, unit and PDU (1..253 bytes)."""

    transaction: int
    unit: int
    pdu: bytes


class Foreign(NamedTuple):
    """A frame of another protocol identifier: skipped, never answered (TCP guide, 4.3.2.2)."""

    protocol: int
    length: int


class Why(Enum):
    """Why a connection has to be closed."""

    LENGTH = auto()  # the header announces 0, 1 or more than 254 bytes
    HALF_FRAME = auto()  # the rest of a frame did not come in time
    LOST = auto()  # the connection ended inside a frame
    CHECK = auto()  # RTU over TCP: the check does not fit where a frame must end


class Closing(NamedTuple):
    """Nothing more can be read from this connection; bytes that come after it are ignored."""

    why: Why
    half: bytes  # the partial frame: at most 259 bytes


Event = Request | Foreign | Closing


class Framing:
    """One connection.  Holds at most one half frame (259 bytes) and the unread answers."""

    def __init__(self, receive_limit: Ns = RECEIVE_LIMIT) -> None:
        self._receive_limit = receive_limit
        self._half = b""
        self._due: Ns | None = None
        self._closed = False
        self._output: list[bytes] = []

    def receive(self, data: bytes, now: Ns) -> list[Event]:
        events = self.wake(now)  # a deadline that passed before these bytes came is reported first
        if self._closed:
            return events
        stream = self._half + data if self._half else data
        start, end = 0, len(stream)
        while end - start >= HEADER.size:
            transaction, protocol, length = HEADER.unpack_from(stream, start)
            if not MIN_LENGTH <= length <= MAX_LENGTH:
                return [*events, self._close(Why.LENGTH, stream[start : start + HEADER.size])]
            after = start + HEADER.size + length
            if after > end:
                break
            if protocol == MODBUS:
                events.append(Request(transaction, stream[start + 6], stream[start + 7 : after]))
            else:
                events.append(Foreign(protocol, length))
            start = after
        self._keep(stream[start:], now, begun=start > 0)
        return events

    def reply(self, request: Request, pdu: bytes) -> None:
        """Queues the answer (1..253 bytes) to a request; answers leave in the order of these calls."""
        self._output.append(ANSWER.pack(request.transaction, MODBUS, len(pdu) + 1, request.unit) + pdu)

    def reading_again(self, now: Ns) -> None:
        """The caller had stopped reading: the rest of a half frame may wait in the port, so its limit restarts."""
        if self._due is not None:
            self._due = now + self._receive_limit

    def damaged(self, kind: Damage, now: Ns) -> list[Event]:
        return []  # a TCP stream has no damaged characters

    def sent(self, now: Ns) -> list[Event]:
        return []  # a server waits for nothing after its answer

    def wake(self, now: Ns) -> list[Event]:
        if self._due is None or now < self._due:
            return []
        return [self._close(Why.HALF_FRAME, self._half)]

    def deadline(self) -> Ns | None:
        return self._due

    def take_output(self) -> bytes:
        output, self._output = b"".join(self._output), []
        return output

    def lost(self, now: Ns) -> list[Event]:
        self._output = []
        return [self._close(Why.LOST, self._half)] if self._half else []

    def _keep(self, half: bytes, now: Ns, begun: bool) -> None:
        """The limit runs from a frame's first byte, so a trickle cannot hold a connection open for ever."""
        if not half:
            self._due = None
        elif begun or not self._half:
            self._due = now + self._receive_limit
        self._half = half

    def _close(self, why: Why, half: bytes) -> Closing:
        self._half, self._due, self._closed = b"", None, True
        return Closing(why, half)
