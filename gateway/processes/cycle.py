"""The cycle: one thread, one absolute grid.  SYNC and set values leave only from here, and only from a completed cycle.

Order of one cycle (AX-001): at the grid instant SYNC and the set values for the next SYNC in one burst; drives answer with what they
latched; then the core thinks, and what it decided is published.  A grid instant that was missed is counted and never made up for.

Buses of any family hang on one core (AX-300).  Frames that are no cyclic data come from the master of the services through the ring
`acyclic`, at most one a bus and cycle, and what the bus says aside goes back through the ring `heard` (AX-301).
"""

import argparse
import os
import select
import signal
import time
from collections import deque
from collections.abc import Sequence

from drivers.drives.family import Actual, BusFamily, SetRecord
from drivers.drives.listening import ListeningFamily
from drivers.ports.base import CanPort, PortError
from drivers.ports.can import open_can
from gateway.alterplan import alter_of_cell
from gateway.assembly import RunPlan, load_plan
from gateway.axes import assumed_permits, core_axes, rc_numbers
from gateway.cyclebelts import BeltOffsets, Encoder, belts_of, encoders_of
from gateway.families import make_family
from gateway.fastwires import fast_wires
from gateway.image import RegionReader, RegionWriter, RingReader, RingWriter, fds_from_text
from gateway.io_cycle import InputMarks, IoErrors, cycle_contacts
from gateway.pathoutputs import functions_of
from gateway.pure.core import Core
from gateway.pure.plannerrecords import PIECE_LAYOUT, unpack_piece
from gateway.pure.recording.messages import What
from gateway.pure.records import (
    ASIDE_LAYOUT,
    TRACE_LAYOUT,
    Aside,
    AsideRecord,
    InputImage,
    OrderRecord,
    cell_state_packer,
    pack_aside,
    pack_trace,
    unpack_aside,
    unpack_inputs,
    unpack_order,
)
from gateway.pure.rho3can.family import RhoFamily
from gateway.pure.scope.records import SCOPE_LAYOUT, pack_scope
from gateway.realtime import Alarm, die_with_parent, go_realtime
from gateway.recording.tap import CycleTap
from gateway.sharedplan import shared_of_cell
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, FrameFault

PRIORITY = 40  # broker 30, emulator 20, line process 15: all below the cycle
PIECES_SHARE = 8  # of the period may be spent on the planner's pieces; the rest waits in the ring
THINKING_NS, THINKING_SHARE = 3_000_000, 0.4  # kept free for the core at the end of a cycle: the smaller of both (AX-149)
REOPEN_NS = 200_000_000
ACYCLIC_AT_ONCE = 8  # records taken from the ring in one cycle; each bus still sends one frame of them a cycle


BUS_OFF = (
    "bus-off: the controller left the bus after too many errors and is restarted; check cable, termination (120 ohm at both ends) and bit"
    " rate; if it stays away: sudo ip link set can0 type can restart (axisgate does that itself where it has CAP_NET_ADMIN)"
)


def patience_ns(period_ns: int) -> int:
    """How long after the grid instant an actual value is waited for; what is not here by then is missing (AX-149)."""
    return period_ns - min(THINKING_NS, int(THINKING_SHARE * period_ns))


