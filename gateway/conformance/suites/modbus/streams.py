"""Modbus TCP, several requests in one stream: their order, their data, their numbers; units of others (TCP guide, 4.2, 4.4)."""

import struct

from gateway.conformance.suites.modbus.content import kept, same_values
from gateway.conformance.suites.modbus.framing import TCP, readable_request
from gateway.conformance.suites.modbus.tester import ModbusTester
from gateway.pure.conformance.verdict import Disturbed, Fail, NotApplicable, Warn
from protocols.modbus.mbap import HEADER

__all__ = ["TCP"]  # the registry finds the complete group here

FIRST, TOGETHER, PIECES, MISSING = "MBTCP_FUN_BV_01", "MBTCP_TCP_BV_02", "MBTCP_TCP_BV_03", "MBTCP_TCP_BI_06"
NUMBER = 0x5001
VALUE = 0x5AA5
BUSY = 0x06
FEW = 20  # registers that make a request long


def _reads(t: ModbusTester) -> list[bytes]:
    """Requests of one function whose answers differ: one, two and three values, from two addresses."""
    for function, at in t.setup.base.items():
        count = 17 if function < 3 else 3
        if t.setup.span.get(function, 1) > count:
            sizes = (1, count, 9) if function < 3 else (1, count, 2)
            return [struct.pack(">BHH", function, at + place % 2, size) for place, size in enumerate(sizes)]
    raise NotApplicable("no four values can be read at once")


def _answer(t: ModbusTester) -> bytes:
    """The next frame; a busy answer repeats the case."""
    found = t.answer_frame()
    if len(found) == 9 and found[7] & 0x80 and found[8] == BUSY:
        raise Disturbed("a request was refused with 06h: busy", "an answer", t.words(found[7:]))
    return found


def _shown(t: ModbusTester, frame: bytes) -> str:
    return t.words(frame[7:]) if len(frame) > 7 else t.words(frame)


@TCP.case(
    "BV_04",
    "requests of one segment are each answered with their own data",
    "Anfragen eines Segments werden je mit ihren eigenen Daten beantwortet",
    clause="TCP guide, 4.2.2",
    preamble=(FIRST, TOGETHER),
)
def own_data(t: ModbusTester) -> None:
    reads = _reads(t)
    alone = [t.ask(pdu) for pdu in reads]
    t.quiet()
    t.send(b"".join(t.frame(pdu, transaction=NUMBER + at) for at, pdu in enumerate(reads)))
    for _ in reads:
        found = _answer(t)
        at = HEADER.unpack_from(found)[0] - NUMBER if len(found) > 8 else -1
        if not 0 <= at < len(reads):
            raise Fail("a request of several in one segment is not answered", "an answer to each", t.words(found))
        if found[7:] != alone[at]:
            said = f"request {at + 1} of {len(reads)} in one segment: another answer than alone"
            raise Fail(said, t.words(alone[at]), _shown(t, found))


@TCP.case(
    "BV_05",
    "a write and a read in one segment: the read brings what was written",
    "Schreiben und Lesen in einem Segment: gelesen wird das Geschriebene",
    clause="TCP guide, 4.2.2",
    condition=("write_holding", "fc6"),
    preamble=(FIRST, TOGETHER, "MBTCP_CON_BV_06"),
)
def in_order(t: ModbusTester) -> None:
    """The guide orders nothing, but clients rely on it: WARN."""
    at = t.setup.holding[0]
    with kept(t, 3, at, 1):
        value = t.registers(3, at, 1)[0] ^ VALUE
        t.quiet()
        write, read = struct.pack(">BHH", 6, at, value), struct.pack(">BHH", 3, at, 1)
        t.send(t.frame(write, transaction=NUMBER) + t.frame(read, transaction=NUMBER + 1))
        answers = {HEADER.unpack_from(found)[0]: found[7:] for found in (_answer(t), _answer(t)) if len(found) > 8}
        wanted, got = struct.pack(">BBH", 3, 2, value), answers.get(NUMBER + 1, b"")
        if got != wanted:
            raise Warn("the read was executed before the write ahead of it in the segment", t.words(wanted), t.words(got))


