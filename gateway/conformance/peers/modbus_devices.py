"""Axisgate's Modbus servers as byte machines: four tables, and answers that can be changed."""

from collections.abc import Callable, Sequence

from protocols.base.machine import Damage, Ns
from protocols.modbus.answering import answer
from protocols.modbus.mbap import Closing, Foreign, Framing, Request
from protocols.modbus.rtu import RtuFraming
from protocols.modbus.station import Station
from protocols.modbus.timing import timing
from protocols.modbus.view import ExceptionCode, Kind

SIZE = 120
INPUTS, DISCRETE = [0x7000 + 3 * at for at in range(SIZE)], [at % 3 == 0 for at in range(SIZE)]
Answer = Callable[["Device", bytes, bytes], bytes]  # request and right answer -> the answer sent


class Tables:
    """Four tables of 120, each with its own content."""

    def __init__(self) -> None:
        self.words = {Kind.HOLDING_REGISTERS: [0] * SIZE, Kind.INPUT_REGISTERS: list(INPUTS)}
        self.flags = {Kind.COILS: [False] * SIZE, Kind.DISCRETE_INPUTS: list(DISCRETE)}

    def read_bits(self, kind: Kind, address: int, count: int) -> Sequence[bool] | ExceptionCode:
        return self.flags[kind][address : address + count] if address + count <= SIZE else ExceptionCode.ILLEGAL_DATA_ADDRESS

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        return self.words[kind][address : address + count] if address + count <= SIZE else ExceptionCode.ILLEGAL_DATA_ADDRESS

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        if address + len(values) > SIZE:
            return ExceptionCode.ILLEGAL_DATA_ADDRESS
        self.flags[Kind.COILS][address : address + len(values)] = values
        return None

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        if address + len(values) > SIZE:
            return ExceptionCode.ILLEGAL_DATA_ADDRESS
        self.words[Kind.HOLDING_REGISTERS][address : address + len(values)] = values
        return None


class Device:
    """A server on TCP or RTU; `changed` alters answers, `tables` hold the values."""

    def __init__(
        self,
        rtu: bool,
        changed: Answer | None = None,
        tables: Tables | None = None,
        late: Ns = 0,
        without: Sequence[int] = (),
        any_unit: bool = False,
    ) -> None:
        self.rtu, self._changed, self.tables = rtu, changed, tables or Tables()
        self.framing: Framing | RtuFraming = RtuFraming(timing(9600)) if rtu else Framing()
        self.station = Station(serial=rtu)
        self._late, self._without, self._any_unit = late, without, any_unit
        self._queue: list[tuple[Ns, bytes]] = []
        self.count = 0
        self.dead = False
        self.refused = 0

    def serve(self, request: Request, now: Ns) -> bytes:
        """The answer PDU; b"": none."""
        broadcast = self.rtu and request.unit == 0
        if request.unit not in (1, 0, 255) and not self._any_unit:
            return b"" if self.rtu else answer(request.pdu, None)
        if request.pdu[:1] and request.pdu[0] in self._without:
            return b"" if broadcast else bytes((request.pdu[0] | 0x80, 1))
        said = answer(request.pdu, self.tables, True, self.station)
        if self._changed is not None and said:
            said = self._changed(self, request.pdu, said)
        return b"" if broadcast else said

    def _take(self, events: Sequence[object], now: Ns) -> list[object]:
        for event in events:
            if isinstance(event, Request):
                self.count += 1
                said = self.serve(event, now)
                if said and not self.dead:
                    self.framing.reply(event, said)
            elif isinstance(event, (Closing, Foreign)):
                self.strange(event)
        said = self.framing.take_output()
        if said:
            self._queue.append((now + self._late, self.framed(said)))
        return []

    def strange(self, event: object) -> None:
        """A frame that is none."""

    def framed(self, said: bytes) -> bytes:
        return said

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        return self._take(self.framing.receive(data, now), now)

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        return self._take(self.framing.damaged(kind, now), now)

    def sent(self, now: Ns) -> Sequence[object]:
        self._now = now
        return []

    def wake(self, now: Ns) -> Sequence[object]:
        self._ready = now
        due = self.framing.deadline()
        return self._take(self.framing.wake(now), now) if due is not None and due <= now else []

    _ready: Ns = -1
    _now: Ns = 0

    def deadline(self) -> Ns | None:
        moments = [moment for moment in (self.framing.deadline(), self._queue[0][0] if self._queue else None) if moment is not None]
        return min(moments, default=None)

    def take_output(self) -> bytes:
        said = b""
        while self._queue and (not self._late or self._queue[0][0] <= self._ready):
            said += self._queue.pop(0)[1]
        return said

    def lost(self, now: Ns) -> Sequence[object]:
        """A new connection: a new stream, the same values."""
        self._queue.clear()
        self.framing = RtuFraming(timing(9600)) if self.rtu else Framing()
        return []


class Busy(Device):
    """Too busy for every 40th request: exception 06, the client repeats it."""

    def serve(self, request: Request, now: Ns) -> bytes:
        if self.count % 40 == 39 and request.pdu and request.unit == 1:
            return bytes((request.pdu[0] | 0x80, 6))
        return super().serve(request, now)
