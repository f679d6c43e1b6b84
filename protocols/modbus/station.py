"""Data of a Modbus server about itself: counters and event log (FC 8, 11, 12), its name (FC 17), its identification (FC 43/14).

Source: V1.1b3, sections 6.8 to 6.13 and 6.21.  The specification defines 7, 8, 11, 12 and 17 for serial lines only; they are answered on
TCP as well, because clients use them (AX-342).
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from protocols.modbus.validate import IDENTIFICATION
from protocols.modbus.view import ExceptionCode

LOG_EVENTS = 64  # V1.1b3, 6.10
RUN_INDICATOR = 0xFF
CONFORMITY = 0x83  # extended identification, stream and individual access
OBJECTS_BYTES = 253 - 7  # of one answer to FC 43/14
BASIC, REGULAR, EXTENDED, ONE = 1, 2, 3, 4
CLASSES = {BASIC: 0x02, REGULAR: 0x7F, EXTENDED: 0xFF}  # highest object of each stream

# Event bytes of FC 12 (6.10)
RECEIVED, RECEIVED_ERROR, RECEIVED_LISTENING = 0x80, 0x82, 0xA0
SENT, SENT_READ_EXCEPTION, SENT_ABORT, SENT_BUSY = 0x40, 0x41, 0x42, 0x44
LISTENING_ENTERED, RESTARTED = 0x04, 0x00

SENT_EVENTS = {1: SENT_READ_EXCEPTION, 2: SENT_READ_EXCEPTION, 3: SENT_READ_EXCEPTION, 4: SENT_ABORT, 5: SENT_BUSY, 6: SENT_BUSY}
UNCOUNTED = (8, 11, 12)  # diagnoses fetch the counter, they do not move it


@dataclass(frozen=True, slots=True)
class Identity:
    """Names of the device, ASCII; objects 0 to 6 of FC 43/14, more from 80h on."""

    vendor: str = "axisgate"
    product_code: str = "axisgate"
    revision: str = ""
    url: str = ""
    product: str = "hardware-in-the-loop fieldbus gateway"
    model: str = ""
    application: str = ""
    more: Mapping[int, str] = field(default_factory=lambda: MappingProxyType({}))

    def objects(self) -> dict[int, bytes]:
        """By object number, in order."""
        named = (self.vendor, self.product_code, self.revision, self.url, self.product, self.model, self.application)
        all_ = {**dict(enumerate(named)), **self.more}
        return {number: text.encode("ascii", "replace")[:240] for number, text in sorted(all_.items())}


class Station:
    """One server's own data; all its units share it."""

    def __init__(self, identity: Identity | None = None, number: int = 1, serial: bool = False) -> None:
        self.serial, self.listening_only = serial, False
        self._objects = (identity or Identity()).objects()
        self._number = number
        self._log: deque[int] = deque(maxlen=LOG_EVENTS)
        self.clear()

    def clear(self) -> None:
        """FC 8, sub-function 10."""
        self.messages = self.line_faults = self.exceptions = self.answered = self.unanswered = self.busy = self.overruns = 0
        self.events = 0

    # ---- events
    def heard(self) -> None:
        """A good frame for any unit."""
        self.messages += 1

    def spoiled(self, overrun: bool = False) -> None:
        """A frame whose check did not fit or that was cut off; overrun: characters were lost in between."""
        self.line_faults += 1
        self.overruns += overrun
        self._log.appendleft(RECEIVED_ERROR | (0x10 if overrun else 0))

    def said(self, request: bytes, answer: bytes) -> None:
        """A request for us got this answer (b"": none, a broadcast or while listening only)."""
        self.answered += 1
        self._log.appendleft(RECEIVED_LISTENING if self.listening_only else RECEIVED)
        if not answer:
            self.unanswered += 1
            return
        if answer[0] & 0x80:
            self.exceptions += 1
            self.busy += answer[1] in (5, 6)
            self._log.appendleft(SENT | SENT_EVENTS.get(answer[1], 0))
        elif request[0] not in UNCOUNTED:
            self.events = (self.events + 1) & 0xFFFF
            self._log.appendleft(SENT)

    # ---- requests (legal ones)
    def diagnose(self, pdu: bytes) -> bytes:
        """FC 8; b"": no answer."""
        sub, data = pdu[1] << 8 | pdu[2], pdu[3:]
        match sub:
            case 1:
                return self._restart(pdu)
            case 4:
                self.listening_only = True
                self._log.appendleft(LISTENING_ENTERED)
                return b""
            case 10:
                self.clear()
            case 20:
                self.overruns = 0
        counted = {
            2: 0,
            11: self.messages,
            12: self.line_faults,
            13: self.exceptions,
            14: self.answered,
            15: self.unanswered,
            16: 0,
            17: self.busy,
            18: self.overruns,
        }
        return pdu[:3] + ((counted[sub] & 0xFFFF).to_bytes(2, "big") if sub in counted else data)

    def _restart(self, pdu: bytes) -> bytes:
        """Counters at zero, listening only ended; then (and only then) no answer is sent (6.8.1, 01)."""
        silent, self.listening_only = self.listening_only, False
        self.clear()
        if pdu[3]:
            self._log.clear()
        self._log.appendleft(RESTARTED)
        return b"" if silent else pdu

    def event_counter(self) -> bytes:
        """FC 11: never busy."""
        return b"\x0b\x00\x00" + self.events.to_bytes(2, "big")

    def event_log(self) -> bytes:
        """FC 12: the newest event first."""
        counts = b"\x00\x00" + self.events.to_bytes(2, "big") + (self.messages & 0xFFFF).to_bytes(2, "big")
        return bytes((12, 6 + len(self._log))) + counts + bytes(self._log)

    def server_id(self) -> bytes:
        """FC 17: our number, the run indicator, then words for people."""
        words = b" ".join(self._objects[number] for number in (0, 1, 2) if self._objects[number])
        return bytes((17, 2 + len(words), self._number, RUN_INDICATOR)) + words

    def identify(self, pdu: bytes) -> bytes | ExceptionCode:
        """FC 43/14: one object, or a stream from an object on, in as many answers as needed (6.21)."""
        code, first = pdu[2], pdu[3]
        if code == ONE:
            if first not in self._objects:
                return ExceptionCode.ILLEGAL_DATA_ADDRESS
            return self._identification(pdu, [first], 0, 0)
        stream = [number for number in self._objects if number <= CLASSES[code]]
        fitting = stream[stream.index(first) :] if first in stream else stream  # an unknown one restarts from the beginning (6.21)
        taken: list[int] = []
        room = OBJECTS_BYTES
        for number in fitting:
            room -= 2 + len(self._objects[number])
            if room < 0:
                return self._identification(pdu, taken, 0xFF, number)
            taken.append(number)
        return self._identification(pdu, taken, 0, 0)

    def _identification(self, pdu: bytes, numbers: list[int], more: int, following: int) -> bytes:
        head = bytes((43, IDENTIFICATION, pdu[2], CONFORMITY, more, following, len(numbers)))
        return head + b"".join(bytes((number, len(self._objects[number]))) + self._objects[number] for number in numbers)
