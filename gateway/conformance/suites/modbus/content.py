"""Modbus, contents: tables apart, order of bits and words, padding, echo and effect of every write (V1.1b3, 4.3, 4.4, 6)."""

import random
import struct
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from gateway.conformance.suites.modbus.tester import ModbusTester, amount
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Ended, Fail, NotApplicable, Warn

NAMES = {"coil": 1, "discrete": 2, "holding": 3, "input": 4}
NAME_OF = {function: name for name, function in NAMES.items()}


def _run(numbers: tuple[int, ...], most: int) -> tuple[int, int]:
    """First address and length of the first run without a hole."""
    size = 1
    while size < min(len(numbers), most) and numbers[size] == numbers[0] + size:
        size += 1
    return numbers[0], size


@contextmanager
def kept(t: ModbusTester, function: int, at: int, count: int) -> Iterator[None]:
    """The former values are written back."""
    with t.given():
        try:
            before = t.read(function, at, count)
        except Fail as failed:
            there = f"{NAME_OF[function]} {at}" + (f" to {at + count - 1}" if count > 1 else "")
            hint = f"{failed.reason}; [touch] names {there}: state only addresses that the device has"
            raise Fail(hint, failed.expected, failed.got) from failed
    try:
        yield
    finally:
        with suppress(Ended):
            write_back(t, function, at, before)


def write_back(t: ModbusTester, function: int, at: int, values: list[int]) -> None:
    for offset, value in enumerate(values):
        if function == 3:
            if t.setup.pics.get("fc6"):
                t.ask(struct.pack(">BHH", 6, at + offset, value))
            else:
                t.ask(struct.pack(">BHHBH", 16, at + offset, 1, 2, value))
        elif t.setup.pics.get("fc5"):
            t.ask(struct.pack(">BHH", 5, at + offset, 0xFF00 * value))
        else:
            t.ask(struct.pack(">BHHBB", 15, at + offset, 1, 1, value))


def same_values(got: list[int], wanted: list[int], what: str) -> None:
    if got == wanted:
        return
    why = ""
    if got == wanted[::-1]:
        why = ": in reverse order"
    elif got == [(value & 0xFF) << 8 | value >> 8 for value in wanted]:
        why = ": the bytes of each register are exchanged"
    shown = (
        [f"{value:04X}" if max(wanted + got) > 1 else str(value) for value in wanted],
        [f"{value:04X}" if max(wanted + got) > 1 else str(value) for value in got],
    )
    raise Fail(f"{what} reads differently{why}", " ".join(shown[0]), " ".join(shown[1]))


def pattern(count: int) -> list[int]:
    """Registers no two of which are equal, nor equal with their bytes exchanged."""
    return [(0x0103 + 0x1111 * at + at) & 0xFFFF for at in range(count)]


def _collect(prefix: str) -> Purposes[ModbusTester]:
    basic = f"{prefix}_FUN_BV_01"
    p = Purposes[ModbusTester](f"{prefix}_CON", "server", "V1.1b3, 4.3", preamble=(basic,))
    first = (basic, f"{prefix}_CON_BV_06")
    _register_writes(p)
    _other_registers(p, first)
    _writes_in_one_request(p, first)
    _many_writes(p, first)
    _coils(p, prefix, basic)
    _fill_bits(p, (basic, f"{prefix}_CON_BV_05"))
    _tables(p)
    _kept_apart(p, prefix, basic)
    return p


