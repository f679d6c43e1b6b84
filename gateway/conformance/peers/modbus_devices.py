"""Axisgate's Modbus servers as byte machines, each with one fault or with correct but different behaviour."""

import struct
from collections.abc import Callable, Sequence

from gateway.conformance.peers.powered import Powered
from gateway.conformance.peers.stations import Maker, Mutant, Variant
from protocols.base.machine import Damage, Ns, ms
from protocols.modbus.answering import answer
from protocols.modbus.mbap import Closing, Foreign, Framing, Request
from protocols.modbus.rtu import RtuFraming
from protocols.modbus.station import Station
from protocols.modbus.timing import timing
from protocols.modbus.view import ExceptionCode, Kind

SIZE = 120
INPUTS, DISCRETE = [0x7000 + 3 * at for at in range(SIZE)], [at % 3 == 0 for at in range(SIZE)]
Answer = Callable[["Device", bytes, bytes], bytes]  # request and right answer -> what is said


class Tables:
    """Four tables of 120, each with its own content."""

    def __init__(self) -> None:
        self.words = {Kind.HOLDING_REGISTERS: [0] * SIZE, Kind.INPUT_REGISTERS: list(INPUTS)}
        self.flags = {Kind.COILS: [False] * SIZE, Kind.DISCRETE_INPUTS: list(DISCRETE)}

    def read_bits(self, kind: Kind, address: int, count: int) -> Sequence[bool] | ExceptionCode:
        return self.flags[kind][address : address + count] if address + count <= SIZE else ExceptionCode.ILLEGAL_DATA_ADDRESS

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        return self.words[kind][address : address + count] if address + count <= SIZE else ExceptionCode.ILLEGAL_DATA_ADDRESS

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        if address + len(values) > SIZE:
            return ExceptionCode.ILLEGAL_DATA_ADDRESS
        self.flags[Kind.COILS][address : address + len(values)] = values
        return None

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        if address + len(values) > SIZE:
            return ExceptionCode.ILLEGAL_DATA_ADDRESS
        self.words[Kind.HOLDING_REGISTERS][address : address + len(values)] = values
        return None


class Device:
    """A server on TCP or RTU; `changed` alters answers, `tables` hold the values."""

    def __init__(
        self,
        rtu: bool,
        changed: Answer | None = None,
        tables: Tables | None = None,
        late: Ns = 0,
        without: Sequence[int] = (),
        any_unit: bool = False,
    ) -> None:
        self.rtu, self._changed, self.tables = rtu, changed, tables or Tables()
        self.framing: Framing | RtuFraming = RtuFraming(timing(9600)) if rtu else Framing()
        self.station = Station(serial=rtu)
        self._late, self._without, self._any_unit = late, without, any_unit
        self._queue: list[tuple[Ns, bytes]] = []
        self.count = 0
        self.dead = False
        self.refused = 0

    def serve(self, request: Request, now: Ns) -> bytes:
        """The answer PDU; b"": none."""
        broadcast = self.rtu and request.unit == 0
        if request.unit not in (1, 0, 255) and not self._any_unit:
            return b"" if self.rtu else answer(request.pdu, None)
        if request.pdu[:1] and request.pdu[0] in self._without:
            return bytes((request.pdu[0] | 0x80, 1))
        said = answer(request.pdu, self.tables, True, self.station)
        if self._changed is not None and said:
            said = self._changed(self, request.pdu, said)
        return b"" if broadcast else said

    def _take(self, events: Sequence[object], now: Ns) -> list[object]:
        for event in events:
            if isinstance(event, Request):
                self.count += 1
                said = self.serve(event, now)
                if said and not self.dead:
                    self.framing.reply(event, said)
            elif isinstance(event, (Closing, Foreign)):
                self.strange(event)
        said = self.framing.take_output()
        if said:
            self._queue.append((now + self._late, self.framed(said)))
        return []

    def strange(self, event: object) -> None:
        """A frame that is none."""

    def framed(self, said: bytes) -> bytes:
        return said

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        return self._take(self.framing.receive(data, now), now)

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        return self._take(self.framing.damaged(kind, now), now)

    def sent(self, now: Ns) -> Sequence[object]:
        self._now = now
        return []

    def wake(self, now: Ns) -> Sequence[object]:
        self._ready = now
        due = self.framing.deadline()
        return self._take(self.framing.wake(now), now) if due is not None and due <= now else []

    _ready: Ns = -1
    _now: Ns = 0

    def deadline(self) -> Ns | None:
        moments = [moment for moment in (self.framing.deadline(), self._queue[0][0] if self._queue else None) if moment is not None]
        return min(moments, default=None)

    def take_output(self) -> bytes:
        said = b""
        while self._queue and (not self._late or self._queue[0][0] <= self._ready):
            said += self._queue.pop(0)[1]
        return said

    def lost(self, now: Ns) -> Sequence[object]:
        """A new connection: a new stream, the same values."""
        self._queue.clear()
        self.framing = RtuFraming(timing(9600)) if self.rtu else Framing()
        return []


