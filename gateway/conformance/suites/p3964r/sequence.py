"""3964R, direct sequences: a repeat on a NAK, a block on the station's own block (serial-protocols 1.3, 1.4)."""

from gateway.conformance.suites.line import LineTester
from gateway.conformance.suites.p3964r.receive import BLOCK, CONNECT, GAP, PAYLOAD
from gateway.pure.conformance.purpose import Purposes
from protocols.base.machine import ms
from protocols.p3964r.characters import Char, wire_block

SEQ = Purposes[LineTester]("3964R_SEQ", "both", "serial-protocols 1.3, 1.4", preamble=(CONNECT, BLOCK))
AT_ONCE = 6  # characters within which a second NAK would come


def _spoilt(t: LineTester) -> bytes:
    """A block that is refused with and without block check."""
    if not t.profile.block_check:
        return b"U\x10AV\x10\x03"
    wire = wire_block(PAYLOAD, True)
    return wire[:-1] + bytes((wire[-1] ^ 0x21,))


def _taken_now(t: LineTester, after: str) -> None:
    """Judged: STX and a block are answered directly after that."""
    t.open()
    t.say(wire_block(t.harmless, t.profile.block_check))
    t.expect(Char.DLE, t.profile.ack_delay, f"a good block directly after {after}")


@SEQ.case("BI_01", "a refused block brings one NAK", "ein abgelehnter Block bringt ein NAK", requirements=("RHO-SER-09",))
def one_nak(t: LineTester) -> None:
    with t.given():
        t.refused(_spoilt(t), "a spoilt block")
    _nothing_more(t, "NAK to a spoilt block")


def _nothing_more(t: LineTester, after: str) -> None:
    got = t.answer(AT_ONCE * t.wire.char_ns + ms(5))
    if got not in (None, Char.STX):
        t.fail(after, got, "nothing")
    if got == Char.STX:
        t.serve()


@SEQ.case(
    "BI_02",
    "a block that broke off brings one NAK",
    "ein abgebrochener Block bringt ein NAK",
    requirements=("RHO-SER-06",),
    preamble=(CONNECT, BLOCK, GAP, "3964R_SEQ_BI_01"),
)
def one_nak_behind_gap(t: LineTester) -> None:
    for part in (b"", b"UV"):
        t.connect()
        if part:
            t.say(part)
        with t.given():
            t.expect(Char.NAK, t.profile.char_delay, "silence inside a block")
        _nothing_more(t, "NAK to a block that broke off")


@SEQ.case(
    "RC_01",
    "the repeat that follows directly on its NAK is taken",
    "die Wiederholung direkt nach seinem NAK wird angenommen",
    requirements=("RHO-SER-09",),
    preamble=(CONNECT, BLOCK, "3964R_SEQ_BI_01"),
)
def repeat_at_once(t: LineTester) -> None:
    with t.given():
        t.refused(_spoilt(t), "a spoilt block")
    _taken_now(t, "NAK")


@SEQ.case(
    "BO_01",
    "directly after its own block it takes one",
    "direkt nach seinem eigenen Block nimmt er einen an",
    condition=("sends",),
    preamble=(CONNECT, BLOCK, "3964R_SND_BV_01"),
)
def after_own(t: LineTester) -> None:
    t.starts_sending()
    t.take()
    _taken_now(t, "its own block")