def _register_writes(p: Purposes[ModbusTester]) -> None:
    @p.case(
        "BV_06",
        "FC 6: echo and effect, high byte first",
        "FC 6: Echo und Wirkung, High-Byte zuerst",
        clause="V1.1b3, 6.6",
        condition=("write_holding", "fc6"),
    )
    def single(t: ModbusTester) -> None:
        at = t.setup.holding[0]
        with kept(t, 3, at, 1):
            for value in (0x0103, 0xA55A, 0x0000, 0xFFFF):
                t.echo(struct.pack(">BHH", 6, at, value), 5, f"FC 6 with {value:04X}h")
                same_values(t.registers(3, at, 1), [value], f"register {at}")

    @p.case(
        "BV_16",
        "FC 16: echo and effect, the first register first",
        "FC 16: Echo und Wirkung, erstes Register zuerst",
        clause="V1.1b3, 6.12",
        condition=("write_holding", "fc16"),
    )
    def several(t: ModbusTester) -> None:
        at, count = _run(t.setup.holding, t.setup.most(16, 123))
        with kept(t, 3, at, count):
            for size in sorted({1, min(2, count), min(3, count), max(count - 1, 1), count}):
                values = pattern(size)
                t.echo(struct.pack(f">BHHB{size}H", 16, at, size, 2 * size, *values), 5, f"FC 16, {amount(size, 'register')}")
                same_values(t.registers(3, at, size), values, f"{amount(size, 'register')} from {at}")

    @p.case(
        "BV_17",
        "one register by several requests: register n is element n of a longer read",
        "ein Register über mehrere Anfragen: Register n ist Element n eines längeren Lesens",
        clause="V1.1b3, 6.3",
        condition=("write_holding", "fc16"),
    )
    def by_address(t: ModbusTester) -> None:
        at, count = _run(t.setup.holding, t.setup.most(16, 8))
        with kept(t, 3, at, count):
            values = pattern(count)
            with t.given():
                t.normal(struct.pack(f">BHHB{count}H", 16, at, count, 2 * count, *values), "FC 16")
            for offset in range(count):
                same_values(t.registers(3, at + offset, 1), values[offset : offset + 1], f"register {at + offset} alone")
            if count > 2:
                same_values(t.registers(3, at + 1, count - 1), values[1:], f"{amount(count - 1, 'register')} from {at + 1}")


def _other_registers(p: Purposes[ModbusTester], first: tuple[str, ...]) -> None:
    @p.case(
        "BV_18",
        "a write changes its registers and no others",
        "ein Schreiben ändert seine Register und keine anderen",
        condition=("write_holding", "fc6"),
        preamble=first,
    )
    def neighbours(t: ModbusTester) -> None:
        at, count = _run(t.setup.holding, t.setup.most(16, 8))
        if count < 3:
            raise NotApplicable("fewer than three registers in a row may be written")
        with kept(t, 3, at, count):
            with t.given():
                write_back(t, 3, at, pattern(count))
            middle = count // 2
            t.echo(struct.pack(">BHH", 6, at + middle, 0x5AC3), 5, "FC 6")
            wanted = pattern(count)
            wanted[middle] = 0x5AC3
            same_values(t.registers(3, at, count), wanted, f"{amount(count, 'register')} after a write to {at + middle}")

    @p.case(
        "BV_19",
        "registers far apart are apart: addresses are not cut",
        "weit entfernte Register sind getrennt: Adressen werden nicht gekürzt",
        condition=("write_holding", "fc6"),
        preamble=first,
    )
    def aliases(t: ModbusTester) -> None:
        first_one = t.setup.holding[0]
        apart = {first_one + (1 << bit) for bit in range(16)} & set(t.setup.holding)  # one bit of the number each
        numbers = sorted({first_one, *t.setup.holding[-1:], *apart})
        if len(numbers) < 2:
            raise NotApplicable("one register may be written")
        with t.given():
            before = [t.registers(3, number, 1)[0] for number in numbers]
        try:
            for at, number in enumerate(numbers):
                t.echo(struct.pack(">BHH", 6, number, 0x4000 + 0x0101 * at), 5, "FC 6")
            for at, number in enumerate(numbers):
                same_values(t.registers(3, number, 1), [0x4000 + 0x0101 * at], f"register {number}")
            _shown_elsewhere(t, first_one)
        finally:
            with suppress(Ended):
                for number, value in zip(numbers, before, strict=True):
                    write_back(t, 3, number, [value])


