"""3964R, the station sends: form of its block, and the acknowledgement delay (serial-protocols 1.3, 6)."""

from collections.abc import Callable

from gateway.conformance.suites.line import DLE, Block, LineTester, named
from gateway.conformance.suites.p3964r.receive import BLOCK, CONNECT
from gateway.conformance.suites.rk512.forms import judge_forms
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char

FIRST, SILENCE, REPEATS = "3964R_SND_BV_01", "3964R_SND_BI_01", "3964R_SND_BI_06"
SND = Purposes[LineTester]("3964R_SND", "sender", "serial-protocols 1.3", condition=("sends",), preamble=(FIRST,))
REACTS = Purposes[LineTester]("3964R_SND", "sender", "serial-protocols 1.2", condition=("passive",), preamble=(CONNECT, BLOCK))
JUST = ms(40)
BY_ITSELF = ms(10_000)  # one that sends the same block cyclically does so again within this
MOST = 300
GAP = ms(250)  # after an answer of ours within which a repeat begins; retry_pause of the profile is added


def attempts(t: LineTester, silent: bool = False) -> int:
    return 1 if silent and t.profile.silence_ends else t.profile.connect_attempts


def judge_count(t: LineTester, what: str, count: int, expected: int) -> None:
    if count != expected:
        got = f"{count} {what.replace('attempts', 'attempt', 1) if count == 1 else what}"
        raise Fail(f"{got}, expected {expected} ({t.profile.name})", f"{expected} {what}", got)


def gives_up(t: LineTester, got: int | Damage | None) -> None:
    if t.profile.nak_when_giving_up and got != Char.NAK:
        raise Fail(f"after the last attempt: {named(got)}, expected NAK when it gives up", "NAK (15h)", named(got))
    if got == Char.NAK and (more := t.answer(2 * t.wire.char_ns + ms(5))) is not None:
        if more == Char.STX:
            t.serve()  # its next job
        else:
            t.fail("the NAK with which it gives up", more, "nothing: one NAK")
    if not t.profile.nak_when_giving_up and got not in (None, Char.NAK):
        t.fail("the last attempt", got, "nothing")


# ---- valid behaviour
@SND.case(
    "BV_01",
    "it connects with STX, sends after DLE and ends its block",
    "er baut mit STX auf, sendet nach DLE und schließt seinen Block ab",
    requirements=("RHO-SER-01",),
    preamble=(CONNECT,),
    beside=Particulars(postamble=False),
)
def sends(t: LineTester) -> None:
    if t.setup.stimulus is None:
        raise NotApplicable("the bench names no [stimulus]")
    t.setup.stimulus(t)
    t.first_stx(t.setup.stimulus_wait)
    t.say(DLE)
    block = t.read()
    if block is None:
        raise Fail("the block breaks off", "data, DLE ETX" + (" and the block check" if t.profile.block_check else ""), t.last(24))
    t.say(DLE)


@SND.case(
    "BV_02",
    "DLE doubled, block check right, nothing after it",
    "DLE verdoppelt, Blockprüfung richtig, nichts dahinter",
    requirements=("RHO-SER-03", "RHO-SER-04"),
)
def well_formed(t: LineTester) -> None:
    t.starts_sending()
    block = t.take(acknowledge=False)
    extra = t.answer(3 * t.wire.char_ns + ms(5))
    t.say(DLE)
    if block.fault:
        raise Fail(f"the station's block: {block.fault}", "a block by the rule", block.raw.hex(" ").upper())
    if extra is not None:
        t.fail("the end of its block", extra, "nothing until the acknowledgement")
    if not block.data:
        raise Fail("the station's block is empty", "at least one character", block.raw.hex(" ").upper())


@REACTS.case(
    "BV_06",
    "the reactions of an RK512 station are blocks by the rule",
    "die Reaktionen einer RK512-Station sind Blöcke nach der Regel",
    requirements=("RHO-SER-03", "RHO-SER-04"),
)
def reactions(t: LineTester) -> None:
    """Reactions to data other than its own blocks, and to the number 10h, which is doubled."""
    judge_forms(t, "3964R_SND_BV_06")


