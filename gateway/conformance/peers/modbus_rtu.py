"""Modbus RTU: faulty and correct servers."""

from collections.abc import Sequence
from dataclasses import replace

from gateway.conformance.peers.modbus_devices import Device
from gateway.conformance.peers.modbus_rows import Row, mutants, variants
from protocols.base.machine import Damage, Ns, ms
from protocols.modbus.crc import crc, sealed
from protocols.modbus.mbap import Request
from protocols.modbus.rtu import Dropped, Fault


class BadCrc(Device):
    def framed(self, said: bytes) -> bytes:
        return said[:-2] + said[:-3:-1]


class OtherUnit(Device):
    def framed(self, said: bytes) -> bytes:
        return sealed(b"\x09" + said[1:-2])


class AnyCrc(Device):
    """Does not look at the CRC."""

    def _take(self, events: Sequence[object], now: Ns) -> list[object]:
        return super()._take([self._good(event) for event in events], now)

    def _good(self, event: object) -> object:
        if isinstance(event, Dropped) and event.why is Fault.CHECK and len(event.frame) == 8:
            return Request(0, event.frame[0], event.frame[1:-2])
        return event


class AnyCrcOfWrites(AnyCrc):
    """Does not look at the CRC of FC 6."""

    def _good(self, event: object) -> object:
        return super()._good(event) if isinstance(event, Dropped) and event.frame[1:2] == b"\x06" else event


class LowCrc(AnyCrc):
    """Looks at one byte of the CRC."""

    def _good(self, event: object) -> object:
        if isinstance(event, Dropped) and event.why is Fault.CHECK and sealed(event.frame[:-2])[-2] == event.frame[-2]:
            return Request(0, event.frame[0], event.frame[1:-2])
        return event


class AnyUnit(Device):
    """Answers for every unit."""

    def serve(self, request: Request, now: Ns) -> bytes:
        return super().serve(Request(0, 1, request.pdu), now)


class ExceptionForBad(Device):
    """A frame whose CRC is wrong is answered with an exception."""

    def _take(self, events: Sequence[object], now: Ns) -> list[object]:
        for event in events:
            if isinstance(event, Dropped) and len(event.frame) > 3:
                self._queue.append((now, sealed(bytes((event.frame[0], event.frame[1] | 0x80, 3)))))
        return super()._take(events, now)


class NoBroadcast(Device):
    """Broadcasts are not received, though its PICS has them."""

    def serve(self, request: Request, now: Ns) -> bytes:
        return super().serve(request, now) if request.unit else b""


class AnswersBroadcast(Device):
    def serve(self, request: Request, now: Ns) -> bytes:
        return super().serve(request._replace(unit=1) if request.unit == 0 else request, now)


class AnswersBroadcastInputs(Device):
    """Answers a broadcast of FC 4."""

    def serve(self, request: Request, now: Ns) -> bytes:
        return super().serve(request._replace(unit=1) if request.unit == 0 and request.pdu[:1] == b"\x04" else request, now)


class WritesForOthers(Device):
    """Requests for another unit are executed without an answer."""

    def serve(self, request: Request, now: Ns) -> bytes:
        if request.unit > 1:
            super().serve(request._replace(unit=1), now)
        return super().serve(request, now)


class LosesNext(Device):
    """The request after a frame that is too short is lost."""

    _lost = False

    def _take(self, events: Sequence[object], now: Ns) -> list[object]:
        good: list[object] = []
        for event in events:
            if isinstance(event, Dropped) and event.why is Fault.SHORT:
                self._lost = True
            elif isinstance(event, Request) and self._lost:
                self._lost = False
                continue
            good.append(event)
        return super()._take(good, now)


class Tires(Device):
    def framed(self, said: bytes) -> bytes:
        return said if self.count < 80 else b""


class NoiseKills(Device):
    """Five damaged frames end its service."""

    _bad = 0

    def _take(self, events: Sequence[object], now: Ns) -> list[object]:
        self._bad += sum(isinstance(event, Dropped) for event in events)
        self.dead = self.dead or self._bad > 5
        return super()._take(events, now)


class NoSilence(Device):
    """Takes a request of FC 1 to 6 by its length, whatever the silence within."""

    _last = b""

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        super().receive(data, now)
        self._last = (self._last + data)[-8:]
        if len(self._last) == 8 and self._by_length(self._last[1]) and not crc(self._last):
            frame, self._last = self._last, b""
            return super()._take([Request(0, frame[0], frame[1:-2])], now)
        return []

    def _take(self, events: Sequence[object], now: Ns) -> list[object]:
        return super()._take([event for event in events if not self._taken(event)], now)

    def _taken(self, event: object) -> bool:
        return isinstance(event, Request) and len(event.pdu) == 5 and self._by_length(event.pdu[0])

    @staticmethod
    def _by_length(function: int) -> bool:
        return 1 <= function <= 6


class SevenBitUnit(Device):
    """The top bit of a unit does not count."""

    def serve(self, request: Request, now: Ns) -> bytes:
        return super().serve(request._replace(unit=request.unit & 0x7F), now)


