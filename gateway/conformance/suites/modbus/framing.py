"""Modbus, framing and life: headers, pipelining, several clients, garbage, idling; RTU: CRC, gaps, broadcasts."""

import struct

from gateway.conformance.framework.causes import PREPARING
from gateway.conformance.suites.modbus.tester import ModbusTester
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Ended, Fail, Inconclusive, Warn
from protocols.base.machine import ms
from protocols.modbus.crc import sealed
from protocols.modbus.mbap import ANSWER, HEADER

TCP = Purposes[ModbusTester]("MBTCP_TCP", "server", "TCP guide, 3.1.3", preamble=("MBTCP_FUN_BV_01",))
RTU = Purposes[ModbusTester]("MBRTU_RTU", "server", "serial line guide V1.02, 2.5.1", preamble=("MBRTU_FUN_BV_01",))
MANY, TEN, CLIENTS = 100, 10, 4
PAUSE_MS = 1500


def readable_request(t: ModbusTester) -> bytes:
    function = next(iter(t.setup.base), 3)
    return struct.pack(">BHH", function, t.setup.base.get(function, 0), 1)


def _served(t: ModbusTester, after: str) -> None:
    """A read is answered; FAIL where the server does not live on."""
    try:
        got = t.ask(readable_request(t))
    except Inconclusive as ended:
        raise Fail(f"after {after}: {ended.reason.removeprefix(PREPARING)}", "an answer", ended.got) from ended
    if not got:
        raise Fail(f"after {after} nothing is answered", "an answer", t.words(got))


def _many(t: ModbusTester) -> None:
    for count in range(MANY):
        got = t.ask(readable_request(t))
        if not got or got[0] & 0x80:
            raise Fail(f"request {count + 1} of {MANY}: {t.words(got)}", "a normal answer", t.words(got))


def _exceptions(t: ModbusTester) -> None:
    refusals = [b"\x41\x00\x00\x00\x01", b"\x03\xff\xff\x00\x02"]
    answered = [*t.setup.refused, *(pdu for pdu in refusals if t.ask(pdu))]
    for count in range(1, 21):
        for pdu in answered:
            if not t.ask(pdu) and not t.ask(pdu):  # it may close a connection with many refusals: repeat on a new one
                t.setup.refusals_end = t.case
                raise Fail(f"after {len(answered) * count} refusals nothing is answered", "an exception", "silence, or closed")
    _served(t, f"{20 * len(answered)} refusals")


@TCP.case("BV_01", "transaction numbers are returned unchanged", "Transaktionsnummern kommen unverändert zurück")
def transactions(t: ModbusTester) -> None:
    for number in (0, 1, 0x00FF, 0xFF00, 0xFFFF, 0x1234, 0x1234):
        t.quiet()
        t.send(t.frame(readable_request(t), transaction=number))
        found = t.answer_frame()
        if len(found) < 8 or HEADER.unpack_from(found)[0] != number:
            raise Fail(f"transaction {number:04X}h is not returned", f"{number:04X}h", t.words(found))


@TCP.case(
    "BV_02",
    f"{TEN} requests in one segment: {TEN} answers, each with its number",
    f"{TEN} Anfragen in einem Segment: {TEN} Antworten, je mit ihrer Nummer",
    clause="TCP guide, 4.2.2",
)
def pipelined(t: ModbusTester) -> None:
    t.quiet()
    t.send(b"".join(t.frame(readable_request(t), transaction=0x2000 + at) for at in range(TEN)))
    numbers = []
    for _ in range(TEN):
        found = t.answer_frame()  # the time-out counts from each answer
        if len(found) < 8:
            break
        numbers.append(HEADER.unpack_from(found)[0])
    if sorted(numbers) != [0x2000 + at for at in range(TEN)]:
        raise Fail(
            f"{len(numbers)} of {TEN} requests answered",
            f"{TEN} answers, 2000h to {0x2000 + TEN - 1:04X}h",
            " ".join(f"{number:04X}h" for number in numbers) or "nothing",
        )


