"""3964R, the station receives: connection, block check, data, gaps, damage, repeats (serial-protocols 1.2, 1.4, 6).

Blocks begin with 55h, never with 00 or FF: to an RK512 station they are no telegrams and change nothing.
"""

import random

from gateway.conformance.suites.line import BETWEEN, DLE, NAK, STX, LineTester, named
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Disturbed, Fail, NotApplicable, Warn
from protocols.base.machine import Damage, ms
from protocols.p3964r.characters import Char, check_of, wire_block
from protocols.p3964r.profiles import BrokenPair, Stray

CONNECT, BLOCK = "3964R_RCV_BV_01", "3964R_RCV_BV_02"
RCV = Purposes[LineTester]("3964R_RCV", "receiver", "serial-protocols 1.4", preamble=(CONNECT, BLOCK))
CHECK = ("block_check",)
REFUSES, GAP = "3964R_RCV_BI_01", "3964R_RCV_TI_01"
BAD = (CONNECT, BLOCK, REFUSES)
PAYLOAD = b"UVW"
LONG_RUN = 60


def text(size: int) -> bytes:
    """Data without control characters, of that length."""
    return (b"U" + bytes(range(0x20, 0x7F)) * (size // 95 + 1))[:size]


# ---- valid behaviour
@RCV.case(
    "BV_01",
    "each STX in idle is answered with DLE within QVZ",
    "jedes STX in Ruhe wird innerhalb QVZ mit DLE beantwortet",
    requirements=("RHO-SER-01",),
    preamble=(),
    beside=Particulars(limits="QVZ of the profile + 20 ms + one character", postamble=False),
)
def connection(t: LineTester) -> None:
    for _ in range(3):  # one that answers each second STX only is found here
        t.open()
        t.say(wire_block(t.harmless, t.profile.block_check))
        t.answer(t.profile.ack_delay)
        t.settle(BETWEEN)


@RCV.case(
    "BV_02",
    "a good block is acknowledged with DLE",
    "ein guter Block wird mit DLE quittiert",
    requirements=("RHO-SER-04",),
    preamble=(CONNECT,),
)
def good_block(t: LineTester) -> None:
    t.good(PAYLOAD)


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
        for data in (b"U" + bytes((value, value)) + b"V", bytes((value,)) + b"U", b"U" + bytes((value,))):
            t.good(data, f"a block with {value:02X}h in its data ({data.hex(' ')})")


for _number, _value in enumerate((0x02, 0x15, 0x03, 0x17), 10):
    _as_data(_number, _value)


def _length(number: int, size: int | None) -> None:
    words = "the longest block of the profile" if size is None else f"a block of {size} characters"
    german = "der längste Block des Profils" if size is None else f"ein Block von {size} Zeichen"

    @RCV.case(f"BV_{number}", f"{words} is acknowledged", f"{german} wird quittiert", requirements=("RHO-SER-05",))
    def body(t: LineTester) -> None:
        most = _most(t)
        if size is not None and size > most:
            raise NotApplicable(f"the station takes {most} characters")
        t.good(text(most if size is None else size), words)


def _most(t: LineTester) -> int:
    stated = t.setup.pics.get("most_received")
    return stated if isinstance(stated, int) and not isinstance(stated, bool) else t.profile.most_received


for _number, _size in ((14, 1), (15, 64), (16, 128), (17, None)):
    _length(_number, _size)


@RCV.case("BV_18", "64 times 10h, every one doubled", "64-mal 10h, jedes verdoppelt", requirements=("RHO-SER-03",))
def all_dle(t: LineTester) -> None:
    t.good(DLE * 64, "a block of 64 times 10h")


@RCV.case("BV_19", "every value of a character passes", "jeder Wert eines Zeichens kommt durch")
def every_value(t: LineTester) -> None:
    for start in range(0, 256, 64):
        t.good(b"U" + bytes(range(start, start + 64)), f"a block with {start:02X}h to {start + 63:02X}h")


@RCV.case(
    "BV_20",
    "10h 03h as data, doubled, does not end the block",
    "10h 03h als Nutzinformation, verdoppelt, beendet den Block nicht",
    requirements=("RHO-SER-03",),
)
def false_end(t: LineTester) -> None:
    t.good(b"U\x10\x03V\x10\x17W", "a block that holds 10h 03h and 10h 17h as data")


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
        raise Warn(f"takes more than the {size - 1} characters of its profile", "NAK (15h)", "DLE (10h)")
    if got != Char.NAK:
        t.fail(f"a block of {size} characters", got, "NAK (15h)")


# ---- invalid behaviour
def _wrong(data: bytes, change: int) -> bytes:
    wire = wire_block(data)
    return wire[:-1] + bytes((wire[-1] ^ change,))


@RCV.case(
    "BI_01",
    "each wrong bit of the block check is refused with NAK",
    "jedes falsche Bit der Blockprüfung wird mit NAK abgelehnt",
    clause="serial-protocols 1.2",
    requirements=("RHO-SER-09",),
    condition=CHECK,
)
def wrong_check(t: LineTester) -> None:
    for bit in range(8):
        t.refused(_wrong(PAYLOAD, 1 << bit), f"a block check with bit {bit} wrong")


@RCV.case(
    "BI_02",
    "a check that counts a doubled DLE once is refused",
    "eine Blockprüfung, in die ein verdoppeltes DLE einmal eingeht, wird abgelehnt",
    clause="serial-protocols 1.2",
    requirements=("RHO-SER-09",),
    condition=CHECK,
    preamble=BAD,
)
def check_once(t: LineTester) -> None:
    t.refused(_wrong(b"U\x10V", 0x10), "a check that counts a doubled DLE once")


@RCV.case(
    "BI_03",
    "a check that is the complement, or zero, is refused",
    "eine Blockprüfung als Komplement oder null wird abgelehnt",
    clause="serial-protocols 1.2",
    requirements=("RHO-SER-09",),
    condition=CHECK,
    preamble=BAD,
)
def complement(t: LineTester) -> None:
    t.refused(_wrong(PAYLOAD, 0xFF), "a complemented check")
    t.refused(wire_block(PAYLOAD)[:-1] + b"\x00", "a check of 00h")


@RCV.case(
    "BI_04",
    "each single wrong character of a block is refused",
    "jedes einzelne falsche Zeichen eines Blocks wird abgelehnt",
    requirements=("RHO-SER-09",),
    condition=CHECK,
    preamble=BAD,
)
def each_character(t: LineTester) -> None:
    data = b"UABCDEFGHI"
    wire = wire_block(data)
    for at in range(len(data)):
        broken = wire[:at] + bytes((wire[at] ^ 0x20,)) + wire[at + 1 :]
        t.refused(broken, f"a block whose character {at + 1} is wrong")


@RCV.case(
    "BI_05",
    "a character too few or too many is refused",
    "ein fehlendes oder überzähliges Zeichen wird abgelehnt",
    requirements=("RHO-SER-09",),
    condition=CHECK,
    preamble=BAD,
)
def lost_character(t: LineTester) -> None:
    wire = wire_block(b"UABCD")
    t.refused(wire[:2] + wire[3:], "a block that lost a character")
    t.refused(wire[:2] + b"Z" + wire[2:], "a block with a character more")


@RCV.case(
    "BI_06",
    "DLE followed by neither DLE nor ETX: one NAK, nothing delivered",
    "auf DLE folgt weder DLE noch ETX: ein NAK, nichts wird übergeben",
    preamble=BAD,
)
def broken_pair(t: LineTester) -> None:
    body = b"U\x10AV\x10\x03"
    wire = body + (bytes((check_of(body),)) if t.profile.block_check else b"")
    got = t.block(wire, "a block with a DLE that is not doubled")
    if got == Char.DLE:
        if t.profile.broken_pair is BrokenPair.DROP_DLE:
            return
        t.fail("a block with a DLE that is not doubled", got, "NAK (15h)")
    if got != Char.NAK:
        t.fail("a block with a DLE that is not doubled", got, "NAK (15h)")


@RCV.case(
    "BI_07",
    "the rest of a refused block is no connection",
    "der Rest eines abgelehnten Blocks ist kein Verbindungsaufbau",
    clause="serial-protocols 1.4: noted, heard to the end",
    preamble=BAD,
)
def rest(t: LineTester) -> None:
    body = b"U\x10A\x02V\x02W\x10\x03"
    t.connect()
    t.say(body + (bytes((check_of(body) ^ 0x01,)) if t.profile.block_check else b""))
    got = [t.answer(t.profile.ack_delay)]
    while (more := t.answer(t.profile.char_delay + t.tolerance)) is not None:
        got.append(more)
    if Char.DLE in got:
        raise Fail("a 02h in the rest of a refused block was answered with DLE", "one NAK (15h)", ", ".join(map(named, got)))
    if Char.NAK not in got:
        raise Fail("a refused block was not answered", "one NAK (15h)", ", ".join(map(named, got)))


@RCV.case(
    "BI_08",
    "a parity error in the data: heard to the end, NAK",
    "ein Paritätsfehler in den Daten: bis zum Ende gehört, NAK",
    requirements=("RHO-SER-09",),
    preamble=BAD,
)
def parity(t: LineTester) -> None:
    wire = wire_block(PAYLOAD, t.profile.block_check)
    t.connect()
    t.say(wire[:1])
    t.spoil()
    t.say(wire[1:])
    t.expect(Char.NAK, t.profile.ack_delay, "a block with a damaged character")


@RCV.case(
    "BI_09",
    "a parity error in the block check: NAK",
    "ein Paritätsfehler in der Blockprüfung: NAK",
    condition=CHECK,
    requirements=("RHO-SER-09",),
    preamble=BAD,
)
def parity_in_check(t: LineTester) -> None:
    t.connect()
    t.say(wire_block(PAYLOAD)[:-1])
    t.spoil()
    t.expect(Char.NAK, t.profile.ack_delay, "a damaged block check")


@RCV.case("BI_10", "BREAK inside a block: left without an answer", "BREAK im Block: ohne Antwort verlassen")
def break_inside(t: LineTester) -> None:
    t.connect()
    t.say(b"UV")
    t.spoil(Damage.BREAK)
    got = t.answer(t.profile.char_delay + t.tolerance)
    if got == Char.NAK:
        raise Warn("answers a BREAK inside a block with NAK; the manual has no answer", "nothing", "NAK (15h)")
    if got is not None and got != Char.STX:
        t.fail("BREAK inside a block", got, "nothing")


# ---- inopportune behaviour
def stray_answer(t: LineTester, after: str) -> None:
    """What may be answered to a character in idle: the profile's own, or what another maker does (WARN)."""
    start = t.mark
    got = t.answer(t.profile.char_delay + t.tolerance + ms(200))
    if got == Char.STX:
        t.serve()
        raise Disturbed(f"the station began to send after {after}", "nothing", named(got))
    if got not in (None, Char.NAK):
        t.fail(after, got, "nothing, or NAK (15h)")
    if got == Char.NAK:
        t.timed(f"NAK after {after}", t.mark - start, None, None)
    wanted = t.profile.stray is not Stray.SILENT
    if (got is not None) is not wanted:
        what = "NAK (15h)" if wanted else "nothing"
        raise Warn(f"after {after}: {named(got)}; its profile has {what}, other makers differ", what, named(got))


@RCV.case(
    "BO_01",
    "a stray character in idle opens nothing",
    "ein Irrläufer in Ruhe öffnet nichts",
    clause="serial-protocols 1.4: disputed",
    preamble=(CONNECT,),
)
def stray(t: LineTester) -> None:
    t.say(b"U")
    stray_answer(t, "a stray character in idle")


@RCV.case("BO_02", "NAK in idle is never answered", "NAK in Ruhe wird nie beantwortet", preamble=(CONNECT,))
def idle_nak(t: LineTester) -> None:
    t.say(NAK)
    t.silence(t.profile.char_delay + t.tolerance, "NAK in idle")


@RCV.case("BO_03", "BREAK in idle is not answered", "BREAK in Ruhe wird nicht beantwortet", preamble=(CONNECT,))
def idle_break(t: LineTester) -> None:
    t.spoil(Damage.BREAK)
    t.silence(t.profile.char_delay + t.tolerance, "BREAK in idle")


@RCV.case("BO_04", "DLE in idle acknowledges nothing and opens nothing", "DLE in Ruhe quittiert und öffnet nichts", preamble=(CONNECT,))
def idle_dle(t: LineTester) -> None:
    t.say(DLE)
    stray_answer(t, "DLE in idle")


@RCV.case("BO_05", "DLE ETX in idle is no block", "DLE ETX in Ruhe ist kein Block", preamble=(CONNECT,))
def idle_end(t: LineTester) -> None:
    t.say(b"\x10\x03\x55")
    got = [t.answer(t.profile.char_delay + t.tolerance + ms(200))]
    while (more := t.answer(t.profile.char_delay + t.tolerance)) is not None:
        got.append(more)
    if Char.STX in got:
        raise Disturbed("the station began to send", "nothing", "STX (02h)")
    if Char.DLE in got:
        raise Fail("after DLE ETX in idle: DLE", "nothing, or NAK (15h)", "DLE (10h)")


@RCV.case(
    "BO_06",
    "STX while no buffer is free: NAK after the wait of the profile",
    "STX ohne freien Puffer: NAK nach der Wartezeit des Profils",
    condition=("hold",),
    requirements=("RHO-SER-12",),
    preamble=BAD,
)
def full(t: LineTester) -> None:
    assert t.setup.hold is not None
    t.setup.hold(True)
    try:
        t.say(STX)
        t.expect_at(Char.NAK, t.profile.no_buffer_wait, "STX while the buffer is full")
    finally:
        t.setup.hold(False)


@RCV.case(
    "BO_07",
    "a buffer that becomes free within the wait takes the block",
    "ein Puffer, der in der Wartezeit frei wird, nimmt den Block",
    condition=("hold",),
    requirements=("RHO-SER-12",),
)
def freed(t: LineTester) -> None:
    assert t.setup.hold is not None
    if t.profile.no_buffer_wait < ms(200):
        raise NotApplicable("this profile does not wait for a buffer")
    t.setup.hold(True)
    try:
        t.say(STX)
        got = t.answer(ms(150))
        if got is not None:
            t.fail("STX while the buffer is full", got, "nothing for 150 ms")
    finally:
        t.setup.hold(False)
    t.mark = max(t.mark, t.wire.now())
    t.expect(Char.DLE, t.profile.ack_delay, "the buffer became free")
    t.say(wire_block(PAYLOAD, t.profile.block_check))
    t.expect(Char.DLE, t.profile.ack_delay, "a good block")


# ---- timers
ZVZ = Particulars(limits="ZVZ of the profile, 20 ms and one character to either side")


@RCV.case(
    "TI_01",
    "silence after its DLE: NAK when ZVZ is over",
    "Stille nach seinem DLE: NAK nach Ablauf der ZVZ",
    requirements=("RHO-SER-06",),
    beside=ZVZ,
)
def gap_first(t: LineTester) -> None:
    t.connect()
    t.expect_at(Char.NAK, t.profile.char_delay, "its DLE and silence")


@RCV.case(
    "TI_02",
    "silence inside the data: NAK when ZVZ is over",
    "Stille in den Daten: NAK nach Ablauf der ZVZ",
    requirements=("RHO-SER-06",),
    beside=ZVZ,
    preamble=(CONNECT, BLOCK, GAP),
)
def gap_in_data(t: LineTester) -> None:
    t.connect()
    t.say(b"UV")
    t.expect_at(Char.NAK, t.profile.char_delay, "silence in the data")


@RCV.case(
    "TI_03",
    "silence before the block check: NAK when ZVZ is over",
    "Stille vor der Blockprüfung: NAK nach Ablauf der ZVZ",
    condition=CHECK,
    requirements=("RHO-SER-06",),
    beside=ZVZ,
    preamble=(CONNECT, BLOCK, GAP),
)
def gap_before_check(t: LineTester) -> None:
    t.connect()
    t.say(wire_block(PAYLOAD)[:-1])
    t.expect_at(Char.NAK, t.profile.char_delay, "silence before the block check")


@RCV.case(
    "TI_04",
    "silence behind a DLE: NAK when ZVZ is over",
    "Stille hinter einem DLE: NAK nach Ablauf der ZVZ",
    requirements=("RHO-SER-06",),
    beside=ZVZ,
    preamble=(CONNECT, BLOCK, GAP),
)
def gap_in_pair(t: LineTester) -> None:
    t.connect()
    t.say(b"UV\x10")
    t.expect_at(Char.NAK, t.profile.char_delay, "silence behind a DLE")


@RCV.case(
    "TI_05",
    "a pause shorter than ZVZ is none; ZVZ starts again at each character",
    "eine Pause kürzer als ZVZ ist keine; ZVZ beginnt mit jedem Zeichen neu",
    requirements=("RHO-SER-06",),
)
def short_gap(t: LineTester) -> None:
    t.connect()
    wire = wire_block(PAYLOAD, t.profile.block_check)
    for part in (wire[:1], wire[1:2], wire[2:4]):
        t.say(part)
        got = t.answer(t.profile.char_delay * 8 // 10 - ms(10))
        if got is not None:
            t.fail("a pause of eight tenths of ZVZ", got, "nothing")
        t.mark = t.wire.now()
    t.say(wire[4:])
    t.expect(Char.DLE, t.profile.ack_delay, "a block with short pauses")


@RCV.case(
    "TI_06", "a repeat within the block wait time is taken", "eine Wiederholung innerhalb der Blockwartezeit wird angenommen", preamble=BAD
)
def repeat_in_time(t: LineTester) -> None:
    _bad(t)
    t.silence(min(ms(500), t.profile.block_wait // 2), "its NAK")
    t.good(PAYLOAD, "the repeat within the block wait time")


@RCV.case(
    "TI_07",
    "a block after the block wait time is taken as well",
    "ein Block nach der Blockwartezeit wird ebenfalls angenommen",
    preamble=BAD,
)
def repeat_late(t: LineTester) -> None:
    _bad(t)
    t.silence(t.profile.block_wait + ms(200), "its NAK")
    t.good(PAYLOAD, "a block after the block wait time")


# ---- recovery and stress
def _bad(t: LineTester) -> None:
    with t.given():
        t.refused(_wrong(PAYLOAD, 0x21) if t.profile.block_check else b"U\x10AV\x10\x03", "a bad block")


@RCV.case(
    "RC_01",
    "seven bad blocks in a row, each NAK, then a good one",
    "sieben schlechte Blöcke hintereinander, jeder NAK, dann ein guter",
    preamble=BAD,
)
def seven_bad(t: LineTester) -> None:
    for count in range(7):
        t.refused(_wrong(PAYLOAD, 0x21) if t.profile.block_check else b"U\x10AV\x10\x03", f"bad block {count + 1}")
    t.good(PAYLOAD, "a good block after seven bad ones")


@RCV.case("RC_02", "after a block that broke off the next one is taken", "nach einem abgebrochenen Block wird der nächste angenommen")
def after_gap(t: LineTester) -> None:
    for part in (b"", b"U", b"U\x10", b"U\x10\x03" if t.profile.block_check else b"UV"):
        t.connect()
        if part:
            t.say(part)
        got = t.answer(t.profile.char_delay * 3 + ms(500))
        if got not in (Char.NAK, None):
            t.fail("a block that broke off", got, "NAK (15h)")
        t.good(PAYLOAD, f"a good block after one that broke off behind {part.hex(' ') or 'DLE'}")


@RCV.case("RC_03", "garbage on an idle line does not lock the station", "Unsinn auf ruhender Leitung sperrt den Teilnehmer nicht")
def garbage(t: LineTester) -> None:
    noise = bytes(random.Random(t.setup.seed).choices([byte for byte in range(256) if byte not in (2, 16)], k=64))
    t.say(noise)
    t.settle()
    t.good(PAYLOAD, "a good block after 64 characters of garbage")


@RCV.case("ST_01", f"{LONG_RUN} blocks without a pause are all acknowledged", f"{LONG_RUN} Blöcke ohne Pause werden alle quittiert")
def long_run(t: LineTester) -> None:
    chosen = random.Random(t.setup.seed)
    for count in range(LONG_RUN):
        data = b"U" + bytes(chosen.randrange(256) for _ in range(chosen.randrange(1, 24)))
        t.good(data, f"block {count + 1} ({data.hex(' ')})")
        if count % 5 == 4:
            t.settle(ms(60))  # to RK512 each one was a wrong command, whose reaction waits


@RCV.case(
    "ST_02",
    "good and bad blocks in turn: each answered as it deserves",
    "gute und schlechte Blöcke im Wechsel: jeder richtig beantwortet",
    condition=CHECK,
    preamble=BAD,
)
def in_turn(t: LineTester) -> None:
    for count in range(12):
        if count % 3 == 1:
            t.refused(_wrong(PAYLOAD, 1 << count % 8), f"bad block {count + 1}")
        else:
            t.good(PAYLOAD, f"good block {count + 1}")
