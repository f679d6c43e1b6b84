"""The cycle: one thread, one absolute grid.  SYNC and set values leave only from here, and only from a completed cycle.

Order of one cycle (AX-001): at the grid instant SYNC and the set values for the next SYNC in one burst; drives answer with the latched
values; then the core decides, and its decision is published.  A missed grid instant is counted and never made up for.

Buses of any family are connected to one core (AX-300).  Acyclic frames come from the master of the services through the ring
`acyclic`, at most one a bus and cycle, and other received frames go back through the ring `heard` (AX-301).
"""

import argparse
import os
import select
import signal
import time
from collections.abc import Sequence

from drivers.drives.family import Actual, SetRecord
from drivers.drives.listening import ListeningFamily
from gateway.assembly.axes import core_axes
from gateway.assembly.core import core_parts, core_rules
from gateway.assembly.cycle_belts import belt_regions, encoders_of
from gateway.assembly.drive_buses import make_family
from gateway.assembly.fast_inputs import fast_wires
from gateway.assembly.run import RunPlan, load_plan
from gateway.cycle.bus_link import BusLink
from gateway.cycle.contacts import InputMarks, IoErrors, cycle_contacts
from gateway.cycle.corrected import Corrected
from gateway.cycle.native.quick import Collect, NativeParts
from gateway.cycle.piece_ring import piece_ring
from gateway.cycle.recording_tap import CycleTap
from gateway.pure.buses.cia401 import CouplerFamily, contacts_lost
from gateway.pure.controllers.rho3.can.family import RhoFamily
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.records.aside import ASIDE_LAYOUT, Aside, AsideRecord, pack_aside, unpack_aside
from gateway.pure.image.records.cell import CELL_STATE_LAYOUT, ORDER_LAYOUT, InputImage, OrderRecord, unpack_inputs, unpack_order
from gateway.pure.image.records.planner import unpack_piece
from gateway.pure.image.records.trace import TRACE_LAYOUT, pack_trace
from gateway.pure.recording.messages import What
from gateway.pure.reports.waited import WaitedTime
from gateway.pure.scope.records import SCOPE_LAYOUT, pack_scope
from gateway.runtime.realtime import die_with_parent, go_realtime
from gateway.runtime.regions import RegionReader, RingReader, RingWriter, fds_from_text
from protocols.base.machine import Frame

PRIORITY = 40  # broker 30, emulator 20, line process 15: all below the cycle
PIECES_SHARE = 8  # of the period may be spent on the planner's pieces; the rest waits in the ring
THINKING_NS, THINKING_SHARE = 3_000_000, 0.4  # kept free for the core at the end of a cycle: the smaller of both (AX-149)
WAITS_NS = 700_000_000  # stretched simulation: time for delayed frames, shorter than the services' limit for a silent cycle
JITTER = 8  # part of a period a stretched grid may be late before it is moved
LAST_LOOKS = 4  # messages read after the deadline: those present came in time, and a flood does not hold the cycle
ACYCLIC_AT_ONCE = 32  # records taken from the ring in one cycle: one for each axis of a cell


def patience_ns(period_ns: int) -> int:
    """How long after the grid instant to wait for an actual value; one not here by then is missing (AX-149)."""
    return period_ns - min(THINKING_NS, int(THINKING_SHARE * period_ns))


