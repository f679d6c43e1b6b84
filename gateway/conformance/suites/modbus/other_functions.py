"""Modbus: functions that are none, FC 8 and FC 43 (suites modbus-tcp and modbus-rtu)."""

from gateway.conformance.suites.modbus.tester import CROSS, ModbusTester
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, Warn

MOST_PARTS = 4  # answers of a basic stream


def _never_executed(t: ModbusTester, function: int) -> None:
    t.quiet()
    t.send(t.frame(bytes((function, 0, 0, 0, 1))))
    found = t.answer_frame()
    pdu = found[1:-2] if t.rtu else found[7:]
    if function > 0x80 and pdu == bytes((function & 0x7F, 1)):  # 80h is added and cut to a byte: meant as a refusal
        said = f"function {function:02X}h is refused as function {function & 0x7F:02X}h with 01h: bit 7 is added, not set"
        raise Warn(said, f"{function:02X} 01", t.words(pdu))
    if pdu and (not pdu[0] & 0x80 or len(pdu) > 2):
        raise Fail(f"function {function:02X}h was executed", "exception 01h, or silence", t.words(pdu))


def _objects(t: ModbusTester, got: bytes) -> list[int]:
    """The numbers of the objects in one answer of FC 43/14."""
    if len(got) < 8 or got[1] != 0x0E or got[2] != 1 or got[6] < 1:
        raise Fail("FC 43/14: malformed answer", "2B 0E 01, conformity, more, next, count, objects", t.words(got))
    if got[3] & 0x7F not in (1, 2, 3):
        raise Fail(f"FC 43/14: conformity level {got[3]:02X}h", "01h, 02h, 03h, 81h, 82h or 83h", t.words(got))
    if got[4] not in (0, 0xFF):
        raise Fail(f"FC 43/14: more follows is {got[4]:02X}h", "00h or FFh", t.words(got))
    at, named = 7, []
    for _ in range(got[6]):
        if at + 2 > len(got):
            raise Fail("FC 43/14: an object is cut off", "number, length, text", t.words(got))
        named.append(got[at])
        at += 2 + got[at + 1]
    if at != len(got):
        raise Fail(f"FC 43/14: {len(got) - at} bytes after the last object", "none", t.words(got))
    return named


def _short_answers(p: Purposes[ModbusTester], basic: str) -> None:
    @p.case(
        "CA_07",
        "FC 7: one byte of status",
        "FC 7: ein Statusbyte",
        clause="V1.1b3, 6.7",
        condition=("fc7",),
        preamble=(basic,),
    )
    def status(t: ModbusTester) -> None:
        got = t.normal(b"\x07", "FC 7")
        if len(got) != 2:
            raise Fail(f"FC 7: {len(got) - 1} bytes of status", "07 and one byte", t.words(got))

    @p.case(
        "CA_17",
        "FC 17: as many bytes as it counts",
        "FC 17: so viele Bytes, wie es zählt",
        clause="V1.1b3, 6.13",
        condition=("fc17",),
        preamble=(basic,),
    )
    def server_id(t: ModbusTester) -> None:
        got = t.normal(b"\x11", "FC 17")
        if len(got) < 2 or got[1] != len(got) - 2:
            raise Fail(
                "FC 17: its byte count is wrong", f"11 {len(got) - 2:02X} .." if len(got) > 1 else "11, byte count, data", t.words(got)
            )

    @p.case(
        "CA_08",
        "FC 8/0: the data are returned",
        "FC 8/0: die Daten kommen zurück",
        clause="V1.1b3, 6.8",
        condition=("fc8",),
        preamble=(basic,),
    )
    def loop(t: ModbusTester) -> None:
        for data in (b"\xa5\x37", b"\x00\x00", b"\xff\xff"):
            t.echo(b"\x08\x00\x00" + data, 5, "FC 8/0")


def other_functions(p: Purposes[ModbusTester], basic: str) -> None:
    @p.case(
        "BI_01",
        "functions that are none are refused with 01h and the function with bit 7",
        "Funktionen, die keine sind, werden mit 01h abgelehnt",
        clause="V1.1b3, 7",
        preamble=(basic, basic.replace("BV_01", "BI_04")),
        beside=CROSS,
    )
    def none(t: ModbusTester) -> None:
        for function in (0x41, 0x09, 0x64, 0x6E, 0x7F):
            t.exception(bytes((function, 0, 0, 0, 1)), 1, f"FC {function:02X}h, which does not exist")

    @p.case(
        "BI_02",
        "functions 0 and from 80h are never executed",
        "die Funktionen 0 und ab 80h werden nie ausgeführt",
        clause="V1.1b3, 4.1",
        preamble=(basic,),
    )
    def high(t: ModbusTester) -> None:
        for function in (0x83, 0xFF, 0x00):
            _never_executed(t, function)

    @p.case(
        "CA_43",
        "FC 43/14: the basic stream names vendor, product and revision",
        "FC 43/14: der Basisstrom nennt Hersteller, Produkt und Stand",
        clause="V1.1b3, 6.21",
        condition=("fc43",),
        preamble=(basic,),
    )
    def identification(t: ModbusTester) -> None:
        got = t.normal(b"\x2b\x0e\x01\x00", "FC 43/14")
        named = _objects(t, got)
        for _ in range(MOST_PARTS):
            if not got[4]:
                break
            got = t.normal(bytes((0x2B, 0x0E, 1, got[5])), f"FC 43/14 from object {got[5]}, which is to follow")
            named += _objects(t, got)
        if named[:3] != [0, 1, 2] or got[4]:
            shown = ", ".join(f"{number:02X}h" for number in named) + (", and more to follow" if got[4] else "")
            raise Fail(f"FC 43/14: the basic stream has the objects {shown}", "00h, 01h, 02h, and no more to follow", t.words(got))
        t.exception(b"\x2b\x0e\x00\x00", 3, "FC 43/14, code 0")
        other = t.ask(b"\x2b\x55\x00\x00")  # a transport that is none
        if other and not other[0] & 0x80:
            raise Fail("FC 43 with MEI type 55h, which does not exist, was executed", "an exception", t.words(other))

    _short_answers(p, basic)