@TCP.case(
    "BV_03",
    "a request in pieces is answered once it is whole",
    "eine Anfrage in Stücken wird beantwortet, sobald sie ganz ist",
    clause="TCP guide, 4.2.1",
)
def pieces(t: ModbusTester) -> None:
    for cut in ((6,), (7,), (9,), tuple(range(1, 12))):
        t.quiet()
        frame = t.frame(readable_request(t))
        last = 0
        for place in (*cut, len(frame)):
            t.send(frame[last:place])
            last = place
            if place < len(frame) and t.hear(t.wire.now() + ms(20)):
                raise Fail(f"answered after {place} of {len(frame)} bytes", "nothing yet", "an answer")
        found = t.answer_frame()
        if len(found) < 8 or found[:2] != frame[:2]:
            raise Fail(f"a request cut after byte {cut[0]}: {t.words(found)}", "an answer", t.words(found))


@TCP.case(
    "BI_01",
    "another protocol identifier is not answered",
    "eine andere Protokollkennung wird nicht beantwortet",
    clause="TCP guide, 4.4.2.2",
)
def foreign(t: ModbusTester) -> None:
    """The guide: discard such an indication (AX-1771)."""
    pdu = readable_request(t)
    for protocol in (0x0001, 0x0100, 0xFFFF):
        t.quiet()
        t.send(ANSWER.pack(0x3001, protocol, len(pdu) + 1, t.setup.unit) + pdu)
        found = t.answer_frame()
        if found:
            raise Fail(f"protocol identifier {protocol:04X}h is answered: it is not Modbus", "silence, or close", t.words(found))
        _served(t, f"a frame with the protocol identifier {protocol:04X}h")


def _length(number: int, what: str, de: str, size: int) -> None:
    @TCP.case(
        f"BI_{number:02}",
        f"{what}: nothing is executed, and a new connection is served",
        f"{de}: nichts wird ausgeführt, eine neue Verbindung wird bedient",
    )
    def body(t: ModbusTester) -> None:
        """Send a complete read after such a header: a server that ignores the length would execute it."""
        t.quiet()
        t.send(HEADER.pack(0x3000 + number, 0, size) + bytes((t.setup.unit,)) + readable_request(t))
        found = t.answer_frame()
        if len(found) >= 8 and not found[7] & 0x80:
            raise Fail(f"{what} was answered as if it were good", "close, silence or an exception", t.words(found))
        t.reconnect()
        _served(t, what)


_length(2, "a length of 0", "eine Länge 0", 0)
_length(3, "a length of 1", "eine Länge 1", 1)
_length(4, "a length of 255", "eine Länge 255", 255)
_length(5, "a length of 65535", "eine Länge 65535", 0xFFFF)


@TCP.case(
    "BI_06",
    "a unit that does not exist: silence, 0Ah or 0Bh",
    "ein nicht vorhandenes Gerät: Stille, 0Ah oder 0Bh",
    clause="TCP guide, 4.4.2.3",
)
def missing_unit(t: ModbusTester) -> None:
    got = t.ask(readable_request(t), unit=t.setup.missing)
    if got and not (got[0] & 0x80 and got[1] in (10, 11)):
        raise Warn(f"unit {t.setup.missing}: {t.words(got)}", "silence, exception 0Ah or 0Bh", t.words(got))


@TCP.case(
    "BV_10",
    "units 0 and 255: what answers carries the unit that was asked",
    "Geräte 0 und 255: eine Antwort trägt das gefragte Gerät",
    clause="TCP guide, 4.4.2.3",
)
def other_units(t: ModbusTester) -> None:
    for unit in (0, 255):
        t.ask(readable_request(t), unit=unit, judge=True)


@TCP.case("RC_01", "garbage does not stop the server", "Unsinn hält den Server nicht an")
def garbage(t: ModbusTester) -> None:
    for noise in (b"GET / HTTP/1.0\r\n\r\n", b"\xff" * 300, bytes(range(256))):
        t.quiet()
        t.send(noise)
        t.answer_frame(ms(200))
        t.reconnect()
        _served(t, f"garbage ({noise[:6].hex(' ').upper()} ..)")


@TCP.case("RC_02", "half a request and a new connection: it is served", "halbe Anfrage, dann neue Verbindung: sie wird bedient")
def half(t: ModbusTester) -> None:
    for size in (3, 7, 10):
        t.quiet()
        t.send(t.frame(readable_request(t))[:size])
        t.reconnect()
        _served(t, f"{size} bytes of a request")