class BusLink:
    """One drive bus: its port and the family of drives on it."""

    def __init__(self, url: str, family: BusFamily, number: int = 0) -> None:
        self.url, self.family, self.number = url, family, number
        self.tap: CycleTap | None = None  # while somebody records
        self.port: CanPort | None = None
        self.fd = -1  # of the port
        self.refused = 0  # frames the port did not take: never silent
        self.foreign = 0
        self.last_error = ""
        self.acyclic: deque[Frame] = deque()  # from the master, one leaves with each burst
        self.encoders: dict[int, Encoder] = {}  # of belts, by identifier
        self.late = 0  # actual values that came in the cycle after theirs
        self._retry_ns = self.sent_ns = 0
        self._burst: list[Frame] = []

    def prepare(self, values: Sequence[SetRecord]) -> None:
        """The next burst; `values` by the index of the cell."""
        self._burst = self.family.burst(values)

    def send(self, now: int) -> bool:
        """The burst; False when the bus is not there."""
        if self.port is None and not self._open(now):
            return False
        assert self.port is not None
        if any(kind is FrameFault.BUS_OFF for kind, _ in self.port.take_faults()):
            self._lose(PortError(f"{self.url}: {BUS_OFF}"))
            return False
        if self.tap is not None:
            self.tap.sent(self.number, self._burst)
        if self.acyclic:
            self._burst.append(self.acyclic.popleft())
        self.sent_ns = now
        try:
            self.refused += len(self._burst) - self.port.send(self._burst)
        except PortError as error:
            self._lose(error)
            return False
        return True

    def receive(self, actuals: list[Actual | None], *, next_only: bool = False) -> int:
        """Take what came; how many axes answered for the first time since the burst.  What the bus saw before it belongs to a cycle that
        is over: counted as late.  `next_only`: what came first may do, the rest waits for the next call."""
        if self.port is None:
            return 0
        try:
            frames = self.port.receive_next() if next_only else self.port.receive()
        except PortError as error:
            self._lose(error)
            return 0
        if self.tap is not None:
            self.tap.heard(self.number, frames)
        fresh, hear, sent_ns = 0, self.family.hear, self.sent_ns
        for frame in frames:
            try:
                heard = hear(frame)
            except DecodeError:
                encoder = self.encoders.get(frame.identifier)
                if encoder is None:
                    self.foreign += 1
                else:
                    fresh += encoder.hear(frame.data)
                continue
            if heard is None:
                continue
            index, actual = heard
            if frame.stamp_ns < sent_ns:
                self.late += 1
                continue
            fresh += actuals[index] is None
            actuals[index] = actual
        return fresh

    def receive_rest(self, axes: int) -> None:
        """Before the next burst: modules of inputs are not waited for, but what they said counts."""
        self.late += self.receive([None] * axes)

    def close(self) -> None:
        if self.port is not None:
            self.port.close()
            self.port = None

    def _open(self, now: int) -> bool:
        if now < self._retry_ns:
            return False
        self._retry_ns = now + REOPEN_NS
        try:
            self.port = open_can(self.url)
            self.fd = self.port.fileno()
        except PortError as error:
            self._say(error)
            return False
        self.last_error = ""
        print(f"{self.url}: open", flush=True)
        return True

    def _lose(self, error: PortError) -> None:
        self.close()
        self.acyclic.clear()  # the master asks again
        self._say(error)

    def _say(self, error: PortError) -> None:
        if str(error) != self.last_error:
            self.last_error = str(error)
            print(self.last_error, flush=True)


