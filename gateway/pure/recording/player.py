"""Plays the script of a recording on a core and its buses: the same calls in the same order, with the recorded stamps (AX-485).  Pure.

The output is compared with the state published then; the computing time of the cycle is not an output and not compared.
"""

import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from drivers.drives.family import Actual, BusFamily
from gateway.pure.buses.cia401 import CouplerFamily, contacts_lost
from gateway.pure.controllers.rho3.can.family import RhoFamily
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.fast_inputs import FastWires
from gateway.pure.image.records.cell import (
    RC_BYTES,
    STATE,
    CellState,
    InputImage,
    pack_cell_state,
    unpack_cell_state,
    unpack_inputs,
    unpack_order,
)
from gateway.pure.image.records.planner import unpack_piece
from gateway.pure.recording.messages import BEGIN, NODE, STEP, Message, Phase, What, unpack_frames, unpack_shown
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, Ns

NOT_COMPARED = ("compute_ns",)
AXIS_FIELDS = ("actual", "set", "speed", "lag", "torque", "flags", "fault_code", "power", "finding", "measured")


class Encoder(Protocol):
    """A belt's measuring system on a bus."""

    def hear(self, data: bytes) -> int: ...


@dataclass(frozen=True, slots=True)
class Difference:
    """The recording expects one thing, the core made another."""

    cycle: int
    stamp_ns: Ns
    name: str
    expected: object
    got: object


