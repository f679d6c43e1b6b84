"""The client's side of each kind of Modbus line: packing a request, finding the answer to it in the received bytes.

One request is pending at a time.  Other bytes (a late answer, another unit's) are dropped and counted.
"""

from enum import Enum, auto
from typing import NamedTuple, Protocol

from protocols.base.machine import Damage, Ns
from protocols.modbus.crc import crc, sealed
from protocols.modbus.lengths import LONGEST_FRAME, answer_length
from protocols.modbus.mbap import ANSWER, HEADER, MAX_LENGTH, MIN_LENGTH, MODBUS
from protocols.modbus.timing import Timing

SHORTEST_FRAME = 4  # unit, function, check


class Spoiled(Enum):
    """Reason why the received bytes are not an answer."""

    CHECK = auto()  # RTU: the CRC does not fit
    SHORT = auto()  # RTU: silence before the frame was complete
    DAMAGED = auto()  # a character with a parity or framing fault
    HEADER = auto()  # TCP: a header that cannot be; the connection has lost its beat
    STRANGER = auto()  # an answer of another unit or to another function


class Answer(NamedTuple):
    """A complete answer PDU to the pending request."""

    pdu: bytes


Heard = Answer | Spoiled | None


class Wire(Protocol):
    """One request, one answer."""

    quiet: Ns  # silence to keep after the last byte before the next request
    broadcasts: bool  # unit 0 means all, and no unit answers
    strays: int  # bytes or frames that belonged to nothing

    def ask(self, unit: int, pdu: bytes) -> bytes: ...
    def receive(self, data: bytes, now: Ns) -> Heard: ...
    def damaged(self, kind: Damage, now: Ns) -> Heard: ...
    def wake(self, now: Ns) -> Heard: ...
    def deadline(self) -> Ns | None: ...
    def forget(self) -> None: ...  # no request is pending any more


ECHOED = {5: 5, 6: 5, 15: 5, 16: 5, 22: 7}  # function -> number of bytes of the request repeated in its answer


def _fits(request: bytes, answer: bytes) -> bool:
    """Whether this can be the answer: same function, an exception of two bytes, a write that repeats the request."""
    if not answer or answer[0] & 0x7F != request[0]:
        return False
    if answer[0] != request[0]:
        return len(answer) == 2
    echoed = ECHOED.get(request[0])
    return echoed is None or answer == request[:echoed]


class TcpWire:
    """MBAP: answers are matched by their transaction number; late ones of aborted requests are dropped."""

    quiet: Ns = 0
    broadcasts = False

    def __init__(self) -> None:
        self.strays = 0
        self._transaction = 0
        self._wanted: tuple[int, int, bytes] | None = None
        self._half = b""

    def ask(self, unit: int, pdu: bytes) -> bytes:
        self._transaction = (self._transaction + 1) & 0xFFFF
        self._wanted, self._half = (self._transaction, unit, pdu), b""  # a stream that lost its beat finds it again here (AX-345)
        return ANSWER.pack(self._transaction, MODBUS, len(pdu) + 1, unit) + pdu

    def receive(self, data: bytes, now: Ns) -> Heard:
        stream, start, heard = self._half + data, 0, None
        while heard is None and len(stream) - start >= HEADER.size:
            transaction, protocol, length = HEADER.unpack_from(stream, start)
            if protocol != MODBUS or not MIN_LENGTH <= length <= MAX_LENGTH:
                self._half = b""
                return Spoiled.HEADER
            if len(stream) - start < HEADER.size + length:
                break
            heard = self._judge(transaction, stream[start + 6], stream[start + 7 : start + 6 + length])
            start += HEADER.size + length
        self._half = stream[start:]
        return heard

    def _judge(self, transaction: int, unit: int, pdu: bytes) -> Heard:
        if self._wanted is None or transaction != self._wanted[0]:
            self.strays += 1
            return None
        _, asked, request = self._wanted
        self._wanted = None
        return Answer(pdu) if unit == asked and _fits(request, pdu) else Spoiled.STRANGER

    def damaged(self, kind: Damage, now: Ns) -> Heard:
        return None

    def wake(self, now: Ns) -> Heard:
        return None

    def deadline(self) -> Ns | None:
        return None

    def forget(self) -> None:
        self._wanted = None


class RtuWire:
    """RTU, on a line (silence and CRC) or over TCP (lengths and CRC, Timing OVER_TCP).

    A complete frame with a good CRC is accepted as soon as its length is reached; one of unknown length ends by silence.
    """

    def __init__(self, timing: Timing) -> None:
        self.strays = 0
        self.broadcasts = timing.char_ns > 0
        self.quiet = timing.quiet if timing.char_ns else 0
        self._timing = timing
        self._wanted: tuple[int, bytes] | None = None
        self._half = bytearray()
        self._spoiled = False
        self._last: Ns = 0

    def ask(self, unit: int, pdu: bytes) -> bytes:
        self._wanted = (unit, pdu)
        self._half.clear()
        self._spoiled = False
        return sealed(bytes((unit,)) + pdu)

    def receive(self, data: bytes, now: Ns) -> Heard:
        if self._wanted is None:
            self.strays += len(data)
            return None
        heard = self.wake(now)
        if heard is not None:
            self.strays += len(data)
            return heard
        self._half += data[: LONGEST_FRAME + 1 - len(self._half)]
        self._last = now
        return self._whole()

    def _whole(self) -> Heard:
        assert self._wanted is not None
        size = answer_length(bytes(self._half), self._wanted[1])
        if not size or len(self._half) < size or self._spoiled:
            return None
        frame = bytes(self._half[:size])
        if crc(frame):
            return None  # silence will end it
        self.strays += len(self._half) - size
        return self._take(frame)

    def damaged(self, kind: Damage, now: Ns) -> Heard:
        if self._wanted is not None:
            self._spoiled, self._last = True, now
            self._half.append(0)
        return None

    def wake(self, now: Ns) -> Heard:
        due = self.deadline()
        if due is None or now < due:
            return None
        frame = bytes(self._half)
        if self._spoiled:
            return self._end(Spoiled.DAMAGED)
        if len(frame) < SHORTEST_FRAME:
            return self._end(Spoiled.SHORT)
        return self._end(Spoiled.CHECK) if crc(frame) or len(frame) > LONGEST_FRAME else self._take(frame)

    def deadline(self) -> Ns | None:
        if self._wanted is None or not self._half:
            return None
        return self._last + self._timing.t35 + self._timing.patience

    def forget(self) -> None:
        self._wanted = None
        self._half.clear()

    def _take(self, frame: bytes) -> Heard:
        assert self._wanted is not None
        unit, request = self._wanted
        if frame[0] != unit:  # "unexpected slave": keep waiting (serial line guide, figure 7)
            self.strays += len(frame)
            self._half.clear()
            return None
        pdu = frame[1:-2]
        return self._end(Answer(pdu) if _fits(request, pdu) else Spoiled.STRANGER)

    def _end(self, heard: Heard) -> Heard:
        self.forget()
        return heard
