"""Flying measurement: a probe stores the position while the kinematic keeps moving; SF 43 MEASURE_ON, SF 44 MEASURE_OFF.

Source: rho 3 Releases part 2, section 8 (L7594-7679).  Edge 1 is the positive one, 0 the negative (doubt D-25: the constants of the
printed example are the wrong way round).  One probe per servo board; the channel reads 1 once it has measured.
"""

from dataclasses import dataclass, field

from motion.errors import MotionError
from motion.measure.errors import INADMISSABLE_INPUT, ProgramFault
from motion.measure.inputs import Edge, InputKind, MeasuringInput, admitted
from motion.measure.mpos import measured
from motion.measure.until import Bench


@dataclass(slots=True)
class _Armed:
    asked: MeasuringInput
    bench: Bench
    kinematic: int
    edge: bool
    since_ns: int
    hit_ns: int | None = None
    done: bool = False


@dataclass(slots=True)
class FlyingMeasurement:
    """All probes of one control.  `step` once a cycle, after the positions of the cycle went into the history."""

    _probes: dict[int, _Armed] = field(default_factory=dict, init=False)  # by board

    def on(self, kinematic: int, edge: int, channel: int, bench: Bench, now_ns: int) -> None:
        """SF 43.  Armed anew: what was measured before counts no more; another kinematic's measurement on this board is refused."""
        asked = admitted(channel, bench.boards)
        if asked.kind is not InputKind.PROBE:
            raise ProgramFault(INADMISSABLE_INPUT, f"flying measurement needs a probe channel 6x0, not {channel}")
        if edge not in (0, 1):
            raise MotionError(f"MEASURE_ON: edge {edge}, 1 positive or 0 negative is needed")
        held = self._probes.get(asked.board)
        if held is not None and not held.done and held.kinematic != kinematic:
            raise MotionError(f"MEASURE_ON: the probe of board {asked.board} measures for kinematic {held.kinematic}")
        self._probes[asked.board] = _Armed(asked, bench, kinematic, bool(edge), now_ns)

    def off(self, kinematic: int, channel: int) -> None:
        """SF 44: no edge counts any more; what was measured stays in @MPOS.  Without effect where nothing is armed."""
        held = self._probes.get(admitted_board(channel))
        if held is not None and held.kinematic == kinematic:
            del self._probes[held.asked.board]

    def step(self, edges: tuple[Edge, ...]) -> None:
        """edges: since the last cycle."""
        for probe in self._probes.values():
            if probe.done:
                continue
            if probe.hit_ns is None:
                newest = probe.bench.history.newest_ns or 0
                probe.hit_ns = next((min(e.stamp_ns, newest) for e in edges if _counts(probe, e)), None)
            if probe.hit_ns is not None:
                self._store(probe, probe.hit_ns)

    def input(self, channel: int) -> int:
        """What the channel reads for the program: 1 once it has measured."""
        held = self._probes.get(admitted_board(channel))
        return int(held is not None and held.done)

    @staticmethod
    def _store(probe: _Armed, hit_ns: int) -> None:
        """Only axes with incremental encoders on the probe's board are stored (L7666-7672)."""
        bench = probe.bench
        values = measured(probe.asked, hit_ns, bench.cycle_ns, bench.axes, bench.boards, bench.history)
        if values is not None:
            incremental = bench.boards[probe.asked.board].incremental
            bench.mpos.take([value if axis in incremental else None for axis, value in zip(bench.axes, values, strict=True)])
            probe.done = True


def _counts(probe: _Armed, edge: Edge) -> bool:
    return edge.channel == probe.asked.wire and edge.value == probe.edge and edge.stamp_ns >= probe.since_ns


def admitted_board(channel: int) -> int:
    """Board of a probe channel 6x0; ProgramFault inadmissable input for others."""
    if not (600 < channel < 700 and channel % 10 == 0):
        raise ProgramFault(INADMISSABLE_INPUT, f"channel {channel} is not a probe 6x0")
    return channel // 10 % 10
