"""3964R, the station sends again: form and times of a repeat, attempts of the next job, conflicts (serial-protocols 1.3, 1.6)."""

from gateway.conformance.suites.line import DLE, NAK, Block, LineTester
from gateway.conformance.suites.p3964r.conflicts import both_wish, gives_way, takes_own_job
from gateway.conformance.suites.p3964r.failures import answered, repeats
from gateway.conformance.suites.p3964r.receive import BLOCK, CONNECT, PAYLOAD
from gateway.conformance.suites.p3964r.refusals import with_wrong_check
from gateway.conformance.suites.p3964r.send import FIRST, GAP, REPEATS, SILENCE, attempts, gives_up, judge_count
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable
from protocols.base.machine import Damage, ms
from protocols.p3964r.characters import Char, wire_block

FORM, YIELDS = "3964R_SND_BV_02", "3964R_CON_BV_02"
SND = Purposes[LineTester]("3964R_SND", "sender", "serial-protocols 1.3", condition=("sends",), preamble=(FIRST, FORM))
CON = Purposes[LineTester]("3964R_CON", "both", "serial-protocols 1.6", condition=("sends",), preamble=(CONNECT, BLOCK, FIRST, FORM))
SEQ = Purposes[LineTester]("3964R_SEQ", "both", "serial-protocols 1.4", preamble=(CONNECT, BLOCK))


def _whole(block: Block, what: str) -> None:
    """Judge its form, not its content."""
    if block.fault:
        raise Fail(f"{what}: {block.fault}", "a block by the rule", block.raw.hex(" ").upper())


def _again(t: LineTester, answer: bytes, what: str) -> None:
    """A repeat is due after that answer."""
    t.say(answer)
    with t.given():
        t.expect(Char.STX, t.profile.retry_pause + GAP, what)


# ---- form of a repeat
@SND.case(
    "BV_04",
    "a block whose STX had to be repeated has the right form",
    "ein Block nach wiederholtem STX hat die richtige Form",
    requirements=("RHO-SER-02", "RHO-SER-04"),
    preamble=(FIRST, FORM, SILENCE, "3964R_SND_BI_02"),
)
def after_stx(t: LineTester) -> None:
    if attempts(t) < 2:
        raise NotApplicable("this profile does not repeat STX")
    t.starts_sending()
    for _ in range(min(2, attempts(t) - 1)):
        _again(t, NAK, "NAK to STX")
    _whole(t.take(), "the block after a repeated STX")


@SND.case(
    "BV_05",
    "each repeat of a block is the same block, in the right form",
    "jede Wiederholung eines Blocks ist derselbe Block, in der richtigen Form",
    requirements=("RHO-SER-04", "RHO-SER-07"),
    preamble=(FIRST, FORM, REPEATS),
)
def repeat(t: LineTester) -> None:
    t.starts_sending()
    first = t.take(acknowledge=False)
    for count in range(repeats(t)):
        _again(t, NAK, "NAK after the block")
        block = t.take(acknowledge=False)
        _whole(block, f"repeat {count + 1} of the block")
        if block.data != first.data:
            raise Fail(f"repeat {count + 1} of the block differs from the first", first.raw.hex(" ").upper(), block.raw.hex(" ").upper())
    t.say(DLE)


# ---- times and counters
@SND.case(
    "TI_04",
    "each repeated STX waits QVZ for its answer, as the first one does",
    "jedes wiederholte STX wartet QVZ auf seine Antwort wie das erste",
    requirements=("RHO-SER-02",),
    preamble=(FIRST, SILENCE, "3964R_SND_TI_01"),
    beside=Particulars(limits="QVZ of the profile, 20 ms and one character to either side"),
)
def each_wait(t: LineTester) -> None:
    if attempts(t, True) < 4:
        raise NotApplicable(f"this profile has {attempts(t, True)} connection attempts")
    due = t.profile.ack_delay + t.profile.retry_pause
    t.starts_sending()
    with t.given():
        t.expect(Char.STX, 2 * due, "STX and silence")
    for turn in (2, 3):
        t.expect_at(Char.STX, due, f"STX {turn} and silence")
    t.take()


@SND.case(
    "RC_02",
    "connection attempts are counted anew for each job",
    "Verbindungsversuche zählen bei jedem Auftrag neu",
    requirements=("RHO-SER-02",),
    preamble=(FIRST, SILENCE, "3964R_SND_BI_02"),
)
def counts_anew(t: LineTester) -> None:
    t.starts_sending()
    for _ in range(min(3, attempts(t) - 1)):
        _again(t, NAK, "NAK to STX")
    t.take()
    t.settle()
    answered(t, NAK, "NAK, after a job that needed repeats")


