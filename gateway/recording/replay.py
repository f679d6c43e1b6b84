"""Plays a recording on the core of its cell, or of another one, in virtual time, and finds the first difference (AX-485)."""

import contextlib
import pathlib
import pickle
import tempfile
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from gateway.assembly.axes import core_axes
from gateway.assembly.core import core_parts, core_rules
from gateway.assembly.cycle_belts import Encoder, encoders_of
from gateway.assembly.data_block_signals import signals_of
from gateway.assembly.drive_buses import DRIVE_PROTOCOLS, make_family
from gateway.assembly.fast_inputs import fast_wires
from gateway.assembly.run import known_zeros
from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.belts import CoreBelts
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.addresses import Direction, RcBit
from gateway.pure.image.fast_inputs import FastWires
from gateway.pure.recording.messages import Message, ServiceEvent, What, unpack_service_event
from gateway.pure.recording.player import Difference, Player
from gateway.recording.backup import BackupError, read, restore, stand_ins
from gateway.recording.file import Found, RecordError, Segment
from gateway.recording.renamed import renamed
from gateway.recording.states import Snapshots, Start, StateError, carry_over, frozen, places_of
from protocols.base.errors import DecodeError

EVENTS_KEPT = 8  # words of command sources and tools shown before a difference
EVENTS_NS = 1_000_000_000


@dataclass(slots=True)
class Verdict:
    """Verdict on one recording."""

    cycles: int = 0  # played
    seconds: float = 0.0
    first: Difference | None = None
    also: int = 0  # more differences in the same cycle
    at_s: float = 0.0  # of the first difference, since the beginning of the recording
    events_before: list[ServiceEvent] = field(default_factory=list)  # inputs of command sources and tools in the second before it
    without_outputs: int = 0  # cycles that had nothing to be compared with


@contextlib.contextmanager
def recorded_cell(found: Found) -> Iterator[Cell]:
    """The cell as it was then, unpacked for as long as it is needed; RecordError."""
    with tempfile.TemporaryDirectory(prefix="axisgate-replay-") as folder:
        place = pathlib.Path(folder)
        zipped = place / "cell.zip"
        zipped.write_bytes(found.cell)
        try:
            manifest = read(zipped)
            restore(zipped, manifest, place / "cell")
            with stand_ins(place / "cell", manifest):
                yield load_cell(str(place / "cell" / manifest.cell))
        except BackupError as error:
            raise RecordError(f"its cell cannot be used: {error}; axisgate replay FILE --cell CELL uses another") from error


class Bench:
    """Cores of one cell, as its cycle makes them."""

    def __init__(self, cell: Cell, head: Mapping[str, Any], zeros: Mapping[str, float]) -> None:
        self.cell, self._p5_ms, self._zeros = cell, int(head["p5_ms"]), zeros
        self._simulated = bool(head["simulated"])
        self._driven = [bus for bus in cell.bus if bus.name in list(head["buses"]) and bus.protocol in DRIVE_PROTOCOLS]

    def core(self) -> tuple[CycleLogic, list[Any], list[dict[int, Encoder]]]:
        """A new one, with the families of its buses and the encoders of belts on each."""
        cell, period = self.cell, self._p5_ms
        axes = core_axes(cell, period, self._zeros, simulated=self._simulated)
        core = CycleLogic(
            axes,
            period / 1000.0,
            0,
            core_rules(cell),
            core_parts(cell, period),
        )
        encoders = [encoders_of(cell, bus.name, core.belts) if core.belts is not None else {} for bus in self._driven]
        return core, [make_family(cell, bus, period, simulated=self._simulated) for bus in self._driven], encoders

    def wires(self, families: list[Any]) -> FastWires | None:
        """Wires of these families that bypass the services (AX-481)."""
        return fast_wires(self.cell, {bus.name: family for bus, family in zip(self._driven, families, strict=True)})


