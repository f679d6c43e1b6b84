"""Modbus, function by function: valid, first, last, one beyond, illegal, short, long; refusals without effect (V1.1b3, section 6)."""

import struct
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from gateway.conformance.framework.causes import PREPARING
from gateway.conformance.suites.modbus.content import kept, write_back
from gateway.conformance.suites.modbus.other_functions import other_functions
from gateway.conformance.suites.modbus.tester import CROSS, TABLES, ModbusTester, without_top_bit
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Ended, Fail, Inconclusive, NotApplicable, Warn
from protocols.base.machine import ms

Body = Callable[[ModbusTester], None]
Case = Callable[[str, int, str, str], Callable[[Body], Body]]  # name, function, test purpose in both languages
GERMAN = {1: "Spulen", 2: "diskrete Eingänge", 3: "Halteregister", 4: "Eingangsregister"}


def _collect(prefix: str) -> Purposes[ModbusTester]:
    found = Purposes[ModbusTester](f"{prefix}_FUN", "server", "V1.1b3, 6")
    basic = f"{prefix}_FUN_BV_01"
    _basic(found, basic)
    for function in TABLES:
        reading = Reading(found, basic, f"{prefix}_FUN_BV_{10 * function}", function)
        _reads(reading)
        _refused_reads(reading)
        _misread(reading)
    other_functions(found, basic)
    case = _write_case(found, basic)
    _single_writes(case)
    _counted_writes(case)
    _writes_beyond(case)
    _writes_in_one_request(case)
    return found


def _basic(p: Purposes[ModbusTester], basic: str) -> None:
    @p.case(
        "BV_01",
        "a request is answered, with its own header and function",
        "eine Anfrage wird beantwortet, mit eigenem Kopf und Funktion",
        preamble=(),
        clause="V1.1b3, 4.1; TCP guide, 3.1.3",
        beside=CROSS,
    )
    def answered(t: ModbusTester) -> None:
        function = next(iter(t.setup.base), 3)
        request = struct.pack(">BHH", function, t.setup.base.get(function, 0), 1)
        got = t.steady(request, judge=True)
        if not got:
            raise Fail(f"FC {function}: {t.words(got)}", "an answer", t.words(got))
        if t.missed and not t.ask(request):  # again: it is not only now and then
            raise Fail(t.missed, f"an answer within {t.setup.wait // ms(1)} ms", "silence")

    @p.case(
        "BI_04",
        "an exception has the header of its request, and the function with the top bit set",
        "eine Exception trägt den Kopf ihrer Anfrage und die Funktion mit gesetztem höchsten Bit",
        preamble=(basic,),
        clause="V1.1b3, 7; TCP guide, 3.1.3",
        beside=CROSS,
    )
    def refused(t: ModbusTester) -> None:
        function = next(iter(t.setup.base), 3)
        t.setup.odd_exceptions = t.case
        amount = struct.pack(">BHH", function, t.setup.base.get(function, 0), 0)
        asked = (amount, b"\x41")  # 41h: a function that is not offered
        said = [t.ask(pdu, judge=True) for pdu in asked]
        for got in said:
            if without_top_bit(got):
                raise Fail(f"a refusal without the top bit: {t.words(got)}", f"{got[0] | 0x80:02X} {got[1]:02X}", t.words(got))
        if not any(said):
            raise Fail("neither a quantity of 0 nor function 41h is refused: no answer", "an exception of two bytes", t.words(b""))
        if len(codes := {got[1] for got in said if len(got) == 2}) == 1 and not codes & {1, 3} and all(said):
            what = f"a quantity of 0 and function 41h are both refused with exception {codes.pop():02X}h"
            raise Fail(what, "exception 03h and exception 01h", " and ".join(map(t.words, said)))
        t.setup.odd_exceptions = ""
        t.setup.refused = tuple(pdu for pdu, got in zip(asked, said, strict=True) if got)

    @p.case(
        "BI_03",
        "the answer to a request that is too short is a whole frame, or none",
        "die Antwort auf eine zu kurze Anfrage ist ein ganzes Telegramm, oder keine",
        preamble=(basic,),
        clause="V1.1b3, 7; TCP guide, 3.1.3",
    )
    def short(t: ModbusTester) -> None:
        function = next(iter(t.setup.base), 3)
        t.ask(struct.pack(">BHH", function, t.setup.base.get(function, 0), 1)[:-1], judge=True)


