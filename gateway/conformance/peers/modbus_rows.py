"""Modbus: the mutants and variants that both kinds of framing have."""

from collections.abc import Callable, Sequence

from gateway.conformance.peers.modbus_answers import (
    ReadsFirst,
    after_refusals,
    all_as,
    any_amount,
    any_coil_value,
    byte_more,
    counts_written,
    each_70th,
    limited,
    longer,
    mask_or,
    mirrored,
    number,
    padded,
    reads_126,
    reads_first,
    rewritten,
    too_many,
    wraps,
    writes_bad,
    writes_unread,
)
from gateway.conformance.peers.modbus_devices import SIZE, Answer, Busy, Device, Tables
from gateway.conformance.peers.modbus_tables import (
    AlignedCoils,
    AsFarAsCoilsGo,
    AsFarAsThereIs,
    CoilsToo,
    Cut,
    EvenCounts,
    EveryTenth,
    FillBits,
    FirstCoils,
    FirstOnly,
    Lost,
    LostCoils,
    LowByte,
    Most,
    NextCoil,
    NextToo,
    Nowhere,
    OneBitTable,
    OneRegisterTable,
    ReadOnly,
    ReadsLowByte,
    RegistersToo,
    Reversed,
    ReversedCoils,
    SevenBits,
    Shifted,
    SignedBytes,
    Sticky,
    Swapped,
    WholeBytes,
    WithoutCarry,
)
from gateway.conformance.peers.powered import Powered
from gateway.conformance.peers.stations import Maker, Mutant, Variant
from protocols.base.machine import ms

Row = tuple[str, str, tuple[str, ...], Callable[[bool], object]]


def _answers(name: str, what: str, expects: Sequence[str], changed: Answer) -> Row:
    return name, what, tuple(expects), lambda rtu: Device(rtu, changed)


def _tables(name: str, what: str, expects: Sequence[str], tables: Callable[[], Tables]) -> Row:
    return name, what, tuple(expects), lambda rtu: Device(rtu, tables=tables())


