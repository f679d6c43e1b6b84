"""Lines that are flooded together share a turn of the services: the sign of life does not wait for all of them (AX-1799)."""

import asyncio
import contextlib
import time
from collections import Counter
from collections.abc import Callable, Sequence

from drivers.ports.serial.line_format import LineFormat
from drivers.ports.serial.pty import PtyPort
from gateway.links.serial.runner import LineRunner
from gateway.links.serial.shared_turn import MOST_NS
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
