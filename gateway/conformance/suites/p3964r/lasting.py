"""3964R, after-effects of an earlier step: times of later repeats, attempts after a conflict; long blocks (serial-protocols 1.2 to 1.6)."""

from gateway.conformance.suites.line import BETWEEN, DLE, NAK, STX, Block, LineTester, named
from gateway.conformance.suites.p3964r.conflicts import gives_way
from gateway.conformance.suites.p3964r.failures import refused_to_the_end
from gateway.conformance.suites.p3964r.receive import BLOCK, CHECK, CONNECT, REFUSES, text
from gateway.conformance.suites.p3964r.refusals import with_wrong_check
from gateway.conformance.suites.p3964r.repeats import FORM, YIELDS
from gateway.conformance.suites.p3964r.send import FIRST, GAP, REACTS, REPEATS, SILENCE, attempts, judge_count, same_block, sent_once
from gateway.conformance.suites.rk512.telegrams import fetch
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable
from protocols.base.machine import ms
from protocols.p3964r.characters import Char, wire_block

RCV = Purposes[LineTester]("3964R_RCV", "receiver", "serial-protocols 1.2", preamble=(CONNECT, BLOCK, REFUSES))
SND = Purposes[LineTester]("3964R_SND", "sender", "serial-protocols 1.3", condition=("sends",), preamble=(FIRST, FORM, REPEATS))
CON = Purposes[LineTester]("3964R_CON", "both", "serial-protocols 1.6", condition=("sends",), preamble=(CONNECT, BLOCK, FIRST))
QVZ = Particulars(limits="QVZ of the profile, 20 ms and one character to either side")


@RCV.case(
    "BI_11",
    "a wrong check, and a wrong character, of a block of 128 characters is refused",
    "eine falsche Blockprüfung und ein falsches Zeichen in einem Block von 128 Zeichen werden abgelehnt",
    requirements=("RHO-SER-09",),
    condition=CHECK,
    preamble=(CONNECT, BLOCK, REFUSES, "3964R_RCV_BV_16"),
)
def long_block(t: LineTester) -> None:
    wire = wire_block(text(128))
    for bit in range(8):
        t.refused(with_wrong_check(text(128), 1 << bit), f"a block of 128 characters whose check has bit {bit} wrong")
    for at in (0, 63, 127):
        broken = wire[:at] + bytes((wire[at] ^ 0x08,)) + wire[at + 1 :]
        t.refused(broken, f"a block of 128 characters whose character {at + 1} is wrong")


# ---- the station sends
@SND.case(
    "TI_06",
    "each repeat of a block waits QVZ for its acknowledgement, the last one as well",
    "jede Wiederholung eines Blocks wartet QVZ auf ihre Quittung, auch die letzte",
    requirements=("RHO-SER-08",),
    preamble=(FIRST, SILENCE, "3964R_SND_TI_03", "3964R_SND_BI_09"),
    beside=QVZ,
)
def each_acknowledgement(t: LineTester) -> None:
    """Refused with NAK, so that no connection attempt is used up; then silence after the repeat."""
    if t.profile.silence_ends or t.profile.block_attempts < 2:
        raise NotApplicable("this profile does not repeat a block that is not answered")
    due = t.profile.ack_delay + t.profile.retry_pause
    for turn in (2, t.profile.block_attempts - 1):
        t.starts_sending()
        _refused_until(t, turn)
        t.expect_at(Char.STX, due, f"block {turn} of {t.profile.block_attempts} and silence")
        t.take()
        t.settle()
    if t.profile.nak_when_giving_up:
        t.starts_sending()
        _refused_until(t, t.profile.block_attempts)
        t.expect_at(Char.NAK, t.profile.ack_delay, f"block {t.profile.block_attempts}, the last one, and silence")


def _refused_until(t: LineTester, turn: int) -> None:
    """Refuse its block so many times; do not answer the last one."""
    for count in range(turn):
        t.take(acknowledge=False)
        if count + 1 < turn:
            t.say(NAK)
            with t.given():
                t.expect(Char.STX, t.profile.retry_pause + GAP, "NAK after the block")


@SND.case(
    "BI_11",
    "a block after a repeated STX is the whole block: its repeat is the same",
    "ein Block nach wiederholtem STX ist der ganze Block: seine Wiederholung ist dieselbe",
    requirements=("RHO-SER-02", "RHO-SER-07"),
    preamble=(FIRST, FORM, SILENCE, REPEATS, "3964R_SND_BI_02"),
)
def whole_after_stx(t: LineTester) -> None:
    if attempts(t) < 3:
        raise NotApplicable(f"this profile has {attempts(t)} connection attempts")
    t.starts_sending()
    t.say(NAK)
    with t.given():
        t.expect(Char.STX, t.profile.retry_pause + GAP, "NAK to STX")
    first = t.take(acknowledge=False)
    t.say(NAK)
    with t.given():
        t.expect(Char.STX, t.profile.retry_pause + GAP, "NAK after the block")
    same_block(t, first)