@TCP.case(
    "RC_03",
    "after many refusals it serves on",
    "nach vielen Ablehnungen bedient er weiter",
    preamble=("MBTCP_FUN_BV_01", "MBTCP_FUN_BI_04"),
    beside=Particulars(early=True),  # what others do not see because of it
)
def exceptions(t: ModbusTester) -> None:
    _exceptions(t)


@TCP.case("RC_04", "an idle connection is served afterwards, or a new one", "eine ruhende Verbindung wird danach bedient, oder eine neue")
def idle(t: ModbusTester) -> None:
    t.quiet()
    t.hear(t.wire.now() + ms(3000))
    _served(t, "3 s without a request")


@TCP.case("ST_01", f"{MANY} requests in a row", f"{MANY} Anfragen hintereinander")
def run(t: ModbusTester) -> None:
    _many(t)


@TCP.case("ST_02", "connecting and closing forty times", "vierzigmal verbinden und schließen")
def connections(t: ModbusTester) -> None:
    for count in range(40):
        t.reconnect()
        if count % 4 == 0:
            _served(t, f"{count} connections")


@TCP.case(
    "CA_01",
    f"{CLIENTS} clients at once, each gets its own answers",
    f"{CLIENTS} Clients zugleich, jeder bekommt seine Antworten",
    condition=("several",),
)
def clients(t: ModbusTester) -> None:
    others = [t.another() for _ in range(CLIENTS)]
    try:
        for _ in range(5):
            frames = [one.frame(readable_request(t), transaction=0x4000 + at) for at, one in enumerate(others)]
            for one, frame in zip(others, frames, strict=True):
                one.send(frame)
            for at, one in enumerate(others):
                found = one.answer_frame()
                if len(found) < 8 or HEADER.unpack_from(found)[0] != 0x4000 + at:
                    raise Fail(f"client {at + 1} of {CLIENTS}: {one.words(found)}", f"transaction {0x4000 + at:04X}h", one.words(found))
    finally:
        for one in others:
            t.notes.trace += one.notes.trace
            one.drop()


# ---- RTU
def _silence(t: ModbusTester, frame: bytes, what: str) -> None:
    t.quiet()
    t.send(frame)
    found = t.answer_frame()
    if found:
        raise Fail(f"{what} was answered", "silence", t.words(found))


@RTU.case("BI_01", "each wrong bit of the CRC: silence", "jedes falsche Bit der CRC: Stille", clause="serial line guide V1.02, 2.4.2")
def wrong_crc(t: ModbusTester) -> None:
    frame = t.frame(readable_request(t))
    for bit in range(16):
        place = -2 + bit // 8
        broken = bytearray(frame)
        broken[place] ^= 1 << bit % 8
        _silence(t, bytes(broken), f"a frame whose CRC has bit {bit} wrong")


@RTU.case(
    "BI_02", "a CRC with its bytes exchanged: silence", "eine CRC mit vertauschten Bytes: Stille", clause="serial line guide V1.02, 6.2.2"
)
def swapped(t: ModbusTester) -> None:
    frame = t.frame(readable_request(t))
    _silence(t, frame[:-2] + frame[:-3:-1], "a frame with the CRC's high byte first")


@RTU.case("BI_03", "each wrong character of a request: silence", "jedes falsche Zeichen einer Anfrage: Stille")
def wrong_character(t: ModbusTester) -> None:
    frame = t.frame(readable_request(t))
    for at in range(len(frame) - 2):
        broken = bytearray(frame)
        broken[at] ^= 0x04
        _silence(t, bytes(broken), f"a request whose character {at + 1} is wrong")


@RTU.case(
    "BI_04", "a request for another unit: silence", "eine Anfrage an ein anderes Gerät: Stille", clause="serial line guide V1.02, 2.2"
)
def other_unit(t: ModbusTester) -> None:
    for unit in sorted({t.setup.missing, (t.setup.unit + 1) % 247 or 1} - {t.setup.unit}):
        _silence(t, t.frame(readable_request(t), unit=unit), f"a request for unit {unit}")


