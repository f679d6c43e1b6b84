"""setLatch and getLatch of VAL 3: the joint position at a rising edge of a fast input.

Source: VAL 3 reference, L4609-4656.  Only fIn0 and fIn1, else run-time error 70.  The latch is armed at most 0.2 ms after setLatch; the
edge must be low for 31.25 us and then high for 31.25 us; the position is that of 0 .. 62.5 us after the edge.
"""

from collections.abc import Sequence
from typing import NamedTuple

from motion.measure.history import History
from motion.val3.errors import RuntimeFault

FAST_INPUTS = ("fIn0", "fIn1")
ARMING_NS = 200_000  # longest delay of the original controller; programs that forget delay(0) fail here as they may there
PULSE_NS = 31_250
UPDATE_NS = 62_500  # update time of the arm's position: greatest delay of a latched value; axisgate latches the edge itself (AX-462)


class Change(NamedTuple):
    """A fast input changes."""

    name: str
    stamp_ns: int
    value: bool


class Latch:
    """One arm's latch.  `step` once a cycle, after the positions of the cycle went into the history."""

    def __init__(self, history: History, axes: Sequence[int]) -> None:
        self._history, self._axes = history, tuple(axes)
        self._input: str | None = None  # armed
        self._from_ns = 0
        self._risen: int | None = None  # edge that waits for its 31.25 us of high
        self._low: dict[str, int] = {}  # since when an input has been low
        self._caught: int | None = None
        self._position: tuple[float, ...] | None = None

    def set_latch(self, name: str, now_ns: int) -> None:
        """setLatch(diInput): discard the latched value and wait for the next rising edge."""
        if name not in FAST_INPUTS:
            raise RuntimeFault(70, f"setLatch: {name} is not a fast input, {' and '.join(FAST_INPUTS)} are")
        self._input, self._from_ns = name, now_ns + ARMING_NS
        self._risen = self._caught = self._position = None

    @property
    def armed_ns(self) -> int | None:
        """When the latch armed last began to count; delay(0) lets at least this much pass."""
        return self._from_ns if self._input is not None else None

    def get_latch(self) -> tuple[float, ...] | None:
        """getLatch(jPosition): m or rad of the arm's axes; None is false, jPosition stays.  The same until the next setLatch."""
        return self._position

    def step(self, now_ns: int, changes: Sequence[Change]) -> None:
        """changes: of all fast inputs since the last cycle, in the order of their stamps."""
        for change in changes:
            self._changed(change._replace(stamp_ns=min(change.stamp_ns, now_ns)))
        if self._risen is not None and now_ns - self._risen >= PULSE_NS:
            self._caught, self._risen, self._input = self._risen, None, None
        newest, oldest = self._history.newest_ns, self._history.oldest_ns
        if self._caught is not None and newest is not None and oldest is not None and newest >= self._caught:
            if self._caught >= oldest:  # older edges: the position at that time is no longer kept
                there = self._history.at(self._caught)
                self._position = tuple(there[axis] for axis in self._axes)
            self._caught = None

    def _changed(self, change: Change) -> None:
        if not change.value:
            if self._risen is not None and change.name == self._input:
                if change.stamp_ns - self._risen >= PULSE_NS:
                    self._caught, self._input = self._risen, None
                self._risen = None
            self._low[change.name] = change.stamp_ns
            return
        low = self._low.pop(change.name, None)
        long_enough = low is None or change.stamp_ns - low >= PULSE_NS  # None: low since before anybody looked
        if change.name == self._input and self._risen is None and long_enough and change.stamp_ns >= self._from_ns:
            self._risen = change.stamp_ns
