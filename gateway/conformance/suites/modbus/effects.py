"""Modbus: refused writes must change nothing, the largest writes, and what another client sees (V1.1b3, 6.5 to 6.17)."""

import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

from gateway.conformance.suites.modbus.content import kept, pattern, same_values
from gateway.conformance.suites.modbus.tester import ModbusTester, amount
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable, Warn

VALUE = 0x5A3C
MOST_REGISTERS, MOST_COILS = 123, 1968


@dataclass(frozen=True, slots=True)
class Write:
    """One function that writes: its request to a place, the table, the clause."""

    function: int
    table: int
    clause: str
    request: Callable[[int], bytes]


WRITES = (
    Write(5, 1, "6.5", lambda at: struct.pack(">BHH", 5, at, 0xFF00)),
    Write(6, 3, "6.6", lambda at: struct.pack(">BHH", 6, at, VALUE)),
    Write(15, 1, "6.11", lambda at: struct.pack(">BHHBB", 15, at, 1, 1, 1)),
    Write(16, 3, "6.12", lambda at: struct.pack(">BHHBH", 16, at, 1, 2, VALUE)),
    Write(22, 3, "6.16", lambda at: struct.pack(">BHHH", 22, at, 0, VALUE)),
)


def _needs(function: int) -> tuple[str, str]:
    return "write_coils" if function in (5, 15) else "write_holding", f"fc{function}"


def _touched(t: ModbusTester, table: int) -> tuple[int, ...]:
    return t.setup.coils if table == 1 else t.setup.holding


def _missing(t: ModbusTester, table: int, places: tuple[int, ...]) -> list[int]:
    """Addresses a read of which is refused with 02h."""
    found = []
    for at in places:
        got = t.ask(struct.pack(">BHH", table, at, 1))
        if got[1:] == b"\x02" and got[0] & 0x80:
            found.append(at)
    return found


def _longest(numbers: tuple[int, ...], most: int) -> tuple[int, int]:
    """First address and length of the longest run without a hole."""
    best, start = (numbers[0], 1), 0
    for at in range(1, len(numbers) + 1):
        if at == len(numbers) or numbers[at] != numbers[at - 1] + 1:
            if at - start > best[1]:
                best = numbers[start], at - start
            start = at
    return best[0], min(best[1], most)


def _refused(t: ModbusTester, pdu: bytes, code: int, what: str, others: tuple[int, ...] = ()) -> None:
    lived = t.exception(pdu, code, what, others)
    if lived is not None:
        raise Warn(f"{what} is refused with {lived:02X}h", f"{code:02X}h", f"{lived:02X}h")


@contextmanager
def _unwritten(t: ModbusTester, table: int, at: int) -> Iterator[tuple[int, Callable[[str], None]]]:
    """One value that the requests in the block must not change: the value, and its comparison afterwards."""
    with kept(t, table, at, 1):
        before = t.read(table, at, 1)
        yield before[0], lambda what: same_values(t.read(table, at, 1), before, f"{at} after {what}")


def _collect(prefix: str) -> Purposes[ModbusTester]:
    basic = f"{prefix}_FUN_BV_01"
    p = Purposes[ModbusTester](f"{prefix}_EFF", "server", "V1.1b3, 6", preamble=(basic,))
    for number, write in enumerate(WRITES, 1):
        _nowhere(p, number, write)
    _across_the_end(p)
    _read_and_write(p)
    _largest(p, (basic, f"{prefix}_CON_BV_16"))
    _another_client(p, (basic, f"{prefix}_CON_BV_06"))
    return p


def _nowhere(p: Purposes[ModbusTester], number: int, write: Write) -> None:
    @p.case(
        f"BI_{number:02}",
        f"FC {write.function}: an address that is not there is refused with 02h, and nothing else is written",
        f"FC {write.function}: eine fehlende Adresse wird mit 02h abgelehnt, und nichts anderes wird geschrieben",
        clause=f"V1.1b3, {write.clause}",
        condition=_needs(write.function),
    )
    def body(t: ModbusTester) -> None:
        here = _touched(t, write.table)[0]
        places = _missing(t, write.table, tuple(place for place in (0xFFFF, here + 0x100, here + 0x8000) if place <= 0xFFFF))
        if not places:
            raise NotApplicable("every address that was tried can be read")
        with _unwritten(t, write.table, here) as (_, compare):
            for place in places:
                what = f"FC {write.function} to the unreadable address {place}"
                _refused(t, write.request(place), 2, what, (3,))
                compare(what)


def _across_the_end(p: Purposes[ModbusTester]) -> None:
    for number, function, table, clause in ((10, 15, 1, "6.11"), (11, 16, 3, "6.12")):

        @p.case(
            f"BI_{number}",
            f"FC {function}: a range that goes beyond the end is refused whole, nothing of it is written",
            f"FC {function}: ein Bereich über das Ende hinaus wird ganz abgelehnt, nichts davon wird geschrieben",
            clause=f"V1.1b3, {clause}",
            condition=_needs(function),
        )
        def body(t: ModbusTester, function: int = function, table: int = table) -> None:
            last = max(_touched(t, table))
            if last == 0xFFFF or not _missing(t, table, (last + 1,)) or _missing(t, table, (last,)):
                raise NotApplicable("[touch] does not reach the last address of the table")
            value = b"\xff" if function == 15 else struct.pack(">HH", VALUE, VALUE)
            with _unwritten(t, table, last) as (_, compare):
                what = f"FC {function} of two from the last address, {last}"
                _refused(t, struct.pack(">BHHB", function, last, 2, len(value)) + value, 2, what, (3,))
                compare(what)


