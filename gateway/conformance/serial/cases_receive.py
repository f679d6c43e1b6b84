"""The station receives: idle, gaps, block checks, lengths, damage, repeats (serial-protocols 1.4 and 6).

Payloads begin with 55h, never with 00 or FF: to an RK512 station they are not telegrams and change nothing.
"""

from gateway.conformance.case import Cases
from gateway.conformance.serial.bench import Bench, Fail, NotRun, Warn, named
from gateway.pure.lines.texts import said
from protocols.base.machine import Damage, ms
from protocols.p3964r.characters import Char, check_of, wire_block
from protocols.p3964r.profiles import BrokenPair, Priority, Stray

IDLE, RECEIVE = Cases("idle"), Cases("receive")
NAK, DLE = bytes((Char.NAK,)), bytes((Char.DLE,))
BAD_IN_A_ROW = 7
FILL_UP = 8  # blocks that are offered to fill a buffer


def expect_stray_answer(bench: Bench, after: str) -> None:
    """Answers of this profile to a character in idle."""
    match bench.profile.stray:
        case Stray.SILENT:
            bench.silence(bench.profile.char_delay + bench.tolerance, after)
        case Stray.NAK_AFTER_QUIET:
            bench.expect_at(Char.NAK, bench.profile.char_delay, after)
        case Stray.NAK_AT_ONCE:
            bench.expect(Char.NAK, ms(100), after)


@IDLE.case("stray", "a stray character in idle")
def stray(bench: Bench) -> None:
    bench.say(b"U")
    expect_stray_answer(bench, "a stray character")


@IDLE.case("nak", "NAK in idle is never answered")
def idle_nak(bench: Bench) -> None:
    bench.say(NAK)
    bench.silence(bench.profile.char_delay + bench.tolerance, "NAK in idle")


@IDLE.case("break", "BREAK in idle is not answered")
def idle_break(bench: Bench) -> None:
    bench.spoil(Damage.BREAK)
    bench.silence(bench.profile.char_delay + bench.tolerance, "BREAK in idle")


@IDLE.case("full", "STX while the buffer is full")
def full(bench: Bench) -> None:
    if bench.hold is None:
        raise NotRun("this station has no command to keep its buffer full; see idle.fill")
    bench.hold(True)
    try:
        bench.say(bytes((Char.STX,)))
        bench.expect_at(Char.NAK, bench.profile.no_buffer_wait, "STX while the buffer is full")
    finally:
        bench.hold(False)


@IDLE.case("fill", "eight blocks without a pause: is the buffer ever full, and what is said then")
def fill(bench: Bench) -> None:
    for count in range(FILL_UP):
        bench.say(bytes((Char.STX,)))
        start, got = bench.mark, bench.answer(bench.profile.no_buffer_wait + bench.tolerance + ms(100))
        if got == Char.NAK:
            bench.measured("NAK after STX with a full buffer", bench.mark - start, bench.profile.no_buffer_wait)
            bench.remark(said("the buffer was full after {} blocks", count))
            return
        if got == Char.STX and bench.priority is Priority.HIGH:
            said_too = bench.answer(bench.tolerance)
            if said_too is not None:
                raise Fail(said("with priority it must ignore our STX and wait: {}{}", named(said_too), ""))
            bench.take()  # it has something to send first
            continue
        if got == Char.STX:
            got = bench.answer(bench.profile.ack_delay)
        if got != Char.DLE:
            raise Fail(
                said("STX of block {}: {}, expected DLE, or NAK after {:.0f} ms", count + 1, named(got), bench.profile.no_buffer_wait / 1e6)
            )
        bench.say(wire_block(b"U" + bytes((count,)), bench.profile.block_check))
        bench.expect(Char.DLE, bench.profile.ack_delay, "a good block")
    bench.remark(said("took {} blocks: the buffer cannot be filled from the line", FILL_UP))


# ---- gaps
@RECEIVE.case("gap-after-stx", "silence after DLE: NAK when the character delay (ZVZ/CDT) is over")
def gap_after_stx(bench: Bench) -> None:
    bench.connect()
    bench.expect_at(Char.NAK, bench.profile.char_delay, "its DLE and silence")


@RECEIVE.case("gap-in-data", "silence inside the data: NAK after ZVZ/CDT")
def gap_in_data(bench: Bench) -> None:
    bench.connect()
    bench.say(b"UV")
    bench.expect_at(Char.NAK, bench.profile.char_delay, "silence in the data")