@dataclass(frozen=True, slots=True)
class Reading:
    """The cases of one function that reads: basic, one: those that all and all but the first of them start from."""

    purposes: Purposes[ModbusTester]
    basic: str
    one: str
    function: int

    @property
    def number(self) -> int:
        """Number of its first case."""
        return 10 * self.function

    @property
    def most(self) -> int:
        """That one request may read."""
        return 2000 if self.function < 3 else 125

    def case(self, name: str, summary: str, summary_de: str, first: bool = False, more: tuple[str, ...] = ()) -> Callable[[Body], Body]:
        return self.purposes.case(
            name,
            f"FC {self.function}: {summary}",
            f"FC {self.function}: {summary_de}",
            clause=f"V1.1b3, 6.{self.function}",
            condition=(TABLES[self.function],),
            preamble=(self.basic,) if first else (self.basic, self.one, *more),
            beside=CROSS,
        )


def _reads(reading: Reading) -> None:
    function, number = reading.function, reading.number

    @reading.case(
        f"BV_{number}",
        f"one of the {TABLES[function].replace('_', ' ')}, and as many as can be read",
        f"eines und so viele {GERMAN[function]}, wie lesbar sind",
        first=True,
    )
    def valid(t: ModbusTester) -> None:
        base, span = t.setup.base[function], t.setup.span[function]
        for count in sorted({1, min(span, 3), min(span, 9), min(span, 16), span}):
            t.read(function, base, count)

    @reading.case(f"BV_{number + 1}", "the last that can be read, alone", "das letzte lesbare, allein")
    def last(t: ModbusTester) -> None:
        base, span = t.setup.base[function], t.setup.span[function]
        if t.read(function, base + span - 1, 1) != t.read(function, base, span)[-1:] and not _moves(t, function):
            raise Fail(f"FC {function}: {base + span - 1} alone differs from the last of {span}", "the same value", "another one")

    @reading.case(
        f"BV_{number + 2}",
        f"one request reads up to {reading.most}, or as many as the PICS states",
        f"eine Anfrage liest bis zu {reading.most}, oder so viele, wie die PICS angibt",
    )
    def most(t: ModbusTester) -> None:
        base, span = t.setup.base[function], t.setup.span[function]
        if span >= reading.most:
            return
        if base + span > 0xFFFF or not (reads_well(t, function, base + span, 1) and reads_well(t, function, base + span - 1, 2)):
            raise NotApplicable(f"what can be read ends at {base + span - 1}")
        stated = t.setup.most(function, reading.most)
        if span < stated:
            got = t.ask(struct.pack(">BHH", function, base, span + 1))
            key = "most_bits" if function < 3 else "most_registers"
            wanted = f"up to {stated}; a smaller limit is stated in the PICS: {key} = {span}"
            t.silent_by_now(got, f"FC {function}, {span + 1} from {base}", wanted)
            raise Fail(f"FC {function}: {span} are read, {span + 1} are not, though all of them can be read", wanted, t.words(got))


def reads_well(t: ModbusTester, function: int, at: int, count: int) -> bool:
    got = t.steady(struct.pack(">BHH", function, at, count))
    return bool(got) and not got[0] & 0x80


