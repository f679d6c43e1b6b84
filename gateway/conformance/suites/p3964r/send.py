"""3964R, the station sends, or both at once: form, attempts, acknowledgement delay, conflicts (serial-protocols 1.3, 1.6, 6)."""

from contextlib import suppress

from gateway.conformance.suites.line import DLE, NAK, STX, Block, LineTester, named
from gateway.conformance.suites.p3964r.receive import BLOCK, CONNECT, stray_answer
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Disturbed, Fail, Inconclusive, NotApplicable, Warn
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char, wire_block
from protocols.p3964r.profiles import Interruption, Priority

FIRST, SILENCE, REPEATS = "3964R_SND_BV_01", "3964R_SND_BI_01", "3964R_SND_BI_06"
SND = Purposes[LineTester]("3964R_SND", "sender", "serial-protocols 1.3", condition=("sends",), preamble=(FIRST,))
CON = Purposes[LineTester]("3964R_CON", "both", "serial-protocols 1.6", condition=("sends",), preamble=(CONNECT, BLOCK, FIRST))
JUST = ms(40)
ROUNDS = 5
RUN = 20
MOST = 300
GAP = ms(250)  # behind an answer of ours within which a repeat begins; retry_pause of the profile is added


def _attempts(t: LineTester, silent: bool = False) -> int:
    return 1 if silent and t.profile.silence_ends else t.profile.connect_attempts


def _count(t: LineTester, what: str, count: int, expected: int) -> None:
    if count != expected:
        raise Fail(f"{count} {what}, expected {expected} ({t.profile.name})", f"{expected} {what}", f"{count} {what}")


def _gives_up(t: LineTester, got: int | Damage | None) -> None:
    if t.profile.nak_when_giving_up and got != Char.NAK:
        raise Fail(f"after the last attempt: {named(got)}, expected NAK when it gives up", "NAK (15h)", named(got))
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
    "DLE doubled, block check right, nothing behind it",
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


@SND.case(
    "BV_03",
    "an acknowledged block is not sent again",
    "ein quittierter Block wird nicht noch einmal gesendet",
    requirements=("RHO-SER-07",),
)
def once(t: LineTester) -> None:
    again = b""
    for _ in range(2):  # a station that also sends by itself may hit that moment once
        t.starts_sending()
        first = t.take()
        got = t.answer(t.tolerance + ms(150))
        if got is None:
            return
        if got != Char.STX:
            t.fail("the acknowledged block", got, "nothing")
        again = t.serve() or b""
        if again != first.data or t.setup.stimulus_name == "periodic":
            return
        t.settle()
    raise Fail("the acknowledged block came again at once", "nothing", f"the same block: {again.hex(' ').upper()}")


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
        raise Fail(f"DLE {JUST / 1e6:.0f} ms before the end of QVZ was not taken", "its block", t.last(8))
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
    _same_block(t, first)


def _same_block(t: LineTester, first: Block) -> None:
    again = t.take()
    if again.data != first.data:
        raise Fail("the repeated block differs from the first", first.raw.hex(" ").upper(), again.raw.hex(" ").upper())


# ---- invalid behaviour
@SND.case("BI_01", "a silent partner: all attempts, then NAK", "stummer Partner: alle Versuche, dann NAK", requirements=("RHO-SER-02",))
def silent(t: LineTester) -> None:
    t.starts_sending()
    count, wait = 1, t.profile.ack_delay + t.profile.retry_pause
    got: int | Damage | None = None
    while count < MOST:
        start = t.mark
        got = t.answer(2 * wait + ms(500))
        if got != Char.STX or (count >= _attempts(t, True) and t.mark - start > wait + 2 * t.tolerance):
            break
        count += 1
    _count(t, "connection attempts", count, _attempts(t, True))
    _gives_up(t, got if got != Char.STX else None)


def _answered(t: LineTester, answer: bytes | None, what: str) -> None:
    t.starts_sending()
    count, found = 0, None
    got: int | Damage | None = Char.STX
    while got == Char.STX and count < MOST:
        count += 1
        if answer is None:
            t.spoil()
        else:
            t.say(answer)
        got = found = t.answer(t.profile.retry_pause + GAP)
    _count(t, f"connection attempts when STX is answered with {what}", count, _attempts(t))
    _gives_up(t, found)


