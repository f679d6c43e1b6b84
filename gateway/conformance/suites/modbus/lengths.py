"""Modbus, requests whose length is not that of their function: a byte too many, a header that counts wrongly (V1.1b3, 7; TCP guide)."""

import struct
from collections.abc import Callable, Iterator, Mapping

from gateway.conformance.suites.modbus.functions import unchanged
from gateway.conformance.suites.modbus.tester import CROSS, ModbusTester, without_top_bit
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable, Warn
from protocols.modbus.mbap import ANSWER

NEEDS = {1: "write_coils", 3: "write_holding"}
WRITES: Mapping[int, Mapping[int, Callable[[int, int], bytes]]] = {  # table -> function -> the request that writes a value to an address
    1: {
        5: lambda at, value: struct.pack(">BHH", 5, at, 0xFF00 * value),
        15: lambda at, value: struct.pack(">BHHBB", 15, at, 1, 1, value),
    },
    3: {
        6: lambda at, value: struct.pack(">BHH", 6, at, value),
        16: lambda at, value: struct.pack(">BHHBH", 16, at, 1, 2, value),
        22: lambda at, value: struct.pack(">BHHH", 22, at, 0, value),
        23: lambda at, value: struct.pack(">BHHHHBH", 23, at, 1, at, 1, 2, value),
    },
}
REFUSED = "exception 03h, silence or close"


def _collect(prefix: str) -> Purposes[ModbusTester]:
    p = Purposes[ModbusTester](f"{prefix}_LEN", "server", "V1.1b3, 7", preamble=(f"{prefix}_FUN_BV_01",))
    _longer(p)
    return p


def _longer(p: Purposes[ModbusTester]) -> None:
    """Exception 03h "indicates a fault in the structure of the remainder of a complex request, such as that the implied length is
    incorrect"; the header, or the CRC, counts the byte that is too many."""

    @p.case("BI_01", "a read with a byte too many is not executed", "ein Lesen mit einem Byte zu viel wird nicht ausgeführt", beside=CROSS)
    def reads(t: ModbusTester) -> None:
        others = []
        for function, at in t.setup.base.items():
            got = t.ask(struct.pack(">BHHB", function, at, 1, 0))
            t.reconnect()  # a server that counts by the function has a byte left
            if got and not got[0] & 0x80:
                raise Fail(f"FC {function} with a byte too many was executed", REFUSED, t.words(got))
            if got and got[1] != 3:
                others.append(f"FC {function} with a byte too many: {t.words(got)}")
        if others:
            raise Warn("; ".join(others), "exception 03h", others[0])

    @p.case(
        "BI_02", "a write with a byte too many is not executed", "ein Schreiben mit einem Byte zu viel wird nicht ausgeführt", beside=CROSS
    )
    def writes(t: ModbusTester) -> None:
        for function, table, at, pdu in _writes(t):
            unchanged(t, pdu + b"\0", f"FC {function} with a byte too many", table, at, 1)
            t.reconnect()


def _writes(t: ModbusTester) -> Iterator[tuple[int, int, int, bytes]]:
    """Function, table, address and request of each write that is offered; it would change the present value."""
    found = 0
    for table, touched in ((1, t.setup.coils), (3, t.setup.holding)):
        for function, request in WRITES[table].items():
            if t.setup.pics.get(NEEDS[table]) and t.setup.pics.get(f"fc{function}"):
                found += 1
                with t.given():
                    other = t.read(table, touched[0], 1)[0] ^ (1 if table == 1 else 0x5A5A)
                yield function, table, touched[0], request(touched[0], other)
    if not found:
        raise NotApplicable("nothing may be written")


LEN = _collect("MBTCP")
RTU_LEN = _collect("MBRTU")


# ---- TCP only: the header counts wrongly
def _counted(t: ModbusTester, pdu: bytes, more: int, what: str) -> None:
    """A request whose header counts `more` bytes more than there are; a normal answer is a FAIL."""
    t.quiet()
    frame = t.frame(pdu)
    transaction = int.from_bytes(frame[:2], "big")
    t.send(ANSWER.pack(transaction, 0, len(pdu) + 1 + more, t.setup.unit) + pdu)
    found = t.answer_frame()
    t.reconnect()
    if len(found) >= 8 and not found[7] & 0x80 and not without_top_bit(found[7:]):
        raise Fail(f"{what} was executed: the length of the header does not count", "silence, close or an exception", t.words(found))


def _header(number: int, more: int, summary: str, de: str, what: str) -> None:
    @LEN.case(f"BI_{number:02}", summary, de, clause="TCP guide, 3.1.3")
    def body(t: ModbusTester) -> None:
        function, at = next(iter(t.setup.base.items()), (3, 0))
        _counted(t, struct.pack(">BHH", function, at, 1), more, f"FC {function} {what}")
        if not (t.setup.pics.get("write_holding") and t.setup.pics.get("fc6")):
            return
        at = t.setup.holding[0]
        with t.given():
            before = t.registers(3, at, 1)
        _counted(t, struct.pack(">BHH", 6, at, before[0] ^ 0x5A5A), more, f"FC 6 {what}")
        if (after := t.registers(3, at, 1)) != before:
            raise Fail(f"FC 6 {what} was not answered and had an effect", f"{before[0]:04X}h", f"{after[0]:04X}h")


_header(
    3,
    1,
    "a request whose header counts a byte more than came is not executed",
    "eine Anfrage, deren Kopf ein Byte mehr zählt als kam, wird nicht ausgeführt",
    "before its last byte",
)
_header(
    4,
    -1,
    "a request whose header counts a byte less than it has is not executed",
    "eine Anfrage, deren Kopf ein Byte weniger zählt, als sie hat, wird nicht ausgeführt",
    "cut by its header",
)


@LEN.case(
    "RC_01",
    "after a byte that follows a complete request a new connection is served",
    "nach einem Byte hinter einer ganzen Anfrage wird eine neue Verbindung bedient",
    clause="TCP guide, 4.2.1",
)
def behind(t: ModbusTester) -> None:
    function, at = next(iter(t.setup.base.items()), (3, 0))
    request = struct.pack(">BHH", function, at, 1)
    for byte in (b"\0", b"\xff"):
        t.quiet()
        t.send(t.frame(request) + byte)
        t.answer_frame()  # the request is complete: an answer is right, and so is closing
        t.reconnect()
        got = t.ask(request)
        if not got:
            raise Fail(f"after a request followed by byte {byte.hex().upper()}h nothing is answered", "an answer", t.words(got))
