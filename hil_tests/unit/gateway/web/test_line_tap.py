"""The tap keeps what passes a line's machine and changes nothing of it."""

from gateway.links.serial.tap import KEPT, KEPT_CHARACTERS, Tap
from protocols.base.machine import Damage, ms
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import RHO3, Priority


def test_what_was_heard_and_said_is_kept_in_order() -> None:
    tap = Tap(Link(RHO3, Priority.LOW))
    assert list(tap.receive(b"\x02", ms(1))) == []
    assert tap.take_output() == b"\x10"
    tap.damaged(Damage.PARITY, ms(3))
    assert tap.since(0) == [(1, ms(1), "A", b"\x02"), (2, ms(1), "B", b"\x10"), (3, ms(3), "A", Damage.PARITY)]
    assert tap.since(2) == [(3, ms(3), "A", Damage.PARITY)]
    assert tap.deadline() is not None


def test_a_page_that_counted_with_a_predecessor_gets_everything() -> None:
    tap = Tap(Link(RHO3, Priority.LOW))
    tap.receive(b"\x02", ms(1))
    assert [piece[0] for piece in tap.since(5000)] == [1]


def test_only_so_much_is_kept() -> None:
    tap = Tap(Link(RHO3, Priority.LOW))
    for n in range(KEPT + 10):
        tap.receive(b"A", ms(n))
    assert len(tap.since(0)) == KEPT
    assert tap.since(0)[0][0] == 11


def test_of_a_flooded_line_the_newest_characters_are_kept_and_no_more() -> None:
    """As pieces of 4,096 they were 2 MB, which the services wrote as JSON in one turn whenever a page looked."""
    tap = Tap(Link(RHO3, Priority.LOW))
    for n in range(200):
        tap.receive(b"Z" * 4096, ms(n))
    kept = tap.since(0)
    assert sum(len(what) for _, _, _, what in kept if isinstance(what, bytes)) <= KEPT_CHARACTERS and kept[-1][0] == 200 and len(kept) > 1
    tap.receive(b"\x02" * (2 * KEPT_CHARACTERS), ms(200))
    assert [piece[0] for piece in tap.since(0)] == [201], "one piece is told whole"
