"""Positions a program asks the cycle for: machine positions set anew, the reference path, VAL 3's latch.  Pure.

The rules are those of motion.measure.machine, record and latch; here they get positions as the drives latched them, and what was asked for
becomes the @MPOS of its kinematic (AX-578, AX-579).
"""

from collections.abc import Mapping, Sequence

from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.cycle.inputs import Wire
from gateway.pure.cycle.measured import Measured
from gateway.pure.image.records.cell import CellState, InputImage
from gateway.pure.image.records.points import LatchAt, ReferencePathPoint
from motion.measure.errors import ProgramFault
from motion.measure.history import History
from motion.measure.latch import Change, Latch
from motion.measure.record import BY_CYCLES, BY_DISTANCE, ReferencePaths
from protocols.base.machine import Ns


def set_machine_position(axes: Sequence[HeldAxis], state: CellState, places: Mapping[int, float]) -> None:
    """SF 3: shift the meaning of the increments while the axes rest.  Referencing and a new cycle undo it."""
    for n, place in places.items():
        axis, scaling = axes[n], axes[n].scaling
        way = axis.set - place
        axis.scaling = scaling.with_zero(scaling.zero_inc + way * scaling.inc_per_unit)
        axis.set = place
        state.axes[n].measured -= way


class ReferencePathRecorder:
    """Reference paths; each is kept until the next SF 29 of its kinematic, also after the program."""

    def __init__(self, mpos: Measured) -> None:
        self._mpos = mpos
        self._paths: dict[int, ReferencePaths] = {}
        self._running: set[int] = set()  # kinematics

    @property
    def on(self) -> bool:
        """One is recorded."""
        return bool(self._running)

    def call(self, order: ReferencePathPoint, systems: int) -> None:
        """SF 29, SF 30."""
        kinematic = order.kinematic
        if order.system == 0:
            if kinematic in self._running:
                self._paths[kinematic].off(kinematic)
            self._running.discard(kinematic)
            return
        self._running.add(kinematic)
        self._paths[kinematic] = ReferencePaths(systems, BY_CYCLES if order.cycles else BY_DISTANCE)
        self._paths[kinematic].on(kinematic, order.system, order.distance)

    def store(self, systems: Sequence[float], sets: Sequence[float]) -> None:
        """Call once a cycle.  systems: values of the measuring systems, sets: (axes,) set values."""
        for kinematic in self._running:
            self._paths[kinematic].step(kinematic, systems, sets, ())

    def recall(self, index: int, kinematic: int) -> None:
        """SF 31; the kinematic has measured nothing where no such entry is stored."""
        own = self._mpos.of(kinematic)
        self._mpos.forget(own)
        try:
            entry = self._paths.get(kinematic, ReferencePaths(0)).read(kinematic, index)
        except ProgramFault:
            return
        self._mpos.store({n: place for n, place in enumerate(entry.joints) if own >> n & 1})


class CoreLatch:
    """setLatch and getLatch of VAL 3."""

    def __init__(self, state: CellState, axes: int, period_ns: Ns, mpos: Measured) -> None:
        self._state, self._axes, self._period_ns, self._mpos = state, axes, period_ns, mpos
        self._latch: Latch | None = None
        self._order = LatchAt(0, 0.0, 0, 0, "")
        self._wire, self._history = Wire(0, 0), History(axes)
        self._changes: list[Change] = []

    @property
    def on(self) -> bool:
        """An edge is waited for."""
        return self._latch is not None

    def call(self, order: LatchAt, inputs: InputImage, now: Ns) -> None:
        """setLatch: discard the latched value."""
        self._order, self._history, self._changes = order, History(self._axes), []
        self._wire = Wire(order.number, self._period_ns)
        self._wire.look(inputs, now)
        self._latch = Latch(self._history, range(self._axes))
        self._latch.set_latch(order.name, now)
        self._mpos.forget(order.mask)

    def end(self) -> None:
        """The program is over."""
        self._latch = None

    def look(self, inputs: InputImage, now: Ns) -> None:
        """Once a cycle, before the positions of the cycle are known."""
        if self._latch is None:
            return
        first, stamp = self._wire.level is None, self._wire.look(inputs, now)
        if stamp is not None and not first:
            self._changes.append(Change(self._order.name, stamp, bool(self._wire.level)))

    def store(self, places: Sequence[float]) -> None:
        """places: (axes,) as latched at this SYNC."""
        latch, now = self._latch, self._state.sync_ns
        if latch is None:
            return
        self._history.add(now, places)
        latch.step(now, [change for change in self._changes if change.stamp_ns <= now])
        self._changes = [change for change in self._changes if change.stamp_ns > now]  # where the axes were then comes with the next SYNC
        caught = latch.get_latch()
        if caught is None:
            return
        self._mpos.store({n: place for n, place in enumerate(caught) if self._order.mask >> n & 1})
        self._latch = None
