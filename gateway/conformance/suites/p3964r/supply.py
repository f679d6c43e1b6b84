"""The supply of a 3964R station fails and returns: nothing of the time before is left, and it works again."""

from gateway.conformance.suites.line import LineTester
from gateway.conformance.suites.p3964r.conflicts import first as conflict
from gateway.conformance.suites.p3964r.receive import PAYLOAD
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Ended, Fail
from protocols.base.machine import ms
from protocols.p3964r.characters import Char

SUP = Purposes[LineTester]("3964R_SUP", "station", "power failure", condition=("power",), preamble=("3964R_RCV_BV_01",))
MOMENTS = (b"", b"U", b"U\x10", b"U\x10\x03")


def works_again(t: LineTester, what: str) -> None:
    """Judge: a good block is accepted, soon enough after the supply returned."""
    until = t.wire.now() + t.power.back
    while True:
        try:
            t.settle()
            t.good(PAYLOAD if t.harmless == b"UC" else t.harmless, f"a good block after {what}")
            return
        except Ended as failed:
            if t.wire.now() > until:
                got = failed.got or "nothing"
                raise Fail(f"it does not work again after {what}: {failed.reason}", "DLE (10h) to a good block", got) from failed
            t.power.pause(ms(500))


@SUP.case("RC_01", "the supply fails while it is idle: it works again", "Netzausfall in Ruhe: sie arbeitet wieder")
def idle(t: LineTester) -> None:
    t.power.cycle()
    works_again(t, "a power failure")


@SUP.case(
    "RC_02",
    "the supply fails while it receives a block: it works again, nothing of the block is left",
    "Netzausfall mitten in einem Block, den sie empfängt: sie arbeitet wieder, vom Block bleibt nichts",
)
def receiving(t: LineTester) -> None:
    for part in MOMENTS:
        t.connect()
        t.say(part)
        t.power.cycle()
        works_again(t, f"a power failure after {part.hex(' ').upper() or 'DLE'} of a block")


@SUP.case(
    "RC_03",
    "the supply fails while its own block waits for DLE: it works again",
    "Netzausfall, während ihr eigener Block auf DLE wartet: sie arbeitet wieder",
    condition=("sends",),
    preamble=("3964R_RCV_BV_01", "3964R_SND_BV_01"),
)
def sending(t: LineTester) -> None:
    t.starts_sending()
    t.take(acknowledge=False)
    t.power.cycle()
    works_again(t, "a power failure while it sends")


# ---- settings that the supply must not change
@SUP.case(
    "BV_01",
    "after a power failure the character delay is as before",
    "nach einem Netzausfall ist die Zeichenverzugszeit wie zuvor",
    preamble=("3964R_RCV_BV_01", "3964R_RCV_TI_01"),
    beside=Particulars(limits="ZVZ of the profile, 20 ms and one character to either side"),
)
def keeps_delay(t: LineTester) -> None:
    with t.given():
        t.power.cycle()
        works_again(t, "a power failure")
    t.connect()
    t.expect_at(Char.NAK, t.profile.char_delay, "a power failure, its DLE and silence")


@SUP.case(
    "BV_02",
    "after a power failure the acknowledgement delay and the priority are as before",
    "nach einem Netzausfall sind Quittungsverzugszeit und Priorität wie zuvor",
    condition=("sends",),
    preamble=("3964R_RCV_BV_01", "3964R_SND_TI_01", "3964R_CON_BV_01"),
    beside=Particulars(limits="QVZ of the profile, 20 ms and one character to either side"),
)
def keeps_wait(t: LineTester) -> None:
    with t.given():
        t.power.cycle()
        works_again(t, "a power failure")
    if not t.profile.silence_ends:
        t.starts_sending()
        t.expect_at(Char.STX, t.profile.ack_delay + t.profile.retry_pause, "a power failure, STX and silence")
        t.take()
        t.settle()
    conflict(t)
