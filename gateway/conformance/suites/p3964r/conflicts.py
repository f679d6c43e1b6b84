"""3964R, both stations send STX: which one yields, and what happens to the job (serial-protocols 1.6)."""

from gateway.conformance.suites.line import DLE, NAK, STX, Block, LineTester, named
from gateway.conformance.suites.p3964r.receive import BLOCK, CONNECT
from gateway.conformance.suites.p3964r.send import FIRST, GAP, MOST, attempts, judge_count, sent_once
from gateway.conformance.suites.rk512.telegrams import looks_like_reaction
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Disturbed, Fail, Inconclusive, NotApplicable
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char, wire_block
from protocols.p3964r.profiles import Priority

CON = Purposes[LineTester]("3964R_CON", "both", "serial-protocols 1.6", condition=("sends",), preamble=(CONNECT, BLOCK, FIRST))
ROUNDS = 5


def both_wish(t: LineTester) -> None:
    """The STX of both."""
    _know_its_answer(t)
    t.starts_sending()
    t.say(STX)


def _know_its_answer(t: LineTester) -> None:
    """Measure how long it takes, if no case has done so yet."""
    if not t.slowest:
        with t.given():
            t.good(t.harmless)


def _is_low(t: LineTester, got: int | Damage | None) -> bool:
    """Whether the station withdrew; compared with its priority in the bench."""
    low = got == Char.DLE
    if t.setup.priority is None:
        t.remark(f"assumed from this: priority {'low' if low else 'high'}")
    elif low is not (t.setup.priority is Priority.LOW):
        wanted = "DLE (10h): it withdraws" if t.setup.priority is Priority.LOW else "nothing: it waits for DLE"
        raise Fail(f"both sent STX, its priority is {t.setup.priority.name.lower()}: {named(got)}", wanted, named(got))
    return low


def _conflict(t: LineTester, repeated: bool = False) -> None:
    """Both have sent STX; both blocks must come through."""
    got = t.answer(t.conflict_wait)
    if got not in (None, Char.DLE):
        t.fail("both sent STX", got, "DLE (10h), or nothing with priority")
    low = got == Char.DLE if repeated and t.profile.yields_to_second_conflict else _is_low(t, got)
    if not low:
        t.mark = t.wire.now()
        t.say(DLE)
        if t.read() is None:
            raise Fail("with priority it must go on waiting and send its block", "its block", t.last(8))
        t.say(DLE)
        return
    t.say(wire_block(t.harmless, t.profile.block_check))
    t.expect(Char.DLE, t.profile.ack_delay, "our block in a conflict")


@CON.case(
    "BV_01",
    "both send STX: with priority it waits, without it answers DLE and receives",
    "beide senden STX: mit Priorität wartet er, ohne antwortet er DLE und empfängt",
    requirements=("RHO-SER-10",),
)
def first(t: LineTester) -> None:
    both_wish(t)
    _conflict(t)


def gives_way(t: LineTester) -> None:
    """Both have sent STX and it answered DLE; a station with priority sends its block, and the case is N/A."""
    both_wish(t)
    got = t.answer(t.conflict_wait)
    if got == Char.DLE:
        return
    t.say(DLE)
    with t.given():
        if t.read() is None:
            raise Fail("its block does not come", "its block", t.last(8))
    t.say(DLE)
    if t.setup.priority is Priority.LOW:
        raise Disturbed("it did not give way", "DLE (10h)", named(got))
    raise NotApplicable("it has priority and does not give way")


@CON.case(
    "BV_02",
    "after it gave way its own job comes",
    "nachdem er zurückgetreten ist, kommt sein eigener Auftrag",
    requirements=("RHO-SER-10",),
)
def keeps_job(t: LineTester) -> None:
    gives_way(t)
    t.say(wire_block(t.harmless, t.profile.block_check))
    with t.given():
        t.expect(Char.DLE, t.profile.ack_delay, "our block in a conflict")
    takes_own_job(t, t.profile.char_delay, "our block")


