"""The station sends, or both at once: attempts, acknowledgement delay, answers of every kind, conflicts (serial-protocols 1.3, 1.6, 6)."""

from gateway.conformance.case import Cases
from gateway.conformance.serial.bench import Bench, Fail, NotRun, named
from gateway.conformance.serial.cases_receive import expect_stray_answer
from gateway.pure.lines.texts import said
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char, wire_block
from protocols.p3964r.profiles import Interruption, Priority

SEND, CONFLICT = Cases("send"), Cases("conflict")
STX, DLE, NAK = bytes((Char.STX,)), bytes((Char.DLE,)), bytes((Char.NAK,))
JUST = ms(40)  # before QVZ: more than the tolerance
ROUNDS = 5
MOST_TRIES = 300


def _attempts(bench: Bench, silent: bool = False) -> int:
    return 1 if silent and bench.profile.silence_ends else bench.profile.connect_attempts


def _expect_count(one: str, many: str, count: int, expected: int) -> None:
    if count != expected:
        raise Fail(said("{} {}, expected {}", count, one if count == 1 else many, expected))


def _expect_giving_up(bench: Bench, got: int | Damage | None) -> None:
    wanted = Char.NAK if bench.profile.nak_when_giving_up else None
    if got != wanted:
        raise Fail(said("after the last attempt: {}, expected {} when it gives up", named(got), named(wanted)))


@SEND.case("good", "a block of its own: form, doubling, check; nothing follows our DLE")
def good(bench: Bench) -> None:
    bench.make_it_send()
    data = bench.take()
    bench.remark(said("{} characters: {}{}", len(data), data[:16].hex(" "), " ..." if len(data) > 16 else ""))
    bench.silence(bench.tolerance, "the acknowledged block")


@SEND.case("silent", "the partner is silent: attempts, each after the acknowledgement delay (QVZ/ADT), then it gives up")
def silent(bench: Bench) -> None:
    bench.make_it_send()
    count = 1
    while count < MOST_TRIES:
        start, got = bench.mark, bench.answer(bench.profile.ack_delay + bench.profile.retry_pause + ms(500))
        if got is not None:
            bench.measured(said("{} after STX {} and silence", named(got), count), bench.mark - start, bench.profile.ack_delay)
        if got != Char.STX:
            break
        count += 1
    _expect_count("connection attempt", "connection attempts", count, _attempts(bench, silent=True))
    _expect_giving_up(bench, got)


def _answered_with(bench: Bench, what: str, answer: bytes | None) -> None:
    bench.make_it_send()
    count, got = 0, int(Char.STX)
    while got == Char.STX and count < MOST_TRIES:
        count += 1
        if answer is None:
            bench.spoil()
        else:
            bench.say(answer)
        found = bench.answer(bench.profile.retry_pause + ms(200))
        got = found if isinstance(found, int) else -1
    one = said("connection attempt when STX is answered with {}", what)
    many = said("connection attempts when STX is answered with {}", what)
    _expect_count(one, many, count, _attempts(bench))
    _expect_giving_up(bench, found)


@SEND.case("nak-to-stx", "STX is answered with NAK: repeated at once, so many attempts")
def nak_to_stx(bench: Bench) -> None:
    _answered_with(bench, "NAK", NAK)


@SEND.case("other-to-stx", "STX is answered with another character")
def other_to_stx(bench: Bench) -> None:
    _answered_with(bench, "55h", b"U")


@SEND.case("damaged-to-stx", "STX is answered with a damaged character")
def damaged_to_stx(bench: Bench) -> None:
    _answered_with(bench, "a damaged character", None)


@SEND.case("just-in-time", "DLE just before the acknowledgement delay is over")
def just_in_time(bench: Bench) -> None:
    bench.make_it_send()
    bench.silence(bench.profile.ack_delay - JUST, "STX, before QVZ is over")
    bench.take()


@SEND.case("just-too-late", "no answer: STX again when QVZ is over, and that one is answered")
def just_too_late(bench: Bench) -> None:
    if bench.profile.silence_ends:
        raise NotRun("this profile gives up after one silence")
    bench.make_it_send()
    bench.expect_at(Char.STX, bench.profile.ack_delay, "STX and silence")
    bench.take()


@SEND.case("nak-in-block", "NAK while the block is under way: it begins again with STX")
def nak_in_block(bench: Bench) -> None:
    bench.make_it_send()
    bench.say(DLE)
    bench.answer(bench.profile.char_delay)
    bench.say(NAK)
    last = _last_before_silence(bench, 0)
    if last != Char.STX:
        raise Fail(said("after NAK inside the block: {} at last, expected STX", named(last)))
    bench.take()


def _last_before_silence(bench: Bench, pause: Ns) -> int | Damage | None:
    """Data on the way still arrive; 02h may be data, so the last character before a silence counts."""
    last = None
    while (got := bench.answer(pause + bench.tolerance + ms(30))) is not None:
        last = got
    return last


def _block_answered(bench: Bench, answer: bytes, what: str) -> None:
    bench.make_it_send()
    first = bench.take_unanswered()
    bench.say(answer)
    bench.expect(Char.STX, bench.profile.retry_pause + ms(200), said("{} after the block", what))
    if bench.take() != first:
        raise Fail("the repeated block differs from the first")


@SEND.case("nak-after-block", "NAK after the block: begins again with STX, same block")
def nak_after_block(bench: Bench) -> None:
    _block_answered(bench, NAK, "NAK")


@SEND.case("other-after-block", "another character after the block: begins again")
def other_after_block(bench: Bench) -> None:
    _block_answered(bench, b"U", "55h")


