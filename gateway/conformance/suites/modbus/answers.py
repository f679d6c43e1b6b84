"""Modbus: the frame of every function's answer, bits and bytes in every place; RTU: other units, broadcasts, frames too short."""

import struct
from collections.abc import Iterator

from gateway.conformance.framework.causes import PREPARING
from gateway.conformance.suites.modbus.content import kept, same_values, write_back
from gateway.conformance.suites.modbus.functions import end_of, reads_well
from gateway.conformance.suites.modbus.tester import ModbusTester
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Ended, Fail, NotApplicable, Warn
from protocols.modbus.crc import sealed

OTHERS = (b"\x07", b"\x08\x00\x00\xa5\x37", b"\x0b", b"\x0c", b"\x11", b"\x2b\x0e\x01\x00")
PLACES = (0x0080, 0x8000, 0x00FF, 0xFF00, 0x7FFF, 0x8001, 0x0100)
NEEDED = {1: "write_coils", 3: "write_holding"}
ROW = 20  # coils: more than two bytes
EDGE = 256  # the low byte of an address begins again


def _row(numbers: tuple[int, ...], least: int, what: str) -> int:
    """The first address with so many writable ones in a row."""
    for at in numbers:
        if all(at + offset in numbers for offset in range(least)):
            return at
    raise NotApplicable(f"no {least} {what} in a row may be written")


def _writes(t: ModbusTester) -> Iterator[bytes]:
    """Write the present values again, by each function."""
    if t.setup.pics.get("write_coils"):
        at = t.setup.coils[0]
        bit = t.bits(1, at, 1)[0]
        yield struct.pack(">BHH", 5, at, 0xFF00 * bit)
        yield struct.pack(">BHHBB", 15, at, 1, 1, bit)
    if t.setup.pics.get("write_holding"):
        at = t.setup.holding[0]
        value = t.registers(3, at, 1)[0]
        yield struct.pack(">BHH", 6, at, value)
        yield struct.pack(">BHHBH", 16, at, 1, 2, value)
        yield struct.pack(">BHHH", 22, at, 0xFFFF, 0)
        yield struct.pack(">BHHHHBH", 23, at, 1, at, 1, 2, value)


def _frames(p: Purposes[ModbusTester], basic: str) -> None:
    @p.case(
        "BV_01",
        "the answer of every function has the frame of its request: transaction or CRC, unit, function",
        "die Antwort jeder Funktion hat den Rahmen ihrer Anfrage: Transaktion oder CRC, Gerät, Funktion",
        clause="V1.1b3, 4.1",
        preamble=(basic, basic.replace("BV_01", "BI_04")),
    )
    def body(t: ModbusTester) -> None:
        with t.given():
            writes = list(_writes(t))
        reads = [struct.pack(">BHH", function, at, 1) for function, at in t.setup.base.items()]
        others = [pdu for pdu in OTHERS if t.setup.pics.get(f"fc{pdu[0]}")]
        for pdu in (*reads, *writes, *others):
            t.ask(pdu, judge=True)


def _places(p: Purposes[ModbusTester], con: str) -> None:
    @p.case(
        "BV_02",
        "every bit of a register is its own: no byte is extended or cut",
        "jedes Bit eines Registers ist ein eigenes: kein Byte wird erweitert oder gekürzt",
        clause="V1.1b3, 4.2",
        condition=("write_holding",),
        preamble=(f"{con}_FUN_BV_01", f"{con}_CON_BV_06"),
    )
    def registers(t: ModbusTester) -> None:
        if not (t.setup.pics.get("fc6") or t.setup.pics.get("fc16")):
            raise NotApplicable("it has neither FC 6 nor FC 16")
        at = t.setup.holding[0]
        with kept(t, 3, at, 1):
            for value in (*PLACES, *(1 << bit for bit in range(16))):
                write_back(t, 3, at, [value])
                same_values(t.registers(3, at, 1), [value], f"register {at} with {value:04X}h")

    @p.case(
        "BV_03",
        "coils are read from any address, not from a whole byte on",
        "Spulen werden ab jeder Adresse gelesen, nicht ab einem ganzen Byte",
        clause="V1.1b3, 6.1",
        condition=("write_coils",),
        preamble=(f"{con}_FUN_BV_01", f"{con}_CON_BV_05"),
    )
    def coils(t: ModbusTester) -> None:
        if not (t.setup.pics.get("fc5") or t.setup.pics.get("fc15")):
            raise NotApplicable("it has neither FC 5 nor FC 15")
        at = _row(t.setup.coils, ROW, "coils")
        values = [int(offset % 3 == 0 or offset % 5 == 1) for offset in range(ROW)]
        with kept(t, 1, at, ROW):
            with t.given():
                write_back(t, 1, at, values)
            for first in range(1, 10):
                same_values(t.bits(1, at + first, ROW - first), values[first:], f"{ROW - first} coils from {at + first}")

    @p.case(
        "BV_04",
        "FC 23 that reads less than it writes: byte count and data of what is read",
        "FC 23, das weniger liest als schreibt: Byteanzahl und Daten des Gelesenen",
        clause="V1.1b3, 6.17",
        condition=("write_holding", "fc23"),
        preamble=(f"{con}_FUN_BV_01", f"{con}_CON_BV_23"),
    )
    def unequal(t: ModbusTester) -> None:
        at = _row(t.setup.holding, 3, "registers")
        with kept(t, 3, at, 3):
            for count in (1, 2):
                values = [0x1201 + count, 0x3402 + count, 0x5603 + count]
                got = t.normal(struct.pack(">BHHHHB3H", 23, at, count, at, 3, 6, *values), "FC 23")
                if len(got) != 2 + 2 * count or got[1] != 2 * count:
                    why = f"FC 23 reads {count} and writes 3: byte count {got[1]}, {len(got) - 2} data bytes"
                    raise Fail(why, f"byte count {2 * count}", t.words(got))
                same_values(list(struct.unpack(f">{count}H", got[2:])), values[:count], "what FC 23 read")