def _both(read: int, count: int, at: int, values: list[int], amount: int | None = None) -> bytes:
    written = len(values) if amount is None else amount
    return struct.pack(f">BHHHHB{len(values)}H", 23, read, count, at, written, 2 * len(values), *values)


def _read_and_write(p: Purposes[ModbusTester]) -> None:
    case = partial(p.case, clause="V1.1b3, 6.17", condition=_needs(23))

    @case(
        "BI_20",
        "FC 23: where the part to be read is missing nothing is written",
        "FC 23: fehlt der zu lesende Teil, wird nichts geschrieben",
    )
    def unreadable(t: ModbusTester) -> None:
        at = t.setup.holding[0]
        places = _missing(t, 3, (0xFFFF,))
        if not places:
            raise NotApplicable("address 65535 can be read")
        with _unwritten(t, 3, at) as (before, compare):
            _refused(t, _both(0xFFFF, 1, at, [before ^ VALUE]), 2, "FC 23 that reads a missing register", (3,))
            compare("FC 23 was refused")

    @case(
        "BI_21",
        "FC 23: a missing register is not written: 02h",
        "FC 23: ein fehlendes Register wird nicht geschrieben: 02h",
    )
    def unwritable(t: ModbusTester) -> None:
        if not _missing(t, 3, (0xFFFF,)):
            raise NotApplicable("address 65535 can be read")
        _refused(t, _both(t.setup.holding[0], 1, 0xFFFF, [VALUE]), 2, "FC 23 that writes a missing register", (3,))

    @case(
        "BI_22",
        "FC 23: 0 and 126 registers to read, and 0 to write, are refused with 03h",
        "FC 23: 0 und 126 zu lesende und 0 zu schreibende Register werden mit 03h abgelehnt",
    )
    def amounts(t: ModbusTester) -> None:
        at = t.setup.holding[0]
        with _unwritten(t, 3, at) as (before, compare):
            for what, pdu in (
                ("0 registers to read", _both(at, 0, at, [before ^ VALUE])),
                ("126 registers to read", _both(at, 126, at, [before ^ VALUE])),
                ("0 registers to write", _both(at, 1, at, [])),
            ):
                _refused(t, pdu, 3, f"FC 23: {what}")
                compare(f"FC 23 with {what}")


def _largest(p: Purposes[ModbusTester], first: tuple[str, ...]) -> None:
    @p.case(
        "BV_01",
        f"FC 16 writes as many registers as may be written, {MOST_REGISTERS} at most",
        f"FC 16 schreibt so viele Register wie erlaubt, höchstens {MOST_REGISTERS}",
        clause="V1.1b3, 6.12",
        condition=_needs(16),
        preamble=first,
    )
    def registers(t: ModbusTester) -> None:
        at, count = _longest(t.setup.holding, t.setup.most(16, MOST_REGISTERS))
        with kept(t, 3, at, count):
            wanted = pattern(count)
            t.echo(struct.pack(f">BHHB{count}H", 16, at, count, 2 * count, *wanted), 5, f"FC 16, {amount(count, 'register')} from {at}")
            same_values(t.read(3, at, count), wanted, f"{amount(count, 'register')} from {at}")

    @p.case(
        "BV_02",
        f"FC 15 writes as many coils as may be written, {MOST_COILS} at most",
        f"FC 15 schreibt so viele Spulen wie erlaubt, höchstens {MOST_COILS}",
        clause="V1.1b3, 6.11",
        condition=_needs(15),
    )
    def coils(t: ModbusTester) -> None:
        at, count = _longest(t.setup.coils, t.setup.most(15, MOST_COILS))
        with kept(t, 1, at, count):
            wanted = [int(number % 3 == 0 or number % 7 == 1) for number in range(count)]
            packed = bytes(sum(bit << place for place, bit in enumerate(wanted[start : start + 8])) for start in range(0, count, 8))
            t.echo(struct.pack(">BHHB", 15, at, count, len(packed)) + packed, 5, f"FC 15, {amount(count, 'coil')} from {at}")
            same_values(t.read(1, at, count), wanted, f"{amount(count, 'coil')} from {at}")


def _another_client(p: Purposes[ModbusTester], first: tuple[str, ...]) -> None:
    @p.case(
        "CA_01",
        "what one client writes the next connection reads",
        "was ein Client schreibt, liest die nächste Verbindung",
        condition=("tcp", "write_holding", "fc6"),
        preamble=first,
    )
    def next_one(t: ModbusTester) -> None:
        at = t.setup.holding[0]
        with kept(t, 3, at, 1):
            value = t.read(3, at, 1)[0] ^ VALUE
            t.echo(struct.pack(">BHH", 6, at, value), 5, "FC 6")
            t.reconnect()
            got = t.read(3, at, 1)
            if got != [value]:
                raise Fail(f"{at} after a new connection: {got[0]:04X}h", f"{value:04X}h", f"{got[0]:04X}h")


TCP_EFF = _collect("MBTCP")
RTU_EFF = _collect("MBRTU")