@SND.case(
    "BI_02",
    "STX answered with NAK: repeated at once, then given up with NAK",
    "STX mit NAK beantwortet: sofort wiederholt, dann mit NAK aufgegeben",
    requirements=("RHO-SER-02",),
    preamble=(FIRST, SILENCE),
)
def nak_to_stx(t: LineTester) -> None:
    _answered(t, NAK, "NAK")


@SND.case(
    "BI_03",
    "STX answered with another character: repeated",
    "STX mit einem anderen Zeichen beantwortet: wiederholt",
    requirements=("RHO-SER-02",),
    preamble=(FIRST, SILENCE),
)
def other_to_stx(t: LineTester) -> None:
    _answered(t, b"U", "55h")


@SND.case(
    "BI_04",
    "STX answered with a damaged character: repeated",
    "STX mit einem gestörten Zeichen beantwortet: wiederholt",
    requirements=("RHO-SER-02",),
    preamble=(FIRST, SILENCE),
)
def damaged_to_stx(t: LineTester) -> None:
    _answered(t, None, "a damaged character")


@SND.case("BI_05", "NAK while the block is under way: begins again with STX", "NAK während des Blocks: beginnt erneut mit STX")
def nak_inside(t: LineTester) -> None:
    t.starts_sending()
    t.say(DLE)
    with t.given():
        t.answer(t.profile.char_delay)
    t.say(NAK)
    last = _last(t, ms(30))
    if last != Char.STX:
        t.fail("NAK inside the block", last, "STX (02h) at last")
    t.take()


def _last(t: LineTester, pause: Ns) -> int | Damage | None:
    """What was under way still comes, and 02h may be data: the last character before a silence counts."""
    last = None
    for _ in range(2 * MOST):
        got = t.answer(pause + t.tolerance + t.profile.retry_pause)
        if got is None:
            break
        last = got
    return last


def _block_answered(t: LineTester, answer: bytes | None, what: str) -> None:
    t.starts_sending()
    first = t.take(acknowledge=False)
    if answer is None:
        t.spoil()
    else:
        t.say(answer)
    t.expect(Char.STX, t.profile.retry_pause + GAP, f"{what} after the block")
    _same_block(t, first)


@SND.case(
    "BI_06",
    "NAK after the block: begins again with STX, the same block",
    "NAK nach dem Block: beginnt erneut mit STX, derselbe Block",
    requirements=("RHO-SER-07",),
)
def nak_after(t: LineTester) -> None:
    _block_answered(t, NAK, "NAK")


@SND.case(
    "BI_07",
    "another character after the block: begins again",
    "ein anderes Zeichen nach dem Block: beginnt erneut",
    requirements=("RHO-SER-07",),
    preamble=(FIRST, REPEATS),
)
def other_after(t: LineTester) -> None:
    _block_answered(t, b"U", "55h")


@SND.case(
    "BI_08",
    "a damaged character after the block: begins again",
    "ein gestörtes Zeichen nach dem Block: beginnt erneut",
    requirements=("RHO-SER-07",),
    preamble=(FIRST, REPEATS),
)
def damaged_after(t: LineTester) -> None:
    _block_answered(t, None, "a damaged character")


@SND.case(
    "BI_09",
    "every block refused: all block attempts, then NAK",
    "jeder Block abgelehnt: alle Blockversuche, dann NAK",
    requirements=("RHO-SER-07",),
    preamble=(FIRST, REPEATS),
)
def all_refused(t: LineTester) -> None:
    t.starts_sending()
    count = 0
    got: int | Damage | None = Char.STX
    while got == Char.STX and count < MOST:
        t.take(acknowledge=False)
        count += 1
        t.say(NAK)
        got = t.answer(t.profile.retry_pause + GAP)
    _count(t, "block attempts", count, t.profile.block_attempts)
    _gives_up(t, got)


