"""Modbus RTU server on a serial port, a pty or a serial device server: silences by the timer of gateway.links.serial.runner."""

import time
from collections.abc import Callable

from drivers.ports.base import BytePort
from gateway.links.modbus.responder import Client, Counters, ModbusResponder, OnRequest
from gateway.links.serial.machine_loop import LineState
from gateway.links.serial.runner import LineRunner
from protocols.base.machine import Ns
from protocols.modbus.mbap import Request
from protocols.modbus.rights import Rights
from protocols.modbus.rtu import Dropped, Fault, LineEvent, RtuFraming
from protocols.modbus.station import Identity, Station
from protocols.modbus.timing import Timing
from protocols.modbus.view import View


class ModbusLine:
    """One port; view_for(unit) returns the tables of a unit served here; requests for others are ignored.

    Clients on a line have no address: the master has the rights in `rights`.
    """

    def __init__(
        self,
        open_port: Callable[[], BytePort],
        timing: Timing,
        view_for: Callable[[int], View | None],
        *,
        unit: int = 1,
        name: str = "line",
        rights: Rights | None = None,
        on_request: OnRequest | None = None,
        identity: Identity | None = None,
    ) -> None:
        self.responder = ModbusResponder(view_for, unit, on_request, Station(identity, unit, serial=True), line=True)
        self._framing = RtuFraming(timing)
        self._open_port = open_port
        now = time.monotonic_ns()
        self.client = Client(name, rights or Rights(), now, now)
        self._runner: LineRunner[LineEvent] | None = None

    @property
    def counters(self) -> Counters:
        return self.responder.counters

    @property
    def state(self) -> LineState | None:
        """Connected or why not; None before start."""
        return None if self._runner is None else self._runner.state

    async def start(self) -> None:
        """Begins to open the port; a port that is not there is tried again for ever."""
        self._runner = LineRunner[LineEvent](self._open_port, self._framing, self._on_event)

    async def close(self) -> None:
        """Release the port."""
        if self._runner is not None:
            self._runner.close()
            self._runner = None

    def _on_event(self, event: LineEvent, now: Ns) -> None:
        if isinstance(event, Dropped):
            self.counters.dropped[event.why.name.lower()] += 1
            self.responder.station.spoiled(overrun=event.why is Fault.OVERRUN)
            return
        self.client.last_byte_ns = now
        self._answer(event, now)

    def _answer(self, request: Request, now: Ns) -> None:
        pdu = self.responder.serve(request, self.client, now)
        if pdu and self._runner is not None:
            self._framing.reply(request, pdu)
            self._runner.kick()