def replay(
    found: Found, pristine: Cell, cell: Cell, *, stop_at_first: bool = True, said: Callable[[int], None] = lambda cycles: None
) -> Verdict:
    """`pristine`: the cell as recorded; `cell`: the one to be played, the same or a changed one.  RecordError."""
    if [axis.name for axis in cell.axis] != [axis.name for axis in pristine.axis]:
        raise RecordError(f"{cell.file}: other axes than the recording's ({', '.join(axis.name for axis in pristine.axis)})")
    if pristine.belt and any("encoders" not in segment.start for segment in found.segments):
        raise RecordError(f"{pristine.file}: this file was recorded before axisgate kept the encoders of belts; record it again")
    if [belt.name for belt in cell.belt] != [belt.name for belt in pristine.belt]:
        raise RecordError(f"{cell.file}: other belts than the recording's ({', '.join(belt.name for belt in pristine.belt) or 'none'})")
    verdict = Verdict()
    zeros = dict(found.head.get("zeros", {}))
    before, then = Bench(pristine, found.head, zeros), Bench(cell, found.head, zeros if cell is pristine else zeros | known_zeros(cell))
    signals = signals_of(cell)

    def name(number: int) -> str:
        signal = signals.at(RcBit(Direction.OUTPUT, number))
        return f"rc_out.{number}" + (f" ({signal.name})" if signal is not None else "")

    for segment in found.segments:
        player = started(segment, before, then, name)
        try:
            if _play(segment, player, verdict, int(found.head["stamp_ns"]), said, stop=stop_at_first):
                break
        except DecodeError as error:
            raise RecordError(f"after cycle {segment.start['cycle']}: {error}") from error
    return verdict


def started(segment: Segment, before: Bench, then: Bench, names: Callable[[int], str]) -> Player:
    """A core and its buses in the state the segment begins with."""
    start = segment.start
    was_core, was_families, _ = before.core()
    core, families, encoders = then.core()
    kept = Snapshots(was_core, was_families)
    was = pickle.loads(kept.take(Start(was_core, was_families, [], [])))  # settings in it are numbers, as in the recording
    settings = places_of(kept.settings, Snapshots(core, families).settings)
    try:
        core = carry_over(renamed(start["core"]), frozen(was.core), core, settings)
        families = carry_over(renamed(start["families"]), frozen(was.families), families, settings)
    except (StateError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise RecordError(f"the state after cycle {start['cycle']} does not fit this cell or version: {error}") from error
    if core.belts is not None:
        _set_encoders(start["encoders"], encoders, core.belts)
    return Player(core, families, start["late"], start["sent"], names, encoders, then.wires(families))


def _set_encoders(kept: Sequence[Sequence[Any]], encoders: Sequence[Mapping[int, Encoder]], belts: CoreBelts) -> None:
    """As they were; a belt whose encoder has moved to another telegram restarts."""
    for each in encoders:
        for encoder in each.values():
            encoder.belts = belts  # those of the state that was carried over
    for bus, identifier, last, count in kept:
        there = encoders[bus].get(identifier) if bus < len(encoders) else None
        if there is not None:
            there.last, there.count = last, count


def _play(segment: Segment, player: Player, verdict: Verdict, zero: int, said: Callable[[int], None], *, stop: bool) -> bool:
    """True: the first difference was found."""
    events_before: deque[ServiceEvent] = deque(maxlen=EVENTS_KEPT)
    first_ns = 0
    for _, script in segment.played():
        if script[0].what is not What.BEGIN:  # records of the start
            _prepare(player, script)
            continue
        events_before.extend(unpack_service_event(payload) for what, payload in script if what is What.SERVICE_EVENT)
        differences = list(player.play(message for message in script if message.what is not What.SERVICE_EVENT))
        first_ns = first_ns or player.stamp_ns
        verdict.cycles += 1
        verdict.without_outputs += all(what is not What.OUTPUTS for what, _ in script)
        if verdict.cycles % 256 == 0:
            said(verdict.cycles)
        if differences and verdict.first is None:
            verdict.first, verdict.also = differences[0], len(differences) - 1
            verdict.at_s = (player.stamp_ns - zero) / 1e9
            verdict.events_before = [each for each in events_before if player.stamp_ns - each.stamp < EVENTS_NS]
            if stop:
                break
    verdict.seconds += (player.stamp_ns - first_ns) / 1e9
    return verdict.first is not None and stop


def _prepare(player: Player, script: list[Message]) -> None:
    for what, payload in script:
        if what is What.IMAGE:
            player.prepare_image(payload)
