"""3964R, the station sends and is refused, not answered or answered wrongly; recovery and jobs in a row (serial-protocols 1.3, 6)."""

from contextlib import suppress

from gateway.conformance.suites.line import BETWEEN, DLE, NAK, STX, LineTester, named
from gateway.conformance.suites.p3964r.refusals import stray_answer
from gateway.conformance.suites.p3964r.send import FIRST, GAP, MOST, REPEATS, SILENCE, SND, attempts, gives_up, judge_count, same_block
from gateway.conformance.suites.rk512.telegrams import is_command, serve_command
from gateway.pure.conformance.verdict import Fail, Inconclusive, Warn
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char, wire_block
from protocols.p3964r.profiles import Interruption

__all__ = ["SND"]  # the registry finds the complete group here

RUN = 20
OTHERS = b"U\x06\x03\x05\x04\x17"  # neither DLE, NAK nor STX; among them answers of other protocols
JOBS = 4  # jobs that may queue up


@SND.case("BI_01", "a silent partner: all attempts, then NAK", "stummer Partner: alle Versuche, dann NAK", requirements=("RHO-SER-02",))
def silent(t: LineTester) -> None:
    t.starts_sending()
    count, wait = 1, t.profile.ack_delay + t.profile.retry_pause
    got: int | Damage | None = None
    while count < MOST:
        start = t.mark
        got = t.answer(2 * wait + ms(500))
        if got != Char.STX or (count >= attempts(t, True) and t.mark - start > wait + 2 * t.tolerance):
            break
        count += 1
    judge_count(t, "connection attempts", count, attempts(t, True))
    gives_up(t, got if got != Char.STX else None)


def answered(t: LineTester, answer: bytes | None, what: str) -> None:
    """Each STX of a job is answered with the next of these characters, None: with a damaged one."""
    t.starts_sending()
    count, found = 0, None
    got: int | Damage | None = Char.STX
    while got == Char.STX and count < MOST:
        if answer is None:
            t.spoil()
        else:
            at = count % len(answer)
            t.say(answer[at : at + 1])
        count += 1
        got = found = t.awaited(t.profile.retry_pause + GAP)
    judge_count(t, f"connection attempts when STX is answered with {what}", count, attempts(t))
    gives_up(t, found)


@SND.case(
    "BI_02",
    "STX answered with NAK: repeated at once, then given up with NAK",
    "STX mit NAK beantwortet: sofort wiederholt, dann mit NAK aufgegeben",
    requirements=("RHO-SER-02",),
    preamble=(FIRST, SILENCE),
)
def nak_to_stx(t: LineTester) -> None:
    answered(t, NAK, "NAK")


@SND.case(
    "BI_03",
    "STX answered with another character: repeated",
    "STX mit einem anderen Zeichen beantwortet: wiederholt",
    requirements=("RHO-SER-02",),
    preamble=(FIRST, SILENCE),
)
def other_to_stx(t: LineTester) -> None:
    answered(t, OTHERS, f"other characters ({OTHERS.hex(' ').upper()})")


@SND.case(
    "BI_04",
    "STX answered with a damaged character: repeated",
    "STX mit einem gestörten Zeichen beantwortet: wiederholt",
    requirements=("RHO-SER-02",),
    preamble=(FIRST, SILENCE),
)
def damaged_to_stx(t: LineTester) -> None:
    answered(t, None, "a damaged character")


@SND.case("BI_05", "NAK while the block is under way: begins again with STX", "NAK während des Blocks: beginnt erneut mit STX")
def nak_inside(t: LineTester) -> None:
    t.starts_sending()
    t.say(DLE)
    with t.given():
        t.answer(t.profile.char_delay)
    t.say(NAK)
    last = _last(t, max(ms(30), min(t.slowest * 3 // 2, t.profile.ack_delay // 2)))  # as slow as its DLE
    if last != Char.STX:
        t.fail("NAK inside the block", last, "STX (02h) at last")
    t.take()


def _last(t: LineTester, pause: Ns) -> int | Damage | None:
    """Data on the way still arrive, and 02h may be data: the last character before a silence counts."""
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
    same_block(t, first)


def repeats(t: LineTester) -> int:
    """Number of repeats of a block in any profile: some count connections and blocks together."""
    return max(1, min(t.profile.block_attempts, t.profile.connect_attempts) - 1)


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
    "any other character after the block: begins again",
    "jedes andere Zeichen nach dem Block: beginnt erneut",
    requirements=("RHO-SER-07",),
    preamble=(FIRST, REPEATS),
)
def other_after(t: LineTester) -> None:
    t.starts_sending()
    t.take(acknowledge=False)
    for char in OTHERS[: repeats(t)]:
        t.say(bytes((char,)))
        t.expect(Char.STX, t.profile.retry_pause + GAP, f"{named(char)} after the block")
        t.take(acknowledge=False)
    t.say(DLE)


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
        got = t.awaited(t.profile.retry_pause + GAP)
    judge_count(t, "block attempts", count, t.profile.block_attempts)
    gives_up(t, got)


@SND.case(
    "BI_10",
    "STX after the block is not an acknowledgement",
    "STX nach dem Block ist keine Quittung",
    requirements=("RHO-SER-07",),
    preamble=(FIRST, REPEATS),
)
def stx_after(t: LineTester) -> None:
    t.starts_sending()
    first = t.take(acknowledge=False)
    t.say(STX)
    got = t.awaited(t.profile.retry_pause + GAP)
    if got == Char.DLE:  # it yields to our STX; its own job must come afterwards
        t.say(wire_block(t.harmless, t.profile.block_check))
        t.expect(Char.DLE, t.profile.ack_delay, "our block")
        got = t.awaited(t.profile.ack_delay + GAP)
    if got != Char.STX:
        t.fail("STX after the block", got, "STX (02h): the block was not acknowledged")
    same_block(t, first)


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
        raise Warn("breaks off when DLE comes twice, as one source states", "its block", t.last(8))
    t.say(DLE)
    got = t.answer(t.tolerance)
    if got == Char.NAK:
        raise Warn("answers one of the two DLE with NAK, as a stray character", "nothing", named(got))
    if got not in (None, Char.STX):
        t.fail("the acknowledged block", got, "nothing")


@SND.case("BO_02", "DLE after it gave up: no block follows", "DLE, nachdem er aufgegeben hat: kein Block folgt", preamble=(FIRST, SILENCE))
def late_dle(t: LineTester) -> None:
    t.starts_sending()
    with t.given():
        for _ in range(JOBS):
            refused_to_the_end(t)
            if t.answer(BETWEEN) != Char.STX:  # another job that waits is refused as well
                break
    t.say(DLE)
    stray_answer(t, "a DLE after it gave up")


def refused_to_the_end(t: LineTester) -> None:
    """Answers each STX of the job with NAK; its first STX has been received."""
    got: int | Damage | None = Char.STX
    for _ in range(MOST):
        if got != Char.STX:
            break
        t.say(NAK)
        got = t.awaited(t.profile.retry_pause + GAP)


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
        raise Warn("continues its attempts after a BREAK; one maker's manual ends them", "nothing", "STX (02h)")
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
    refused_to_the_end(t)
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
        if is_command(block.data):  # of RK512: its reaction ends the job
            serve_command(t, block.data)
