"""Lines that are flooded together share a turn of the services: the sign of life does not wait for all of them (AX-1799)."""

import asyncio
import contextlib
import time
from collections import Counter
from collections.abc import Callable, Sequence

from drivers.ports.serial.line_format import LineFormat
from drivers.ports.serial.pty import PtyPort
from gateway.links.serial.runner import LineRunner
from gateway.links.serial.shared_turn import MOST_NS, SharedTurn
from hil_tests.lab.partners.pty_master import PtyMaster
from protocols.base.machine import Damage, Ns, ms

LINES, COST_NS = 20, ms(13)


class Costly:
    """A machine that takes its time for each read."""

    def __init__(self, read: Callable[[], None]) -> None:
        self._read = read

    def receive(self, data: bytes, now: Ns) -> Sequence[object]:
        time.sleep(COST_NS / 1e9)
        self._read()
        return []

    def damaged(self, kind: Damage, now: Ns) -> Sequence[object]:
        return []

    def sent(self, now: Ns) -> Sequence[object]:
        return []

    wake = lost = sent

    def deadline(self) -> Ns | None:
        return None

    def take_output(self) -> bytes:
        return b""


def runner(path: str, at: int, reads: Counter[int]) -> LineRunner[object]:
    return LineRunner(lambda: PtyPort(path, LineFormat(9600)), Costly(lambda: reads.update([at])), lambda event, now: None)


def test_twenty_flooded_ptys_leave_the_turn_in_time_and_all_get_theirs() -> None:
    reads: Counter[int] = Counter()
    turns: list[int] = []

    async def play() -> None:
        masters = [PtyMaster() for _ in range(LINES)]
        runners = [runner(master.path, at, reads) for at, master in enumerate(masters)]
        while not all(each.state.connected for each in runners):
            await asyncio.sleep(0.01)
        for _ in range(60):
            for master in masters:
                with contextlib.suppress(BlockingIOError):
                    master.write(b"\xff\x02Z" * 400)
            before = reads.total()
            await asyncio.sleep(0)
            turns.append(reads.total() - before)
        for each in runners:
            each.close()
        for master in masters:
            master.close()

    asyncio.run(play())
    assert max(turns) <= MOST_NS // COST_NS + 1, "reads in one turn"
    assert max(reads.values()) - min(reads[at] for at in range(LINES)) <= 1, f"in turn: {reads}"


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