def _ends(p: Purposes[ModbusTester], basic: str) -> None:
    @p.case(
        "BV_06",
        "a range that ends at the last address is served, in each table",
        "ein Bereich, der an der letzten Adresse endet, wird in jeder Tabelle bedient",
        clause="V1.1b3, 6.1 to 6.4",
        preamble=(basic,),
    )
    def reads(t: ModbusTester) -> None:
        for function, base in t.setup.base.items():
            end = end_of(t, function, base)
            if end > base and reads_well(t, function, end - 1, 1):
                got = t.ask(struct.pack(">BHH", function, end - 1, 2))
                if not got or got[0] & 0x80:
                    why = f"FC {function}: {end - 1} and {end} are read one by one, not together"
                    raise Fail(why, "both: the range ends at the last address", t.words(got))

    @p.case(
        "BV_07",
        "a write that ends at the last address that may be written is done",
        "ein Schreiben, das an der letzten beschreibbaren Adresse endet, wird ausgeführt",
        clause="V1.1b3, 6.11, 6.12",
        preamble=(basic,),
    )
    def writes(t: ModbusTester) -> None:
        found = False
        for function, single, table, touched in ((15, 5, 1, t.setup.coils), (16, 6, 3, t.setup.holding)):
            at = max(touched, default=0) - 1
            allowed = t.setup.pics.get(NEEDED[table]) and t.setup.pics.get(f"fc{function}") and t.setup.pics.get(f"fc{single}")
            if not allowed or at not in touched:
                continue
            found = True
            with kept(t, table, at, 2):
                first, last = t.read(table, at, 2)
                values = struct.pack(">HH", first, last) if table == 3 else bytes((first | last << 1,))
                pdu = struct.pack(">BHHB", function, at, 2, len(values)) + values
                got = t.ask(pdu)
                if got != pdu[:5]:
                    why = f"FC {function}: {at} and {at + 1}, which may be written, are not written together"
                    raise Fail(why, t.words(pdu[:5]), t.words(got))
        if not found:
            raise NotApplicable("no two addresses in a row may be written, or by one function only")


def _across(p: Purposes[ModbusTester], basic: str) -> None:
    @p.case(
        "BV_08",
        f"a range across address {EDGE} holds what single reads and writes hold",
        f"ein Bereich über die Adresse {EDGE} hinweg enthält dasselbe wie einzelne Zugriffe",
        clause="V1.1b3, 4.4",
        preamble=(basic, basic.replace("FUN_BV_01", "CON_BV_19")),
    )
    def body(t: ModbusTester) -> None:
        found = False
        for function in t.setup.base:
            if t.setup.pics.get(NEEDED.get(function, "")) and {EDGE - 1, EDGE} <= set(t.setup.holding if function == 3 else t.setup.coils):
                found = True
                with kept(t, function, EDGE - 1, 2):
                    _written_across(t, function)
                    _read_across(t, function)
            elif reads_well(t, function, EDGE - 1, 2):
                found = True
                _read_across(t, function)
        if not found:
            raise NotApplicable(f"nothing can be read at {EDGE - 1} and {EDGE}")


def _read_across(t: ModbusTester, function: int) -> None:
    single = [t.read(function, at, 1)[0] for at in (EDGE - 1, EDGE)]
    same_values(t.read(function, EDGE - 1, 2), single, f"FC {function}: {EDGE - 1} and {EDGE} together")