def rewritten(function: int, change: Callable[[bytes, bytes], bytes]) -> Answer:
    """The answers to one function are changed, refusals are not."""
    return lambda device, asked, said: change(asked, said) if said[0] == function else said


def _number(old: int, new: int, functions: Sequence[int]) -> Answer:
    return lambda device, asked, said: (
        bytes((said[0], new)) if said[0] & 0x80 and said[1:] == bytes((old,)) and asked[0] in functions else said
    )


class Lost(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return ExceptionCode.ILLEGAL_DATA_ADDRESS if address + len(values) > SIZE else None


class LostCoils(Tables):
    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return ExceptionCode.ILLEGAL_DATA_ADDRESS if address + len(values) > SIZE else None


class Swapped(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, [(value & 0xFF) << 8 | value >> 8 for value in values])


class Reversed(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, list(values)[::-1])


class ReversedCoils(Tables):
    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return super().write_bits(address, list(values)[::-1])


class FirstOnly(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, list(values)[:1])


class FillBits(Tables):
    """Several coils at once: the bits that fill the last byte are written as well."""

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        filled = [*values, *[False] * (-len(values) % 8)] if len(values) > 1 else values
        return super().write_bits(address, filled)


class FirstCoils(Tables):
    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return super().write_bits(address, list(values)[:8])


class NextToo(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, [*values, values[-1]])


class NextCoil(Tables):
    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return super().write_bits(address, [*values, values[-1]])


class Shifted(Tables):
    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        return (
            super().read_words(kind, address + 1, count)
            if kind is Kind.HOLDING_REGISTERS and count > 1 and address + count < SIZE
            else super().read_words(kind, address, count)
        )


class Cut(Tables):
    """Register numbers of five bits."""

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        return (
            super().read_words(kind, address & 0x1F, count)
            if count < 33 and kind is Kind.HOLDING_REGISTERS
            else super().read_words(kind, address, count)
        )

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address & 0x1F, values)


class OneRegisterTable(Tables):
    """Input registers are the holding registers."""

    def __init__(self) -> None:
        super().__init__()
        self.words[Kind.INPUT_REGISTERS] = self.words[Kind.HOLDING_REGISTERS]


class OneBitTable(Tables):
    def __init__(self) -> None:
        super().__init__()
        self.flags[Kind.DISCRETE_INPUTS] = self.flags[Kind.COILS]


class Sticky(Tables):
    """A coil once set stays set."""

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        old = self.flags[Kind.COILS][address : address + len(values)]
        return super().write_bits(address, [value or before for value, before in zip(values, [*old, *[False] * len(values)], strict=False)])


class SevenBits(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, [value & 0x7FFF for value in values])


class ReadsBeyond(Tables):
    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        found = super().read_words(kind, address, count)
        return ExceptionCode.SERVER_DEVICE_FAILURE if isinstance(found, ExceptionCode) else found


