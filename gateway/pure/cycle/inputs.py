"""Inputs of flying measurement, and inputs that a movement waits for, in the cycle.  Pure.

The rules are those of motion.measure.flying (rho 3 Releases part 2, section 8) and motion.measure.start_off (part 1, section 4); here they
get levels and stamps from the image, and positions as the drives latched them (AX-328, AX-329).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from drivers.drives.family import Latched
from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.cycle.measured import Measured
from gateway.pure.cycle.probes import DriveProbe
from gateway.pure.image.records.cell import CellState, InputImage, Quality
from gateway.pure.image.records.inputs import FlyingAt, StartOrder
from motion.measure.flying import FlyingMeasurement
from motion.measure.history import History
from motion.measure.inputs import Board, Edge, InputKind, MeasuringInput
from motion.measure.mpos import MeasuredPosition
from motion.measure.start_off import Clock, StartOff, Wait
from motion.measure.until import Bench
from protocols.base.machine import Ns

GOOD = int(Quality.GOOD)
KINEMATIC = 1
WIRE = MeasuringInput(0, InputKind.HIGH_SPEED, 1, 0)  # the one input a start waits for, whatever its number


@dataclass(slots=True)
class Wire:
    """An RC input watched from cycle to cycle; level None: it was never good."""

    number: int
    period_ns: Ns  # a module received by the cycle itself may have reported this long after the SYNC (AX-481)
    level: bool | None = None
    _stamp: Ns = 0

    def look(self, inputs: InputImage, now: Ns) -> Ns | None:
        """Stamp of a change since the last look: that of its byte where it is new, else `now` (AX-456); None: no change."""
        octet = self.number >> 3
        if inputs.quality[octet] != GOOD:
            return None
        before, self.level = self.level, inputs.bit(self.number)
        stamp, known = inputs.stamps[octet], self._stamp
        self._stamp = stamp
        if before is self.level:
            return None
        return stamp if known < stamp <= now + self.period_ns else now


@dataclass(slots=True)
class Armed:
    """One channel that waits for its edge.  probe: drives catch it; `reported`: the edge was passed on."""

    wire: Wire
    bench: Bench
    mask: int
    since: Ns
    probe: DriveProbe | None = None
    reported: bool = False


class CoreFlying:
    """Probes that store @MPOS on the way."""

    def __init__(self, state: CellState, axes: int, period_ns: Ns, mpos: Measured) -> None:
        self._state, self._axes, self._period_ns, self._mpos = state, axes, period_ns, mpos
        self._probes = FlyingMeasurement()
        self._history = History(axes)
        self._armed: dict[int, Armed] = {}  # by channel
        self._edges: list[Edge] = []  # whose positions are not known yet

    def program_started(self) -> None:
        """What an earlier program switched on is off."""
        self._probes = FlyingMeasurement()
        self.end()

    def end(self) -> None:
        """The program is over."""
        self._armed.clear()
        self._edges.clear()

    @property
    def on(self) -> bool:
        """A probe waits for its edge."""
        return bool(self._armed)

    @property
    def by_drives(self) -> bool:
        """Drives catch an edge that is waited for."""
        return bool(self._armed) and any(armed.probe is not None for armed in self._armed.values())

    def hear(self, said: Sequence[tuple[Latched, HeldAxis] | None]) -> None:
        """What the drives' own probes have caught, before look()."""
        for armed in self._armed.values():
            if armed.probe is not None:
                armed.probe.hear(said)

    def read(self, channel: int) -> int:
        """What the channel reads for the program: 1 once it has measured."""
        return self._probes.input(channel)

    def call(self, order: FlyingAt, inputs: InputImage, now: Ns) -> None:
        """The path has reached the statement."""
        self._armed.pop(order.channel, None)
        if order.edge is None:
            self._probes.off(KINEMATIC, order.channel)
            return
        if not self._armed:
            self._history = History(self._axes)
        board = frozenset(n for n in range(self._axes) if order.mask >> n & 1)
        axes = tuple(range(self._axes))
        boards = {order.channel // 10 % 10: Board(board, board)}
        bench = Bench(axes, (), boards, self._history, MeasuredPosition(axes), self._period_ns, self._period_ns * 1e-9)
        self._probes.on(KINEMATIC, int(order.edge), order.channel, bench, now)
        wire = Wire(order.number, self._period_ns)
        if not order.drives:
            wire.look(inputs, now)
        probe = DriveProbe(order.drives, order.edge) if order.drives else None
        self._armed[order.channel] = Armed(wire, bench, order.mask, now, probe)

    def look(self, inputs: InputImage, now: Ns) -> None:
        """Once a cycle, before the positions of the cycle are known."""
        for channel, armed in self._armed.items():
            if armed.probe is not None:
                continue
            wire = armed.wire
            first, stamp = wire.level is None, wire.look(inputs, now)
            if stamp is not None and not first:
                self._edges.append(Edge(channel, stamp, bool(wire.level)))

    def store(self, places: Sequence[float]) -> None:
        """places: (axes,) as latched at this SYNC."""
        now = self._state.sync_ns
        self._history.add(now, places)
        self._caught()
        self._probes.step(tuple(edge for edge in self._edges if edge.stamp_ns <= now))
        self._edges = [edge for edge in self._edges if edge.stamp_ns > now]  # where the axes were then comes with the next SYNC
        for channel in [channel for channel in self._armed if self._probes.input(channel)]:
            armed = self._armed.pop(channel)
            caught = armed.probe.places if armed.probe is not None else {}
            own = (n for n in range(self._axes) if armed.mask >> n & 1)
            self._mpos.store({n: caught.get(n, armed.bench.mpos.component(n)) for n in own})

    def _caught(self) -> None:
        """Edges of drives whose instant is known now."""
        for channel, armed in self._armed.items():
            instant = armed.probe.instant(self._history) if armed.probe is not None and not armed.reported else None
            if armed.probe is not None and instant is not None:
                armed.reported = True
                self._edges.append(Edge(channel, max(instant, armed.since), armed.probe.edge))


@dataclass(slots=True)
class CoreStart:
    """Fast start-off: the part that follows is held until its input has the value.  Counts cycles: the grid of the SYNC is its clock."""

    period_ns: Ns
    _held: StartOff | None = field(default=None, init=False)
    _wire: Wire = field(default_factory=lambda: Wire(0, 0), init=False)
    _now: Ns = field(default=0, init=False)  # since the wait began

    @property
    def on(self) -> bool:
        """The part is held."""
        return self._held is not None

    def begin(self, order: StartOrder, inputs: InputImage, now: Ns) -> None:
        """The wait is reached; a condition that holds already is met now."""
        self._wire, self._now = Wire(order.number, self.period_ns), 0
        self._wire.look(inputs, now)
        held = self._held = StartOff(Wait(WIRE, order.level, order.delay_s), Clock(self.period_ns, self.period_ns))
        if self._wire.level is not None:
            held.begin(self._wire.level, 0)
        if held.step(0, ()):
            self._held = None

    def step(self, inputs: InputImage, now: Ns) -> bool:
        """One cycle; whether the part begins in it."""
        held = self._held
        if held is None:
            return False
        self._now += self.period_ns
        stamp = self._wire.look(inputs, now)
        edges = [] if stamp is None else [Edge(WIRE.wire, self._now - max(now - stamp, 0), bool(self._wire.level))]
        if held.step(self._now, edges):
            self._held = None
        return self._held is None

    def end(self) -> None:
        """There is nothing to hold any more."""
        self._held = None
