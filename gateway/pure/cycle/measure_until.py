"""MOVE UNTIL in the cycle: the input that ends a part of a program, and the position caught at its edge (@MPOS).  Pure.

Positions are those the drives latched at each SYNC; the edge has the stamp its command source gave the input's byte, and what lies
between two SYNCs is interpolated (motion.measure).  Source: rho 3 Releases part 1, L1100-1290; part 2, L6756-6830; AX-391, AX-457.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot
from typing import NamedTuple

from drivers.drives.family import Latched
from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.cycle.measured import Measured
from gateway.pure.cycle.probes import LATE, DriveProbe
from gateway.pure.image.records.cell import CellState, InputImage, Quality
from gateway.pure.image.records.planner import NO_LIMIT, UntilInput
from motion.execution.stepper import State
from motion.measure.history import History
from motion.measure.inputs import Board, InputKind, MeasuringInput
from motion.measure.mpos import measured
from protocols.base.machine import Ns

BOARD = 1  # the axes of one channel are one servo board
GOOD = int(Quality.GOOD)
PATIENT = 50  # cycles the end of a part waits for positions that do not come
STILL = 1e-9  # m/s or rad/s
TO_REST_NS = 60_000_000  # five time constants of a position loop of Kv 80 1/s: drives lag behind a path that has ended (AX-566)


class Course(NamedTuple):
    """From an edge on: to these places of all axes (m or rad) at this speed; speed 0: the axes stay where they are."""

    places: tuple[float, ...] = ()
    speed: float = 0.0


@dataclass(slots=True)
class _Part:
    """What has happened since the part began."""

    edge: tuple[float, ...] = ()  # where the axes were at it, of a part that runs on
    speeds: tuple[float, ...] = ()  # as its edge was seen
    level: bool | None = None  # of the last cycle in which the input was good
    hit: Ns | None = None
    stored: bool = False
    patience: int = PATIENT
    ended: int = 0  # cycles since the path ended
    moved: int = 0  # cycles the part has moved
    late: bool = False  # its time was up before the input came


class CoreMeasure:
    """One program's measuring.  distance: m or rad that a modified MOVE UNTIL runs on past its edge (special function 42)."""

    def __init__(self, state: CellState, axes: int, period_ns: Ns, mpos: Measured) -> None:
        self._state, self._axes, self._period_ns, self._mpos = state, axes, period_ns, mpos
        self.distance = 0.0
        self._until: UntilInput | None = None
        self._probe: DriveProbe | None = None  # of a part whose edge the drives catch
        self._history = History(axes)
        self._stamp: Ns = 0  # of the input's byte in the last cycle in which it was good
        self._part = _Part()

    def _heard_by(self) -> int:
        """Cycles after the end of a part until the drives have reported every edge that they passed."""
        return TO_REST_NS // self._period_ns + LATE

    def program_started(self) -> None:
        """What an earlier program measured is not this one's (L1132)."""
        self._state.measured_mask = 0
        self.end()

    def begin(self, until: UntilInput, inputs: InputImage, now: Ns) -> None:
        """The part that follows ends with this input."""
        self._until, self._history = until, History(self._axes)
        self._part = _Part()
        self._probe = DriveProbe(until.drives, until.level) if until.drives else None
        if self._probe is None:
            self._see(until, inputs, now)

    def end(self) -> None:
        """The part is over, or the program."""
        self._until, self._probe, self._part.late = None, None, False

    def hear(self, said: Sequence[tuple[Latched, HeldAxis] | None]) -> None:
        """What the drives' own probes have caught, before look()."""
        if self._probe is not None:
            self._probe.hear(said)

    @property
    def by_drives(self) -> bool:
        """The drives catch the edge of this part."""
        return self._probe is not None

    @property
    def on(self) -> bool:
        """Return whether a part with an input is running."""
        return self._until is not None

    @property
    def runs_on(self) -> bool:
        """Return whether this part continues by `distance` after its edge."""
        return self._until is not None and self._until.runs_on

    def course(self, places: Sequence[float], speeds: Sequence[float]) -> Course | None:
        """Behind the edge, once a cycle until it is known; None: where the axes were at the edge is not known yet.  places, speeds: set
        values of this cycle; the speeds of the first call count, they are of the cycle that saw the edge."""
        self._part.speeds = self._part.speeds or tuple(speeds)
        if self.waits:
            return None
        mask = self._until.mask if self._until is not None else 0
        speed = hypot(*(v for n, v in enumerate(self._part.speeds) if mask >> n & 1))
        if not self._part.edge or speed < STILL:
            return Course()
        rows = zip(places, self._part.edge, self._part.speeds, strict=True)
        found = tuple(edge + self.distance * v / speed if v else place for place, edge, v in rows)
        return Course(found, hypot(*self._part.speeds))

    @property
    def waits(self) -> bool:
        """The edge came, its position is not stored yet; or a drive may have passed it and has not reported it yet."""
        if self._until is None or self._part.stored or self._part.late:
            return False
        if self._part.hit is not None:
            return self._part.patience > 0
        return self._probe is not None and self._part.ended < self._heard_by()

    def value_present(self, inputs: InputImage) -> bool:
        """Before the block: an input that has its value already lets nothing move, and the axes' place is measured; a probe has to
        change, whatever its state is now (L1130)."""
        until = self._until
        if until is None or until.by_edge or self._read(until, inputs) is not until.level:
            return False
        self._part.hit = 0
        return True

    def timeless(self) -> bool:
        """Before the block, whose input does not have its value yet: whether its time is 0, so that nothing moves."""
        self._part.late = self._part.late or (self._until is not None and self._until.within == 0.0)
        return self._part.late

    def look(self, inputs: InputImage, now: Ns, path: State) -> bool:
        """Once a cycle while the part is on: whether the path is to stop now, or its edge came.  A stopped path stays for its resume."""
        until = self._until
        if self._part.late:
            return False  # an edge while the axes brake is too late
        if until is not None and self._probe is not None:
            self._part.hit = now if self._part.hit is None and self._probe.hit else self._part.hit
            self._part.ended = self._part.ended + 1 if path is State.IDLE else 0
            return self._part.hit is not None and path in (State.RUNNING, State.IDLE)
        if until is not None and until.runs_on and self._part.hit is not None:
            return path in (State.RUNNING, State.IDLE)  # its path may end before the place of the edge is known
        if until is None or path is State.IDLE:
            return False
        before = self._part.level
        edge = self._see(until, inputs, now)
        if (
            self._part.hit is None
            and self._part.level is until.level
            and ((before is not None and before is not until.level) or not until.by_edge)
        ):
            if path is not State.RUNNING and not until.by_edge:
                return False  # the level counts when the path continues
            self._part.hit = edge
        return self._part.hit is not None and path is State.RUNNING

    def late(self, path: State) -> bool:
        """Once a cycle after look(), while the input has not come: whether the time of the part is up now.  A stopped path does not
        use it up."""
        until = self._until
        if until is None or until.within == NO_LIMIT or self._part.late or path is not State.RUNNING:
            return False
        self._part.moved += 1
        self._part.late = self._part.moved * self._period_ns >= round(until.within * 1e9)
        return self._part.late

    def store(self, actual: Sequence[float | None]) -> None:
        """actual: (axes,) as latched at this SYNC, None where the telegram did not come."""
        until, now = self._until, self._state.sync_ns
        if until is None:
            return
        places = [place for place in actual if place is not None]
        if len(places) == self._axes:
            self._history.add(now, places)
            if self._part.hit == 0:
                self._part.hit = now
        if self._part.hit is None or self._part.stored:
            return
        self._part.patience -= 1
        if self._probe is not None:
            self._part.hit = self._probe.instant(self._history) or 0
            if not self._part.hit:
                return
        board = frozenset(n for n in range(self._axes) if until.mask >> n & 1)
        asked = MeasuringInput(0, InputKind.PROBE if until.by_edge else InputKind.HIGH_SPEED, BOARD, 0)
        hit = max(self._part.hit, self._history.oldest_ns or 0)  # the part began with the oldest
        found = measured(asked, hit, self._period_ns, range(self._axes), {BOARD: Board(board, board)}, self._history)
        if found is None or self._part.hit == 0:
            return
        self._part.stored = True
        caught = self._probe.places if self._probe is not None else {}
        self._mpos.forget(until.mask)
        self._mpos.store({n: caught.get(n, place) for n, place in enumerate(found) if place is not None})
        if until.runs_on:
            self._part.edge = tuple(caught.get(n, place) for n, place in enumerate(self._history.at(hit)))

    def _see(self, until: UntilInput, inputs: InputImage, now: Ns) -> Ns:
        """Remembers the level; the stamp a change of it has: that of its byte where it is new, else this cycle's (AX-456).

        A module the cycle receives itself may have spoken after this SYNC (AX-481); the position of that instant comes with the next one.
        """
        level = self._read(until, inputs)
        if level is None:
            return now
        stamp, before = inputs.stamps[until.number >> 3], self._stamp
        self._part.level, self._stamp = level, stamp
        return stamp if before < stamp <= now + self._period_ns else now

    @staticmethod
    def _read(until: UntilInput, inputs: InputImage) -> bool | None:
        """An input that is not good has no value."""
        return inputs.bit(until.number) if inputs.quality[until.number >> 3] == GOOD else None