class EveryTenth(Tables):
    _count = 0

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        self._count += 1
        return None if self._count % 25 == 0 else super().write_words(address, values)


def _writes_bad(device: Device, asked: bytes, said: bytes) -> bytes:
    """Refuses a bad byte count, and writes all the same."""
    if said[0] == 0x90 and said[1] == 3 and len(asked) > 7:
        device.tables.write_words(asked[1] << 8 | asked[2], [0x5A5A])
    return said


def _any_coil_value(device: Device, asked: bytes, said: bytes) -> bytes:
    if said[0] == 0x85 and len(asked) == 5:
        device.tables.write_bits(asked[1] << 8 | asked[2], [bool(asked[3] or asked[4])])
        return asked
    return said


def _any_amount(device: Device, asked: bytes, said: bytes) -> bytes:
    """Amount 0 is answered with nothing."""
    return bytes((asked[0], 0)) if said[1:] == b"\x03" and asked[0] < 5 and asked[3:5] == b"\0\0" else said


def _too_many(device: Device, asked: bytes, said: bytes) -> bytes:
    if said[1:] == b"\x03" and asked[0] in (3, 4) and asked[3:5] == b"\x00\x7e":
        return bytes((asked[0], 252)) + bytes(252)
    return said


def _wraps(device: Device, asked: bytes, said: bytes) -> bytes:
    """Beyond 65535 it begins again at 0."""
    return bytes((asked[0], 4)) + bytes(4) if said[0] & 0x80 and asked[:5] in (b"\x03\xff\xff\x00\x02", b"\x04\xff\xff\x00\x02") else said


def _reads_first(device: Device, asked: bytes, said: bytes) -> bytes:
    """FC 23 reads before it writes."""
    if said[0] != 23:
        return said
    count = said[1] // 2
    found = getattr(device, "_before", [0] * SIZE)
    at = asked[1] << 8 | asked[2]
    return said[:2] + struct.pack(f">{count}H", *found[at : at + count])


class ReadsFirst(Device):
    def serve(self, request: Request, now: Ns) -> bytes:
        self._before = list(self.tables.words[Kind.HOLDING_REGISTERS])
        return super().serve(request, now)


def _mask_or(device: Device, asked: bytes, said: bytes) -> bytes:
    """FC 22 without the and-mask of the or-mask."""
    if said[0] == 22:
        at, put = asked[1] << 8 | asked[2], asked[5] << 8 | asked[6]
        device.tables.words[Kind.HOLDING_REGISTERS][at] |= put
    return said


def padded(asked: bytes, said: bytes) -> bytes:
    free = -(asked[3] << 8 | asked[4]) % 8
    return said[:-1] + bytes((said[-1] | 0xFF << (8 - free) & 0xFF,)) if free else said


def _mirrored(asked: bytes, said: bytes) -> bytes:
    return said[:2] + bytes(int(f"{byte:08b}"[::-1], 2) for byte in said[2:])


def _byte_more(asked: bytes, said: bytes) -> bytes:
    return said[:1] + bytes((said[1] + 1,)) + said[2:] + b"\0" if asked[3:5] == b"\x00\x08" or (asked[3] << 8 | asked[4]) % 8 == 0 else said


def _after_refusals(device: Device, asked: bytes, said: bytes) -> bytes:
    if said[0] & 0x80:
        device.refused += 1
    return said if device.refused < 100 else bytes((asked[0] | 0x80, 4))


def _each_70th(device: Device, asked: bytes, said: bytes) -> bytes:
    return said if device.count % 70 else bytes((asked[0] | 0x80, 6))


class Nowhere(Tables):
    """Writes to registers and coils that are not there are acknowledged."""

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, values) if address < SIZE else None

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return super().write_bits(address, values) if address < SIZE else None


