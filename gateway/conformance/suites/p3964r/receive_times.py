"""3964R, the station receives: the character delay, repeats, recovery, long runs (serial-protocols 1.4, 6)."""

import random

from gateway.conformance.suites.line import LineTester
from gateway.conformance.suites.p3964r.receive import BAD, BLOCK, CHECK, CONNECT, DOUBLED, GAP, PAYLOAD, RCV
from gateway.conformance.suites.p3964r.refusals import with_wrong_check
from gateway.pure.conformance.purpose import Particulars
from protocols.base.machine import ms
from protocols.p3964r.characters import Char, wire_block

__all__ = ["RCV"]  # the registry finds the complete group here

LONG_RUN = 60


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
    "silence after a DLE: NAK when ZVZ is over",
    "Stille hinter einem DLE: NAK nach Ablauf der ZVZ",
    requirements=("RHO-SER-06",),
    beside=ZVZ,
    preamble=(CONNECT, BLOCK, GAP),
)
def gap_in_pair(t: LineTester) -> None:
    t.connect()
    t.say(b"UV\x10")
    t.expect_at(Char.NAK, t.profile.char_delay, "silence after a DLE")


@RCV.case(
    "TI_05",
    "a pause shorter than ZVZ is none; ZVZ starts again at each character",
    "eine Pause kürzer als ZVZ ist keine; ZVZ beginnt mit jedem Zeichen neu",
    requirements=("RHO-SER-06",),
)
def short_gap(t: LineTester) -> None:
    t.connect()
    wire = wire_block(b"UV\x10\x10W", t.profile.block_check)  # a pause before a pair of DLE, inside it and after it
    for part in (wire[:2], wire[2:3], wire[3:4]):
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
        t.refused(with_wrong_check(PAYLOAD, 0x21) if t.profile.block_check else b"U\x10AV\x10\x03", "a bad block")


@RCV.case(
    "RC_01",
    "seven bad blocks in a row, each NAK, then a good one",
    "sieben schlechte Blöcke hintereinander, jeder NAK, dann ein guter",
    preamble=BAD,
)
def seven_bad(t: LineTester) -> None:
    for count in range(7):
        t.refused(with_wrong_check(PAYLOAD, 0x21) if t.profile.block_check else b"U\x10AV\x10\x03", f"bad block {count + 1}")
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
        after = f"one that broke off after {part.hex(' ') or 'DLE'}"
        t.open()  # judged: finds a station that ignores STX for a while
        t.say(wire_block(PAYLOAD, t.profile.block_check))
        t.expect(Char.DLE, t.profile.ack_delay, f"a good block after {after}")


@RCV.case("RC_03", "garbage on an idle line does not lock the station", "Unsinn auf ruhender Leitung sperrt den Teilnehmer nicht")
def garbage(t: LineTester) -> None:
    noise = bytes(random.Random(t.setup.seed).choices([byte for byte in range(256) if byte not in (2, 16)], k=64))
    t.say(noise)
    t.settle()
    t.good(PAYLOAD, "a good block after 64 characters of garbage")


@RCV.case(
    "ST_01",
    f"{LONG_RUN} blocks without a pause are all acknowledged",
    f"{LONG_RUN} Blöcke ohne Pause werden alle quittiert",
    preamble=(CONNECT, BLOCK, DOUBLED),
)
def long_run(t: LineTester) -> None:
    chosen = random.Random(t.setup.seed)
    with t.each_stx():
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
    with t.each_stx():
        for count in range(12):
            if count % 3 == 1:
                t.refused(with_wrong_check(PAYLOAD, 1 << count % 8), f"bad block {count + 1}")
            else:
                t.good(PAYLOAD, f"good block {count + 1}")
