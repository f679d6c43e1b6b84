"""Homing methods of CiA 402: 1..14 and 17..30 (switches, with and without index), 33, 34 (index), 35 and 37 (here).

Source: CiA 402-3 (IEC 61800-7-201), homing mode, figures of the methods.  Every method with a switch looks for one edge of one switch
in one direction; the figures differ only in the edge, the direction and where the search begins (AX-288).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto

from drivers.emulator.cia402.switches import Edge, Signal


@dataclass(frozen=True, slots=True)
class Method:
    """Home is the edge on `side` of the switch's active range, crossed in direction `final`; then the next index pulse on that way."""

    signal: Signal
    side: int  # -1: lower end of the active range, +1: upper end
    final: int  # direction of the last leg
    start: int  # direction when the search begins with the switch not active
    turns_at_limits: bool  # a limit switch on the way reverses; else it ends the homing with an error
    index: bool

    @property
    def rising(self) -> bool:
        """The wanted edge: in direction `final` the switch turns on."""
        return self.side == -self.final


def _table() -> dict[int, Method]:
    home, low, high = Signal.HOME, Signal.NEGATIVE_LIMIT, Signal.POSITIVE_LIMIT
    rows = {
        1: (low, +1, +1, -1, True),
        2: (high, -1, -1, +1, True),
        3: (home, -1, -1, +1, False),
        4: (home, -1, +1, +1, False),
        5: (home, +1, +1, -1, False),
        6: (home, +1, -1, -1, False),
        7: (home, -1, -1, +1, True),
        8: (home, -1, +1, +1, True),
        9: (home, +1, -1, +1, True),
        10: (home, +1, +1, +1, True),
        11: (home, +1, +1, -1, True),
        12: (home, +1, -1, -1, True),
        13: (home, -1, +1, -1, True),
        14: (home, -1, -1, -1, True),
    }
    table = {number: Method(*row, index=True) for number, row in rows.items()}
    return table | {number + 16: Method(*row, index=False) for number, row in rows.items()}


SWITCHED: Mapping[int, Method] = _table()
TO_INDEX: Mapping[int, int] = {33: -1, 34: +1}
HERE = frozenset((35, 37))
METHODS = frozenset(SWITCHED) | frozenset(TO_INDEX) | HERE


class Phase(Enum):
    IDLE = auto()
    SWITCH = auto()  # on the way to the edge
    INDEX = auto()  # edge found, to the index pulse
    STOPPING = auto()  # home found, slowing down
    DONE = auto()
    INTERRUPTED = auto()
    FAILED = auto()


class Homing:
    """`begin`, then `edge` for each edge crossed; sets `direction` and `fast` for the axis."""

    def __init__(self, active: Callable[[Signal], bool]) -> None:
        self._active = active
        self.phase = Phase.IDLE
        self.direction = 0
        self.fast = True
        self.home: int | None = None  # counter at the home position
        self._method: Method | None = None

    @property
    def running(self) -> bool:
        return self.phase in (Phase.SWITCH, Phase.INDEX, Phase.STOPPING)

    @property
    def wants_index(self) -> bool:
        return self.phase is Phase.INDEX

    def begin(self, number: int, counter: int) -> None:
        """Method `number` of METHODS, from here."""
        self.home, self.fast, self._method = None, True, None
        if number in HERE:
            self.home, self.direction, self.phase = counter, 0, Phase.STOPPING
        elif number in TO_INDEX:
            self.direction, self.fast, self.phase = TO_INDEX[number], False, Phase.INDEX
        else:
            method = self._method = SWITCHED[number]
            self.phase = Phase.SWITCH
            if self._active(method.signal):
                self.direction = -method.final if method.rising else method.final
                self.fast = False
            else:
                self.direction = method.start
                self._blocked()

    def _blocked(self) -> None:
        """A limit switch is in the way from the beginning."""
        for signal, direction in ((Signal.NEGATIVE_LIMIT, -1), (Signal.POSITIVE_LIMIT, 1)):
            if self.direction == direction and self._active(signal):
                self._limit(signal)

    def edge(self, edge: Edge) -> None:
        method = self._method
        if self.phase is Phase.INDEX and edge.signal is Signal.INDEX and edge.direction == self.direction:
            self._found(edge.counter)
        elif self.phase is Phase.SWITCH and method is not None and edge.signal is method.signal:
            self._switch(method, edge)
        elif edge.signal in (Signal.NEGATIVE_LIMIT, Signal.POSITIVE_LIMIT) and edge.rising:
            self._limit(edge.signal)

    def _switch(self, method: Method, edge: Edge) -> None:
        side = -1 if edge.rising is (edge.direction > 0) else 1
        if side != method.side or edge.direction != self.direction:
            return
        if edge.direction == method.final:
            if method.index:
                self.phase, self.fast = Phase.INDEX, False
            else:
                self._found(edge.counter)
        else:
            self.direction, self.fast = method.final, False

    def _limit(self, signal: Signal) -> None:
        towards = -1 if signal is Signal.NEGATIVE_LIMIT else 1
        if towards != self.direction or self.phase is Phase.STOPPING:
            return
        if self.phase is Phase.SWITCH and self._method is not None and self._method.turns_at_limits:
            self.direction = -self.direction
        else:
            self.phase, self.direction = Phase.FAILED, 0

    def _found(self, counter: int) -> None:
        self.home, self.direction, self.phase = counter, 0, Phase.STOPPING

    def stopped(self) -> None:
        if self.phase is Phase.STOPPING:
            self.phase = Phase.DONE

    def interrupt(self) -> None:
        if self.running:
            self.phase, self.direction = Phase.INTERRUPTED, 0