class OtherInputs(Device):
    """Answers FC 4 for every unit."""

    def serve(self, request: Request, now: Ns) -> bytes:
        return super().serve(request._replace(unit=1) if request.pdu[:1] == b"\x04" else request, now)


class OtherCoils(Device):
    """FC 15 for another unit is executed, without an answer."""

    def serve(self, request: Request, now: Ns) -> bytes:
        if request.unit > 1 and request.pdu[:1] == b"\x0f":
            super().serve(request._replace(unit=1), now)
        return super().serve(request, now)


class NoCoilBroadcast(Device):
    """Broadcasts to registers are executed, those to coils are not."""

    def serve(self, request: Request, now: Ns) -> bytes:
        return b"" if request.unit == 0 and request.pdu[:1] in (b"\x05", b"\x0f") else super().serve(request, now)


class RefusesBroadcast(Device):
    """A broadcast that it cannot execute is answered with an exception."""

    def serve(self, request: Request, now: Ns) -> bytes:
        said = super().serve(request._replace(unit=1) if request.unit == 0 else request, now)
        return said if request.unit or (said and said[0] & 0x80 and request.pdu[0] in (5, 15, 16)) else b""


class SkipsDamage(Device):
    """A damaged character is dropped, and the rest accepted."""

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        return []


class MuteAfterDamage(Device):
    """Ignores everything for two seconds after a damaged character."""

    _until: Ns = 0

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        self._until = now + ms(2000)
        return super().damaged(kind, now)

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        return super().receive(data, now) if now >= self._until else []


class LongCrc(Device):
    """The CRC of answers of more than a hundred bytes is wrong."""

    def framed(self, said: bytes) -> bytes:
        return said if len(said) < 100 else said[:-1] + bytes((said[-1] ^ 1,))


MORE: tuple[Row, ...] = (
    ("seven-bit-unit", "the top bit of a unit does not count", ("STA_BI_01",), lambda rtu: SevenBitUnit(True)),
    ("other-inputs", "answers FC 4 for every unit", ("STA_BI_01",), lambda rtu: OtherInputs(True)),
    ("other-coils", "executes FC 15 for other units", ("STA_BI_01",), lambda rtu: OtherCoils(True)),
    ("no-coil-broadcast", "a broadcast to coils has no effect", ("STA_BV_01",), lambda rtu: NoCoilBroadcast(True)),
    ("refuses-broadcast", "answers a bad broadcast with an exception", ("STA_BI_02",), lambda rtu: RefusesBroadcast(True)),
    ("skips-damage", "leaves a damaged character out", ("STA_BI_04",), lambda rtu: SkipsDamage(True)),
    ("mute-after-damage", "mute for 2 s after a damaged character", ("STA_RC_01",), lambda rtu: MuteAfterDamage(True)),
    ("long-crc", "the CRC of long answers is wrong", ("ANS_BV_05",), lambda rtu: LongCrc(True)),
    ("bad-crc", "sends its CRC high byte first", ("FUN_BV_01",), lambda rtu: BadCrc(True)),
    ("other-unit", "answers as unit 9", ("FUN_BV_01",), lambda rtu: OtherUnit(True)),
    ("any-crc", "does not look at the CRC", ("RTU_BI_01",), lambda rtu: AnyCrc(True)),
    ("half-crc", "looks at one byte of the CRC", ("RTU_BI_01",), lambda rtu: LowCrc(True)),
    ("any-unit", "answers for every unit", ("RTU_BI_04",), lambda rtu: AnyUnit(True)),
    ("exception-for-bad", "answers a bad frame with an exception", ("RTU_BI_01",), lambda rtu: ExceptionForBad(True)),
    ("answers-broadcast", "answers a broadcast", ("RTU_BI_06",), lambda rtu: AnswersBroadcast(True)),
    ("answers-inputs", "answers a broadcast of FC 4", ("RTU_BI_06",), lambda rtu: AnswersBroadcastInputs(True)),
    ("writes-any-crc", "does not look at the CRC of FC 6", ("STA_BI_05",), lambda rtu: AnyCrcOfWrites(True)),
    ("writes-for-others", "executes writes to other units", ("ANS_BI_01",), lambda rtu: WritesForOthers(True)),
    ("loses-next", "the request after a short frame is lost", ("ANS_RC_01",), lambda rtu: LosesNext(True)),
    ("no-broadcast", "a broadcast has no effect", ("RTU_BV_01",), lambda rtu: NoBroadcast(True)),
    ("no-silence", "takes a request by its length, whatever the silence within", ("RTU_BI_08",), lambda rtu: NoSilence(True)),
    ("tires", "silent after 80 requests", ("RTU_ST_01", "FUN_BV_10"), lambda rtu: Tires(True)),
    ("noise-kills", "five spoiled frames end its service", ("RTU_BI_01",), lambda rtu: NoiseKills(True)),
)
STATED: dict[str, dict[str, object]] = {"no-broadcast": {"broadcast": True}}
MUTANTS = tuple(
    replace(mutant, pics=dict(STATED.get(mutant.id, {})))
    for mutant in mutants("MBRTU", True, MORE, without=("after-refusals", "each-70th", "tires"))
)
VARIANTS = variants(True)
