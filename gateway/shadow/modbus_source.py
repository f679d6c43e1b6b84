"""A Modbus server's command source without a server: the PLC's requests to the old controller are processed as if they were for us, and the
answers are compared.  Nothing is written (AX-512).
"""

import ipaddress
import time
from collections.abc import Mapping

from gateway.assembly.data_block_signals import signals_of
from gateway.links.modbus.responder import Client
from gateway.links.modbus.tcp_server import ModbusServer
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.modbus import Modbus
from gateway.pure.image.addresses import Direction, RcBit
from gateway.pure.modbus.registers import MEASURED
from gateway.pure.modbus.rho3_view import BLOCK_AT
from gateway.pure.shadow.compare import Answer, Comparison, as_data
from gateway.pure.shadow.modbus_addresses import READ_BYTES, READS, Number, read_name, read_places
from gateway.pure.shadow.modbus_talk import Answered, Asked, Endpoint, ModbusTalk
from gateway.registry import MODBUS_VIEWS
from gateway.services.sources.modbus import ModbusSource, placed
from gateway.shadow.capture import CaptureTap
from gateway.shadow.known_outputs import state_is_known
from protocols.base.machine import Ns
from protocols.modbus.mbap import Request
from protocols.modbus.rights import Rights

MOST_READS, MOST_OPEN = 64, 256
LIFE_WORD, FIRST_REAL = 7, 10  # of the status block (AX-011)
OWN = ("lag", "speed")  # of an axis: the shadow's path runs in parallel with the drives, so these are not answers


class ShadowModbusSource(ModbusSource):
    """One tapped Modbus TCP server."""

    async def start(self) -> None:
        """Nothing is bound."""

    def follow(self, settings: Modbus, tap: tuple[str, str]) -> None:
        """`tap`: capture, host:port of the old controller."""
        host, _, port = tap[1].rpartition(":")
        self._settings, self._tap = settings, tap
        self._capture = CaptureTap(tap[0])
        self._talk = ModbusTalk((ipaddress.ip_address(host.strip("[]")).packed, int(port)))
        self.comparison = Comparison()
        self.telegrams = {"heard": 0, "answered": 0, "other_number": 0}
        self.first_other_number = ""
        self.since: Ns = time.monotonic_ns()
        self._settled = False
        self._clients: dict[Endpoint, Client] = {}
        self._open: dict[tuple[Endpoint, int], bytes] = {}  # our answers until the old controller's arrives
        self._reads: dict[tuple[int, bytes], Request] = {}
        self._signals = signals_of(self._run.cell)
        self._numbers = numbers_of(self._run.cell, settings, self._run.plan.tolerances)

    def take(self, now: Ns) -> None:
        """Read the waiting packets of the capture."""
        self._settled = self._settled or state_is_known(self._image, len(self._run.cell.axis), self.since, now)
        for packet in self._capture.turn(now):
            for exchange in self._talk.take(packet, self._capture.offset):
                if isinstance(exchange, Asked):
                    self._asked(exchange)
                else:
                    self._answered_there(exchange)

    def compare(self, now: Ns) -> None:
        """Our tables as they are after this tick."""
        for key, request in self._reads.items():
            self._ours(key, request, now)
        self.comparison.settle(now)

    def _asked(self, asked: Asked) -> None:
        self.telegrams["heard"] += 1
        if not self._settled:
            self.restart()  # until our own state is known, a command only sets the initial state of its toggle (AX-141)
        client = self._clients.get(asked.client)
        if client is None:
            client = self._clients[asked.client] = self._client(asked.client, asked.stamp)
        self._open[asked.client, asked.request.transaction] = self.server.responder.serve(asked.request, client, asked.stamp)
        while len(self._open) > MOST_OPEN:
            del self._open[next(iter(self._open))]

    def _client(self, end: Endpoint, now: Ns) -> Client:
        host = str(ipaddress.ip_address(end[0]))
        assert isinstance(self.server, ModbusServer)
        rights = self.writers.of(host) if self.writers is not None else Rights(write=self.server.may_write(host))
        return Client(f"{host}:{end[1]}", rights, now, now)

    def _answered_there(self, answered: Answered) -> None:
        ours = self._open.pop((answered.client, answered.request.transaction), None)
        if ours is None:
            return
        self.telegrams["answered"] += 1
        there, here = _refusal(answered.pdu), _refusal(ours)
        if there != here:
            self.telegrams["other_number"] += 1
            job = answered.request.pdu[:6].hex(" ")
            self.first_other_number = self.first_other_number or f"{job}: there {_words(there)}, here {_words(here)}"
        elif not there and answered.request.pdu[0] in READS and self._settled:
            self._read(answered)

    def _read(self, answered: Answered) -> None:
        request = answered.request
        key = (request.unit, request.pdu[:READ_BYTES])
        if key not in self._reads:
            if len(self._reads) >= MOST_READS:
                return
            self._reads[key] = request
            numbers = self._numbers if request.unit in (0, 255, self._settings.unit) else {}
            places = read_places(request.pdu, self._bit_name, numbers.get(request.pdu[0], {}))
            self.comparison.declare(key, f"modbus {self.name}, {read_name(request.unit, request.pdu)}", places)
            self._ours(key, request, time.monotonic_ns())
        self.comparison.theirs(Answer(key, answered.asked, answered.stamp, 0, answered.pdu[2:]))

    def _ours(self, key: tuple[int, bytes], request: Request, now: Ns) -> None:
        found = self.server.responder.look(request)
        if not _refusal(found):
            self.comparison.ours(key, found[2:], now)

    def _bit_name(self, function: int, number: int) -> str:
        if not MODBUS_VIEWS[self._settings.view].signals:
            return ""
        signal = self._signals.at(RcBit(Direction.INPUT if function == 1 else Direction.OUTPUT, number))
        return signal.name if signal is not None else ""

    def result(self, now: Ns) -> Mapping[str, object]:
        """For the report."""
        return {
            "line": self.name,
            "kind": "modbus",
            "taps": list(self._tap),
            "connected": self._capture.connected,
            "why": self._capture.why,
            "comparing": self._settled,
            "characters": self._talk.characters,
            "telegrams": dict(self.telegrams),
            "first_other_number": self.first_other_number,
            "blocks": as_data(self.comparison, self.since, now),
        }