def waited_until(patience: int, due: int, sent: int) -> int:
    """Instant at which an actual value is missing; after a late SYNC drives have at least half the time (AX-915)."""
    return max(due + patience, sent + patience // 2)


class Cycle:
    """The loop around the core."""

    def __init__(self, plan: RunPlan, fds: dict[str, int], quick: NativeParts | None = None) -> None:
        cell, quick = plan.cell, quick or NativeParts(python=True)
        self.period_ns = plan.p5_ms * 1_000_000
        self._patience = patience_ns(self.period_ns)
        axes = core_axes(cell, plan.p5_ms, plan.zeros, simulated=plan.simulated)
        drive_buses = [bus for bus in cell.bus if bus.name in plan.buses]
        self.core = CycleLogic(
            axes,
            plan.p5_ms / 1000.0,
            time.monotonic_ns(),
            core_rules(cell),
            core_parts(cell, plan.p5_ms),
            loops=quick.loops,
            foresight=quick.foresight,
        )
        self.buses = [
            BusLink(
                plan.buses[bus.name],
                make_family(cell, bus, plan.p5_ms, simulated=plan.simulated),
                n,
                quick,
                protocol=bus.protocol if bus.name not in plan.listening else "",
                listens=not plan.own_bus(bus.name) and bus.name not in plan.listening,
            )
            for n, bus in enumerate(drive_buses)
        ]
        self._driving = [bus for bus in self.buses if not (isinstance(bus.family, RhoFamily) and bus.family.drives is None)]
        self._driving = [bus for bus in self._driving if not isinstance(bus.family, ListeningFamily)]
        self._coupled = [bus.family for bus in self.buses if isinstance(bus.family, CouplerFamily)]
        self._pack_state = quick.packer(len(axes), len(self.core.state.lanes))
        for bus, link in zip(drive_buses, self.buses, strict=True):
            link.encoders = encoders_of(cell, bus.name, self.core.belts) if self.core.belts is not None else {}
        self.with_io = [(bus, bus.family) for bus in self.buses if isinstance(bus.family, RhoFamily)]
        self._open_regions(fds, quick)
        self.contacts = cycle_contacts(cell, [bus.family for bus in self.buses], fds, plan.p5_ms)
        self.wires = fast_wires(cell, {bus.name: link.family for bus, link in zip(drive_buses, self.buses, strict=True)})
        self.marks = InputMarks([family for _, family in self.with_io], fds["marks"]) if "marks" in fds else None
        self.io_errors = IoErrors([family for _, family in self.with_io], fds["io_errors"]) if "io_errors" in fds else None
        self.belt_regions = belt_regions(self.core.belts, fds)
        self._correction = Corrected(cell, fds)
        self.tap = CycleTap(self.core, self.buses, fds)
        self._collect_quickly = quick.collect
        self._look = quick.looker(self.links, self.planner, self.pieces, self.orders, self.inputs)
        self._image, self._image_index = InputImage(), -1
        self._services_pid = self.links.writer_pid
        self._alarm = quick.alarm()
        self._stretched, self._waited = plan.stretched, WaitedTime(self.period_ns)
        self._stop = False

    def _open_regions(self, fds: dict[str, int], quick: NativeParts) -> None:
        """Regions of other processes that it reads and writes."""
        self.inputs = RegionReader(fds["rc_in"], "rc_in")
        self.links = RegionReader(fds["links"], "links")
        self.orders = RingReader(fds["orders"], "orders", ORDER_LAYOUT)
        self.acyclic = RingReader(fds["acyclic"], "acyclic", ASIDE_LAYOUT)
        self.heard = RingWriter(fds["heard"], "heard", ASIDE_LAYOUT)
        self.pieces = piece_ring(fds)
        self.planner = RegionReader(fds["planner"], "planner") if "planner" in fds else None
        self._planner_pid = self.planner.writer_pid if self.planner else 0
        self.axes = quick.region(fds["axes"], "axes", CELL_STATE_LAYOUT)
        self.outputs = quick.region(fds["rc_out"], "rc_out")
        self.scope = quick.ring(fds["scope"], "scope", SCOPE_LAYOUT)
        self.trace = quick.ring(fds["trace"], "trace", TRACE_LAYOUT)
        self.wake = fds.get("wake")  # for parts that act once per cycle (AX-398)

    _waits = True  # in a stretched simulation: the drives that are missing have not been waited for in vain

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
            if self._stretched and now - due > self.period_ns // JITTER:
                self._waited.late(now - due)
                due = now  # simulated time waits: no SYNC is skipped (AX-681)
            missed = max(0, (now - due) // self.period_ns)
            if self.tap.on:
                self.tap.began(now, missed)
            if missed:
                self.core.skipped(missed)
                due += missed * self.period_ns
            self._cycle(due, now)
            if self._stretched and (words := self._waited.take_words(now)):
                print(words, flush=True)
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
        self._exchange(len(actuals), now)
        up = [bus for bus in self.buses if bus.send(now)]
        sent = time.monotonic_ns()
        if len(up) < len(self.buses) and any(bus not in up for bus in self._driving):
            core.drives_lost()
            self.tap.note(What.DRIVES_LOST)
        missing = self._gather(up, actuals, waited_until(self._patience, due, sent))
        got = time.monotonic_ns()
        self._count(missing)
        services_pid, services_ns, planner_pid, pieces, waiting, fresh = self._look()
        if services_pid != self._services_pid:
            self._watch_services()
        if self.pieces is not None and (planner_pid != self._planner_pid or pieces != self.pieces.position):
            self._take_pieces()
        image = self._inputs() if fresh != self._image_index else self._image
        if self._correction.there:
            image = self._correction.over(image, self.tap)
        orders = self._take_orders() if waiting != self.orders.position else []
        self.tap.stepped(now, services_ns, missing)
        core.contacts_lost = contacts_lost(self._coupled) if self._coupled else False
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
        if self.pieces is not None:
            self.pieces.publish(now)
        if self.marks is not None:
            self.marks.turn(now)
        if self.io_errors is not None:
            self.io_errors.turn(now)
        for region in self.belt_regions:
            region.turn(now)
        self.axes.beat(now)
        self.scope.put(pack_scope(state, core.outputs, self._image.values))
        if self.wake is not None:
            os.eventfd_write(self.wake, 1)
        self.trace.put(pack_trace(core.state.cycle, due, sent, got, ready, missing))
        self._hand_back_all()
        self.tap.turn(now)

    def _count(self, missing: int) -> None:
        """For the published state."""
        state = self.core.state
        state.incomplete += missing > 0
        state.late = sum([bus.late for bus in self.buses])

    def _prepare(self, values: Sequence[SetRecord]) -> None:
        for bus in self.buses:
            bus.prepare(values)

    def _exchange(self, axes: int, now: int) -> None:
        """Digital inputs and outputs on the buses of a rho 3."""
        for bus, family in self.with_io:
            bus.receive_rest(axes)
            if self._stretched:
                self._await_modules(bus, family, axes)
            image = self._inputs()
            self.tap.exchange(bus.number, there=bus.port is not None)
            for said in (*family.exchange(image, self.core.outputs, now, up=bus.port is not None), *family.take_news()):
                print(f"{bus.url}: {said}", flush=True)

    def _await_modules(self, bus: BusLink, family: RhoFamily, axes: int) -> None:
        """In a stretched simulation: wait for inputs that this computer delays.  A module that does not answer is silent until it does."""
        until = time.monotonic_ns() + WAITS_NS
        while bus.port is not None and family.awaited and (left := until - time.monotonic_ns()) > 0:
            select.select((bus.fd,), (), (), left * 1e-9)
            bus.receive_rest(axes)

    def _take_acyclic(self) -> None:
        """Frames from the master; a missing bus drops them, and the master repeats its request."""
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

    def _hand_back_all(self) -> None:
        for number, bus in enumerate(self.buses):
            if bus.family.aside:
                self._hand_back(number, bus.family.aside)

    def _hand_back(self, number: int, frames: list[Frame]) -> None:
        for frame in frames:
            self.heard.put(pack_aside(AsideRecord(Aside.FRAME, number, frame.identifier, frame.data, frame.stamp_ns)))
        frames.clear()

    def _gather(self, up: Sequence[BusLink], actuals: list[Actual | None], until: int) -> int:
        """Actual values in time; in a stretched simulation also those this computer delays.  Returns how many are missing.

        A drive that does not answer is silent, and is not waited for again until all answer.
        """
        missing = self._collect(up, actuals, until)
        if not self._stretched:
            return missing
        if missing and self._waits:
            missing = self._collect(up, actuals, time.monotonic_ns() + WAITS_NS, missing)
        self._waits = missing == 0
        return missing

    def _collect(self, up: Sequence[BusLink], actuals: list[Actual | None], until: int, missing: int | None = None) -> int:
        """Wait for all actual values, or for those `missing`, at most to `until`; return how many are missing.

        A value present at the deadline came in time: the cycle was late, not the drive (AX-915).
        """
        if missing is None:
            missing = sum([bus.family.expected + len(bus.encoders) for bus in self.buses])
        if not missing:  # nothing to wait for, but other frames still arrive
            for bus in up:
                bus.receive(actuals)
        if self._collect_quickly is not None and missing and all(bus.plain for bus in up):
            return self._collected(self._collect_quickly, up, actuals, missing, until)
        first, looks = (
            True,
            0,
        )  # all actual values of a bus mostly arrive together: a further read would cost as much again
        while missing and looks < LAST_LOOKS and (fds := [bus.fd for bus in up if bus.port is not None]):
            left = until - time.monotonic_ns()
            looks += left <= 0
            ready = select.select(fds, (), (), max(0, left) * 1e-9)[0]
            if not ready and left <= 0:
                break
            for bus in up:
                if bus.fd in ready:
                    missing -= bus.receive(actuals, next_only=first)
            first = False
        return missing

    def _collected(self, collect: Collect, up: Sequence[BusLink], actuals: list[Actual | None], missing: int, until: int) -> int:
        """The same in C; a frame it cannot read is passed on, and a lost bus is not read any more."""
        while buses := [bus for bus in up if bus.plain and bus.telegrams is not None]:
            asked = [(bus.telegrams.table, bus.fd, bus.sent_ns) for bus in buses if bus.telegrams is not None]
            missing, late, odd = collect(asked, actuals, missing, until)
            buses[0].late += late
            if odd is None:
                break
            missing -= buses[odd[0]].receive_odd(odd[1], actuals)
        return missing

    def _watch_services(self) -> None:
        """A successor may be quicker than the life counter's limit: then only the writer's pid shows the death."""
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
        """A few per cycle: records waiting in the ring are not lost."""
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
        """Orders for this very process: an older generation's are dropped (a command is executed once)."""
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
    quick = NativeParts()
    for words in quick.missing:
        print(f"in Python: {words}", flush=True)
    cycle = Cycle(plan, fds_from_text(arguments.fds), quick)
    for warning in go_realtime(PRIORITY):
        print(warning, flush=True)
    cycle.run()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
