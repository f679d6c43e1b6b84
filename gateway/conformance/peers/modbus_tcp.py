"""Modbus TCP: faulty and correct servers."""

from collections.abc import Sequence

from gateway.conformance.peers.modbus_answers import ForgetsWithTheClient
from gateway.conformance.peers.modbus_devices import Device
from gateway.conformance.peers.modbus_rows import Row, mutants, variants
from protocols.base.machine import Ns
from protocols.modbus.mbap import ANSWER, HEADER, Closing, Foreign, Framing, Request


class Framed(Device):
    """The header of its answers is wrong: `change(transaction, protocol, length, unit)`."""

    def __init__(self, change: int) -> None:
        super().__init__(False)
        self._change = change

    def framed(self, said: bytes) -> bytes:
        found, at = b"", 0
        while at < len(said):
            transaction, protocol, length = HEADER.unpack_from(said, at)
            body = said[at + 7 : at + 6 + length]
            unit = said[at + 6]
            changed = (
                ((transaction + 1) & 0xFFFF, protocol, length, unit),
                (transaction, 1, length, unit),
                (transaction, protocol, length + 1, unit),
                (transaction, protocol, length, unit + 1),
            )
            found += ANSWER.pack(*changed[self._change]) + body
            at += 6 + length
        return found


class ExceptionUnit(Device):
    """Its exceptions carry unit 0."""

    def framed(self, said: bytes) -> bytes:
        return said[:6] + b"\0" + said[7:] if len(said) == 9 and said[7] & 0x80 else said


class OtherUnitZero(Device):
    """Requests to unit 0 are answered as unit 1."""

    def framed(self, said: bytes) -> bytes:
        return said[:6] + b"\1" + said[7:] if said[6:7] == b"\0" else said


class LowTransaction(Device):
    """Returns only eight bits of the transaction number."""

    def framed(self, said: bytes) -> bytes:
        return b"\0" + said[1:]


class OneOfTen(Device):
    """Of several requests in one segment only the first is answered."""

    def _take(self, events: Sequence[object], now: Ns) -> list[object]:
        return super()._take(events[:1], now)


class LastTransaction(Device):
    """The answer to FC 16 carries the transaction of the request before."""

    _last = 0

    def framed(self, said: bytes) -> bytes:
        before, self._last = self._last, HEADER.unpack_from(said)[0]
        return before.to_bytes(2, "big") + said[2:] if said[7] == 16 else said


class WholeOnly(Device):
    """A request must come in one piece."""

    _last: Ns = 0

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        if now != self._last:
            self.framing = Framing()
        self._last = now
        return super().receive(data, now)


class AnswersForeign(Device):
    """A frame that cannot be is answered like a good one."""

    def strange(self, event: object) -> None:
        if isinstance(event, Closing):
            self._queue.append((0, ANSWER.pack(1, 0, 5, 1) + b"\x03\x02\x00\x00"))


class ByFunction(Device):
    """Takes the length of a request from its function, not from its header."""

    _half = b""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        self._half += data
        if len(self._half) < 8:
            return []
        fixed = self._half[7] in range(1, 7)
        size = 12 if fixed else 6 + HEADER.unpack_from(self._half)[2]
        if len(self._half) < size:
            return []
        frame, self._half = self._half[:size], self._half[size:]
        found = super().receive(frame[:4] + b"\x00\x06" + frame[6:] if fixed else frame, now)
        return [*found, *self.receive(b"", now)]

    def lost(self, now: Ns) -> Sequence[object]:
        self._half = b""
        return super().lost(now)


class AnyProtocol(Device):
    """These bits of the protocol identifier are ignored."""

    def __init__(self, bits: int) -> None:
        super().__init__(False)
        self._counts = 0xFFFF ^ bits

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        if len(data) < HEADER.size:
            return super().receive(data, now)
        seen = int.from_bytes(data[2:4], "big") & self._counts
        return super().receive(data[:2] + seen.to_bytes(2, "big") + data[4:], now)


class LocksUp(Device):
    """A frame of another protocol ends its service."""

    def strange(self, event: object) -> None:
        self.dead = self.dead or isinstance(event, Foreign)


class Tires(Device):
    """After 80 requests it is silent."""

    def framed(self, said: bytes) -> bytes:
        return said if self.count < 80 else b""


class GivesUp(Device):
    """After ten refusals in a row it is silent, on a new connection as well."""

    def serve(self, request: Request, now: Ns) -> bytes:
        said = super().serve(request, now)
        self.refused = self.refused + 1 if said[:1] >= b"\x80" else 0
        self.dead = self.dead or self.refused > 10
        return said


class Sleeps(Device):
    """After two seconds without a request it is silent."""

    _heard: Ns = 0

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        if self.count and now - self._heard > 2_000_000_000:
            self.dead = True
        self._heard = now
        return super().receive(data, now)


class HangsAtCount(Device):
    """A FC 16 with a wrong byte count ends its service for half a minute."""

    _until: Ns = 0

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        if data[7:8] == b"\x10" and data[12:13] != bytes((2 * data[11] & 0xFF,)):
            self._until = now + 30_000_000_000
        return [] if now < self._until else super().receive(data, now)


