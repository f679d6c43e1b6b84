"""One turn of an event loop, shared by all lines of the process: the reading of flooded lines together is bounded (AX-1799)."""

import asyncio
import time
from collections.abc import Callable
from weakref import WeakKeyDictionary

from protocols.base.machine import Ns, ms

MOST_NS: Ns = ms(25)  # of a turn; a read that began before is finished
SHORT_NS: Ns = ms(1)  # total duration of reads up to which the next turn needs no notice: a notice costs as much as such a read

_turns: "WeakKeyDictionary[asyncio.AbstractEventLoop, SharedTurn]" = WeakKeyDictionary()


class SharedTurn:
    """Lines call it before they read, and report that they have.  A deferred line stays readable, so it calls again in the next turn;
    deferred lines read in their order, before any other line reads again.
    """

    def __init__(self, again: Callable[[Callable[[], None]], object], clock: Callable[[], Ns] = time.monotonic_ns) -> None:
        """`again` calls a function at the beginning of the next turn."""
        self._again, self._clock = again, clock
        self._began: Ns = 0  # the read under way
        self._spent: Ns = 0  # with reading, since the last notice of a turn
        self._awaited = False  # the next turn is announced
        self._asked: set[object] = set()  # in this turn
        self._queue: dict[object, None] = {}  # put off, the longest waiting first

    def may_read(self, line: object) -> bool:
        """Whether this line reads in this turn."""
        if self._awaited or self._queue:
            self._await()
            self._asked.add(line)
            if self._spent >= MOST_NS or (self._queue and next(iter(self._queue)) is not line):
                self._queue[line] = None
                return False
            self._queue.pop(line, None)
        self._began = self._clock()
        return True

    def has_read(self) -> None:
        """The line that was let read has done so."""
        self._spent += self._clock() - self._began
        if self._spent >= SHORT_NS:
            self._await()

    def _await(self) -> None:
        if not self._awaited:
            self._awaited = True
            self._again(self._next)

    def _next(self) -> None:
        self._queue = {line: None for line in self._queue if line in self._asked}  # a line that calls no more has no data, or no port
        self._spent, self._awaited = 0, False
        self._asked.clear()


def shared_turn(loop: asyncio.AbstractEventLoop) -> SharedTurn:
    """That of all lines of a loop."""
    if loop not in _turns:
        _turns[loop] = SharedTurn(lambda call: asyncio.get_running_loop().call_soon(call))  # no loop in it: it would never be forgotten
    return _turns[loop]