@SND.case(
    "RC_03",
    "block attempts are counted anew for each job",
    "Blockversuche zählen bei jedem Auftrag neu",
    requirements=("RHO-SER-07",),
    preamble=(FIRST, REPEATS, "3964R_SND_BI_09"),
)
def blocks_anew(t: LineTester) -> None:
    t.starts_sending()
    for _ in range(min(3, t.profile.block_attempts - 1)):
        t.take(acknowledge=False)
        _again(t, NAK, "NAK after the block")
    t.take()
    t.settle()
    t.starts_sending()
    count, got = 0, _refuses(t)
    while got == Char.STX and count < t.profile.block_attempts + 2:
        count, got = count + 1, _refuses(t)
    judge_count(t, "block attempts after a job that needed repeats", count + 1, t.profile.block_attempts)
    gives_up(t, got)


def _refuses(t: LineTester) -> int | Damage | None:
    t.take(acknowledge=False)
    t.say(NAK)
    return t.awaited(t.profile.retry_pause + GAP)


# ---- after a conflict
@CON.case(
    "BV_04",
    "the block of a job that gave way has the right form",
    "der Block eines zurückgetretenen Auftrags hat die richtige Form",
    requirements=("RHO-SER-10",),
    preamble=(CONNECT, BLOCK, FIRST, FORM, YIELDS),
)
def form_of_kept(t: LineTester) -> None:
    gives_way(t)
    t.say(wire_block(t.harmless, t.profile.block_check))
    with t.given():
        t.expect(Char.DLE, t.profile.ack_delay, "our block in a conflict")
        t.first_stx(t.profile.char_delay + t.profile.ack_delay + ms(500))
    _whole(t.take(), "its block after it gave way")


@CON.case(
    "BI_02",
    "it gave way and our block was corrupted: our repeat is taken, its own job comes",
    "er trat zurück und unser Block war gestört: die Wiederholung wird angenommen, sein Auftrag kommt",
    requirements=("RHO-SER-10",),
    preamble=(CONNECT, BLOCK, FIRST, "3964R_RCV_BI_01", YIELDS),
)
def corrupted(t: LineTester) -> None:
    came: list[bytes] = []
    gives_way(t)
    t.say(with_wrong_check(PAYLOAD, 0x21) if t.profile.block_check else b"U\x10AV\x10\x03")
    with t.given():
        t.expect(Char.NAK, t.profile.ack_delay, "our corrupted block in a conflict")
    t.on_block = came.append
    try:
        t.good(t.harmless, "the repeat of our block")
    finally:
        t.on_block = None
    if came:
        return
    takes_own_job(t, t.profile.block_wait, "our repeat")


@CON.case(
    "BO_01",
    "with priority: our STX of the conflict is not answered after its block",
    "mit Priorität: unser STX des Konflikts wird nach seinem Block nicht beantwortet",
    requirements=("RHO-SER-10",),
    preamble=(CONNECT, BLOCK, FIRST, "3964R_CON_BV_01"),
)
def forgets_stx(t: LineTester) -> None:
    both_wish(t)
    if t.answer(t.conflict_wait) == Char.DLE:
        t.say(wire_block(t.harmless, t.profile.block_check))
        t.settle()
        raise NotApplicable("it has no priority and gives way")
    t.mark = t.wire.now()
    t.take()
    t.silence(t.profile.char_delay + t.tolerance + ms(100), "its block, which had priority")


# ---- quiet after a block
@SEQ.case(
    "BO_02",
    "after an acknowledged block the line stays quiet: no timer runs on",
    "nach einem quittierten Block bleibt die Leitung ruhig: keine Zeit läuft weiter",
    requirements=("RHO-SER-06",),
)
def stays_quiet(t: LineTester) -> None:
    for data in (t.harmless, t.harmless):
        with t.given():
            t.good(data)
        t.silence(2 * t.profile.char_delay + t.tolerance, "an acknowledged block")


@SEQ.case(
    "BO_03",
    "after its own acknowledged block the line stays quiet",
    "nach seinem eigenen quittierten Block bleibt die Leitung ruhig",
    condition=("sends",),
    preamble=(CONNECT, BLOCK, FIRST, "3964R_SND_BV_03"),
)
def own_quiet(t: LineTester) -> None:
    t.starts_sending()
    t.take()
    t.silence(t.profile.ack_delay + t.tolerance + ms(100), "its own acknowledged block")