class Player:
    """One core from one start on."""

    def __init__(
        self,
        core: CycleLogic,
        families: Sequence[BusFamily],
        late: Sequence[int],
        sent_ns: Sequence[Ns],
        names: Callable[[int], str] = str,
        encoders: Sequence[Mapping[int, Encoder]] = (),
        wires: FastWires | None = None,
    ) -> None:
        """`names`: of an RC output by its number; `encoders`: of each bus, by their identifiers; none where the cell has no belts; `wires`:
        inputs these families bring to the core themselves."""
        self.core, self.families = core, families
        self._encoders = encoders or [{} for _ in families]
        self._wires = wires
        self.stamp_ns: Ns = 0
        self._late, self._sent_ns, self._names = list(late), list(sent_ns), names
        self._image = InputImage()
        self._bursts: list[list[Frame] | None] = [None] * len(families)
        self._actuals: list[Actual | None] = []
        self._missing = 0
        self._doing = {
            What.BEGIN: self._begin,
            What.RELEASE: self._release,
            What.HOLD: self._hold,
            What.HEARD: self._heard,
            What.IMAGE: self._take_image,
            What.EXCHANGE: self._exchange,
            What.DRIVES_LOST: lambda _: core.drives_lost(),
            What.SERVICES_LOST: lambda _: core.services_lost(),
            What.PLANNER_LOST: lambda _: core.planner_lost(),
            What.PIECE: lambda payload: core.feed(unpack_piece(payload)),
            What.SHOWN: self._shown,
        }

    def play(self, messages: Iterable[Message]) -> Iterator[Difference]:
        """The messages of one cycle, the first of them BEGIN; every difference, in the order of the calls.  DecodeError: no script."""
        orders = []
        try:
            for what, payload in messages:
                if what is What.SENT:
                    yield from self._compare_burst(payload)
                elif what is What.ORDER:
                    orders.append(unpack_order(payload))
                elif what is What.STEP:
                    _, now, services_ns, missing = STEP.unpack(payload)
                    self._settle(missing)
                    image = self._image if self._wires is None else self._wires.over(self._image)
                    self.core.contacts_lost = contacts_lost(self.families)
                    values = self.core.step(self._actuals, image, orders, services_ns, now)
                elif what is What.OUTPUTS:
                    yield from self._compare(payload)
                elif what in self._doing:
                    self._doing[what](payload)
            for number, family in enumerate(self.families):
                self._bursts[number] = family.burst(values)
        except (struct.error, IndexError, ValueError, UnboundLocalError) as error:
            raise DecodeError(f"cycle {self.core.state.cycle}: its script cannot be played ({error})") from error

    def prepare_image(self, payload: bytes) -> None:
        """State at the start."""
        self._take_image(payload)

    # ---- the calls of the cycle ------------------------------------------------------------------------------------------
    def _begin(self, payload: bytes) -> None:
        self.stamp_ns, missed = BEGIN.unpack(payload)
        if missed:
            self.core.skipped(missed)
        self._actuals = [None] * len(self.core.plans)

    def _settle(self, missing: int) -> None:
        self.core.state.incomplete += missing > 0
        self.core.state.late = sum(self._late)

    def _release(self, payload: bytes) -> None:
        bus, node, mode = NODE.unpack(payload)
        self.families[bus].release(node, mode)

    def _hold(self, payload: bytes) -> None:
        bus, node, _ = NODE.unpack(payload)
        self.families[bus].hold(node)

    def _take_image(self, payload: bytes) -> None:
        self._image = unpack_inputs(payload)

    def _heard(self, payload: bytes) -> None:
        """Process frames as the cycle does: those that the bus received before the burst belong to a completed cycle."""
        bus, phase, frames = unpack_frames(payload)
        before = phase == Phase.BEFORE
        actuals: list[Actual | None] = [None] * len(self._actuals) if before else self._actuals
        for frame in frames:
            try:
                heard = self.families[bus].hear(frame)
            except DecodeError:
                encoder = self._encoders[bus].get(frame.identifier)
                if encoder is not None:
                    encoder.hear(frame.data)
                continue
            if heard is None:
                continue
            if frame.stamp_ns < self._sent_ns[bus]:
                self._late[bus] += 1
                continue
            index, actual = heard
            self._late[bus] += before and actuals[index] is None
            actuals[index] = actual

    def _exchange(self, payload: bytes) -> None:
        family = self.families[payload[0]]
        if isinstance(family, RhoFamily):
            family.exchange(self._image, self.core.outputs, self.stamp_ns, up=bool(payload[1]))
            family.take_news()

    def _shown(self, payload: bytes) -> None:
        bus, contacts = unpack_shown(payload)
        family = self.families[bus]
        if isinstance(family, CouplerFamily):
            family.show(contacts)

    # ---- what came out ----------------------------------------------------------------------------------------------------
    def _compare_burst(self, payload: bytes) -> Iterator[Difference]:
        bus, _, frames = unpack_frames(payload)
        self._sent_ns[bus] = self.stamp_ns
        made = self._bursts[bus]
        if made is None:
            return  # it was made before the start
        cycle = self.core.state.cycle + 1
        for at in range(max(len(frames), len(made))):
            expected = _frame(frames[at]) if at < len(frames) else "no frame"
            got = _frame(made[at]) if at < len(made) else "no frame"
            if expected != got:
                yield Difference(cycle, self.stamp_ns, f"bus {bus + 1} sends", expected, got)

    def _compare(self, payload: bytes) -> Iterator[Difference]:
        core = self.core
        core.state.compute_ns = 0
        octets, outputs = payload[:-RC_BYTES], payload[-RC_BYTES:]
        expected, got = unpack_cell_state(octets), unpack_cell_state(pack_cell_state(core.state))
        for name, was, now in _fields(expected, got, [plan.name for plan in core.plans]):
            yield Difference(core.state.cycle, self.stamp_ns, name, was, now)
        for number in range(8 * len(outputs)):
            was, now = outputs[number >> 3] >> (number & 7) & 1, core.outputs[number >> 3] >> (number & 7) & 1
            if was != now:
                yield Difference(core.state.cycle, self.stamp_ns, self._names(number), was, now)


def _fields(expected: CellState, got: CellState, axes: Sequence[str]) -> Iterator[tuple[str, object, object]]:
    for name in STATE.names:
        was, now = getattr(expected, name), getattr(got, name)
        if name not in NOT_COMPARED and not _same(was, now):
            yield f"cell.{name}", was, now
    for number, axis in enumerate(axes):
        for name in AXIS_FIELDS:
            was, now = getattr(expected.axes[number], name), getattr(got.axes[number], name)
            if not _same(was, now):
                yield f"axis.{axis}.{name}", was, now


def _same(one: object, other: object) -> bool:
    return one == other or (one != one and other != other)


def _frame(frame: Frame) -> str:
    return f"{frame.identifier:03X}h {frame.data.hex(' ') or 'no data'}"