def _refused_reads(reading: Reading) -> None:
    function, number, most = reading.function, reading.number, reading.most

    def refusal(at: int, what: str, de: str, pdu: bytes, code: int, others: tuple[int, ...] = ()) -> None:
        prefix = reading.basic.removesuffix("BV_01")
        more = (f"{prefix}BI_{number}",) if at in (1, 2) else ()  # a wrong number for an amount is one fault

        @reading.case(f"BI_{number + at}", f"{what} is refused with {code:02X}h", f"{de} wird mit {code:02X}h abgelehnt", more=more)
        def body(t: ModbusTester) -> None:
            request = pdu[:1] + (t.setup.base[function].to_bytes(2, "big") if pdu[1:3] == b"\xee\xee" else pdu[1:3]) + pdu[3:]
            lived = t.exception(request, code, f"FC {function}: {what}", others)
            if lived is not None:
                raise Warn(f"FC {function}: {what} is refused with {lived:02X}h", f"{code:02X}h", f"{lived:02X}h")

    here = b"\xee\xee"
    refusal(0, "a quantity of 0", "eine Anzahl 0", bytes((function,)) + here + b"\0\0", 3)
    refusal(1, f"a quantity of {most + 1}", f"eine Anzahl {most + 1}", bytes((function,)) + here + (most + 1).to_bytes(2, "big"), 3)
    refusal(2, "a quantity of 65535", "eine Anzahl 65535", bytes((function,)) + here + b"\xff\xff", 3)
    refusal(3, "a range beyond address 65535", "ein Bereich über Adresse 65535", struct.pack(">BHH", function, 0xFFFF, 2), 2, (3,))


def end_of(t: ModbusTester, function: int, low: int) -> int:
    """The last address that can be read, where the table has no gap."""
    high = 0x10000
    while high - low > 1:
        middle = (low + high) // 2
        got = t.ask(struct.pack(">BHH", function, middle, 1))
        low, high = (middle, high) if got and not got[0] & 0x80 else (low, middle)
    return low


def _misread(reading: Reading) -> None:
    function, number = reading.function, reading.number

    @reading.case(
        f"BI_{number + 4}",
        "a range that is partly missing is refused with 02h",
        "ein teilweise fehlender Bereich wird mit 02h abgelehnt",
        more=(f"{reading.basic.removesuffix('BV_01')}BI_{number + 3}",),
    )
    def partly(t: ModbusTester) -> None:
        base, span = t.setup.base[function], t.setup.span[function]
        if span >= reading.most or (base + span <= 0xFFFF and reads_well(t, function, base + span, 1)):
            end = end_of(t, function, base + span - 1)
            start, count = end, 2
        else:
            end, start, count = base + span - 1, base, span + 1
        if end >= 0xFFFF:
            raise NotApplicable("the table has no end")
        lived = t.exception(struct.pack(">BHH", function, start, count), 2, f"FC {function}: one more than there are", (3,))
        if lived is not None:
            raise Warn(f"FC {function}: one more than there are is refused with {lived:02X}h", "02h", f"{lived:02X}h")

    @reading.case(
        f"BI_{number + 5}",
        "a request that is too short is not taken for another",
        "eine zu kurze Anfrage wird nicht falsch verstanden",
        more=(reading.basic.replace("BV_01", "BI_03"),),
    )
    def short(t: ModbusTester) -> None:
        got = t.ask(struct.pack(">BHH", function, t.setup.base[function], 1)[:-1])
        if got and got[0] & 0x80 and got[1] == 3:
            return
        if got and not got[0] & 0x80:
            raise Fail(f"FC {function} with a byte too few was executed", "exception 03h, silence or close", t.words(got))
        if not t.rtu:
            raise Warn(f"FC {function}: a byte too few: {t.words(got)}", "exception 03h", t.words(got))


def _moves(t: ModbusTester, function: int) -> bool:
    """Values of a process change on their own."""
    base, span = t.setup.base[function], t.setup.span[function]
    return t.read(function, base, span) != t.read(function, base, span)


