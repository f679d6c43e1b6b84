"""One turn of an event loop, shared by all lines of the process: the reading of flooded lines together is bounded (AX-1799)."""

import asyncio
import time
from collections.abc import Callable
from weakref import WeakKeyDictionary

from protocols.base.machine import Ns, ms

MOST_NS: Ns = ms(25)  # of a turn; a read that began before is finished

_turns: "WeakKeyDictionary[asyncio.AbstractEventLoop, SharedTurn]" = WeakKeyDictionary()


class SharedTurn:
    """Lines ask it before they read.  A line that is put off stays readable, so it asks again in the next turn; those put off read in
    their order, before any other line reads again."""

    def __init__(self, again: Callable[[Callable[[], None]], object], clock: Callable[[], Ns] = time.monotonic_ns) -> None:
        """`again` calls a function at the beginning of the next turn."""
        self._again, self._clock = again, clock
        self._began: Ns | None = None  # of the reading in this turn
        self._asked: set[object] = set()  # in this turn
        self._queue: dict[object, None] = {}  # put off, the longest waiting first

    def may_read(self, line: object) -> bool:
        """Whether this line reads in this turn."""
        if not self._asked:
            self._again(self._next)
        self._asked.add(line)
        now = self._clock()
        spent = self._began is not None and now - self._began >= MOST_NS
        if spent or (self._queue and next(iter(self._queue)) is not line):
            self._queue[line] = None
            return False
        self._queue.pop(line, None)
        if self._began is None:
            self._began = now
        return True

    def _next(self) -> None:
        self._queue = {line: None for line in self._queue if line in self._asked}  # one that asks no more has nothing to read, or no port
        self._began, self._asked = None, set()


def shared_turn(loop: asyncio.AbstractEventLoop) -> SharedTurn:
    """That of all lines of a loop."""
    if loop not in _turns:
        _turns[loop] = SharedTurn(lambda call: asyncio.get_running_loop().call_soon(call))  # no loop in it: it would never be forgotten
    return _turns[loop]