def _shown_elsewhere(t: ModbusTester, at: int) -> None:
    """Judged: addresses beyond those that may be written, one bit away, do not show this register.  A lone one may be meant so."""
    bits = [bit for bit in range(16) if at ^ 1 << bit not in t.setup.holding]
    for value in (0x2A55, 0x55D2):  # an address that shows both values is this register
        t.echo(struct.pack(">BHH", 6, at, value), 5, "FC 6")
        bits = [bit for bit in bits if t.ask(struct.pack(">BHH", 3, at ^ 1 << bit, 1)) == struct.pack(">BBH", 3, 2, value)]
    if not bits:
        return
    others = ", ".join(str(at ^ 1 << bit) for bit in bits)
    found = f"register {at} is also read at {others}"
    if len(bits) > 2 and bits == list(range(bits[0], 16)):
        raise Fail(f"{found}: bits {bits[0]} to 15 of the address do not count", "02h, or values of their own", f"{value:04X}")
    raise Warn(found, "02h, or values of their own", f"{value:04X}")


def _writes_in_one_request(p: Purposes[ModbusTester], first: tuple[str, ...]) -> None:
    @p.case(
        "BV_22",
        "FC 22: (current AND and-mask) OR (or-mask AND NOT and-mask)",
        "FC 22: (Wert UND Und-Maske) ODER (Oder-Maske UND NICHT Und-Maske)",
        clause="V1.1b3, 6.16",
        condition=("write_holding", "fc22", "fc6"),
        preamble=first,
    )
    def mask(t: ModbusTester) -> None:
        at = t.setup.holding[0]
        with kept(t, 3, at, 1):
            for current, keep, put in (
                (0x0012, 0x00F2, 0x0025),
                (0xFFFF, 0x0F0F, 0x5555),
                (0x1234, 0xFFFF, 0xFFFF),
                (0x1234, 0x0000, 0xA5A5),
            ):
                with t.given():
                    write_back(t, 3, at, [current])
                t.echo(struct.pack(">BHHH", 22, at, keep, put), 7, "FC 22")
                same_values(t.registers(3, at, 1), [current & keep | put & ~keep & 0xFFFF], f"register {at} after FC 22")

    @p.case(
        "BV_23",
        "FC 23 writes first, then reads",
        "FC 23 schreibt zuerst, dann liest es",
        clause="V1.1b3, 6.17",
        condition=("write_holding", "fc23", "fc6"),
        preamble=first,
    )
    def both(t: ModbusTester) -> None:
        at, count = _run(t.setup.holding, t.setup.most(16, 4))
        with kept(t, 3, at, count):
            with t.given():
                write_back(t, 3, at, [0x1111] * count)
            values = pattern(count)
            got = t.normal(struct.pack(f">BHHHHB{count}H", 23, at, count, at, count, 2 * count, *values), "FC 23")
            if len(got) != 2 + 2 * count or got[1] != 2 * count:
                raise Fail("FC 23: malformed answer", f"17h, byte count {2 * count}, data", t.words(got))
            same_values(list(struct.unpack(f">{count}H", got[2:])), values, "what FC 23 read")
            same_values(t.registers(3, at, count), values, "what FC 23 wrote")
            half = count // 2
            if half:
                got = t.normal(struct.pack(f">BHHHHB{half}H", 23, at + half, half, at, half, 2 * half, *[0x5A00] * half), "FC 23")
                same_values(
                    list(struct.unpack(f">{half}H", got[2 : 2 + 2 * half])),
                    values[half : 2 * half],
                    "what FC 23 read in addition to its write",
                )


def _many_writes(p: Purposes[ModbusTester], first: tuple[str, ...]) -> None:
    @p.case(
        "ST_01",
        "40 writes of chosen registers, each read back",
        "40 Schreibzugriffe, je zurückgelesen",
        condition=("write_holding", "fc6"),
        preamble=first,
    )
    def many(t: ModbusTester) -> None:
        chosen = random.Random(1)
        at, count = _run(t.setup.holding, 16)
        with kept(t, 3, at, count):
            for turn in range(40):
                number, value = at + chosen.randrange(count), chosen.randrange(0x10000)
                t.echo(struct.pack(">BHH", 6, number, value), 5, f"write {turn + 1}")
                same_values(t.registers(3, number, 1), [value], f"register {number}, write {turn + 1}")


