"""Framing of Modbus RTU, the server's side: silence ends a frame on a line, its length ends it over TCP.

Source: MODBUS over Serial Line V1.02, section 2.5.1.  Both machines have the methods of mbap.Framing, so one server works with all three.
"""

from enum import Enum, auto
from typing import NamedTuple

from protocols.base.machine import Damage, Ns
from protocols.modbus.crc import START, crc, sealed
from protocols.modbus.lengths import LONGEST_FRAME, request_length
from protocols.modbus.mbap import RECEIVE_LIMIT, Closing, Request, Why
from protocols.modbus.timing import Timing

SHORTEST_FRAME = 4  # unit, function, check


class Fault(Enum):
    """Why a frame is dropped; nothing is answered to it (serial line guide, 2.4.2)."""

    CHECK = auto()
    SHORT = auto()
    LONG = auto()
    GAP = auto()  # more than t1.5 inside a frame, where the timing is strict
    DAMAGED = auto()  # parity or framing fault of a character
    OVERRUN = auto()  # characters were lost in the UART
    LOST = auto()  # the port went away inside a frame


class Dropped(NamedTuple):
    """A frame that was none."""

    why: Fault
    frame: bytes


LineEvent = Request | Dropped


class RtuFraming:
    """One serial line.  Holds at most one frame (256 bytes) and the unread answer."""

    def __init__(self, timing: Timing) -> None:
        self._timing = timing
        self._half = bytearray()
        self._why: Fault | None = None
        self._last: Ns = 0
        self._output = b""

    def receive(self, data: bytes, now: Ns) -> list[LineEvent]:
        """These bytes have just ended: the first of them began len(data) characters ago."""
        events: list[LineEvent] = []
        gap = now - self._last - len(data) * self._timing.char_ns
        if self._open and gap >= self._silence():
            events += self._end()
        elif self._open and gap > self._timing.t15 and self._timing.strict:
            self._why = self._why or Fault.GAP
        self._take(data, now)
        return events

    def reply(self, request: Request, pdu: bytes) -> None:
        """The answer to a request; it leaves at once, t3.5 of silence have already passed."""
        self._output += sealed(bytes((request.unit,)) + pdu)

    def damaged(self, kind: Damage, now: Ns) -> list[LineEvent]:
        events = self.receive(b"\x00", now)  # it counts as a character on the line
        self._why = Fault.OVERRUN if kind is Damage.OVERRUN else self._why or Fault.DAMAGED
        return events

    def sent(self, now: Ns) -> list[LineEvent]:
        return []

    def wake(self, now: Ns) -> list[LineEvent]:
        due = self.deadline()
        return self._end() if due is not None and now >= due else []

    def deadline(self) -> Ns | None:
        return self._last + self._silence() if self._open else None

    def take_output(self) -> bytes:
        output, self._output = self._output, b""
        return output

    def lost(self, now: Ns) -> list[LineEvent]:
        events: list[LineEvent] = [Dropped(Fault.LOST, bytes(self._half))] if self._open else []
        self._half.clear()
        self._why, self._output = None, b""
        return events

    @property
    def _open(self) -> bool:
        return bool(self._half) or self._why is not None

    def _silence(self) -> Ns:
        """A complete frame ends after t3.5; an incomplete one may still be on its way through an adapter (AX-344)."""
        if self._timing.patience and (self._why is not None or not self._whole()):
            return self._timing.t35 + self._timing.patience
        return self._timing.t35

    def _whole(self) -> bool:
        return len(self._half) >= SHORTEST_FRAME and crc(bytes(self._half)) == 0

    def _take(self, data: bytes, now: Ns) -> None:
        room = LONGEST_FRAME - len(self._half)
        if len(data) > room:
            self._why = self._why or Fault.LONG
        self._half += data[:room]
        self._last = now

    def _end(self) -> list[LineEvent]:
        frame, why = bytes(self._half), self._why
        self._half.clear()
        self._why = None
        if why is None and len(frame) < SHORTEST_FRAME:
            why = Fault.SHORT
        if why is None and crc(frame):
            why = Fault.CHECK
        return [Request(0, frame[0], frame[1:-2])] if why is None else [Dropped(why, frame)]


class RtuTcpFraming:
    """RTU frames in a TCP stream: silence cannot be detected there, so the length for the function code ends a frame; a wrong
    check sum means lost framing and closes the connection."""

    def __init__(self, receive_limit: Ns = RECEIVE_LIMIT) -> None:
        self._receive_limit = receive_limit
        self._half = b""
        self._checked, self._check = 0, START  # bytes of `_half` included in the check, and its present value
        self._due: Ns | None = None
        self._closed = False
        self._output: list[bytes] = []

    def receive(self, data: bytes, now: Ns) -> list[Request | Closing]:
        events = self.wake(now)
        if self._closed:
            return events
        stream, begun = self._half + data, False
        while len(stream) >= SHORTEST_FRAME:
            size = self._request_size(stream)
            if size == 0:
                break
            if size < 0:
                return [*events, self._close(Why.CHECK, stream[:LONGEST_FRAME])]
            events.append(Request(0, stream[0], stream[1 : size - 2]))
            stream, begun = stream[size:], True
            self._checked, self._check = 0, START
        if not stream:
            self._due = None
        elif begun or not self._half:
            self._due = now + self._receive_limit
        self._half = stream
        return events

    def reply(self, request: Request, pdu: bytes) -> None:
        self._output.append(sealed(bytes((request.unit,)) + pdu))

    def reading_again(self, now: Ns) -> None:
        """As mbap.Framing."""
        if self._due is not None:
            self._due = now + self._receive_limit

    def damaged(self, kind: Damage, now: Ns) -> list[Request | Closing]:
        return []

    def sent(self, now: Ns) -> list[Request | Closing]:
        return []

    def wake(self, now: Ns) -> list[Request | Closing]:
        if self._due is None or now < self._due:
            return []
        return [self._close(Why.HALF_FRAME, self._half)]

    def deadline(self) -> Ns | None:
        return self._due

    def take_output(self) -> bytes:
        output, self._output = b"".join(self._output), []
        return output

    def lost(self, now: Ns) -> list[Request | Closing]:
        self._output = []
        return [self._close(Why.LOST, self._half)] if self._half else []

    def _close(self, why: Why, half: bytes) -> Closing:
        self._half, self._due, self._closed = b"", None, True
        return Closing(why, half)

    def _request_size(self, stream: bytes) -> int:
        """Bytes of the frame at the start of the stream; 0: incomplete, -1: not a frame."""
        size = request_length(stream)
        if size is None or stream[1] == 8:  # nothing states the length (a diagnosis may carry more words): the check does
            return self._by_check(stream)
        if size > LONGEST_FRAME:
            return -1
        if size == 0 or len(stream) < size:
            return 0
        return -1 if crc(stream[:size]) else size

    def _by_check(self, stream: bytes) -> int:
        """Where the check comes out first; each byte is looked at once, however many pieces it comes in."""
        end = min(len(stream), LONGEST_FRAME)
        while self._checked < end:
            self._check = crc(stream[self._checked : self._checked + 1], self._check)
            self._checked += 1
            if self._check == 0 and self._checked >= SHORTEST_FRAME:
                return self._checked
        return -1 if len(stream) >= LONGEST_FRAME else 0