def _write_case(p: Purposes[ModbusTester], basic: str) -> Case:
    def case(name: str, function: int, summary: str, de: str) -> Callable[[Body], Body]:
        short = (basic.replace("BV_01", "BI_03"),) if name in ("BI_60", "BI_80") else ()
        needs = "write_coils" if function in (5, 15) else "write_holding"
        section = {5: 5, 6: 6, 15: 11, 16: 12, 22: 16, 23: 17}[function]
        return p.case(
            name,
            f"FC {function}: {summary}",
            f"FC {function}: {de}",
            clause=f"V1.1b3, 6.{section}",
            condition=(needs, f"fc{function}"),
            preamble=(basic, *short),
            beside=CROSS,
        )

    return case


def _single_writes(case: Case) -> None:
    @case(
        "BI_50",
        5,
        "a value that is neither 0000h nor FF00h is refused with 03h, without effect",
        "ein Wert außer 0000h und FF00h wird mit 03h abgelehnt, wirkungslos",
    )
    def coil_value(t: ModbusTester) -> None:
        at = t.setup.coils[0]
        with kept(t, 1, at, 1):
            for state in (0, 1):
                with t.given():
                    t.echo(struct.pack(">BHH", 5, at, 0xFF00 * state), 5, "FC 5")
                for value in (0x0001, 0xFFFF, 0xFF01, 0x00FF):
                    _without_effect(t, struct.pack(">BHH", 5, at, value), 3, f"FC 5 with {value:04X}h", 1, at, 1)

    @case("BI_60", 6, "a request that is too short is refused, without effect", "eine zu kurze Anfrage wird abgelehnt, wirkungslos")
    def register_short(t: ModbusTester) -> None:
        unchanged(t, struct.pack(">BHH", 6, t.setup.holding[0], 0x5A5A)[:-1], "FC 6 with a byte too few", 3, t.setup.holding[0], 1)


def _counted_writes(case: Case) -> None:
    @case(
        "BI_70",
        15,
        "amount 0, and byte counts that do not fit, are refused with 03h, without effect",
        "Anzahl 0 und unpassende Bytezahlen werden mit 03h abgelehnt, wirkungslos",
    )
    def coils(t: ModbusTester) -> None:
        at = t.setup.coils[0]
        with kept(t, 1, at, 1):
            with t.given():
                write_back(t, 1, at, [0])
            for what, pdu in (
                ("0 coils", struct.pack(">BHHB", 15, at, 0, 0)),
                ("9 coils in one byte", struct.pack(">BHHBB", 15, at, 9, 1, 0xFF)),
                ("1 coil in two bytes", struct.pack(">BHHBH", 15, at, 1, 2, 0xFFFF)),
                ("1969 coils", struct.pack(">BHHB", 15, at, 1969, 247) + b"\xff" * 247),
            ):
                _without_effect(t, pdu, 3, f"FC 15: {what}", 1, at, 1)

    @case(
        "BI_71",
        16,
        "amount 0, and byte counts that do not fit, are refused with 03h, without effect",
        "Anzahl 0 und unpassende Bytezahlen werden mit 03h abgelehnt, wirkungslos",
    )
    def registers(t: ModbusTester) -> None:
        at = t.setup.holding[0]
        for what, pdu in (
            ("0 registers", struct.pack(">BHHB", 16, at, 0, 0)),
            ("2 registers in two bytes", struct.pack(">BHHBH", 16, at, 2, 2, 0x5A5A)),
            ("1 register in four bytes", struct.pack(">BHHBHH", 16, at, 1, 4, 0x5A5A, 0x5A5A)),
            ("byte count 3", struct.pack(">BHHBHB", 16, at, 1, 3, 0x5A5A, 0x5A)),
        ):
            _without_effect(t, pdu, 3, f"FC 16: {what}", 3, at, 1)