ROWS: tuple[Row, ...] = (
    _answers("silent", "never answers", ["FUN_BV_01"], lambda device, asked, said: b""),
    _answers("wrong-function", "answers with function 0", ["FUN_BV_01"], lambda device, asked, said: b"\0" + said[1:]),
    _answers(
        "exception-without-bit",
        "refuses FC 41h with function 00",
        ["FUN_BI_04", "FUN_BI_01"],
        lambda device, asked, said: b"\x80" + said[1:] if asked[0] == 0x41 else said,
    ),
    _answers("all-is-04", "refuses everything with 04", ["FUN_BI_04"], all_as(4)),
    _answers("unknown-is-04", "refuses unknown functions with 04", ["FUN_BI_01"], number(1, 4, (0x41, 9, 0x64, 0x6E))),
    _answers(
        "seven-bits",
        "executes function 83h as function 3",
        ["FUN_BI_02"],
        lambda device, asked, said: b"\x83\x02\0\0" if asked[0] == 0x83 else said,
    ),
    _answers(
        "end-refused",
        "refuses two input registers that end at the last one",
        ["ANS_BV_06"],
        lambda device, asked, said: b"\x84\x02" if asked == bytes((4, 0, SIZE - 2, 0, 2)) else said,
    ),
    _answers(
        "end-unwritten",
        "refuses FC 16 of two registers that end at the last one",
        ["ANS_BV_07"],
        lambda device, asked, said: b"\x90\x02" if asked[:5] == bytes((16, 0, SIZE - 2, 0, 2)) else said,
    ),
    _answers("loop-cut", "FC 8 returns two bytes of four", ["ANS_CA_08"], rewritten(8, lambda asked, said: said[:5])),
    _answers(
        "any-diagnosis",
        "executes sub-functions of FC 8 that are none",
        ["ANS_CA_08"],
        lambda device, asked, said: asked if asked[:2] == b"\x08\x7f" else said,
    ),
    _answers("function-0", "executes function 0", ["FUN_BI_02"], lambda device, asked, said: b"\0\0" if not asked[0] else said),
    _answers("amount-0", "serves an amount of 0", ["FUN_BI_30"], any_amount),
    _answers("amount-126", "serves 126 registers", ["FUN_BI_31"], too_many),
    _answers("limit-100", "serves 100 registers of 120 in one request", ["FUN_BV_32", "FUN_BV_42"], limited(100)),
    _answers("longer-reads", "executes reads with a byte too many", ["LEN_BI_01"], longer((1, 2, 3, 4), 6)),
    _answers("longer-fc3", "executes FC 3 with a byte too many", ["LEN_BI_01"], longer((3,), 6)),
    _answers("longer-fc6", "executes FC 6 with a byte too many", ["LEN_BI_02"], longer((6,), 6)),
    _answers("longer-fc16", "executes FC 16 with a byte too many", ["LEN_BI_02"], longer((16,))),
    _answers("wraps", "wraps around after address 65535", ["FUN_BI_33"], wraps),
    _answers("value-as-01", "refuses bad amounts with 01", ["FUN_BI_30"], number(3, 1, (3, 4))),
    _answers("address-as-04", "refuses missing addresses with 04", ["FUN_BI_33", "FUN_BI_34"], number(2, 4, (3, 4))),
    _answers("coil-amount", "refuses bad amounts of coils with 02", ["FUN_BI_10"], number(3, 2, (1, 2))),
    _answers("any-coil-value", "takes any value for a coil", ["FUN_BI_50"], any_coil_value),
    _answers("writes-bad", "refuses a bad byte count, and writes", ["FUN_BI_71"], writes_bad),
    _answers(
        "byte-count",
        "byte count of FC 3 is the number of registers",
        ["FUN_BV_30"],
        rewritten(3, lambda asked, said: said[:1] + bytes((said[1] // 2,)) + said[2:]),
    ),
    _answers("byte-count-4", "FC 4 lacks its last byte", ["FUN_BV_40"], rewritten(4, lambda asked, said: said[:-1])),
    _answers("bit-bytes", "FC 1 sends a byte more for whole bytes", ["FUN_BV_10"], rewritten(1, byte_more)),
    _answers("bit-bytes-2", "FC 2 sends a byte more for whole bytes", ["FUN_BV_20"], rewritten(2, byte_more)),
    _answers(
        "little-endian",
        "FC 3 low byte first",
        ["CON_BV_06"],
        rewritten(3, lambda asked, said: said[:2] + b"".join(said[at + 1 : at + 2] + said[at : at + 1] for at in range(2, len(said), 2))),
    ),
    _answers(
        "word-order",
        "FC 3 sends the last register first",
        ["CON_BV_16"],
        rewritten(3, lambda asked, said: said[:2] + b"".join(said[at : at + 2] for at in range(len(said) - 2, 1, -2))),
    ),
    _answers("bit-order", "FC 1 sends the highest bit first", ["CON_BV_24", "CON_BV_05"], rewritten(1, mirrored)),
    _answers("padding", "unused bits are 1", ["CON_BV_24"], rewritten(1, padded)),
    _answers("echo-5", "FC 5 answers with 0000h", ["CON_BV_05"], rewritten(5, lambda asked, said: said[:3] + b"\0\0")),
    _answers("echo-6", "FC 6 answers with its own value", ["CON_BV_06"], rewritten(6, lambda asked, said: said[:3] + b"\x12\x34")),
    _answers(
        "echo-15", "FC 15 answers with an amount more", ["CON_BV_15"], rewritten(15, lambda asked, said: said[:4] + bytes((said[4] + 1,)))
    ),
    _answers("echo-16", "FC 16 answers with address 0", ["CON_BV_16"], rewritten(16, lambda asked, said: said[:3] + b"\0\0")),
    _answers("echo-22", "FC 22 answers without its masks", ["CON_BV_22"], rewritten(22, lambda asked, said: said[:3] + bytes(4))),
    _answers("mask", "FC 22 sets all bits of the or-mask", ["CON_BV_22"], mask_or),
    ("reads-first", "FC 23 reads before it writes", ("CON_BV_23",), lambda rtu: ReadsFirst(rtu, reads_first)),
    _answers("loop-data", "FC 8 returns zeros", ["FUN_CA_08"], rewritten(8, lambda asked, said: said[:3] + b"\0\0")),
    _answers(
        "identification",
        "FC 43 announces an object more",
        ["FUN_CA_43"],
        rewritten(43, lambda asked, said: said[:6] + bytes((said[6] + 1,)) + said[7:]),
    ),
    _tables("lost-writes", "acknowledges writes of registers without effect", ["CON_BV_06", "CON_BV_16"], Lost),
    _tables("lost-coils", "acknowledges writes of coils without effect", ["CON_BV_05"], LostCoils),
    _tables("swapped", "exchanges the bytes it writes", ["CON_BV_06"], Swapped),
    _tables("reversed", "writes the last register first", ["CON_BV_16"], Reversed),
    _tables("reversed-coils", "writes the last coil first", ["CON_BV_15"], ReversedCoils),
    _tables("first-only", "FC 16 writes the first register only", ["CON_BV_16"], FirstOnly),
    _tables("fill-bits", "FC 15 writes the bits that fill its last byte", ["CON_BV_25"], FillBits),
    _tables("first-coils", "FC 15 writes eight coils at most", ["CON_BV_15"], FirstCoils),
    _tables("next-too", "writes the next register as well", ["CON_BV_18"], NextToo),
    _tables("next-coil", "writes the next coil as well", ["CON_BV_24"], NextCoil),
    _tables("shifted", "longer reads begin one register too late", ["CON_BV_16", "CON_BV_17"], Shifted),
    _tables("cut", "register numbers of five bits", ["CON_BV_19"], Cut),
    _tables("one-register-table", "input registers are the holding registers", ["CON_BV_30"], OneRegisterTable),
    _tables("one-bit-table", "discrete inputs are the coils", ["CON_BV_31"], OneBitTable),
    _tables("coils-too", "FC 16 changes coils as well", ["CON_BV_32"], CoilsToo),
    _tables("registers-too", "a write of coils clears registers", ["CON_BV_32"], RegistersToo),
    _tables("sticky", "a coil stays on", ["CON_BV_05"], Sticky),
    _tables("fifteen-bits", "registers of fifteen bits", ["CON_BV_06"], SevenBits),
    _tables("each-25th", "each 25th write is lost", ["CON_ST_01", "CON_BV_16", "CON_BV_17"], EveryTenth),
    _tables("nowhere", "acknowledges writes to what is not there", ["EFF_BI_02", "EFF_BI_04"], Nowhere),
    _tables("reads-low-byte", "the high byte of an address does not count", ["CON_BV_19"], ReadsLowByte),
    _tables("low-byte", "writes to the low byte of an address", ["EFF_BI_02", "EFF_BI_04"], LowByte),
    _tables("as-far-as", "a refused range is written up to the end", ["EFF_BI_11"], AsFarAsThereIs),
    _tables("as-far-as-coils", "a refused range of coils is written up to the end", ["EFF_BI_10"], AsFarAsCoilsGo),
    _tables("ninety-registers", "the rest of a long write is lost", ["EFF_BV_01", "CON_BV_16"], Most),
    _answers("writes-unread", "FC 23 writes though its reading part is missing", ["EFF_BI_20"], writes_unread),
    _answers("reads-126", "FC 23 serves 126 registers", ["EFF_BI_22"], reads_126),
    _answers("status-two", "FC 7 brings two bytes", ["FUN_CA_07"], lambda device, asked, said: b"\x07\0\0" if asked[0] == 7 else said),
    _answers(
        "id-count", "FC 17 counts a byte too many", ["FUN_CA_17"], lambda device, asked, said: b"\x11\3a\xff" if asked[0] == 17 else said
    ),
    _tables("whole-bytes", "coils are read from whole bytes on", ["ANS_BV_03"], WholeBytes),
    _tables("aligned-coils", "coils are written from whole bytes on", ["CON_BV_15"], AlignedCoils),
    _tables("without-carry", "a read across address 256 begins again at 0", ["ANS_BV_08"], WithoutCarry),
    _tables("even-counts", "FC 16 writes an even number of registers", ["CON_BV_16"], EvenCounts),
    _tables("signed-bytes", "extends a value of one byte by its top bit", ["ANS_BV_02"], SignedBytes),
    _answers("counts-written", "FC 23 counts what was written", ["ANS_BV_04"], counts_written),
    _answers("after-refusals", "fails after a hundred refusals", ["RC_02", "RC_03"], after_refusals),
    ("dead-after-power", "does not work after a power failure", ("SUP_RC_01",), lambda rtu: Powered(lambda: Device(rtu), False)),
    _answers("each-70th", "each 70th request is refused with 06", ["ST_01"], each_70th),
)


def mutants(prefix: str, rtu: bool, more: Sequence[Row], without: Sequence[str] = ()) -> tuple[Mutant, ...]:
    """Mutants of both kinds of framing."""
    area = "RTU" if rtu else "TCP"

    def full(name: str) -> str:
        return f"{prefix}_{name}" if name.count("_") > 1 else f"{prefix}_{area}_{name}"

    def maker(make: Callable[[bool], object]) -> Maker:
        return lambda: make(rtu)

    rows = [row for row in (*ROWS, *more) if row[0] not in without]
    return tuple(Mutant(name, what, tuple(map(full, expects)), maker(make), {}, {}) for name, what, expects, make in rows)


def variants(rtu: bool) -> tuple[Variant, ...]:
    def one(name: str, what: str, make: Maker, touch: bool = True, **pics: object) -> Variant:
        return Variant(name, what, make, {}, dict(pics), touch)

    return (
        one("all", "offers all functions", lambda: Device(rtu)),
        one("slow", "answers after 300 ms", lambda: Device(rtu, late=ms(300))),
        one("read-only", "nothing may be written", lambda: Device(rtu, tables=ReadOnly()), touch=False),
        one("registers-only", "no coils and discrete inputs", lambda: Device(rtu, without=(1, 2, 5, 15))),
        one(
            "few-functions", "FC 3, 6 and 16 only", lambda: Device(rtu, without=(1, 2, 4, 5, 7, 8, 11, 12, 15, 17, 20, 21, 22, 23, 24, 43))
        ),
        one("no-single-writes", "FC 15 and 16, not 5 and 6", lambda: Device(rtu, without=(5, 6, 22, 23))),
        one("no-diagnosis", "no FC 8 and 43", lambda: Device(rtu, without=(8, 43))),
        one(
            "address-as-03",
            "refuses a range beyond 65535 with 03",
            lambda: Device(rtu, lambda device, asked, said: bytes((said[0], 3)) if said[1:] == b"\x02" and len(said) == 2 else said),
        ),
        one(
            "limit-100",
            "serves 100 registers in one request, as its PICS states",
            lambda: Device(rtu, limited(100)),
            most_registers=100,
        ),
        one("busy", "refuses each 40th request with 06: busy", lambda: Busy(rtu)),
        one("powered", "its supply can be switched", lambda: Powered(lambda: Device(rtu))),
        one("any-unit", "answers for any unit" if not rtu else "one more of the usual", lambda: Device(rtu, any_unit=not rtu)),
        one(
            "mapped",
            "input registers show the holding registers, as declared in its PICS",
            lambda: Device(rtu, tables=OneRegisterTable()),
            mapped=True,
        ),
    )