@RECEIVE.case("gap-before-check", "silence before the block check: NAK after ZVZ/CDT")
def gap_before_check(bench: Bench) -> None:
    _with_check(bench)
    bench.connect()
    bench.say(wire_block(b"UV")[:-1])
    bench.expect_at(Char.NAK, bench.profile.char_delay, "silence before the check")


@RECEIVE.case("short-gap", "a pause of nine tenths of ZVZ/CDT is none")
def short_gap(bench: Bench) -> None:
    bench.connect()
    wire = wire_block(b"UVW", bench.profile.block_check)
    bench.say(wire[:2])
    bench.silence(bench.profile.char_delay * 9 // 10 - ms(20), "a short pause")
    bench.say(wire[2:])
    bench.expect(Char.DLE, bench.profile.ack_delay, "a block with a short pause")


# ---- block check
def _with_check(bench: Bench) -> None:
    if not bench.profile.block_check:
        raise NotRun("procedure 3964 has no block check")


def _refused(bench: Bench, wire: bytes, what: str) -> None:
    bench.connect()
    bench.say(wire)
    start, got = bench.mark, bench.answer(bench.profile.ack_delay)
    if got is None:
        raise Fail(said("after {}: nothing, expected NAK", what))
    if got != Char.NAK:
        raise Fail(said("after {}: {}, expected NAK", what, named(got)))
    bench.measured(said("NAK after {}", what), bench.mark - start, None)


@RECEIVE.case("wrong-check", "a wrong block check: NAK")
def wrong_check(bench: Bench) -> None:
    _with_check(bench)
    wire = wire_block(b"UVW")
    _refused(bench, wire[:-1] + bytes((wire[-1] ^ 0x21,)), "a wrong block check")


@RECEIVE.case("check-once", "a doubled DLE enters the check both times: a check that counts it once is refused")
def check_once(bench: Bench) -> None:
    _with_check(bench)
    wire = wire_block(b"U\x10V")
    _refused(bench, wire[:-1] + bytes((wire[-1] ^ Char.DLE,)), "a check that counts a doubled DLE once")


@RECEIVE.case("doubled-dle", "a block with one DLE in it, its check by the rule: DLE")
def doubled_dle(bench: Bench) -> None:
    bench.give_good(b"U\x10V", "a block with one doubled DLE and the right check")


@RECEIVE.case("check-with-stx", "a check that includes STX (off by 02h) is refused")
def check_with_stx(bench: Bench) -> None:
    _with_check(bench)
    wire = wire_block(b"UVW")
    _refused(bench, wire[:-1] + bytes((wire[-1] ^ Char.STX,)), "a check that includes STX")


@RECEIVE.case("check-missing", "the check is missing and STX comes in its place: NAK")
def check_missing(bench: Bench) -> None:
    _with_check(bench)
    _refused(bench, wire_block(b"UVW")[:-1] + b"\x02", "STX in place of the check")


def _check_equals(value: int) -> None:
    def run(bench: Bench) -> None:
        _with_check(bench)
        data = b"U" + bytes((value ^ check_of(b"U\x10\x03"),))
        bench.give_good(data, said("a block whose check is {:02X}h", value))

    RECEIVE.add(f"check-{value:02x}", said("the block check is {:02X}h: sent once, read as it is", value), run)


for _value in (0x10, 0x15, 0x02, 0x03):
    _check_equals(_value)


# ---- data
@RECEIVE.case("dle-other", "DLE followed by neither DLE nor ETX")
def dle_other(bench: Bench) -> None:
    body = b"U\x10AV\x10\x03"
    wire = body + (bytes((check_of(body),)) if bench.profile.block_check else b"")
    if bench.profile.broken_pair is BrokenPair.DROP_DLE:
        bench.connect()
        bench.say(wire)
        bench.expect(Char.DLE, bench.profile.ack_delay, "DLE and another character")
    else:
        _refused(bench, wire, "DLE and another character")


@RECEIVE.case("stx-as-data", "02h inside a block is data")
def stx_as_data(bench: Bench) -> None:
    bench.give_good(b"U\x02\x02V", "a block with 02h in its data")


@RECEIVE.case("nak-as-data", "15h inside a block is data")
def nak_as_data(bench: Bench) -> None:
    bench.give_good(b"U\x15\x15V", "a block with 15h in its data")


def _length(name: str, title: str, extra: int | None, fixed: int = 0) -> None:
    def run(bench: Bench) -> None:
        size = fixed if extra is None else bench.profile.most_received + extra
        data = (b"U" + bytes(range(0x20, 0x7F)) * 43)[:size]
        if extra is not None and extra > 0:
            bench.connect()
            bench.say(wire_block(data, bench.profile.block_check))
            got = bench.answer(bench.profile.ack_delay)
            if got == Char.DLE:  # its own buffer may be longer: the maker's table gives the minimum
                raise Warn(said("the station takes more than this profile's {} characters", bench.profile.most_received))
            if got != Char.NAK:
                raise Fail(said("after {}: {}, expected NAK", said("a block of {} characters", size), named(got)))
        else:
            bench.give_good(data, said("a block of {} characters", size))

    RECEIVE.add(name, title, run)


_length("length-1", "a block of 1 character", None, 1)
_length("length-128", "a block of 128 characters", None, 128)
_length("length-limit", "a block as long as the profile allows (138 for RK512)", 0)
_length("length-over", "one character more: NAK, nothing delivered", 1)


@RECEIVE.case("all-dle", "a block of 64 times 10h, every one doubled")
def all_dle(bench: Bench) -> None:
    bench.give_good(DLE * 64, "a block of 64 times 10h")


@RECEIVE.case("empty", "an empty block: any answer, and the link stays good")
def empty(bench: Bench) -> None:
    got = bench.give(b"")
    if got not in (Char.DLE, Char.NAK):
        raise Fail(said("after an empty block: {}, expected DLE or NAK", named(got)))
    bench.remark(said("answers {}; the sources leave the choice open", named(got)))
    bench.settle()
    bench.give_good(b"UV", "a good block after an empty one")


@RECEIVE.case("etb", "DLE ETB ends a block as DLE ETX does")
def etb(bench: Bench) -> None:
    bench.connect()
    bench.say(wire_block(b"UV", bench.profile.block_check, Char.ETB))
    got = bench.answer(bench.profile.ack_delay)
    if got == Char.NAK:
        raise Warn("NAK: this station does not know DLE ETB, which only process computers send")
    if got != Char.DLE:
        raise Fail(said("after a block that ends with DLE ETB: {}, expected DLE", named(got)))


# ---- damage
@RECEIVE.case("parity-in-data", "a parity error in the data: received to the end, NAK")
def parity_in_data(bench: Bench) -> None:
    wire = wire_block(b"UVW", bench.profile.block_check)
    bench.connect()
    bench.say(wire[:1])
    bench.spoil()
    bench.say(wire[1:])
    bench.expect(Char.NAK, bench.profile.ack_delay, "a block with a parity error")


@RECEIVE.case("parity-in-check", "a parity error in the block check: NAK")
def parity_in_check(bench: Bench) -> None:
    _with_check(bench)
    bench.connect()
    bench.say(wire_block(b"UVW")[:-1])
    bench.spoil()
    bench.expect(Char.NAK, bench.profile.ack_delay, "a damaged check")


@RECEIVE.case("break-in-data", "BREAK inside a block: the station leaves it without an answer")
def break_in_data(bench: Bench) -> None:
    bench.connect()
    bench.say(b"UV")
    bench.spoil(Damage.BREAK)
    bench.silence(bench.profile.char_delay + bench.tolerance, "BREAK inside a block")


# ---- repeats
def _bad_block(bench: Bench) -> None:
    if bench.profile.block_check:
        wire = wire_block(b"UVW")
        _refused(bench, wire[:-1] + bytes((wire[-1] ^ 0x21,)), "a bad block")
    else:
        _refused(bench, b"U\x10AV\x10\x03", "a bad block")


@RECEIVE.case("repeat-in-time", "a good block after a bad one, within the block wait time (BWZ)")
def repeat_in_time(bench: Bench) -> None:
    _bad_block(bench)
    bench.silence(min(ms(500), bench.profile.block_wait // 2), "its NAK")
    bench.give_good(b"UVW", "the repeat within the block wait time")


@RECEIVE.case("repeat-late", "a good block after a bad one, after the block wait time")
def repeat_late(bench: Bench) -> None:
    _bad_block(bench)
    bench.silence(bench.profile.block_wait + ms(200), "its NAK")
    bench.give_good(b"UVW", "a block after the block wait time")


@RECEIVE.case("seven-bad", "seven bad blocks in a row, each NAK, then a good one")
def seven_bad(bench: Bench) -> None:
    for _ in range(BAD_IN_A_ROW):
        _bad_block(bench)
    bench.give_good(b"UVW", "a good block after seven bad ones")