def numbers_of(cell: Cell, settings: Modbus, tolerances: Mapping[str, float]) -> dict[int, dict[int, Number]]:
    """Function code -> first register -> contents; the command block is compared word by word."""
    names = [axis.name for axis in cell.axis]
    extras = {each.at: _number(each.name, each.type, settings.float, tolerances) for each in placed(settings, names)}
    status: dict[int, Number] = {}
    if MODBUS_VIEWS[settings.view].signals and settings.command_block:
        status[BLOCK_AT + LIFE_WORD] = Number("cell.life", "UINT16", counts=True)
        for n, name in enumerate(names):
            for word, what in ((0, "actual"), (2, "lag")):
                status[BLOCK_AT + FIRST_REAL + 4 * n + word] = _number(f"axis.{name}.{what}", "REAL", "ABCD", tolerances)
    return {3: extras, 4: {**status, **extras}}


def _number(name: str, type_: str, order: str, tolerances: Mapping[str, float]) -> Number:
    head, _, what = name.rpartition(".")
    if what not in MEASURED:
        return Number(name, type_, order=order, counts=name == "cell.life")
    return Number(name, type_, tolerances.get(head.removeprefix("axis."), 0.0), order, judged=what not in OWN)


def _refusal(pdu: bytes) -> bytes:
    """Empty for an answer that is none."""
    return pdu[1:2] or b"\0" if not pdu or pdu[0] & 0x80 else b""


def _words(refusal: bytes) -> str:
    return f"exception {refusal[0]:02X}h" if refusal else "an answer"