class Cycle:
    """The loop around the core."""

    def __init__(self, plan: RunPlan, fds: dict[str, int]) -> None:
        cell = plan.cell
        self.period_ns = plan.p5_ms * 1_000_000
        axes = core_axes(cell, plan.p5_ms, plan.zeros, simulated=plan.simulated)
        drive_buses = [bus for bus in cell.bus if bus.name in plan.buses]
        self.core = Core(
            axes,
            plan.p5_ms / 1000.0,
            time.monotonic_ns(),
            numbers=rc_numbers(cell),
            assumed=assumed_permits(cell),
            finish_without_services=cell.cell.on_services_loss == "finish_move",
            belts=belts_of(cell, plan.p5_ms) if cell.belt else None,
            functions=functions_of(cell, plan.p5_ms),
            alter=alter_of_cell(cell, plan.p5_ms),
            shared=shared_of_cell(cell, plan.p5_ms),
        )
        self.buses = [
            BusLink(plan.buses[bus.name], make_family(cell, bus, plan.p5_ms, simulated=plan.simulated), n)
            for n, bus in enumerate(drive_buses)
        ]
        self._driving = [bus for bus in self.buses if not (isinstance(bus.family, RhoFamily) and bus.family.drives is None)]
        self._driving = [bus for bus in self._driving if not isinstance(bus.family, ListeningFamily)]
        self._pack_state = cell_state_packer(len(axes))
        for bus, link in zip(drive_buses, self.buses, strict=True):
            link.encoders = encoders_of(cell, bus.name, self.core.belts) if self.core.belts is not None else {}
        self.with_io = [(bus, bus.family) for bus in self.buses if isinstance(bus.family, RhoFamily)]
        self.inputs = RegionReader(fds["rc_in"], "rc_in")
        self.links = RegionReader(fds["links"], "links")
        self.orders = RingReader(fds["orders"], "orders")
        self.acyclic = RingReader(fds["acyclic"], "acyclic", ASIDE_LAYOUT)
        self.heard = RingWriter(fds["heard"], "heard", ASIDE_LAYOUT)
        self.pieces = RingReader(fds["pieces"], "pieces", PIECE_LAYOUT) if "pieces" in fds else None
        self.planner = RegionReader(fds["planner"], "planner") if "planner" in fds else None
        self._planner_pid = self.planner.writer_pid if self.planner else 0
        self.axes = RegionWriter(fds["axes"], "axes")
        self.outputs = RegionWriter(fds["rc_out"], "rc_out")
        self.scope = RingWriter(fds["scope"], "scope", SCOPE_LAYOUT)
        self.trace = RingWriter(fds["trace"], "trace", TRACE_LAYOUT)
        self.wake = fds.get("wake")  # for what is joined once per cycle (AX-398)
        self.contacts = cycle_contacts(cell, [bus.family for bus in self.buses], fds, plan.p5_ms)
        self.wires = fast_wires(cell, {bus.name: link.family for bus, link in zip(drive_buses, self.buses, strict=True)})
        self.marks = InputMarks([family for _, family in self.with_io], fds["marks"]) if "marks" in fds else None
        self.io_errors = IoErrors([family for _, family in self.with_io], fds["io_errors"]) if "io_errors" in fds else None
        belts = self.core.belts
        self.belt_offsets = BeltOffsets(belts, fds["belts"]) if belts is not None and "belts" in fds else None
        self.tap = CycleTap(self.core, self.buses, fds)
        self._image = InputImage()
        self._image_index = -1
        self._services_pid = self.links.writer_pid
        self._alarm = Alarm()
        self._stop = False

    def run(self) -> None:
        """Until SIGTERM."""
        signal.signal(signal.SIGTERM, self._on_signal)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the supervisor's business
        self._prepare(self.core.idle())
        due = time.monotonic_ns() + self.period_ns
        for bus in self.buses:
            bus.family.began(due)
        while not self._stop:
            now = self._alarm.until(due)
            missed = max(0, (now - due) // self.period_ns)
            if self.tap.on:
                self.tap.began(now, missed)
            if missed:
                self.core.skipped(missed)
                due += missed * self.period_ns
            self._cycle(due, now)
            due += self.period_ns
        for bus in self.buses:
            bus.close()

    def _on_signal(self, number: int, frame: object) -> None:
        self._stop = True

    def _cycle(self, due: int, now: int) -> None:
        core = self.core
        actuals: list[Actual | None] = [None] * len(core.plans)
        if self.acyclic.published != self.acyclic.position:
            self._take_acyclic()
        for bus, family in self.with_io:
            bus.receive_rest(len(actuals))
            image = self._inputs()
            self.tap.exchange(bus.number, there=bus.port is not None)
            for said in (*family.exchange(image, core.outputs, now, up=bus.port is not None), *family.take_news()):
                print(f"{bus.url}: {said}", flush=True)
        up = [bus for bus in self.buses if bus.send(now)]
        sent = time.monotonic_ns()
        if len(up) < len(self.buses) and any(bus not in up for bus in self._driving):
            core.drives_lost()
            self.tap.note(What.DRIVES_LOST)
        missing = self._collect(up, actuals, due + patience_ns(self.period_ns))
        got = time.monotonic_ns()
        core.state.incomplete += missing > 0
        core.state.late = sum([bus.late for bus in self.buses])
        self._watch_services()
        self._take_pieces()
        image, orders, services_ns = self._inputs(), self._take_orders(), self.links.life[1]
        self.tap.stepped(now, services_ns, missing)
        values = core.step(actuals, image if self.wires is None else self.wires.over(image), orders, services_ns, now)
        if self.contacts is not None:
            self.contacts.turn(core.state, core.outputs, self.links.life[1], now)
            self.tap.contacts()
        self._prepare(values)
        ready = time.monotonic_ns()
        core.state.compute_ns = ready - got
        state = self._pack_state(core.state)
        self.axes.write(state, now)
        self.outputs.write(core.outputs, now)
        if self.marks is not None:
            self.marks.turn(now)
        if self.io_errors is not None:
            self.io_errors.turn(now)
        if self.belt_offsets is not None:
            self.belt_offsets.turn(now)
        self.axes.beat(now)
        self.scope.put(pack_scope(state, core.outputs, self._image.values))
        if self.wake is not None:
            os.eventfd_write(self.wake, 1)
        self.trace.put(pack_trace(core.state.cycle, due, sent, got, ready, missing))
        for number, bus in enumerate(self.buses):
            if bus.family.aside:
                self._hand_back(number, bus.family.aside)
        self.tap.turn(now)

    def _prepare(self, values: Sequence[SetRecord]) -> None:
        for bus in self.buses:
            bus.prepare(values)

    def _take_acyclic(self) -> None:
        """What the master hands over; a bus that is not there forgets it, the master asks again."""
        for _, record in self.acyclic.take(ACYCLIC_AT_ONCE):
            kind, number, identifier, data, _ = unpack_aside(record)
            if number >= len(self.buses):
                continue
            bus = self.buses[number]
            if self.tap.on:
                self.tap.node(kind, number, identifier, data)
            if kind is Aside.RELEASE:
                bus.family.release(identifier, data[0] if data else 0)
            elif kind is Aside.HOLD:
                bus.family.hold(identifier)
            elif bus.port is not None:
                bus.acyclic.append(Frame(identifier, data))

    def _hand_back(self, number: int, frames: list[Frame]) -> None:
        for frame in frames:
            self.heard.put(pack_aside(AsideRecord(Aside.FRAME, number, frame.identifier, frame.data, frame.stamp_ns)))
        frames.clear()

    def _collect(self, up: Sequence[BusLink], actuals: list[Actual | None], until: int) -> int:
        """Wait for all actual values, at most to `until`; how many are missing."""
        missing = sum([bus.family.expected + len(bus.encoders) for bus in self.buses])
        if not missing:  # nobody is waited for, but frames aside come all the same
            for bus in up:
                bus.receive(actuals)
        first = True  # all actual values of a bus mostly come at one go: then nothing more is asked for, which would cost as much again
        while missing and (fds := [bus.fd for bus in up if bus.port is not None]):
            left = until - time.monotonic_ns()
            if left <= 0 or not (ready := select.select(fds, (), (), left * 1e-9)[0]):
                break
            for bus in up:
                if bus.fd in ready:
                    missing -= bus.receive(actuals, next_only=first)
            first = False
        return missing

    def _watch_services(self) -> None:
        """A successor may be quicker than the life counter's limit: then only the writer's pid tells of the death."""
        pid = self.links.writer_pid
        if pid != self._services_pid and pid:
            if self._services_pid:
                self.core.services_lost()
                self.tap.note(What.SERVICES_LOST)
            self._services_pid = pid

    def _inputs(self) -> InputImage:
        payload = self.inputs.read()
        if payload is not None and self.inputs.index != self._image_index:
            self._image_index, self._image = self.inputs.index, unpack_inputs(payload)
            self.tap.image(payload)
        return self._image

    def _take_pieces(self) -> None:
        """A few a cycle: what waits in the ring is not lost."""
        if self.pieces is None or self.planner is None:
            return
        pid = self.planner.writer_pid
        if pid != self._planner_pid and pid:
            if self._planner_pid:
                self.core.planner_lost()
                self.tap.note(What.PLANNER_LOST)
            self._planner_pid = pid
        if self.pieces.published == self.pieces.position:
            return
        until = time.monotonic_ns() + self.period_ns // PIECES_SHARE
        while time.monotonic_ns() < until and (records := self.pieces.take(1)):
            if self.tap.on:
                self.tap.put(What.PIECE, records[0][1])
            self.core.feed(unpack_piece(records[0][1]))

    def _take_orders(self) -> list[OrderRecord]:
        """Orders meant for this very process: an older generation's are dropped (a command is taken once)."""
        if self.orders.published == self.orders.position:
            return []
        taken = self.orders.take(8)
        if taken and self.tap.on:
            self.tap.orders(taken)
        records = [unpack_order(record) for _, record in taken]
        return [record for record in records if record.generation == self.core.state.generation]


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="axisgate cycle", description="the cycle process; started by the supervisor")
    parser.add_argument("--plan", type=int, required=True)
    parser.add_argument("--fds", required=True)
    arguments = parser.parse_args(argv)
    die_with_parent(number=signal.SIGKILL)
    plan = load_plan(arguments.plan)
    cycle = Cycle(plan, fds_from_text(arguments.fds))
    for warning in go_realtime(PRIORITY):
        print(warning, flush=True)
    cycle.run()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