def _coils(p: Purposes[ModbusTester], prefix: str, basic: str) -> None:
    first = (basic, f"{prefix}_CON_BV_05")

    @p.case("BV_05", "FC 5: echo and effect", "FC 5: Echo und Wirkung", clause="V1.1b3, 6.5", condition=("write_coils", "fc5"))
    def single(t: ModbusTester) -> None:
        at = t.setup.coils[0]
        with kept(t, 1, at, 1):
            for value in (1, 0, 1):
                t.echo(struct.pack(">BHH", 5, at, 0xFF00 * value), 5, f"FC 5, {'on' if value else 'off'}")
                same_values(t.bits(1, at, 1), [value], f"coil {at}")

    @p.case(
        "BV_15",
        "FC 15: echo and effect, the first coil is the lowest bit of the first byte",
        "FC 15: Echo und Wirkung, die erste Spule ist das niedrigste Bit",
        clause="V1.1b3, 6.11",
        condition=("write_coils", "fc15"),
    )
    def several(t: ModbusTester) -> None:
        at, count = _run(t.setup.coils, t.setup.most(15, 20))
        with kept(t, 1, at, count):
            for size in sorted({1, min(3, count), min(10, count), count}):
                bits = [1 if (at_bit * 7 + at_bit // 3) % 5 < 2 else 0 for at_bit in range(size)]
                number = sum(bit << place for place, bit in enumerate(bits))
                data = number.to_bytes((size + 7) // 8, "little")
                t.echo(struct.pack(">BHHB", 15, at, size, len(data)) + data, 5, f"FC 15, {amount(size, 'coil')}")
                same_values(t.bits(1, at, size), bits, f"{amount(size, 'coil')} from {at}")
            if count > 12:  # not at a byte boundary
                first, bits = at + (2 if (at + 3) % 8 == 0 else 3), [1, 0] * 4 + [1]
                number = sum(bit << place for place, bit in enumerate(bits))
                t.echo(struct.pack(">BHHB", 15, first, 9, 2) + number.to_bytes(2, "little"), 5, "FC 15, 9 coils")
                same_values(t.bits(1, first, 9), bits, f"9 coils from {first}")

    @p.case(
        "BV_24",
        "each coil has its own bit, and unused bits of the last byte are 0",
        "jede Spule hat ihr Bit, freie Bits des letzten Bytes sind 0",
        clause="V1.1b3, 6.1",
        condition=("write_coils", "fc5"),
        preamble=first,
    )
    def own_bit(t: ModbusTester) -> None:
        at, count = _run(t.setup.coils, t.setup.most(15, 11))
        with kept(t, 1, at, count):
            with t.given():
                write_back(t, 1, at, [1] * count)
            for size in range(1, count + 1):
                got = t.normal(struct.pack(">BHH", 1, at, size), "FC 1")
                if got[2:] != ((1 << size) - 1).to_bytes((size + 7) // 8, "little"):
                    raise Fail(
                        f"{amount(size, 'coil')} set to on: FC 1 reads {got[2:].hex(' ').upper()}",
                        ((1 << size) - 1).to_bytes((size + 7) // 8, "little").hex(" ").upper(),
                        t.words(got),
                    )
            for off in range(count):
                t.echo(struct.pack(">BHH", 5, at + off, 0), 5, "FC 5")
                same_values(
                    t.bits(1, at, count), [0] * (off + 1) + [1] * (count - off - 1), f"{amount(count, 'coil')} after {at + off} went off"
                )


def _fill_bits(p: Purposes[ModbusTester], first: tuple[str, ...]) -> None:
    @p.case(
        "BV_25",
        "FC 15 changes the coils it names and no other: bits that fill its last byte do not count",
        "FC 15 ändert nur die genannten Spulen: Füllbits des letzten Bytes zählen nicht",
        clause="V1.1b3, 6.11",
        condition=("write_coils", "fc15", "fc5"),
        preamble=first,
    )
    def fill(t: ModbusTester) -> None:
        at, count = _run(t.setup.coils, t.setup.most(15, 16))
        with kept(t, 1, at, count):
            for size in sorted({1, min(3, count), min(9, count)}):
                with t.given():
                    write_back(t, 1, at, [1] * count)
                length = (size + 7) // 8
                t.echo(struct.pack(">BHHB", 15, at, size, length) + bytes(length), 5, f"FC 15, {amount(size, 'coil')}")
                same_values(t.bits(1, at, count), [0] * size + [1] * (count - size), f"{amount(count, 'coil')} after a write of {size}")


def _tables(p: Purposes[ModbusTester]) -> None:
    @p.case("BV_01", "values that the bench knows are there", "die der Prüfumgebung bekannten Werte sind da", condition=("known",))
    def known(t: ModbusTester) -> None:
        for name, value in t.setup.known.items():
            kind, _, number = name.partition(":")
            got = t.read(NAMES[kind], int(number), 1)
            same_values(got, [value], name)

    def apart(number: int, written: int, read: int, what: str, de: str, condition: tuple[str, ...]) -> None:
        @p.case(f"BV_{number}", f"{what} are tables of their own", f"{de} sind eigene Tabellen", clause="V1.1b3, 4.3", condition=condition)
        def body(t: ModbusTester) -> None:
            numbers = t.setup.holding if written == 3 else t.setup.coils
            base, span = t.setup.base[read], t.setup.span[read]
            shared = [at for at in numbers if base <= at < base + span]
            if not shared:
                raise NotApplicable("no address is in both tables")
            at = shared[0]
            first = t.read(read, at, 1)
            if t.setup.pics.get("mapped"):
                raise NotApplicable("the PICS declares that these tables overlap")
            with kept(t, written, at, 1):
                changed = []
                for value in (0x5AC3, 0xA53C) if written == 3 else (1, 0, 1):
                    with t.given():
                        write_back(t, written, at, [value])
                    changed.append(t.read(read, at, 1) == [value if read > 2 else value & 1])
                if all(changed):
                    raise Fail(f"{what}: a write to {at} of one shows in the other", f"{first}", f"{t.read(read, at, 1)}")

    apart(30, 3, 4, "holding and input registers", "Halte- und Eingangsregister", ("write_holding", "input_registers"))
    apart(31, 1, 2, "coils and discrete inputs", "Spulen und diskrete Eingänge", ("write_coils", "discrete_inputs"))


def _kept_apart(p: Purposes[ModbusTester], prefix: str, basic: str) -> None:
    @p.case(
        "BV_32",
        "a write of registers changes no coil, a write of coils no register",
        "ein Schreiben von Registern ändert keine Spule, ein Schreiben von Spulen kein Register",
        condition=("write_holding", "write_coils"),
        preamble=(basic, f"{prefix}_CON_BV_06", f"{prefix}_CON_BV_05"),
    )
    def body(t: ModbusTester) -> None:
        """Each function that writes, with all coils off and with all of them on."""
        if t.setup.pics.get("mapped"):
            raise NotApplicable("the PICS declares that these tables overlap")
        holding, words = _run(t.setup.holding, t.setup.most(16, 20))
        coils, bits = _run(t.setup.coils, t.setup.most(15, 20))
        with kept(t, 3, holding, words), kept(t, 1, coils, bits):
            for bit in (0, 1):
                for function in (6, 16, 22, 23):
                    if t.setup.pics.get(f"fc{function}"):
                        with t.given():
                            write_back(t, 1, coils, [bit] * bits)
                            t.normal(_registers_by(function, holding, words, 0xA5C3 if bit else 0x5A3D), f"FC {function}")
                        same_values(t.bits(1, coils, bits), [bit] * bits, f"{amount(bits, 'coil')} from {coils} after FC {function}")
                with t.given():
                    before = t.registers(3, holding, words)
                    write_back(t, 1, coils, [1 - bit] * bits)
                same_values(t.registers(3, holding, words), before, f"{amount(words, 'register')} from {holding} after a write of coils")


def _registers_by(function: int, at: int, count: int, value: int) -> bytes:
    """Values with ones and zeros, by one function; all registers where it can."""
    values = struct.pack(f">{count}H", *[value ^ 0xFFFF * (offset & 1) for offset in range(count)])
    return {
        6: struct.pack(">BHH", 6, at, value),
        16: struct.pack(">BHHB", 16, at, count, 2 * count) + values,
        22: struct.pack(">BHHH", 22, at, 0, value),
        23: struct.pack(">BHHHHB", 23, at, 1, at, count, 2 * count) + values,
    }[function]


CON = _collect("MBTCP")
RTU_CON = _collect("MBRTU")