class LowByte(Tables):
    """The high byte of an address to be written does not count."""

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address & 0xFF, values)

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return super().write_bits(address & 0xFF, values)


class AsFarAsThereIs(Tables):
    """A range beyond the end is written up to the end, and refused."""

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        super().write_words(address, list(values)[: max(0, SIZE - address)])
        return super().write_words(address, values)


class AsFarAsCoilsGo(Tables):
    """The same for coils."""

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        super().write_bits(address, list(values)[: max(0, SIZE - address)])
        return super().write_bits(address, values)


class Most(Tables):
    """Ninety registers at most in one request; the rest is lost."""

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        refused = super().write_words(address, values) if address + len(values) > SIZE else None
        return refused or super().write_words(address, list(values)[:90])


def _writes_unread(device: Device, asked: bytes, said: bytes) -> bytes:
    """FC 23 writes though the part to be read is missing."""
    if said == b"\x97\x02" and len(asked) >= 12:
        device.tables.write_words(asked[5] << 8 | asked[6], [asked[10] << 8 | asked[11]])
    return said


def _reads_126(device: Device, asked: bytes, said: bytes) -> bytes:
    """FC 23 serves 126 registers."""
    return bytes((23, 252)) + bytes(252) if said == b"\x97\x03" and asked[3:5] == b"\x00\x7e" else said