@RTU.case(
    "BI_05",
    "a gap of 20 characters inside a request: no answer to it",
    "eine Lücke von 20 Zeichen in der Anfrage: keine Antwort darauf",
    clause="serial line guide V1.02, 2.5.1.1",
)
def gap(t: ModbusTester) -> None:
    frame = t.frame(readable_request(t))
    t.quiet()
    t.send(frame[:4])
    found = t.hear(t.wire.drained() + max(ms(50), 20 * t.wire.char_ns))
    t.send(frame[4:])
    found += t.answer_frame()
    if found:
        raise Warn("a request with a gap of 20 characters was answered", "silence", t.words(found))
    _served(t, "a request with a gap")


@RTU.case(
    "BI_08",
    f"a request of two pieces {PAUSE_MS / 1000:g} s apart is none: silence ends a frame",
    f"eine Anfrage aus zwei Stücken im Abstand von {PAUSE_MS / 1000:g} s ist keine: Stille beendet ein Telegramm",
    clause="serial line guide V1.02, 2.5.1.1",
)
def torn(t: ModbusTester) -> None:
    """Pause longer than adapters hold bytes back, and longer than the byte time-outs of servers after them."""
    frame = t.frame(readable_request(t))
    for cut in (1, 4, len(frame) - 1):
        t.quiet()
        t.send(frame[:cut])
        found = t.hear(t.wire.drained() + ms(PAUSE_MS))
        t.send(frame[cut:])
        found += t.answer_frame()
        if found:
            raise Fail(f"a request with {PAUSE_MS} ms of silence after byte {cut} was answered", "silence", t.words(found))


@RTU.case("BI_06", "a broadcast read is not answered", "ein Rundspruch-Lesen wird nicht beantwortet", clause="serial line guide V1.02, 2.1")
def broadcast_read(t: ModbusTester) -> None:
    _silence(t, t.frame(readable_request(t), unit=0), "a broadcast read")
    for function, at in t.setup.base.items():
        _silence(t, t.frame(struct.pack(">BHH", function, at, 1), unit=0), f"a broadcast of FC {function}")


@RTU.case(
    "BV_01",
    "a broadcast write: silence, and it is done",
    "ein Rundspruch-Schreiben: Stille, und es wird ausgeführt",
    clause="serial line guide V1.02, 2.1",
    condition=("write_holding", "fc6", "broadcast"),
)
def broadcast(t: ModbusTester) -> None:
    at = t.setup.holding[0]
    with t.given():
        before = t.registers(3, at, 1)[0]
    wanted = before ^ 0x0FF0
    try:
        _silence(t, t.frame(struct.pack(">BHH", 6, at, wanted), unit=0), "a broadcast write")
        if t.registers(3, at, 1) != [wanted]:
            ended = Fail if t.setup.pics.get("broadcast_stated") else Warn
            raise ended("a broadcast write has no effect", f"{wanted:04X}", f"{t.registers(3, at, 1)[0]:04X}")
    finally:
        try:
            t.ask(struct.pack(">BHH", 6, at, before))
        except Ended:
            t.remark("what was there could not be written back")


@RTU.case("BI_07", "frames that are too short: silence", "zu kurze Telegramme: Stille")
def short(t: ModbusTester) -> None:
    for frame in (b"\x01", bytes((t.setup.unit, 3)), sealed(bytes((t.setup.unit,))), t.frame(readable_request(t))[:-1]):
        _silence(t, frame, f"{frame.hex(' ').upper()}")


@RTU.case("RC_01", "garbage and silence, then a good request: answered", "Unsinn und Stille, dann eine gute Anfrage: beantwortet")
def rtu_garbage(t: ModbusTester) -> None:
    for noise in (bytes(range(256)) + bytes(60), b"\x00" * 5, b"\xff" * 300):
        t.quiet()
        t.send(noise)
        t.answer_frame()
        _served(t, "garbage")


@RTU.case(
    "RC_02",
    "after many refusals and bad frames it serves on",
    "nach vielen Ablehnungen und Störungen bedient er weiter",
    preamble=("MBRTU_FUN_BV_01", "MBRTU_FUN_BI_04"),
    beside=Particulars(early=True),
)
def rtu_exceptions(t: ModbusTester) -> None:
    _exceptions(t)


@RTU.case("ST_01", f"{MANY} requests in a row", f"{MANY} Anfragen hintereinander")
def rtu_run(t: ModbusTester) -> None:
    _many(t)