def takes_own_job(t: LineTester, delay: Ns, after: str) -> Block:
    """Its own block, which has waited for `after`; it may begin `delay` later."""
    for _ in range(3):
        got = t.answer(delay + t.profile.ack_delay + ms(500))
        if got != Char.STX:
            raise Fail(f"after {after} it must send its own job: {named(got)}, the job is lost", "STX (02h)", named(got))
        block = t.take()
        if not (t.setup.pics.get("rk512") and looks_like_reaction(block.data)):  # the answer to our block is not its job
            break
    return block


@CON.case(
    "BO_02",
    "a job that gave way is sent once",
    "ein zurückgestellter Auftrag wird einmal gesendet",
    requirements=("RHO-SER-10",),
    preamble=(CONNECT, BLOCK, FIRST, "3964R_CON_BV_02"),
)
def own_job_once(t: LineTester) -> None:
    def taken() -> Block:
        gives_way(t)
        t.say(wire_block(t.harmless, t.profile.block_check))
        with t.given():
            t.expect(Char.DLE, t.profile.ack_delay, "our block in a conflict")
            return takes_own_job(t, t.profile.char_delay, "our block")

    sent_once(t, taken, t.tolerance + ms(150), "its own job that gave way")


@CON.case(
    "BV_03",
    "the conflict comes in a repeat: both blocks come through",
    "der Konflikt trifft eine Wiederholung: beide Blöcke kommen durch",
    requirements=("RHO-SER-10",),
)
def in_repeat(t: LineTester) -> None:
    _know_its_answer(t)
    t.starts_sending()
    t.say(NAK)
    with t.given():
        t.expect(Char.STX, t.profile.retry_pause + GAP, "NAK to STX")
    t.say(STX)
    _conflict(t, repeated=True)


@CON.case(
    "BI_01",
    "both have the same priority: it ends by the rule",
    "beide mit gleicher Priorität: es endet nach der Regel",
    requirements=("RHO-SER-10",),
)
def same_priority(t: LineTester) -> None:
    both_wish(t)
    got = t.answer(t.conflict_wait)
    if got == Char.DLE:
        t.say(DLE)  # as a partner without priority: it counts as the first character of our block
        t.expect_at(Char.NAK, t.profile.char_delay, "DLE in place of a block")
        return
    if got is not None:
        t.fail("both sent STX", got, "DLE (10h), or nothing with priority")
    count = 1
    while (got := t.answer(t.profile.ack_delay + t.profile.retry_pause + ms(500))) == Char.STX and count < MOST:
        count += 1
        t.say(STX)
    if got == Char.DLE:
        t.say(wire_block(t.harmless, t.profile.block_check))
        t.expect(Char.DLE, t.profile.ack_delay, "our block after it gave way")
    elif not t.profile.silence_ends:
        judge_count(t, "connection attempts with both stations high", count, attempts(t, True))


@CON.case(
    "ST_01",
    f"{ROUNDS} conflicts in a row: no job is lost",
    f"{ROUNDS} Konflikte hintereinander: kein Auftrag geht verloren",
    requirements=("RHO-SER-10",),
)
def rounds(t: LineTester) -> None:
    low = None
    for count in range(ROUNDS if t.setup.stimulus_name != "operator" else 1):
        both_wish(t)
        got = t.answer(t.conflict_wait)
        if low not in (None, got == Char.DLE):
            words = ("gives way", "does not give way") if low else ("does not give way", "gives way")
            raise Fail(f"it {words[0]} in {count} conflicts, then it {words[1]}", "the same priority each time", named(got))
        low = got == Char.DLE
        if got == Char.DLE:
            with t.given():
                t.say(wire_block(t.harmless, t.profile.block_check))
                t.expect(Char.DLE, t.profile.ack_delay, "our block in a conflict")
            _keeps_this(t, count)
        with t.given():
            t.take()
        t.settle()


def _keeps_this(t: LineTester, count: int) -> None:
    """The first job is judged by BV_02; one that is lost in a later conflict is found here."""
    try:
        with t.given():
            t.first_stx(t.profile.char_delay + t.profile.ack_delay + ms(500))
    except Inconclusive as lost:
        if not count:
            raise
        raise Fail(f"after {count} conflicts the job of the next one is lost", "STX (02h)", lost.got) from lost