@TCP.case(
    "BV_06",
    "one request and the beginning of the next in one segment: both are answered",
    "eine Anfrage und der Anfang der nächsten in einem Segment: beide werden beantwortet",
    clause="TCP guide, 4.2.1",
    preamble=(FIRST, TOGETHER, PIECES),
)
def one_and_a_half(t: ModbusTester) -> None:
    for cut in (1, 6, 9):
        t.quiet()
        first, second = (t.frame(readable_request(t), transaction=NUMBER + at) for at in (0, 1))
        t.send(first + second[:cut])
        found = _answer(t)
        t.send(second[cut:])
        for number, frame in ((NUMBER, found), (NUMBER + 1, _answer(t))):
            if len(frame) < 8 or HEADER.unpack_from(frame)[0] != number:
                what = f"{cut} bytes of the next request came with one: request {number - NUMBER + 1} is not answered"
                raise Fail(what, f"an answer to {number:04X}h", t.words(frame))


@TCP.case(
    "BV_07",
    "a long request in pieces is executed",
    "eine lange Anfrage in Stücken wird ausgeführt",
    clause="TCP guide, 4.2.1",
    condition=("write_holding", "fc16"),
    preamble=(FIRST, PIECES, "MBTCP_CON_BV_16"),
)
def long_pieces(t: ModbusTester) -> None:
    at, count = t.setup.holding[0], 1
    while count < FEW and at + count in t.setup.holding:
        count += 1
    with kept(t, 3, at, count):
        values = t.registers(3, at, count)
        pdu = struct.pack(f">BHHB{count}H", 16, at, count, 2 * count, *values)
        frame = t.frame(pdu)
        for cut in (12, 13, len(frame) // 2, len(frame) - 1):
            t.quiet()
            t.send(frame[:cut])
            t.hear(t.wire.now() + 20_000_000)
            t.send(frame[cut:])
            found = _answer(t)
            if found[7:] != pdu[:5]:
                raise Fail(f"FC 16 of {len(frame)} bytes, cut after byte {cut}", t.words(pdu[:5]), _shown(t, found))


@TCP.case(
    "BV_08",
    "a number that was used before is answered anew, on this connection and on the next",
    "eine schon benutzte Nummer wird neu beantwortet, auf dieser und der nächsten Verbindung",
    clause="TCP guide, 4.2.2",
    preamble=(FIRST, "MBTCP_TCP_BV_01"),
)
def used_number(t: ModbusTester) -> None:
    """Many clients begin with the same number on each connection."""
    reads = _reads(t)[:2]
    alone = [t.ask(pdu) for pdu in reads]
    for again in (False, True):
        for at, pdu in enumerate(reads):
            if at and again:
                t.reconnect()
            t.quiet()
            t.send(t.frame(pdu, transaction=NUMBER))
            found = _answer(t)
            if found[7:] != alone[at]:
                where = "on a new connection" if again else "on the same connection"
                said = f"number {NUMBER:04X}h once more, {where}: another answer than its request has"
                raise Fail(said, t.words(alone[at]), _shown(t, found))


@TCP.case(
    "BI_07",
    "a write to a unit that does not exist is not executed",
    "ein Schreiben an ein nicht vorhandenes Gerät wird nicht ausgeführt",
    clause="TCP guide, 4.4.2.3",
    preamble=(FIRST, MISSING),
)
def foreign_writes(t: ModbusTester) -> None:
    read = t.ask(readable_request(t), unit=t.setup.missing)
    if read and not read[0] & 0x80:
        raise NotApplicable("it answers for every unit")
    for function, table, touched in ((5, 1, t.setup.coils), (6, 3, t.setup.holding), (15, 1, t.setup.coils), (16, 3, t.setup.holding)):
        if not touched or not t.setup.pics.get(f"fc{function}"):
            continue
        at = touched[0]
        with kept(t, table, at, 1):
            before = t.read(table, at, 1)
            value = before[0] ^ (1 if table == 1 else VALUE)
            pdu = {
                5: struct.pack(">BHH", 5, at, 0xFF00 if value else 0),
                6: struct.pack(">BHH", 6, at, value),
                15: struct.pack(">BHHBB", 15, at, 1, 1, value & 1),
                16: struct.pack(">BHHBH", 16, at, 1, 2, value),
            }[function]
            got = t.ask(pdu, unit=t.setup.missing)
            same_values(t.read(table, at, 1), before, f"{at} after FC {function} for unit {t.setup.missing}")
            if got and not got[0] & 0x80:
                said = f"FC {function} for unit {t.setup.missing}, which does not answer reads, is acknowledged"
                raise Fail(said, "silence, exception 0Ah or 0Bh", t.words(got))