class ForgetsWithTheClient(Device):
    """What a client wrote is gone with its connection."""

    def lost(self, now: Ns) -> Sequence[object]:
        self.tables = Tables()
        return super().lost(now)


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
    _answers("unknown-is-04", "refuses unknown functions with 04", ["FUN_BI_01"], _number(1, 4, (0x41, 9, 0x64, 0x6E))),
    _answers("amount-0", "serves an amount of 0", ["FUN_BI_30"], _any_amount),
    _answers("amount-126", "serves 126 registers", ["FUN_BI_31"], _too_many),
    _answers("wraps", "begins again behind address 65535", ["FUN_BI_33"], _wraps),
    _answers("value-as-01", "refuses bad amounts with 01", ["FUN_BI_30"], _number(3, 1, (3, 4))),
    _answers("address-as-04", "refuses missing addresses with 04", ["FUN_BI_34"], _number(2, 4, (3, 4))),
    _answers("coil-amount", "refuses bad amounts of coils with 02", ["FUN_BI_10"], _number(3, 2, (1, 2))),
    _answers("any-coil-value", "takes any value for a coil", ["FUN_BI_50"], _any_coil_value),
    _answers("writes-bad", "refuses a bad byte count, and writes", ["FUN_BI_71"], _writes_bad),
    _answers(
        "byte-count",
        "byte count of FC 3 is the number of registers",
        ["FUN_BV_30"],
        rewritten(3, lambda asked, said: said[:1] + bytes((said[1] // 2,)) + said[2:]),
    ),
    _answers("byte-count-4", "FC 4 lacks its last byte", ["FUN_BV_40"], rewritten(4, lambda asked, said: said[:-1])),
    _answers("bit-bytes", "FC 1 sends a byte more for whole bytes", ["FUN_BV_10"], rewritten(1, _byte_more)),
    _answers("bit-bytes-2", "FC 2 sends a byte more for whole bytes", ["FUN_BV_20"], rewritten(2, _byte_more)),
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
    _answers("bit-order", "FC 1 sends the highest bit first", ["CON_BV_24", "CON_BV_05"], rewritten(1, _mirrored)),
    _answers("padding", "unused bits are 1", ["CON_BV_24"], rewritten(1, padded)),
    _answers("echo-5", "FC 5 answers with 0000h", ["CON_BV_05"], rewritten(5, lambda asked, said: said[:3] + b"\0\0")),
    _answers("echo-6", "FC 6 answers with its own value", ["CON_BV_06"], rewritten(6, lambda asked, said: said[:3] + b"\x12\x34")),
    _answers(
        "echo-15", "FC 15 answers with an amount more", ["CON_BV_15"], rewritten(15, lambda asked, said: said[:4] + bytes((said[4] + 1,)))
    ),
    _answers("echo-16", "FC 16 answers with address 0", ["CON_BV_16"], rewritten(16, lambda asked, said: said[:3] + b"\0\0")),
    _answers("echo-22", "FC 22 answers without its masks", ["CON_BV_22"], rewritten(22, lambda asked, said: said[:3] + bytes(4))),
    _answers("mask", "FC 22 sets all bits of the or-mask", ["CON_BV_22"], _mask_or),
    ("reads-first", "FC 23 reads before it writes", ("CON_BV_23",), lambda rtu: ReadsFirst(rtu, _reads_first)),
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
    _tables("shifted", "longer reads begin one register behind", ["CON_BV_16", "CON_BV_17"], Shifted),
    _tables("cut", "register numbers of five bits", ["CON_BV_19"], Cut),
    _tables("one-register-table", "input registers are the holding registers", ["CON_BV_30"], OneRegisterTable),
    _tables("one-bit-table", "discrete inputs are the coils", ["CON_BV_31"], OneBitTable),
    _tables("sticky", "a coil stays on", ["CON_BV_05"], Sticky),
    _tables("fifteen-bits", "registers of fifteen bits", ["CON_BV_06"], SevenBits),
    _tables("each-25th", "each 25th write is lost", ["CON_ST_01", "CON_BV_16", "CON_BV_17"], EveryTenth),
    _tables("nowhere", "acknowledges writes to what is not there", ["EFF_BI_02", "EFF_BI_04"], Nowhere),
    _tables("low-byte", "writes to the low byte of an address", ["EFF_BI_02", "EFF_BI_04"], LowByte),
    _tables("as-far-as", "a refused range is written up to the end", ["EFF_BI_11"], AsFarAsThereIs),
    _tables("as-far-as-coils", "a refused range of coils is written up to the end", ["EFF_BI_10"], AsFarAsCoilsGo),
    _tables("ninety-registers", "the rest of a long write is lost", ["EFF_BV_01", "CON_BV_16"], Most),
    _answers("writes-unread", "FC 23 writes though its reading part is missing", ["EFF_BI_20"], _writes_unread),
    _answers("reads-126", "FC 23 serves 126 registers", ["EFF_BI_22"], _reads_126),
    _answers("after-refusals", "fails after a hundred refusals", ["RC_02", "RC_03"], _after_refusals),
    ("dead-after-power", "does not work after a power failure", ("SUP_RC_01",), lambda rtu: Powered(lambda: Device(rtu), False)),
    _answers("each-70th", "each 70th request is refused with 06", ["ST_01"], _each_70th),
)


def mutants(prefix: str, rtu: bool, more: Sequence[Row], without: Sequence[str] = ()) -> tuple[Mutant, ...]:
    """Of both kinds of framing."""
    area = "RTU" if rtu else "TCP"

    def full(name: str) -> str:
        return f"{prefix}_{name}" if name.count("_") > 1 else f"{prefix}_{area}_{name}"

    def maker(make: Callable[[bool], object]) -> Maker:
        return lambda: make(rtu)

    rows = [row for row in (*ROWS, *more) if row[0] not in without]
    return tuple(Mutant(name, what, tuple(map(full, expects)), maker(make), {}, {}) for name, what, expects, make in rows)


class ReadOnly(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return ExceptionCode.ILLEGAL_DATA_ADDRESS

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return ExceptionCode.ILLEGAL_DATA_ADDRESS


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
        one("powered", "its supply can be switched", lambda: Powered(lambda: Device(rtu))),
        one("any-unit", "answers for any unit" if not rtu else "one more of the usual", lambda: Device(rtu, any_unit=not rtu)),
        one(
            "mapped",
            "input registers show the holding registers, as declared in its PICS",
            lambda: Device(rtu, tables=OneRegisterTable()),
            mapped=True,
        ),
    )