class BareRefusal(Device):
    """A request that is too short is refused without a header."""

    _bare = False

    def serve(self, request: Request, now: Ns) -> bytes:
        self._bare = len(request.pdu) == 4
        return super().serve(request, now)

    def framed(self, said: bytes) -> bytes:
        return said[7:] if self._bare and len(said) == 9 and said[7] & 0x80 else said


class OneData(Device):
    """All requests of one segment are answered with the data of the first."""

    def _take(self, events: Sequence[object], now: Ns) -> list[object]:
        first = next((event for event in events if isinstance(event, Request)), None)
        return super()._take([event._replace(pdu=first.pdu) if first and isinstance(event, Request) else event for event in events], now)


class Halves(Device):
    """Data after a complete request in its segment are dropped, unless they are complete."""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        before = self.count
        found = super().receive(data, now)
        if self.count > before:
            self.framing = Framing()
        return found


class LongInOne(Device):
    """The first piece of a request of more than 40 bytes is dropped."""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        long = len(data) >= HEADER.size and 40 < HEADER.unpack_from(data)[2] < 255
        return [] if long and len(data) < 6 + HEADER.unpack_from(data)[2] else super().receive(data, now)


class Remembers(Device):
    """A number that was used before brings the answer of then."""

    def __init__(self) -> None:
        super().__init__(False)
        self._answers: tuple[bytes, bytes] = (b"", b"")

    def framed(self, said: bytes) -> bytes:
        if said[:2] != self._answers[0]:
            self._answers = said[:2], said
        return self._answers[1]


class ForeignWrites(Device):
    """Executes FC 6 and 16 for every unit."""

    def serve(self, request: Request, now: Ns) -> bytes:
        self._any_unit = request.pdu[:1] in (b"\x06", b"\x10")
        return super().serve(request, now)


MORE: tuple[Row, ...] = (
    ("transaction", "answers with the next transaction number", ("FUN_BV_01",), lambda rtu: Framed(0)),
    ("protocol", "protocol identifier 1 in its answers", ("FUN_BV_01",), lambda rtu: Framed(1)),
    ("length", "a length one too long", ("FUN_BV_01",), lambda rtu: Framed(2)),
    ("unit", "answers with another unit", ("FUN_BV_01",), lambda rtu: Framed(3)),
    ("exception-unit", "its exceptions carry unit 0", ("FUN_BI_04",), lambda rtu: ExceptionUnit(False)),
    ("unit-0-as-1", "answers unit 0 as unit 1", ("TCP_BV_10",), lambda rtu: OtherUnitZero(False, any_unit=True)),
    ("low-transaction", "eight bits of the transaction come back", ("FUN_BV_01", "TCP_BV_01"), lambda rtu: LowTransaction(False)),
    ("one-of-ten", "answers the first of several requests", ("TCP_BV_02",), lambda rtu: OneOfTen(False, late=1_000_000)),
    ("last-transaction", "FC 16 has the transaction of the request before", ("ANS_BV_01",), lambda rtu: LastTransaction(False)),
    ("whole-only", "a request must come in one piece", ("TCP_BV_03",), lambda rtu: WholeOnly(False)),
    ("answers-foreign", "answers a frame that cannot be", ("TCP_BI_02", "TCP_BI_03"), lambda rtu: AnswersForeign(False)),
    ("by-function", "takes the length of a request from its function", ("LEN_BI_03", "LEN_BI_04"), lambda rtu: ByFunction(False)),
    ("locks-up", "a frame of another protocol ends its service", ("TCP_BI_01",), lambda rtu: LocksUp(False)),
    ("any-protocol", "answers frames of any protocol", ("TCP_BI_01",), lambda rtu: AnyProtocol(0xFFFF)),
    ("low-protocol", "the high byte of the protocol identifier does not count", ("TCP_BI_01",), lambda rtu: AnyProtocol(0xFF00)),
    ("bare-refusal", "refuses a short request without a header", ("FUN_BI_03",), lambda rtu: BareRefusal(False)),
    ("forgets", "what a client wrote is gone with its connection", ("EFF_CA_01",), lambda rtu: ForgetsWithTheClient(False)),
    ("hangs-at-count", "a wrong byte count ends its service for a while", ("FUN_BI_71",), lambda rtu: HangsAtCount(False)),
    ("tires", "silent after 80 requests", ("TCP_ST_01",), lambda rtu: Tires(False)),
    ("gives-up", "silent after ten refusals in a row", ("TCP_RC_03",), lambda rtu: GivesUp(False)),
    ("one-data", "requests of one segment bring the data of the first", ("TCP_BV_04",), lambda rtu: OneData(False)),
    ("halves", "drops what follows a request in its segment", ("TCP_BV_06",), lambda rtu: Halves(False)),
    ("long-in-one", "a long request must come in one piece", ("TCP_BV_07",), lambda rtu: LongInOne(False)),
    ("remembers", "a number used before brings the answer of then", ("TCP_BV_08",), lambda rtu: Remembers()),
    ("foreign-writes", "executes FC 6 and 16 for every unit", ("TCP_BI_07",), lambda rtu: ForeignWrites(False)),
    ("sleeps", "silent after two seconds of rest", ("TCP_RC_04",), lambda rtu: Sleeps(False)),
)
MUTANTS = mutants("MBTCP", False, MORE, without=("after-refusals", "each-70th"))
VARIANTS = variants(False)
