"""Request handling shared by all Modbus servers, independent of transport: client identity, access rights, answer, counters."""

from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, field

from protocols.base.machine import Ns
from protocols.modbus.answering import answer, exception
from protocols.modbus.mbap import Request, Why
from protocols.modbus.rights import Rights
from protocols.modbus.station import Station
from protocols.modbus.validate import refusal
from protocols.modbus.view import ExceptionCode, View, home_unit

EXCEPTION_BIT = 0x80
BROADCAST = 0
BROADCAST_FUNCTIONS = frozenset({5, 6, 8, 15, 16, 21, 22})  # functions that make sense without an answer
OnRequest = Callable[[str, int], None]
KEPT = 128  # exchanges for pages that decode them
SHOWN = 48  # bytes of a PDU shown; its length is added


@dataclass(frozen=True, slots=True)
class Exchange:
    """One request and its answer, as they were on the wire without their frame."""

    number: int  # counts from 1
    stamp: Ns
    address: str
    unit: int
    asked: bytes
    answered: bytes  # empty: answered in silence

    def row(self) -> list[object]:
        """For a page: the bytes as hex, shortened, with their count."""
        return [self.number, self.stamp, self.address, self.unit, self.asked[:SHOWN].hex(), len(self.asked), self.answered[:SHOWN].hex(),
                len(self.answered)]  # fmt: skip


@dataclass(slots=True)
class Client:
    """One connected partner."""

    address: str  # "host:port", or the port's name on a line
    rights: Rights
    since_ns: Ns
    last_byte_ns: Ns
    last_request_ns: Ns | None = None  # the last one answered without exception
    requests: int = 0
    exceptions: int = 0
    foreign: int = 0
    role: str = ""  # TLS
    limited: bool = False  # `rights` must be checked for each request

    def __post_init__(self) -> None:
        self.limited = self.rights.limited


@dataclass(slots=True)
class Counters:
    """Since start, over all clients."""

    connections: int = 0
    refused_connections: int = 0
    requests: int = 0  # with those answered by an exception
    exceptions: Counter[ExceptionCode] = field(default_factory=Counter)
    foreign: int = 0  # frames of another protocol identifier; on a line: for other units
    closed: Counter[Why] = field(default_factory=Counter)
    dropped: Counter[str] = field(default_factory=Counter)  # on a line: frames that were none
    stalled: int = 0  # closed because answers were not read
    idle: int = 0
    view_faults: int = 0  # a view or the callback raised: our own mistake, answered with 04
    last_view_fault: str = ""


class ModbusResponder:
    """Answers requests from the views of the units.

    view_for(unit) returns the tables or None.  on_request(client's address, function code) is called after each request answered without an
    exception.  line: RTU rules, so unit 0 is broadcast and requests for other units get no answer.
    """

    def __init__(
        self,
        view_for: Callable[[int], View | None],
        unit: int = 1,
        on_request: OnRequest | None = None,
        station: Station | None = None,
        line: bool = False,
    ) -> None:
        self.counters = Counters()
        self.station = station or Station(number=unit)
        self.last_request_ns: Ns | None = None
        self._view_for, self._unit, self._on_request, self._line = view_for, unit, on_request, line
        self._kept: deque[Exchange] = deque(maxlen=KEPT)

    def serve(self, request: Request, client: Client, now: Ns) -> bytes:
        """The answer PDU, b"" for none; a view that raises costs its request, never the connection or the loop."""
        unit, pdu = request.unit, request.pdu
        station = self.station
        station.messages += 1
        if self._line:
            if unit != BROADCAST and self._view_for(unit) is None:
                self.counters.foreign += 1
                client.foreign += 1
                return b""
            if station.listening_only and pdu[0] != 8:
                station.said(pdu, b"")
                return b""
        self.counters.requests += 1
        client.requests += 1
        try:
            result = self._broadcast(pdu, client) if self._line and unit == BROADCAST else self._answer(unit, pdu, client)
        except Exception as fault:  # a view is foreign code here: one broken entry must not stop the other partners
            self._blame(fault, request, client)
            result = exception(pdu[0], ExceptionCode.SERVER_DEVICE_FAILURE)
        station.said(pdu, result)
        self._kept.append(Exchange(self.counters.requests, now, client.address, unit, pdu, result))
        if result and result[0] & EXCEPTION_BIT:
            client.exceptions += 1
            self.counters.exceptions[ExceptionCode(result[1])] += 1
        else:
            client.last_request_ns = self.last_request_ns = now
            self._report(request, client)
        return result

    def look(self, request: Request) -> bytes:
        """The present answer to a read without a request: not counted."""
        return answer(request.pdu, self._view_for(home_unit(request.unit, self._unit)), False)

    def since(self, number: int) -> list[Exchange]:
        """Exchanges after that one, as far as they are kept; all of them for a number of a predecessor, which restarted the count."""
        number = number if number <= self.counters.requests else 0
        return [exchange for exchange in self._kept if exchange.number > number]

    def _answer(self, unit: int, pdu: bytes, client: Client) -> bytes:
        rights = client.rights
        view = self._view_for(unit if self._line else home_unit(unit, self._unit))
        if client.limited and view is not None and refusal(pdu, rights.write, self._line) is None:
            denied = rights.refusal(pdu)
            if denied is not None:
                return exception(pdu[0], denied)
        return answer(pdu, view, rights.write, self.station)

    def _broadcast(self, pdu: bytes, client: Client) -> bytes:
        """Executed as if for our own unit, without an answer (serial line guide, 2.1)."""
        if pdu[0] in BROADCAST_FUNCTIONS:
            self._answer(self._unit, pdu, client)
        return b""

    def _report(self, request: Request, client: Client) -> None:
        if self._on_request is None:
            return
        try:
            self._on_request(client.address, request.pdu[0])
        except Exception as fault:  # the request is done and has its answer whatever happens to those who watch
            self._blame(fault, request, client)

    def _blame(self, fault: Exception, request: Request, client: Client) -> None:
        self.counters.view_faults += 1
        self.counters.last_view_fault = f"{client.address}: {request.pdu.hex(' ')}: {fault!r}"
