"""3964R, the station receives: wrong checks, damaged characters, characters at the wrong moment (serial-protocols 1.2, 1.4, 6)."""

from collections.abc import Iterator
from contextlib import contextmanager

from gateway.conformance.suites.line import DLE, NAK, STX, LineTester, named
from gateway.conformance.suites.p3964r.receive import BAD, CHECK, CONNECT, PAYLOAD, RCV
from gateway.pure.conformance.verdict import Disturbed, Fail, NotApplicable, Warn
from protocols.base.machine import Damage, ms
from protocols.p3964r.characters import Char, check_of, wire_block
from protocols.p3964r.profiles import RHO3, BrokenPair, Stray


def with_wrong_check(data: bytes, change: int) -> bytes:
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
        t.refused(with_wrong_check(PAYLOAD, 1 << bit), f"a block check with bit {bit} wrong")


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
    t.refused(with_wrong_check(b"U\x10V", 0x10), "a check that counts a doubled DLE once")


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
    t.refused(with_wrong_check(PAYLOAD, 0xFF), "a complemented check")
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
    t.settle()  # one that answers at once may ignore the rest until the line is quiet
    rest = b"UV\x10\x03"  # a station that restarts after DLE STX finds its check right
    wire = b"UX\x10\x02" + rest + (bytes((check_of(rest),)) if t.profile.block_check else b"")
    t.refused(wire, "a block with DLE STX inside, whose check is that of the rest")


@RCV.case(
    "BI_07",
    "the rest of a refused block is not a connection",
    "der Rest eines abgelehnten Blocks ist kein Verbindungsaufbau",
    clause="serial-protocols 1.4: noted, heard to the end",
    preamble=BAD,
)
def rest(t: LineTester) -> None:
    body = b"U\x10A\x02V\x02W\x10\x03"
    t.connect()
    t.say(body + (bytes((check_of(body) ^ 0x01,)) if t.profile.block_check else b""))
    _one_nak(t, "a refused block")


def _one_nak(t: LineTester, what: str) -> None:
    """Judged: its rest, which holds 02h, opens nothing; it is refused."""
    got = [t.answer(t.profile.ack_delay)]
    while (more := t.answer(t.profile.char_delay + t.tolerance)) is not None:
        got.append(more)
    if Char.DLE in got:
        raise Fail(f"a 02h in the rest of {what} was answered with DLE", "one NAK (15h)", ", ".join(map(named, got)))
    if Char.NAK not in got:
        raise Fail(f"{what} was not answered", "one NAK (15h)", ", ".join(map(named, got)))


@RCV.case(
    "BI_08",
    "a parity error in the data: received to the end, NAK",
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


@RCV.case(
    "BI_12",
    "the rest of a block with a damaged character is not a connection",
    "der Rest eines Blocks mit einem gestörten Zeichen ist kein Verbindungsaufbau",
    clause="serial-protocols 1.4: noted, heard to the end",
    requirements=("RHO-SER-09",),
    preamble=(*BAD, "3964R_RCV_BI_08"),
)
def rest_of_damaged(t: LineTester) -> None:
    wire = wire_block(b"UA\x02V\x02W", t.profile.block_check)
    t.connect()
    t.say(wire[:1])
    t.spoil()
    t.say(wire[1:])
    _one_nak(t, "a block with a damaged character")


@RCV.case("BI_10", "BREAK inside a block: left without an answer", "BREAK im Block: ohne Antwort verlassen")
def break_inside(t: LineTester) -> None:
    wire = wire_block(b"UVW", t.profile.block_check)
    t.connect()
    t.say(wire[:1])
    t.spoil(Damage.BREAK)
    t.say(wire[1:])
    if (got := t.answer(t.profile.char_delay + t.tolerance)) == Char.DLE:
        t.fail("a block with a BREAK inside", got, "nothing, or NAK (15h)")
    t.settle()
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
    """Permitted answers to a character in idle: the profile's own, or another maker's (WARN)."""
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


@RCV.case("BO_05", "DLE ETX in idle is not a block", "DLE ETX in Ruhe ist kein Block", preamble=(CONNECT,))
def idle_end(t: LineTester) -> None:
    t.say(b"\x10\x03\x55")
    got = [t.answer(t.profile.char_delay + t.tolerance + ms(200))]
    while (more := t.answer(t.profile.char_delay + t.tolerance)) is not None:
        got.append(more)
    if Char.STX in got:
        raise Disturbed("the station began to send", "nothing", "STX (02h)")
    if Char.DLE in got:
        raise Fail("after DLE ETX in idle: DLE", "nothing, or NAK (15h)", "DLE (10h)")


@contextmanager
def _no_own_request() -> Iterator[None]:
    """An STX of the station is a request of its own that collided with ours: repeat the case, other cases judge conflicts."""
    try:
        yield
    except Fail as failed:
        if failed.got == named(Char.STX):
            raise Disturbed("its own send request has collided with our STX", failed.expected, failed.got) from failed
        raise


def _wait_is_open(t: LineTester) -> bool:
    """No source states for this maker how long it waits for a buffer."""
    return "no_buffer_wait" in t.profile.open_fields or t.profile.name == RHO3.name  # AX-006: its manual has only the block refused


@contextmanager
def _as_makers_differ(t: LineTester) -> Iterator[None]:
    """A NAK before the wait of the profile is WARN where the profile leaves that wait open."""
    start = t.mark
    try:
        yield
    except Fail as failed:
        if _wait_is_open(t) and t.notes.trace[-1].data == NAK and t.mark - start < t.profile.no_buffer_wait:
            said = f"{failed.reason}; makers differ, and no source states it for {t.profile.name}"
            raise Warn(said, failed.expected, failed.got) from failed
        raise


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
        with _no_own_request(), _as_makers_differ(t):
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
        with _no_own_request():
            if got == Char.NAK and _wait_is_open(t):
                raise NotApplicable("it refuses at once while no buffer is free")
            if got is not None:
                t.fail("STX while the buffer is full", got, "nothing for 150 ms")
    finally:
        t.setup.hold(False)
    t.mark = max(t.mark, t.wire.now())
    t.expect(Char.DLE, t.profile.ack_delay, "the buffer became free")
    t.say(wire_block(PAYLOAD, t.profile.block_check))
    t.expect(Char.DLE, t.profile.ack_delay, "a good block")