@SND.case(
    "BO_04",
    "NAK after its acknowledged block brings nothing",
    "NAK nach seinem quittierten Block bewirkt nichts",
    preamble=(FIRST, "3964R_SND_BV_03", "3964R_RCV_BO_02"),
)
def nak_behind(t: LineTester) -> None:
    def taken() -> Block:
        t.starts_sending()
        block = t.take()
        t.say(NAK)
        return block

    sent_once(t, taken, t.tolerance + ms(150), "an acknowledged block followed by NAK")


@REACTS.case(
    "TI_07",
    "a long reaction waits QVZ for its acknowledgement from its last character on",
    "eine lange Reaktion wartet QVZ auf ihre Quittung, ab ihrem letzten Zeichen",
    clause="serial-protocols 1.3",
    requirements=("RHO-SER-08",),
    preamble=(CONNECT, BLOCK, "3964R_SND_BV_06", "3964R_SND_TI_03"),
    beside=QVZ,
)
def from_its_end(t: LineTester) -> None:
    """A short block does not show from where the wait runs."""
    if t.profile.silence_ends or t.profile.block_attempts < 2:
        raise NotApplicable("this profile does not repeat a block that is not answered")
    with t.given():
        t.good(fetch(t.setup.db, 0, min(t.setup.words, t.setup.job)), "a command telegram")
        t.first_stx(t.setup.reaction_wait)
    block = t.take(acknowledge=False)
    if len(block.raw) * t.wire.char_ns < 3 * t.tolerance:
        t.say(DLE)
        raise NotApplicable(f"its block of {len(block.raw)} characters takes no longer than the tolerance")
    t.expect_at(Char.STX, t.profile.ack_delay + t.profile.retry_pause, f"a block of {len(block.raw)} characters and silence")
    t.take()


@SND.case(
    "RC_04",
    "a job that waits is sent after the one before was given up",
    "ein wartender Auftrag wird gesendet, nachdem der vor ihm aufgegeben wurde",
    preamble=(FIRST, SILENCE, "3964R_SND_RC_01"),
)
def waits_behind(t: LineTester) -> None:
    assert t.setup.stimulus is not None
    if not t.setup.stimulus_name.startswith("stimulate()") or not t.profile.nak_when_giving_up:
        raise NotApplicable("it cannot be given two jobs at once")
    wait = t.profile.char_delay + t.profile.ack_delay + ms(500)
    t.setup.stimulus(t)
    t.starts_sending()
    t.take()
    if t.answer(wait) != Char.STX:
        raise NotApplicable("two jobs at once are not kept, or the second one waits for more than the acknowledgement")
    t.take()
    with t.given():
        if t.answers_jobs():  # it may keep one job at a time, and wait for this reaction
            t.settle(BETWEEN)
        t.settle()
    t.unanswered = b""  # else the first of the two jobs would be served before the second is queued
    t.setup.stimulus(t)
    t.starts_sending()
    refused_to_the_end(t)
    got = t.answer(wait)
    if got != Char.STX:
        raise Fail(f"after it gave up a job, the one that waited must be sent: {named(got)}, it is lost", "STX (02h)", named(got))
    t.take()


# ---- both send STX
@CON.case(
    "TI_01",
    "with priority: our STX does not prolong its QVZ",
    "mit Priorität: unser STX verlängert seine QVZ nicht",
    requirements=("RHO-SER-10",),
    preamble=(CONNECT, BLOCK, FIRST, "3964R_CON_BV_01", "3964R_SND_TI_01"),
    beside=QVZ,
)
def keeps_waiting(t: LineTester) -> None:
    if t.profile.silence_ends:
        raise NotApplicable("this profile gives up after one silence")
    t.starts_sending()
    start = t.mark
    if t.answer(t.profile.ack_delay * 4 // 10) is not None:
        raise NotApplicable("it does not wait for DLE")
    t.mark = t.wire.now()
    t.say(STX)
    got = t.answer(t.profile.ack_delay + t.profile.retry_pause + ms(500))
    if got == Char.DLE:
        t.say(wire_block(t.harmless, t.profile.block_check))
        t.settle()
        raise NotApplicable("it has no priority and gives way")
    due = t.profile.ack_delay + t.profile.retry_pause
    if got != Char.STX:
        t.fail("both sent STX", got, f"STX (02h) {due / 1e6:.0f} ms after its first one")
    t.timed("STX (02h) after its own STX, that of the tester and silence", t.mark - start, due - t.tolerance, due + t.tolerance)
    t.take()


@CON.case(
    "RC_01",
    "a job that gave way has all its attempts",
    "ein zurückgestellter Auftrag hat alle seine Versuche",
    requirements=("RHO-SER-02", "RHO-SER-10"),
    preamble=(CONNECT, BLOCK, FIRST, SILENCE, YIELDS, "3964R_SND_BI_02"),
)
def all_attempts(t: LineTester) -> None:
    gives_way(t)
    t.say(wire_block(t.harmless, t.profile.block_check))
    with t.given():
        t.expect(Char.DLE, t.profile.ack_delay, "our block in a conflict")
        t.first_stx(t.profile.char_delay + t.profile.ack_delay + ms(500))
    count = 1
    t.say(NAK)
    while t.awaited(t.profile.retry_pause + GAP) == Char.STX and count < attempts(t) + 3:
        count += 1
        t.say(NAK)
    judge_count(t, "connection attempts of a job that gave way", count, attempts(t))