def _written_across(t: ModbusTester, table: int) -> None:
    function = 16 if table == 3 else 15
    if not t.setup.pics.get(f"fc{function}"):
        return
    wanted = [value ^ (1 if table == 1 else flip) for value, flip in zip(t.read(table, EDGE - 1, 2), (0x5AA5, 0x1EE1), strict=True)]
    values = struct.pack(">HH", *wanted) if table == 3 else bytes((wanted[0] | wanted[1] << 1,))
    t.echo(struct.pack(">BHHB", function, EDGE - 1, 2, len(values)) + values, 5, f"FC {function}, 2 from {EDGE - 1}")
    same_values([t.read(table, at, 1)[0] for at in (EDGE - 1, EDGE)], wanted, f"FC {function} of two from {EDGE - 1}")


def _diagnostics(p: Purposes[ModbusTester], basic: str) -> None:
    @p.case(
        "CA_08",
        "FC 8: data of four bytes are returned unchanged, and a sub-function that is none is refused",
        "FC 8: vier Datenbytes kommen ganz zurück, und eine Unterfunktion, die keine ist, wird abgelehnt",
        clause="V1.1b3, 6.8",
        condition=("fc8",),
        preamble=(basic, basic.replace("BV_01", "CA_08")),
    )
    def body(t: ModbusTester) -> None:
        asked = b"\x08\0\0\x12\x34\x56\x78"
        got = t.ask(asked)
        if got and not got[0] & 0x80 and got != asked:
            raise Fail("FC 8/0 with four bytes: they are not returned", t.words(asked), t.words(got))
        lived = t.exception(b"\x08\x7f\xff\0\0", 1, "FC 8/32767, which does not exist", (2, 3))
        if lived is not None:
            raise Warn(f"FC 8/32767, which does not exist, is refused with {lived:02X}h", "01h", f"{lived:02X}h")


def _collect(prefix: str) -> Purposes[ModbusTester]:
    basic = f"{prefix}_FUN_BV_01"
    p = Purposes[ModbusTester](f"{prefix}_ANS", "server", "V1.1b3, 4", preamble=(basic,))
    _frames(p, basic)
    _places(p, prefix)
    _ends(p, basic)
    _across(p, basic)
    _diagnostics(p, basic)
    return p


TCP_ANS = _collect("MBTCP")
RTU_ANS = _collect("MBRTU")


# ---- RTU only
@RTU_ANS.case(
    "BI_01",
    "a write to another unit: silence, and nothing is written",
    "ein Schreiben an ein anderes Gerät: Stille, und nichts wird geschrieben",
    clause="serial line guide V1.02, 2.2",
    condition=("write_holding", "fc6"),
    preamble=("MBRTU_FUN_BV_01", "MBRTU_RTU_BI_04"),
)
def other_unit(t: ModbusTester) -> None:
    at = t.setup.holding[0]
    with kept(t, 3, at, 1):
        before = t.registers(3, at, 1)
        for unit in sorted({t.setup.missing, (t.setup.unit + 1) % 247 or 1} - {t.setup.unit}):
            _unanswered(t, t.frame(struct.pack(">BHH", 6, at, before[0] ^ 0x5AA5), unit=unit), f"a write to unit {unit}")
            same_values(t.registers(3, at, 1), before, f"{at} after a write to unit {unit}")


def _unanswered(t: ModbusTester, frame: bytes, what: str) -> None:
    t.quiet()
    t.send(frame)
    if found := t.answer_frame():
        raise Fail(f"{what} was answered", "silence", t.words(found))


@RTU_ANS.case(
    "RC_01",
    "the first request after a frame that is too short or spoilt is answered",
    "die erste Anfrage nach einem zu kurzen oder gestörten Telegramm wird beantwortet",
    clause="serial line guide V1.02, 2.5.1.1",
    preamble=("MBRTU_FUN_BV_01", "MBRTU_RTU_BI_07"),
)
def next_request(t: ModbusTester) -> None:
    function, at = next(iter(t.setup.base.items()))
    good = struct.pack(">BHH", function, at, 1)
    whole = t.frame(good)
    for bad in (b"\x01", whole[:2], sealed(whole[:1]), whole[:-1], whole[:-1] + bytes((whole[-1] ^ 0x10,))):
        _unanswered(t, bad, f"the frame {bad.hex(' ').upper()}")
        try:
            got = t.ask(good)
        except Ended as ended:
            raise Fail(f"after the frame {bad.hex(' ').upper()}: {ended.reason.removeprefix(PREPARING)}", "an answer", ended.got) from ended
        if not got:
            raise Fail(f"after the frame {bad.hex(' ').upper()} the next request is lost", "an answer", t.words(got))