@SEND.case("silence-after-block", "silence after the block: STX again after QVZ/ADT")
def silence_after_block(bench: Bench) -> None:
    bench.make_it_send()
    bench.take_unanswered()
    bench.expect_at(Char.STX, bench.profile.ack_delay, "the block and silence")
    bench.take()


@SEND.case("all-blocks-refused", "every block is answered with NAK: so many block attempts, then it gives up")
def all_blocks_refused(bench: Bench) -> None:
    bench.make_it_send()
    count = 0
    got: int | Damage | None = Char.STX
    while got == Char.STX and count < MOST_TRIES:
        bench.take_unanswered()
        count += 1
        bench.say(NAK)
        got = bench.answer(bench.profile.retry_pause + ms(200))
    _expect_count("block attempt", "block attempts", count, bench.profile.block_attempts)
    _expect_giving_up(bench, got)


@SEND.case("dle-twice", "STX is answered with DLE DLE")
def dle_twice(bench: Bench) -> None:
    bench.make_it_send()
    bench.say(DLE + DLE)
    if bench.profile.interruption is Interruption.BACK_OFF and _last_before_silence(bench, bench.profile.char_delay) == Char.STX:
        bench.take()  # it broke off and begins again
        return
    if bench.profile.interruption is not Interruption.BACK_OFF:
        bench.read_block()
    bench.say(DLE)
    bench.silence(bench.tolerance, "the acknowledged block")


@SEND.case("late-dle", "DLE after it gave up is a stray character: no block follows")
def late_dle(bench: Bench) -> None:
    bench.make_it_send()
    got: int | Damage | None = Char.STX
    while got == Char.STX:
        got = bench.answer(bench.profile.ack_delay + ms(500))
    bench.say(DLE)
    expect_stray_answer(bench, "a DLE after giving up")


# ---- both at once
def _settle_conflict(bench: Bench, repeated: bool = False) -> None:
    """Its STX and ours have collided; which station continues?  Both blocks must come through."""
    if bench.priority is Priority.LOW or (repeated and bench.profile.yields_to_second_conflict):
        got = bench.answer(bench.profile.ack_delay)
        if got != Char.DLE:
            raise Fail(said("without priority it must withdraw and answer our STX with DLE: {}{}", named(got), _same(got)))
        bench.say(wire_block(bench.harmless, bench.profile.block_check))
        bench.expect(Char.DLE, bench.profile.ack_delay, "our block in a conflict")
        got = bench.answer(bench.profile.char_delay + ms(500))
        if got != Char.STX:
            raise Fail(said("after our block it must send its own job: {}, its job is lost", named(got)))
        bench.take()
        return
    got = bench.answer(min(bench.profile.ack_delay // 2, ms(200)))
    if got is not None:
        raise Fail(said("with priority it must ignore our STX and wait: {}{}", named(got), _same(got)))
    bench.take()


def _same(got: int | Damage | None) -> str:
    if got is None:
        return "; it behaves as with priority"
    if got == Char.DLE:
        return "; it behaves as without priority"
    return "; it refuses a conflicting STX" if got == Char.NAK else ""


@CONFLICT.case("first", "both send STX: the station without priority withdraws, keeps its job, sends it afterwards")
def first(bench: Bench) -> None:
    bench.make_it_send()
    bench.say(STX)
    _settle_conflict(bench)


@CONFLICT.case("in-repeat", "the conflict comes in a repeat")
def in_repeat(bench: Bench) -> None:
    bench.make_it_send()
    bench.say(NAK)
    bench.expect(Char.STX, bench.profile.retry_pause + ms(200), "NAK to STX")
    bench.say(STX)
    _settle_conflict(bench, repeated=True)


@CONFLICT.case("rounds", "five conflicts in a row: no job is lost on either side")
def rounds(bench: Bench) -> None:
    for _ in range(ROUNDS):
        first(bench)
        bench.settle()


@CONFLICT.case("same-priority", "both have the same priority: it ends by the rule, and the link is good afterwards")
def same_priority(bench: Bench) -> None:
    bench.make_it_send()
    if bench.priority is Priority.LOW:
        _both_low(bench)
    else:
        _both_high(bench)
    bench.settle()
    bench.give_good(b"UV", "a good block after the conflict")


def _both_low(bench: Bench) -> None:
    bench.say(STX)
    got = bench.answer(bench.profile.ack_delay)
    if got != Char.DLE:
        raise Fail(said("both without priority, after our STX: {}, expected DLE", named(got)))
    bench.say(DLE)  # it counts as the first character of our block
    bench.expect_at(Char.NAK, bench.profile.char_delay, "DLE in place of a block")


def _both_high(bench: Bench) -> None:
    count = 1
    while True:
        bench.say(STX)
        start, got = bench.mark, bench.answer(bench.profile.ack_delay + bench.profile.retry_pause + ms(500))
        if got != Char.STX:
            break
        bench.measured(
            said("STX {} after a conflict in which neither side gives way", count + 1), bench.mark - start, bench.profile.ack_delay
        )
        count += 1
    if bench.profile.yields_to_second_conflict and got == Char.DLE:
        bench.say(wire_block(bench.harmless, bench.profile.block_check))
        bench.expect(Char.DLE, bench.profile.ack_delay, "our block after the second conflict")
        return
    one, many = "connection attempt with both stations high", "connection attempts with both stations high"
    _expect_count(one, many, count, _attempts(bench, silent=True))
    _expect_giving_up(bench, got)