def _writes_beyond(case: Case) -> None:
    @case(
        "BI_72",
        16,
        "124 registers are refused or the connection is closed, without effect",
        "124 Register werden abgelehnt oder die Verbindung wird geschlossen, wirkungslos",
    )
    def too_many(t: ModbusTester) -> None:
        unchanged(
            t, struct.pack(">BHHB", 16, t.setup.holding[0], 124, 248) + b"\x5a" * 248, "FC 16: 124 registers", 3, t.setup.holding[0], 1
        )

    @case("BI_73", 16, "a range beyond address 65535 is refused with 02h", "ein Bereich über Adresse 65535 wird mit 02h abgelehnt")
    def beyond(t: ModbusTester) -> None:
        lived = t.exception(struct.pack(">BHHBHH", 16, 0xFFFF, 2, 4, 1, 2), 2, "FC 16 beyond 65535", (3,))
        if lived is not None:
            raise Warn("FC 16 beyond 65535 is refused with 03h", "02h", "03h")


def _writes_in_one_request(case: Case) -> None:
    @case("BI_80", 22, "a request that is too short is refused, without effect", "eine zu kurze Anfrage wird abgelehnt, wirkungslos")
    def mask_short(t: ModbusTester) -> None:
        unchanged(t, struct.pack(">BHHH", 22, t.setup.holding[0], 0, 0x5A5A)[:-1], "FC 22 with a byte too few", 3, t.setup.holding[0], 1)

    @case(
        "BI_81",
        23,
        "a byte count that does not fit is refused with 03h, without effect",
        "eine unpassende Bytezahl wird mit 03h abgelehnt, wirkungslos",
    )
    def both(t: ModbusTester) -> None:
        at = t.setup.holding[0]
        _without_effect(t, struct.pack(">BHHHHBHH", 23, at, 1, at, 1, 4, 0x5A5A, 0x5A5A), 3, "FC 23: 1 register in four bytes", 3, at, 1)


def _without_effect(t: ModbusTester, pdu: bytes, code: int, what: str, table: int, at: int, count: int) -> None:
    with t.given():
        before = t.read(table, at, count)
    lived = t.exception(pdu, code, what, (1,))
    _same(t, what, table, at, before)
    if lived is not None:
        raise Warn(f"{what} is refused with {lived:02X}h", f"{code:02X}h", f"{lived:02X}h")


def unchanged(t: ModbusTester, pdu: bytes, what: str, table: int, at: int, count: int) -> None:
    """Any refusal, silence or close."""
    with t.given():
        before = t.read(table, at, count)
    got = t.ask(pdu)
    if without_top_bit(got):
        raise Fail(f"{what} is refused without the top bit", f"{got[0] | 0x80:02X} {got[1]:02X}", t.words(got))
    if got and not got[0] & 0x80:
        _restored(t, table, at, before)
        raise Fail(f"{what} was executed", "a refusal, silence or close", t.words(got))
    _same(t, what, table, at, before)


def _restored(t: ModbusTester, table: int, at: int, before: list[int]) -> None:
    """On a new connection: the server may have lost the beat of the old one."""
    t.reconnect()
    with suppress(Ended):
        write_back(t, table, at, before)


def _read_again(t: ModbusTester, what: str, table: int, at: int, count: int) -> list[int]:
    """Values that could be read before can be read now, if necessary on a new connection."""
    for last in (False, True):
        try:
            with t.given():
                return t.read(table, at, count)
        except Inconclusive as ended:
            if last:
                raise Fail(f"after {what}: {ended.reason.removeprefix(PREPARING)}", "an answer as before", ended.got) from ended
        t.reconnect()
    raise AssertionError("both tries end")


def _same(t: ModbusTester, what: str, table: int, at: int, before: list[int]) -> None:
    after = _read_again(t, what, table, at, len(before))
    if after != before:
        _restored(t, table, at, before)
        raise Fail(f"{what} was refused and had an effect", f"{before}", f"{after}")


FUN = _collect("MBTCP")
RTU_FUN = _collect("MBRTU")