@SND.case(
    "BI_10",
    "STX after the block is no acknowledgement",
    "STX nach dem Block ist keine Quittung",
    requirements=("RHO-SER-07",),
    preamble=(FIRST, REPEATS),
)
def stx_after(t: LineTester) -> None:
    t.starts_sending()
    first = t.take(acknowledge=False)
    t.say(STX)
    got = t.answer(t.profile.retry_pause + GAP)
    if got == Char.DLE:  # it takes our wish; its own job must come afterwards
        t.say(wire_block(t.harmless, t.profile.block_check))
        t.expect(Char.DLE, t.profile.ack_delay, "our block")
        got = t.answer(t.profile.ack_delay + GAP)
    if got != Char.STX:
        t.fail("STX after the block", got, "STX (02h): the block was not acknowledged")
    _same_block(t, first)


# ---- inopportune behaviour
@SND.case(
    "BO_01",
    "DLE DLE after STX: the block is sent once",
    "DLE DLE nach STX: der Block wird einmal gesendet",
    clause="open: reaction inside the block",
)
def dle_twice(t: LineTester) -> None:
    t.starts_sending()
    t.say(DLE + DLE)
    if t.profile.interruption is Interruption.BACK_OFF:
        if _last(t, t.profile.char_delay) == Char.STX:
            t.take()
        return
    block = t.read()
    if block is None:
        raise Warn("breaks off when DLE comes twice, as one source has it", "its block", t.last(8))
    t.say(DLE)
    got = t.answer(t.tolerance)
    if got not in (None, Char.STX):
        t.fail("the acknowledged block", got, "nothing")


@SND.case("BO_02", "DLE after it gave up: no block follows", "DLE, nachdem er aufgegeben hat: kein Block folgt", preamble=(FIRST, SILENCE))
def late_dle(t: LineTester) -> None:
    t.starts_sending()
    got: int | Damage | None = Char.STX
    with t.given():
        for _ in range(MOST):
            if got != Char.STX:
                break
            t.say(NAK)
            got = t.answer(t.profile.retry_pause + GAP)
    t.say(DLE)
    stray_answer(t, "a DLE after it gave up")


@SND.case(
    "BO_03",
    "BREAK while it waits for the answer: no repeat is started",
    "BREAK beim Warten auf die Antwort: keine Wiederholung",
    clause="serial-protocols 1.3: any state",
)
def break_waiting(t: LineTester) -> None:
    t.starts_sending()
    t.spoil(Damage.BREAK)
    got = t.answer(t.profile.ack_delay + t.tolerance + ms(100))
    if got == Char.STX:
        t.take()
        raise Warn("goes on with its attempts after a BREAK; one maker's manual ends them", "nothing", "STX (02h)")
    if got not in (None, Char.NAK):
        t.fail("BREAK after its STX", got, "nothing")


# ---- recovery and stress
@SND.case(
    "RC_01",
    "after it gave up the next job is sent",
    "nachdem er aufgegeben hat, wird der nächste Auftrag gesendet",
    preamble=(FIRST, SILENCE),
)
def next_job(t: LineTester) -> None:
    with suppress(Inconclusive):  # whatever the case before has left
        t.starts_sending()
        t.take()
    t.settle()
    t.starts_sending()
    got: int | Damage | None = Char.STX
    for _ in range(MOST):
        if got != Char.STX:
            break
        t.say(NAK)
        got = t.answer(t.profile.retry_pause + GAP)
    t.settle()
    assert t.setup.stimulus is not None
    t.setup.stimulus(t)
    t.first_stx(t.setup.stimulus_wait)
    t.take()


@SND.case(
    "ST_01",
    f"{RUN} jobs in a row are each sent whole",
    f"{RUN} Aufträge hintereinander werden je ganz gesendet",
    preamble=(FIRST, "3964R_SND_BV_02"),
)
def run(t: LineTester) -> None:
    for count in range(RUN if t.setup.stimulus_name != "operator" else 2):
        try:
            t.starts_sending()
        except Inconclusive as ended:
            if not count or t.setup.stimulus_name == "operator":
                raise
            raise Fail(f"after {count} jobs it sends no more: {ended.reason}", "STX (02h)", ended.got) from ended
        block = t.take()
        if block.fault:
            raise Fail(f"block {count + 1}: {block.fault}", "a block by the rule", block.raw.hex(" ").upper())


