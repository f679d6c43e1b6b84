"""3964R, the station receives: connection, block check, data, lengths, blocks that end otherwise (serial-protocols 1.2, 1.4, 6).

Blocks begin with 55h, never with 00 or FF: to an RK512 station they are not telegrams and change nothing.
"""

from gateway.conformance.suites.line import BETWEEN, DLE, NAK, LineTester, named
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable, Warn
from protocols.base.machine import ms
from protocols.p3964r.characters import Char, check_of, wire_block

CONNECT, BLOCK, DOUBLED = "3964R_RCV_BV_01", "3964R_RCV_BV_02", "3964R_RCV_BV_03"
RCV = Purposes[LineTester]("3964R_RCV", "receiver", "serial-protocols 1.4", preamble=(CONNECT, BLOCK))
CHECK = ("block_check",)
REFUSES, GAP = "3964R_RCV_BI_01", "3964R_RCV_TI_01"
BAD = (CONNECT, BLOCK, REFUSES)
PAYLOAD = b"UVW"


def text(size: int) -> bytes:
    """Data without control characters, of that length."""
    return (b"U" + bytes(range(0x20, 0x7F)) * (size // 95 + 1))[:size]


# ---- valid behaviour
def _echoes(t: LineTester) -> bool:
    """Three different characters in idle came back at once."""
    for char in (b"U", NAK, b"V"):
        t.say(char)
        came_back = t.answer(6 * t.wire.char_ns + ms(5)) == char[0]
        t.settle(t.profile.char_delay + BETWEEN)
        if not came_back:
            return False
    return True


@RCV.case(
    "BV_01",
    "each STX in idle is answered with DLE within QVZ",
    "jedes STX in Ruhe wird innerhalb QVZ mit DLE beantwortet",
    requirements=("RHO-SER-01",),
    preamble=(),
    beside=Particulars(limits="QVZ of the profile + 20 ms + one character", postamble=False),
)
def connection(t: LineTester) -> None:
    if _echoes(t):
        raise Fail("each character is returned: an echo, or a short circuit between wires", "DLE (10h) after STX", "what was sent")
    refusals = list[int]()
    for _ in range(3):  # one that answers each second STX only is found here
        refusals.append(t.open())
        t.say(wire_block(t.harmless, t.profile.block_check))
        t.answer(t.profile.ack_delay)
        t.settle(BETWEEN)
    if all(refusals):  # one without a free buffer has it before the first block
        raise Fail("each STX is answered with NAK at first, and with DLE only when it is repeated", named(Char.DLE), named(Char.NAK))


@RCV.case(
    "BV_02",
    "a good block is acknowledged with DLE",
    "ein guter Block wird mit DLE quittiert",
    requirements=("RHO-SER-04",),
    preamble=(CONNECT,),
)
def good_block(t: LineTester) -> None:
    t.good_once(PAYLOAD, "a good block")  # one that sends DLE twice has this FAIL only


@RCV.case(
    "BV_03",
    "a doubled DLE is one character and enters the check twice",
    "ein verdoppeltes DLE ist ein Zeichen und geht zweimal in die Blockprüfung ein",
    clause="serial-protocols 1.2",
    requirements=("RHO-SER-03", "RHO-SER-04"),
)
def doubled(t: LineTester) -> None:
    for data in (b"U\x10V", b"\x10UV", b"UV\x10", b"U\x10\x10\x10V"):
        t.good(data, f"a block with the data {data.hex(' ')}")


def _check_is(number: int, value: int) -> None:
    @RCV.case(
        f"BV_{number:02}",
        f"a block check of {value:02X}h is sent once and read as it is",
        f"eine Blockprüfung {value:02X}h steht einmal und wird gelesen, wie sie ist",
        clause="serial-protocols 1.2",
        requirements=("RHO-SER-04",),
        condition=CHECK,
    )
    def body(t: LineTester) -> None:
        t.good(b"U" + bytes((value ^ check_of(b"U\x10\x03"),)), f"a block whose check is {value:02X}h")


for _number, _value in enumerate((0x10, 0x15, 0x02, 0x03, 0x00, 0xFF), 4):
    _check_is(_number, _value)


def _as_data(number: int, value: int) -> None:
    @RCV.case(f"BV_{number:02}", f"{value:02X}h inside a block is data", f"{value:02X}h im Block ist Nutzinformation")
    def body(t: LineTester) -> None:
        for data in (b"UXYZ" + bytes((value, value)) + b"W", bytes((value,)) + b"U", b"U" + bytes((value,))):
            t.good_once(data, f"a block with {value:02X}h in its data ({data.hex(' ')})")


for _number, _value in enumerate((0x02, 0x15, 0x03, 0x17), 10):
    _as_data(_number, _value)


def _length(number: int, size: int | None) -> None:
    words = "the longest block of the profile" if size is None else f"a block of {size} characters"
    german = "der längste Block des Profils" if size is None else f"ein Block von {size} Zeichen"

    @RCV.case(f"BV_{number}", f"{words} is acknowledged", f"{german} wird quittiert", requirements=("RHO-SER-05",))
    def body(t: LineTester) -> None:
        most = _most(t)
        if size is not None and size > most:
            raise NotApplicable(f"the station accepts {most} characters")
        t.good(text(most if size is None else size), words)


def _most(t: LineTester) -> int:
    stated = t.setup.pics.get("most_received")
    return stated if isinstance(stated, int) and not isinstance(stated, bool) else t.profile.most_received


for _number, _size in ((14, 1), (15, 64), (16, 128), (17, None)):
    _length(_number, _size)


@RCV.case("BV_18", "64 times 10h, every one doubled", "64-mal 10h, jedes verdoppelt", requirements=("RHO-SER-03",))
def all_dle(t: LineTester) -> None:
    t.good(DLE * 64, "a block of 64 times 10h")


@RCV.case("BV_19", "every value of a character passes", "jeder Wert eines Zeichens kommt durch", preamble=(CONNECT, BLOCK, DOUBLED))
def every_value(t: LineTester) -> None:
    for start in range(0, 256, 64):
        t.good_once(b"U" + bytes(range(start, start + 64)), f"a block with {start:02X}h to {start + 63:02X}h")
    if not t.setup.pics.get("rk512"):  # to RK512 such blocks are telegrams
        for first in (0x00, 0xFF):
            t.good(bytes((first,)) + PAYLOAD, f"a block that begins with {first:02X}h")


@RCV.case(
    "BV_20",
    "10h 03h as data, doubled, does not end the block",
    "10h 03h als Nutzinformation, verdoppelt, beendet den Block nicht",
    requirements=("RHO-SER-03",),
)
def false_end(t: LineTester) -> None:
    t.good_once(b"U\x10\x03X\x10\x17W", "a block that contains 10h 03h and 10h 17h as data")


# ---- capabilities
@RCV.case("CA_01", "DLE ETB ends a block as DLE ETX does", "DLE ETB beendet einen Block wie DLE ETX", clause="serial-protocols 1.1")
def etb(t: LineTester) -> None:
    got = t.block(wire_block(PAYLOAD, t.profile.block_check, Char.ETB), "a block that ends with DLE ETB")
    if got in (Char.NAK, None):
        raise Warn("the station does not know DLE ETB, which only process computers send", "DLE (10h)", named(got))
    if got != Char.DLE:
        t.fail("a block that ends with DLE ETB", got, "DLE (10h)")


@RCV.case(
    "CA_02",
    "an empty block: DLE or NAK, and the link stays usable",
    "ein leerer Block: DLE oder NAK, die Kopplung bleibt brauchbar",
    clause="open: not specified by any source",
)
def empty(t: LineTester) -> None:
    got = t.block(wire_block(b"", t.profile.block_check), "an empty block")
    if got not in (Char.DLE, Char.NAK):
        t.fail("an empty block", got, "DLE (10h) or NAK (15h)")
    t.remark(f"answers {named(got)}")


@RCV.case("CA_03", "a block longer than the station takes is refused", "ein zu langer Block wird abgelehnt", requirements=("RHO-SER-05",))
def too_long(t: LineTester) -> None:
    size = _most(t) + 1
    t.connect()
    t.say(wire_block(text(size), t.profile.block_check))
    got = t.answer(t.profile.ack_delay + t.tolerance)
    if got == Char.DLE:
        raise Warn(f"accepts more than the {size - 1} characters of its profile", "NAK (15h)", "DLE (10h)")
    if got != Char.NAK:
        t.fail(f"a block of {size} characters", got, "NAK (15h)")
