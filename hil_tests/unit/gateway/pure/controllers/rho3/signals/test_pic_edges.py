"""A PIC that comes back switches nothing on by itself (AX-981)."""

from gateway.pure.controllers.rho3.functions.addresses import Places
from gateway.pure.controllers.rho3.signals.pic import OFF_NS, FreshEdges
from gateway.services.sources.pic import edges_of

ON, SELECT, PERMIT = 66, 81, 24
MS = 1_000_000


def octets(*bits: int) -> bytes:
    made = bytearray(128)
    for bit in bits:
        made[bit >> 3] |= 1 << (bit & 7)
    return bytes(made)


def test_the_first_scans_act_as_they_are() -> None:
    fresh = FreshEdges(edges_of(Places()))
    fresh.lost()  # the first interpreter begins
    assert fresh.passed(octets(ON, PERMIT), 0) == octets(ON, PERMIT)


def test_behind_a_loss_nothing_acts_until_drives_are_off_and_edges_are_fresh() -> None:
    fresh = FreshEdges(edges_of(Places()))
    fresh.passed(octets(ON, SELECT, PERMIT), 0)
    fresh.lost()
    assert fresh.passed(octets(ON, SELECT, PERMIT), 100 * MS) is None
    assert fresh.passed(octets(ON, SELECT, PERMIT), 100 * MS + OFF_NS - 1) is None
    assert fresh.passed(octets(ON, SELECT, PERMIT), 100 * MS + OFF_NS) == octets(PERMIT), "levels act, edges do not"
    assert fresh.passed(octets(SELECT, PERMIT), 700 * MS) == octets(PERMIT)
    assert fresh.passed(octets(ON, SELECT, PERMIT), 710 * MS) == octets(ON, PERMIT), "a fresh edge of one, the other still held"
    fresh.lost()
    fresh.lost()
    assert fresh.passed(octets(PERMIT), 800 * MS) is None, "lost again, held again"