# ---- conflicts
def _is_low(t: LineTester, got: int | Damage | None) -> bool:
    """Whether the station withdrew; compared with what the bench says of its priority."""
    low = got == Char.DLE
    if t.setup.priority is None:
        t.remark(f"assumed from this: priority {'low' if low else 'high'}")
    elif low is not (t.setup.priority is Priority.LOW):
        wanted = "DLE (10h): it withdraws" if t.setup.priority is Priority.LOW else "nothing: it waits for DLE"
        raise Fail(f"both sent STX, its priority is {t.setup.priority.name.lower()}: {named(got)}", wanted, named(got))
    return low


def _conflict(t: LineTester, repeated: bool = False) -> None:
    """Both have sent STX; both blocks must come through."""
    got = t.answer(min(t.profile.ack_delay // 2, ms(200)))
    if got not in (None, Char.DLE):
        t.fail("STX from both", got, "DLE (10h), or nothing with priority")
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
    t.starts_sending()
    t.say(STX)
    _conflict(t)


@CON.case(
    "BV_02",
    "after it gave way its own job comes",
    "nachdem er zurückgetreten ist, kommt sein eigener Auftrag",
    requirements=("RHO-SER-10",),
)
def keeps_job(t: LineTester) -> None:
    t.starts_sending()
    t.say(STX)
    got = t.answer(min(t.profile.ack_delay // 2, ms(200)))
    if got != Char.DLE:
        t.say(DLE)
        with t.given():
            if t.read() is None:
                raise Fail("its block does not come", "its block", t.last(8))
        t.say(DLE)
        if t.setup.priority is Priority.LOW:
            raise Disturbed("it did not give way", "DLE (10h)", named(got))
        raise NotApplicable("it has priority and does not give way")
    t.say(wire_block(t.harmless, t.profile.block_check))
    with t.given():
        t.expect(Char.DLE, t.profile.ack_delay, "our block in a conflict")
    got = t.answer(t.profile.char_delay + t.profile.ack_delay + ms(500))
    if got != Char.STX:
        raise Fail(f"after our block it must send its own job: {named(got)}, the job is lost", "STX (02h)", named(got))
    t.take()


@CON.case(
    "BV_03",
    "the conflict comes in a repeat: both blocks come through",
    "der Konflikt trifft eine Wiederholung: beide Blöcke kommen durch",
    requirements=("RHO-SER-10",),
)
def in_repeat(t: LineTester) -> None:
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
    t.starts_sending()
    t.say(STX)
    got = t.answer(min(t.profile.ack_delay // 2, ms(200)))
    if got == Char.DLE:
        t.say(DLE)  # as a partner without priority: it is taken for the first character of our block
        t.expect_at(Char.NAK, t.profile.char_delay, "DLE in place of a block")
        return
    if got is not None:
        t.fail("STX from both", got, "DLE (10h), or nothing with priority")
    count = 1
    while (got := t.answer(t.profile.ack_delay + t.profile.retry_pause + ms(500))) == Char.STX and count < MOST:
        count += 1
        t.say(STX)
    if got == Char.DLE:
        t.say(wire_block(t.harmless, t.profile.block_check))
        t.expect(Char.DLE, t.profile.ack_delay, "our block after it gave way")
    elif not t.profile.silence_ends:
        _count(t, "connection attempts with both stations high", count, _attempts(t, True))


@CON.case(
    "ST_01",
    f"{ROUNDS} conflicts in a row: no job is lost",
    f"{ROUNDS} Konflikte hintereinander: kein Auftrag geht verloren",
    requirements=("RHO-SER-10",),
)
def rounds(t: LineTester) -> None:
    low = None
    for count in range(ROUNDS if t.setup.stimulus_name != "operator" else 1):
        t.starts_sending()
        t.say(STX)
        got = t.answer(min(t.profile.ack_delay // 2, ms(200)))
        if low not in (None, got == Char.DLE):
            words = ("gives way", "does not give way") if low else ("does not give way", "gives way")
            raise Fail(f"it {words[0]} in {count} conflicts, then it {words[1]}", "the same priority each time", named(got))
        low = got == Char.DLE
        with t.given():
            if got == Char.DLE:
                t.say(wire_block(t.harmless, t.profile.block_check))
                t.expect(Char.DLE, t.profile.ack_delay, "our block in a conflict")
                t.first_stx(t.profile.char_delay + t.profile.ack_delay + ms(500))
            t.take()
        t.settle()