@SND.case(
    "BV_03",
    "an acknowledged block is not sent again",
    "ein quittierter Block wird nicht noch einmal gesendet",
    requirements=("RHO-SER-07",),
)
def once(t: LineTester) -> None:
    def taken() -> Block:
        t.starts_sending()
        return t.take()

    sent_once(t, taken, t.tolerance + ms(150), "the acknowledged block")


def sent_once(t: LineTester, acknowledged: Callable[[], Block], within: Ns, what: str) -> None:
    """Judge: the job that `acknowledged` made it send and acknowledged does not come again; a station that repeats it on its own is not
    blamed.
    """
    for _ in range(2):
        first = acknowledged()
        got = t.answer(within)
        if got is None and t.answers_jobs():  # RK512: its next command follows the reaction
            got = t.answer(within)
        if got is None:
            return
        if got != Char.STX:
            t.fail(what, got, "nothing")
        if t.serve() != first.data or t.setup.stimulus_name == "periodic":
            return
        t.settle()
    t.mark = t.wire.now()
    if t.answer(BY_ITSELF) == Char.STX:
        t.serve()
        raise NotApplicable("it also sends the same block unprompted")
    raise Fail(f"{what} was sent again at once", "nothing", f"the same block: {first.data.hex(' ').upper()}")


@SND.case(
    "TI_01",
    "no answer to STX: STX again when QVZ is over",
    "keine Antwort auf STX: STX erneut nach Ablauf der QVZ",
    requirements=("RHO-SER-02",),
    beside=Particulars(limits="QVZ of the profile, 20 ms and one character to either side"),
)
def repeats_stx(t: LineTester) -> None:
    if t.profile.silence_ends:
        raise NotApplicable("this profile gives up after one silence")
    t.starts_sending()
    t.expect_at(Char.STX, t.profile.ack_delay + t.profile.retry_pause, "STX and silence")
    t.take()


@SND.case("TI_02", "DLE just before QVZ is over is taken", "DLE kurz vor Ablauf der QVZ wird angenommen", requirements=("RHO-SER-02",))
def just_in_time(t: LineTester) -> None:
    t.starts_sending()
    got = t.answer(t.profile.ack_delay - JUST)
    if got is not None:
        t.fail("STX, before QVZ is over", got, "nothing")
    t.mark = t.wire.now()
    t.say(DLE)
    block = t.read()
    if block is None:
        raise Fail(f"DLE {JUST / 1e6:.0f} ms before the end of QVZ was not accepted", "its block", t.last(8))
    t.say(DLE)


@SND.case(
    "TI_03",
    "no answer to the block: STX again when QVZ is over, the same block",
    "keine Antwort auf den Block: STX nach Ablauf der QVZ, derselbe Block",
    requirements=("RHO-SER-08",),
    beside=Particulars(limits="QVZ of the profile, 20 ms and one character to either side"),
)
def repeats_block(t: LineTester) -> None:
    t.starts_sending()
    first = t.take(acknowledge=False)
    t.expect_at(Char.STX, t.profile.ack_delay + t.profile.retry_pause, "the block and silence")
    same_block(t, first)


@SND.case(
    "TI_05",
    "DLE just before QVZ is over acknowledges the block",
    "DLE kurz vor Ablauf der QVZ quittiert den Block",
    requirements=("RHO-SER-08",),
)
def acknowledged_late(t: LineTester) -> None:
    def taken() -> Block:
        t.starts_sending()
        first = t.take(acknowledge=False)
        got = t.answer(t.profile.ack_delay - JUST)
        if got is not None:
            t.fail("its block, before QVZ is over", got, "nothing")
        t.mark = t.wire.now()
        t.say(DLE)
        return first

    sent_once(t, taken, 3 * t.wire.char_ns + ms(5), f"the block acknowledged {JUST / 1e6:.0f} ms before the end of QVZ")


def same_block(t: LineTester, first: Block) -> None:
    again = t.take()
    if again.data != first.data:
        raise Fail("the repeated block differs from the first", first.raw.hex(" ").upper(), again.raw.hex(" ").upper())
