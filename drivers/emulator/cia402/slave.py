"""Emulated CiA 402 drives on one bus, in bus time: the stamps of the frames are the only clock.

The same stamped frames and seed produce the same answers bit for bit, however the frames are divided among calls (see servodyn_slave, whose
rules about `now` and grace apply here too).  Unlike boosters these drives send on their own (boot-up, heartbeat, profiles): time begins
with the first `wake` or frame, and `deadline` is 0 until then.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace

from drivers.emulator.canopen.node import CanopenNode, Handler
from drivers.emulator.canopen.objects import Objects
from drivers.emulator.cia402.delayed_frames import DelayedFrames
from drivers.emulator.cia402.errors import CAUSES
from drivers.emulator.cia402.orders import OrderedAxis
from drivers.emulator.cia402.seat import SPREAD, Counters, Event, Seat
from drivers.emulator.servo import record
from drivers.emulator.servo.model import NEVER, STEP_NS
from drivers.emulator.servo.settings import BusSettings, to_dict
from drivers.emulator.servodyn.slave import AHEAD_MARGIN_NS
from protocols.base.machine import Frame, FrameFault, Ns, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen.dictionary import ObjectDictionary
from protocols.canopen.sdo import Abort


class Cia402Slave:
    """A FrameMachine.  Never raises on frames of the bus."""

    def __init__(self, settings: BusSettings, dictionaries: Mapping[int, ObjectDictionary], substeps: int = 1) -> None:
        """`dictionaries` by node: from the EDS of its settings."""
        self.settings, self.counters = settings, Counters()
        self.cycle_ns = round(settings.cycle_ms * 1e6)
        self.grace_ns = max(ms(1), self.cycle_ns // 4)
        self.seats = [self._seat_of(number, dictionaries[number], substeps) for number in sorted(settings.nodes)]
        self._routes: dict[int, list[tuple[Seat, Handler]]] = {}
        self._sync_ids: set[int] = set()
        self._start: Ns | None = None
        self._time: Ns = 0
        self._soonest: Ns = 0
        self._last_sync: Ns | None = None
        self._row_due: Ns = NEVER
        self._delayed = DelayedFrames()
        self._output: list[Frame] = []
        self._rows = bytearray()

    def _seat_of(self, number: int, dictionary: ObjectDictionary, substeps: int) -> Seat:
        drive = self.settings.nodes[number]
        seed = self.settings.seed * 7919 + number
        axes: list[OrderedAxis] = []

        def application(objects: Objects, node: CanopenNode) -> OrderedAxis:
            axes.append(OrderedAxis(drive, self.cycle_ns, seed, objects, node, substeps))
            return axes[0]

        node = CanopenNode(dictionary, number, application)
        node.lss.identity = node.lss.identity._replace(serial=drive.serial)
        node.boot_ns = round(drive.servo.boot_s * 1e9)
        return Seat(number, node, axes[0], round(drive.tpdo_delay_us * 1e3), round(drive.tpdo_spread_us * 1e3), seed % (SPREAD - 1) + 1)

    # -- FrameMachine ---------------------------------------------------------------------------

    def receive(self, frames: Sequence[Frame], now: Ns) -> list[Event]:
        if self._start is None and frames:
            self._begin(frames[0].stamp_ns)
        for frame in frames:
            identifier = frame.identifier
            routes = self._routes.get(identifier)
            if routes is None:
                continue
            stamp = self._stamp(frame.stamp_ns)
            if stamp >= self._soonest:
                self._expire(stamp)
            self._time = stamp
            self.counters.frames += 1
            if identifier in self._sync_ids:
                self._sync(frame, routes, stamp, now)
            else:
                for seat, handler in routes:
                    self._hand(seat, handler, frame, stamp)
                    self._handled(seat, stamp)
        return []

    def error_frame(self, kind: FrameFault, now: Ns) -> list[Event]:
        """BUS_OFF: the controller that all these nodes share left the bus; the next frame received shows that it is back."""
        self.counters.error_frames += 1
        if kind is FrameFault.BUS_OFF and self._start is not None:
            for seat in self.seats:
                seat.bus_off = not seat.node.silent
                self._bus_off(seat)
            self._output.clear()
        return []

    def sent(self, now: Ns) -> list[Event]:
        return []

    def wake(self, now: Ns) -> list[Event]:
        """Handle what has expired by bus time `now`."""
        if self._start is None:
            self._begin(now)
        if now >= self._soonest:
            self._expire(now)
        return []

    def deadline(self) -> Ns | None:
        """The exact instant of the next expiry; call wake(deadline or later) a grace after it."""
        return None if self._soonest >= NEVER else self._soonest

    def take_output(self) -> list[Frame]:
        output, self._output = self._output, []
        return output

    def lost(self, now: Ns) -> list[Event]:
        """The port is lost: pending output is dropped; the drives keep running without their master."""
        self._output.clear()
        self._delayed.clear()
        return []

    # -- time -----------------------------------------------------------------------------------

    def _begin(self, stamp: Ns) -> None:
        self._start = self._time = stamp
        for seat in self.seats:
            seat.axis.begin(stamp)
            seat.node.power_up(stamp)
            self._collect(seat, stamp)
        self._row_due = stamp + self.cycle_ns
        self._route()
        self._replan()

    def _stamp(self, stamp: Ns) -> Ns:
        if stamp < self._time:
            self.counters.out_of_order += 1
            return self._time
        return stamp

    def _replan(self) -> None:
        soonest = self._row_due
        for seat in self.seats:
            due = seat.node.soonest
            if due < soonest:
                soonest = due
        self._soonest = min(soonest, self._delayed.due)

    def _expire(self, now: Ns) -> None:
        while (due := self._soonest) <= now:
            due = self._time = max(self._time, due)  # an order for "at once" (0) acts now, not in the past
            for seat in self.seats:
                if seat.node.soonest <= due:
                    self._act(seat, due)
            if self._delayed.due <= due:
                self._output += self._delayed.take(due)
            if self._row_due <= due:
                self._idle_row(due)
            if any(seat.node.accepted.changed for seat in self.seats):
                self._route()
            self._replan()

    def _act(self, seat: Seat, due: Ns) -> None:
        seat.axis.advance(due)
        seat.node.expire(due)
        self._collect(seat, due)

    def _handled(self, seat: Seat, stamp: Ns) -> None:
        """After a frame for one node; earlier due times stay noted, so that the effort does not grow with the number of nodes."""
        if seat.node.accepted.changed:
            self._route()
        if self._row_due == NEVER:
            self._row_due = stamp + self.cycle_ns
        self._soonest = min(self._soonest, self._row_due, seat.node.soonest)

    def _after(self, stamp: Ns) -> None:
        """After something that concerned many."""
        if any(seat.node.accepted.changed for seat in self.seats):
            self._route()
        if self._row_due == NEVER:
            self._row_due = stamp + self.cycle_ns
        self._replan()

    def _idle_row(self, due: Ns) -> None:
        """No SYNC: rows come every cycle while anything may move."""
        for seat in self.seats:
            seat.axis.advance(due)
            self._collect(seat, due)
        self._row([seat.axis.make_row(no_sync=True) for seat in self.seats], due)
        self._row_due = NEVER if all(seat.axis.settled for seat in self.seats) else due + self.cycle_ns

    # -- frames ---------------------------------------------------------------------------------

    def _route(self) -> None:
        self._routes, self._sync_ids = {}, {seat.node.sync_identifier for seat in self.seats}
        for seat in self.seats:
            seat.node.accepted.changed = False
            for identifier, handler in seat.node.accepted.data.items():
                self._routes.setdefault(identifier, []).append((seat, handler))
            for identifier, handler in seat.node.accepted.remotes.items():
                self._routes.setdefault(identifier | cobid.REMOTE, []).append((seat, handler))

    def _sync(self, frame: Frame, routes: list[tuple[Seat, Handler]], stamp: Ns, now: Ns) -> None:
        for seat in self.seats:
            seat.axis.row = None
        for seat, handler in routes:
            self._hand(seat, handler, frame, stamp)
        if any(seat.axis.row is not None for seat in self.seats):
            self._synced(stamp, now)
        self._after(stamp)

    def _hand(self, seat: Seat, handler: Handler, frame: Frame, stamp: Ns) -> None:
        if seat.bus_off:
            seat.bus_off = False
            seat.node.bus_on(stamp)
        if seat.node.silent:
            return
        if seat.drop_set and 0x200 <= frame.identifier <= 0x57F:
            seat.drop_set -= 1
            self.counters.dropped += 1
            return
        handler(frame, stamp)
        self._collect(seat, stamp)

    def _synced(self, stamp: Ns, now: Ns) -> None:
        """The record's row of this SYNC: the values all drives latched."""
        self.counters.syncs += 1
        self.counters.late += now - stamp > self.cycle_ns
        rows = []
        for seat in self.seats:
            row = seat.axis.row
            if row is None:
                seat.axis.advance(stamp)
                row = seat.axis.make_row(no_sync=True)
            rows.append(row)
        self._row(rows, stamp)
        self._last_sync, self._row_due = stamp, stamp + 2 * self.cycle_ns + self.cycle_ns // 4

    def _row(self, rows: list[record.AxisRow], stamp: Ns) -> None:
        self._rows += record.pack(stamp, self.counters.syncs, rows)

    def _collect(self, seat: Seat, stamp: Ns) -> None:
        """Read the node's output, and plan its next action."""
        node = seat.node
        output = node.output
        if output:
            node.output = []
            node.emergencies.send = node.output.append
            if not node.silent:
                self._say(seat, output, stamp)
        node.plan(seat.axis.due_ns)

    def _say(self, seat: Seat, frames: list[Frame], stamp: Ns) -> None:
        for frame in frames:
            measured = 0x180 <= frame.identifier <= 0x57F
            if measured and seat.drop_actual:
                seat.drop_actual -= 1
                self.counters.dropped += 1
            elif measured and (seat.delay_ns or seat.spread_ns):
                self._delay(seat, frame, stamp)
            else:
                self._output.append(frame)

    def _delay(self, seat: Seat, frame: Frame, stamp: Ns) -> None:
        seat.random = seat.random * 16807 % SPREAD
        self._delayed.add(frame, stamp + seat.delay_ns + seat.random % (seat.spread_ns + 1))

    # -- outside the protocol -------------------------------------------------------------------

    def prepare(self) -> None:
        """To be called when there is time after a SYNC: works ahead on copies, changes no result."""
        if self._start is None or self._last_sync is None or self._time - self._last_sync > self.cycle_ns:
            return
        step = (self._last_sync + self.cycle_ns - AHEAD_MARGIN_NS - self._start) // STEP_NS
        for seat in self.seats:
            seat.axis.prepare(step)

    def header(self) -> bytes:
        """First line of the record."""
        alone = replace(self.settings, axes={})
        return record.header(tuple(seat.number for seat in self.seats), to_dict(alone))

    def take_record(self) -> bytes:
        rows, self._rows = bytes(self._rows), bytearray()
        return rows

    def axis(self, number: int) -> OrderedAxis:
        """Raises KeyError when the bus has no such node."""
        return self.seat(number).axis

    def seat(self, number: int) -> Seat:
        for seat in self.seats:
            if seat.number == number:
                return seat
        raise KeyError(f"node {number} is not on this bus; there are {[seat.number for seat in self.seats]}")

    def state(self) -> dict[str, object]:
        """State for a tester, as plain JSON values."""
        nodes = {str(seat.number): seat.seen() for seat in self.seats}
        return {"bus_time_ns": self._time, "counters": asdict(self.counters), "nodes": nodes}

    # -- faults to order (act at the bus time reached) --------------------------------------------

    def stuck_encoder(self, node: int) -> None:
        """Counter and speed signal freeze."""
        self._order_axis(node, lambda axis: axis.encoder(0))

    def wrong_sign(self, node: int) -> None:
        """Counter and speed signal run backwards from here."""
        self._order_axis(node, lambda axis: axis.encoder(-1))

    def true_encoder(self, node: int) -> None:
        self._order_axis(node, lambda axis: axis.encoder(1))

    def jump_encoder(self, node: int, increments: int) -> None:
        """Shift the counter by so many increments."""
        self._order_axis(node, lambda axis: axis.jump_encoder(increments))

    def drop_actual(self, node: int, count: int) -> None:
        """The next `count` PDOs of the node are not sent."""
        self.seat(node).drop_actual = count

    def drop_set(self, node: int, count: int) -> None:
        """The next `count` PDOs to the node are not received."""
        self.seat(node).drop_set = count

    def power_off(self, node: int) -> None:
        """The drive is silent and its brake closes; unsaved values are lost."""
        seat = self.seat(node)
        seat.node.power_down()
        self._order_axis(node, lambda axis: axis.power_off())

    def power_on(self, node: int) -> None:
        seat = self.seat(node)
        if seat.node.silent:
            seat.node.power_up(self._time)
            self._order_axis(node, lambda axis: axis.power_on())

    def reset_node(self, node: int) -> None:
        """Its firmware starts again, as after a watchdog."""
        seat = self.seat(node)
        seat.node.power_up(self._time)
        self._order_axis(node, lambda axis: axis.reset(self._time))

    def bus_off(self, node: int) -> None:
        """Its controller leaves the bus; `bus_on` brings it back."""
        self._bus_off(self.seat(node))
        self._ordered(self.seat(node))

    def bus_on(self, node: int) -> None:
        seat = self.seat(node)
        seat.bus_off = False
        if seat.node.silent:
            seat.node.bus_on(self._time)
        self._ordered(seat)

    def force_fault(self, node: int, code: int = 0xFF00) -> None:
        """Any code of 603Fh; reaction as in 605Eh unless the code is one of those that switch the torque off."""
        self._order_axis(node, lambda axis: axis.fail(min(max(code, 1), 0xFFFF)))

    def cause(self, node: int, name: str, present: bool) -> None:
        """One of cia402_errors.CAUSES by its name; remains until it is removed.  Raises KeyError."""
        error = CAUSES[name]
        self._order_axis(node, lambda axis: axis.cause(error, present))

    def stick_brake(self, node: int, stuck: bool) -> None:
        self._order_axis(node, lambda axis: axis.stick_brake(stuck))

    def load_torque(self, node: int, torque_nm: float) -> None:
        """External torque at the motor shaft against positive motion; 0 removes it."""
        self._order_axis(node, lambda axis: axis.servo.load_torque(torque_nm))

    def local_control(self, node: int, local: bool) -> None:
        """The drive is operated at its own panel: bit 9 of the statusword falls, 6040h is refused."""

        def act(axis: OrderedAxis) -> None:
            axis.site.local = local

        self._order_axis(node, act)

    def refuse(self, node: int, index: int, sub: int, code: int = Abort.GENERAL, count: int = 1) -> None:
        """The next `count` SDO accesses to an object end in this abort code."""
        self.seat(node).node.objects.refused[index, sub] = code, count

    def memory_broken(self, node: int, broken: bool) -> None:
        """Storing parameters fails (06060000h; LSS: 2)."""
        seat = self.seat(node)
        seat.node.objects.memory_broken = seat.node.lss.memory_broken = broken

    def _bus_off(self, seat: Seat) -> None:
        if not seat.node.silent:
            seat.node.bus_off(self._time)

    def _order_axis(self, number: int, act: Callable[[OrderedAxis], None]) -> None:
        seat = self.seat(number)
        if self._start is not None:
            seat.axis.advance(self._time)
        act(seat.axis)
        self._ordered(seat)

    def _ordered(self, seat: Seat) -> None:
        if self._start is not None:
            seat.axis.reschedule()
            seat.node.events(self._time)
            self._collect(seat, self._time)
            self._after(self._time)
