"""Where axes were, as programs ask for it: at the edge that ends a part, in passing, latched, on the tape of a reference path.  Pure."""

from collections.abc import Callable, Sequence

from drivers.drives.family import Actual
from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.cycle.inputs import CoreFlying
from gateway.pure.cycle.measure_until import CoreMeasure
from gateway.pure.cycle.measured import Measured
from gateway.pure.cycle.points import CoreLatch, ReferencePathRecorder
from gateway.pure.cycle.probes import latches
from gateway.pure.image.records.cell import CellState, InputImage
from gateway.pure.image.records.inputs import FlyingAt
from gateway.pure.image.records.points import LatchAt, ReferencePathPoint


class Storing:
    """Of one core."""

    def __init__(self, state: CellState, axes: Sequence[HeldAxis], period_ns: int) -> None:
        mpos = Measured(state, axes)
        self._axes = axes
        self.measure = CoreMeasure(state, len(axes), period_ns, mpos)
        self.flying = CoreFlying(state, len(axes), period_ns, mpos)
        self.latch = CoreLatch(state, len(axes), period_ns, mpos)
        self.tape = ReferencePathRecorder(mpos)

    @property
    def on(self) -> bool:
        """Positions are wanted (store)."""
        return self.measure.on or self.flying.on or self.latch.on or self.tape.on

    @property
    def by_drives(self) -> bool:
        """Return whether catches of the drives' own probes are needed (hear)."""
        return self.measure.by_drives or self.flying.by_drives

    def program_started(self) -> None:
        """Of the program before nothing waits any more."""
        self.measure.program_started()
        self.flying.program_started()
        self.latch.end()

    def hear(self, actuals: Sequence[Actual | None]) -> None:
        """actuals: (axes,) of this SYNC, before the mover's step."""
        said = latches(self._axes, actuals)
        self.measure.hear(said)
        self.flying.hear(said)

    def store(self, actual: Sequence[float | None], counters: Callable[[], Sequence[float]], *, program: bool) -> None:
        """actual: (axes,) as latched at this SYNC, None where the telegram did not come; counters: of measuring systems other than axes;
        program: one is under way."""
        self.measure.store(actual)
        if not program:
            self.flying.end()
            self.latch.end()
        places = [place for place in actual if place is not None]
        if len(places) < len(actual):
            return
        if self.flying.on:
            self.flying.store(places)
        if self.latch.on:
            self.latch.store(places)
        if self.tape.on:
            self.tape.store([*places, *counters()], [axis.set for axis in self._axes])

    def call(self, entry: FlyingAt | LatchAt | ReferencePathPoint, inputs: InputImage, sync_ns: int, systems: int) -> None:
        """Execute an action at a place of a piece.  systems: number of measuring systems in addition to the axes."""
        match entry:
            case FlyingAt():
                self.flying.call(entry, inputs, sync_ns)
            case LatchAt():
                self.latch.call(entry, inputs, sync_ns)
            case ReferencePathPoint():
                self.tape.call(entry, len(self._axes) + systems)

    def look(self, inputs: InputImage, sync_ns: int) -> None:
        """For edges, once a cycle of a program."""
        self.flying.look(inputs, sync_ns)
        self.latch.look(inputs, sync_ns)
