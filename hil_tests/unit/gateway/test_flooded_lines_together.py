"""Lines that are flooded together share a turn of the services: those put off come first, in their order (AX-1799)."""

from collections import Counter
from collections.abc import Callable, Sequence

from gateway.links.serial.shared_turn import MOST_NS, SharedTurn
from protocols.base.machine import Ns


class Loop:
    """Turns by hand."""

    def __init__(self) -> None:
        self.now: Ns = 0
        self.next: list[Callable[[], None]] = []
        self.shared = SharedTurn(self.next.append, lambda: self.now)

    def turn(self, asking: Sequence[str], cost: Ns) -> list[str]:
        """Who read."""
        for call in self.next:
            call()
        self.next.clear()
        read = []
        for line in asking:
            if self.shared.may_read(line):
                read.append(line)
                self.now += cost
                self.shared.has_read()
        return read


def test_one_read_a_turn_goes_round() -> None:
    loop = Loop()
    assert [loop.turn("ABCD", MOST_NS) for _ in range(9)] == [[each] for each in "ABCDABCDA"]


def test_three_lines_share_it_evenly_whichever_asks_first() -> None:
    loop = Loop()
    read = [loop.turn("ABC", MOST_NS // 2) for _ in range(30)]
    assert max(map(len, read)) == 2
    counts = Counter(line for turn in read for line in turn)
    assert max(counts.values()) - min(counts.values()) <= 1


def test_a_line_that_stops_asking_holds_nobody_up() -> None:
    loop = Loop()
    assert loop.turn("ABC", MOST_NS) == ["A"]
    assert loop.turn("A", MOST_NS) == [], "B and C come first, and are gone"
    assert loop.turn("A", MOST_NS) == ["A"]
    assert loop.turn("", 0) == [] and loop.turn("B", 0) == ["B"]


def test_short_reads_all_pass_in_one_turn() -> None:
    loop = Loop()
    assert loop.turn("ABCDEFGH", MOST_NS // 16) == list("ABCDEFGH")
