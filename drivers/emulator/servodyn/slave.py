"""Six SERVODYN-GC boosters on one bus, in bus time: the stamps of the frames are the only clock.

The same stamped frames and seed give the same answers bit for bit, however the frames are divided among calls: the model is integrated in
full steps on a grid that starts at the first stamp, and each timeout is handled at its exact instant, whether `wake` or the next frame
finds it.  `wake(now)` must not be called with a `now` later than the stamp of a frame that is still to be handed in: the calling loop
drains its port first and waits a grace (`grace_ns`).

SYNC latches all positions and activates the set values received since the last SYNC; the actual values leave in axis order.  An axis with a
new fault sends one actual value at once.  Source: AX-001; what AX-001 does not define: AX-080..089.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from drivers.emulator.servo import record
from drivers.emulator.servo.model import NEVER, STEP_NS
from drivers.emulator.servo.settings import BusSettings, to_dict
from drivers.emulator.servodyn.axis import CAUSES, Fault, ServodynAxis, State
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, FrameFault, Ns, ms
from protocols.servodyn.codec import ActualValue, Codec, SetValue
from protocols.servodyn.parameters import decode_request, encode_answer, request_id
from protocols.servodyn.plan import SYNC_ID, set_id

IDLE_NS = ms(100)  # without SYNC the slow states move on at least this often
AHEAD_MARGIN_NS = 4 * STEP_NS  # how much earlier than P5 a SYNC may come without the work ahead being in vain


@dataclass(frozen=True, slots=True)
class FaultRaised:
    axis: int
    code: int
    stamp_ns: Ns


@dataclass(frozen=True, slots=True)
class SyncLost:
    stamp_ns: Ns


Event = FaultRaised | SyncLost


@dataclass(slots=True)
class Counters:
    syncs: int = 0
    set_values: int = 0
    undecodable: int = 0  # set values of wrong length or range
    out_of_order: int = 0  # stamps before one already handled: treated as that one
    late: int = 0  # SYNCs passed in more than P5 after their stamp: the integration catches up
    sync_losses: int = 0
    dropped: int = 0  # telegrams swallowed to order
    error_frames: int = 0


@dataclass(slots=True)
class _Seat:
    """One module of the bus: the axis and its state on the bus."""

    number: int
    axis: ServodynAxis
    pending: SetValue | None = None
    life: int | None = None
    life_due: Ns = NEVER
    drop_actual: int = 0
    drop_set: int = 0


@dataclass(slots=True)
class _BusTime:
    """Time from the stamps of the frames; it begins with the first one."""

    start: Ns | None = None
    now: Ns = 0  # the time reached
    last_sync: Ns | None = None

    def steps(self, stamp: Ns) -> tuple[int, int]:
        """The last full step before `stamp`, and the nanoseconds that remain."""
        assert self.start is not None, "time runs from the first stamp"
        return divmod(stamp - self.start, STEP_NS)

    def of_step(self, step: int) -> Ns:
        return (self.start or 0) + step * STEP_NS

    def ahead(self, cycle_ns: Ns) -> int | None:
        """The last step before the next SYNC is expected; None: none has come."""
        if self.start is None or self.last_sync is None:
            return None
        return (self.last_sync + cycle_ns - AHEAD_MARGIN_NS - self.start) // STEP_NS


@dataclass(slots=True)
class _Due:
    """When the bus must act without a frame; NEVER: it need not."""

    sync: Ns = NEVER  # the end of its supervision; never while no SYNC comes
    row: Ns = NEVER  # of the record, without a SYNC
    idle: Ns = NEVER  # slow states move on


class ServodynSlave:
    """A FrameMachine.  Never raises on frames of the bus."""

    def __init__(self, settings: BusSettings, codec: Codec, substeps: int = 1) -> None:
        self.settings, self.counters = settings, Counters()
        self._codec = codec
        self.cycle_ns = round(settings.cycle_ms * 1e6)
        self.supervision_ns = 2 * self.cycle_ns + self.cycle_ns // 4  # one SYNC may be skipped, with jitter (AX-081)
        self.grace_ns = max(ms(1), self.cycle_ns // 4)
        seeds = {number: settings.seed * 7919 + number for number in settings.axes}
        self._seats = [
            _Seat(number, ServodynAxis(axis, self.cycle_ns, seeds[number], substeps)) for number, axis in sorted(settings.axes.items())
        ]
        self._by_id = {set_id(seat.number): seat for seat in self._seats}
        self._parameters = {request_id(seat.number): seat for seat in self._seats}
        self._clock, self._due = _BusTime(), _Due()
        self._soonest = NEVER
        self._output: list[Frame] = []
        self._events: list[Event] = []
        self._rows = bytearray()

    # -- FrameMachine ---------------------------------------------------------------------------

    def receive(self, frames: Sequence[Frame], now: Ns) -> list[Event]:
        for frame in frames:
            mine = frame.identifier == SYNC_ID or frame.identifier in self._by_id
            if not mine and frame.identifier not in self._parameters:
                continue
            stamp = self._stamp(frame.stamp_ns)
            if stamp >= self._soonest:
                self._expire(stamp)
            if not mine:
                self._parameter(self._parameters[frame.identifier], frame, stamp)
            elif frame.identifier != SYNC_ID:
                self._set_value(self._by_id[frame.identifier], frame, stamp)
            elif not frame.data:
                self.counters.late += now - stamp > self.cycle_ns
                self._sync(stamp)
        return self._take_events()

    def error_frame(self, kind: FrameFault, now: Ns) -> list[Event]:
        self.counters.error_frames += 1
        return []

    def sent(self, now: Ns) -> list[Event]:
        return []

    def wake(self, now: Ns) -> list[Event]:
        """Handle what has expired by bus time `now`; see the module's text about `now`."""
        if now >= self._soonest:
            self._expire(now)
        return self._take_events()

    def deadline(self) -> Ns | None:
        """The exact instant of the next expiry; call wake(deadline or later) a grace after it."""
        due = self._next_due()
        return None if due == NEVER else due

    def take_output(self) -> list[Frame]:
        output, self._output = self._output, []
        return output

    def lost(self, now: Ns) -> list[Event]:
        """The port is lost: pending output is dropped; the drives keep running without SYNC."""
        self._output.clear()
        return self._take_events()

    # -- outside the protocol -------------------------------------------------------------------

    def prepare(self) -> None:
        """To be called when there is time after a SYNC: works ahead on copies, changes no result."""
        step = self._clock.ahead(self.cycle_ns) if self._due.sync != NEVER else None
        if step is not None:
            for seat in self._seats:
                seat.axis.prepare(step)

    def header(self) -> bytes:
        """First line of the record."""
        return record.header(tuple(seat.number for seat in self._seats), to_dict(self.settings))

    def take_record(self) -> bytes:
        rows, self._rows = bytes(self._rows), bytearray()
        return rows

    def axis(self, number: int) -> ServodynAxis:
        """Raises KeyError when the bus has no such module."""
        return self._seat(number).axis

    def state(self) -> dict[str, object]:
        """State for a tester, as plain JSON values."""
        axes = {}
        for seat in self._seats:
            axis, servo = seat.axis, seat.axis.servo
            axes[str(seat.number)] = {
                "state": axis.state.name.lower(),
                "fault": axis.fault_code,
                "brake_open": axis.brake_open,
                "warning": axis.warning,
                "position_rad": servo.position_rad,
                "speed_rad_s": servo.speed_rad_s,
                "torque_nm": servo.torque_nm,
                "counter_inc": int(servo.counter_inc // 1.0),
                "reference_switch": axis.reference_switch,
                "limit": axis.limit_active,
                "i2t": servo.i2t,
                "winding_c": servo.winding_c,
            }
        return {"bus_time_ns": self._clock.now, "sync_alive": self._due.sync != NEVER, "counters": asdict(self.counters), "axes": axes}

    # -- faults to order (act at the bus time reached) --------------------------------------------

    def stuck_encoder(self, axis: int) -> None:
        """Counter and speed signal freeze."""
        self._seat(axis).axis.encoder(0)
        self._injected()

    def wrong_sign(self, axis: int) -> None:
        """Counter and speed signal run backwards from here."""
        self._seat(axis).axis.encoder(-1)
        self._injected()

    def true_encoder(self, axis: int) -> None:
        self._seat(axis).axis.encoder(1)
        self._injected()

    def drop_actual(self, axis: int, count: int) -> None:
        """The next `count` actual values are not sent."""
        self._seat(axis).drop_actual = count

    def drop_set(self, axis: int, count: int) -> None:
        """The next `count` set values are not received."""
        self._seat(axis).drop_set = count

    def power_off(self, axis: int) -> None:
        """The booster is silent, its brake falls, references and faults are forgotten."""
        self._seat(axis).axis.power_off()
        self._injected()

    def power_on(self, axis: int) -> None:
        """Boots again; the counter knows the position within one turn only."""
        self._seat(axis).axis.power_on()
        self._injected()

    def force_fault(self, axis: int, code: int = Fault.FORCED) -> None:
        """Any code 1..255; stops along the ramp unless the code is one of those that switch the torque off."""
        self._seat(axis).axis.fail(min(max(code, 1), 255))
        self._injected()

    def cause(self, axis: int, name: str, present: bool) -> None:
        """One of servodyn_axis.CAUSES by its name; remains until it is removed.  Raises KeyError."""
        self._seat(axis).axis.cause(CAUSES[name], present)
        self._injected()

    def stick_brake(self, axis: int, stuck: bool) -> None:
        """The brake does not open any more."""
        self._seat(axis).axis.stick_brake(stuck)

    def jump_encoder(self, axis: int, increments: int) -> None:
        """Shift the counter by so many increments."""
        self._seat(axis).axis.jump_encoder(increments)
        self._injected()

    def load_torque(self, axis: int, torque_nm: float) -> None:
        """External torque at the motor shaft against positive motion; 0 removes it."""
        self._seat(axis).axis.servo.load_torque(torque_nm)
        self._injected()

    def _seat(self, number: int) -> _Seat:
        for seat in self._seats:
            if seat.number == number:
                return seat
        raise KeyError(f"module {number} is not on this bus; there are {[seat.number for seat in self._seats]}")

    def _injected(self) -> None:
        self._report_faults(self._clock.now)
        if self._due.sync == NEVER and self._clock.start is not None and self._due.row == NEVER:
            self._due.row, self._due.idle = self._clock.now + self.cycle_ns, NEVER
        self._soonest = self._next_due()

    # -- time -----------------------------------------------------------------------------------

    def _stamp(self, stamp: Ns) -> Ns:
        clock = self._clock
        if clock.start is None:
            clock.start = clock.now = stamp
            self._due.idle = self._soonest = stamp + IDLE_NS
        if stamp < clock.now:
            self.counters.out_of_order += 1
            return clock.now
        clock.now = stamp
        return stamp

    def _next_due(self) -> Ns:
        own = self._due
        due = min(own.sync, own.row, own.idle)
        for seat in self._seats:
            if seat.life_due < due and seat.axis.supervised:
                due = seat.life_due
        return due

    def _expire(self, now: Ns) -> None:
        while (due := self._next_due()) <= now:
            self._clock.now = max(self._clock.now, due)
            rest = self._advance(due)
            if due == self._due.sync:
                self._sync_lost(due)
            for seat in self._seats:
                if seat.life_due <= due and seat.axis.supervised:
                    seat.life_due = NEVER
                    seat.axis.fail(Fault.LIFE_LOST)
            self._report_faults(due)
            if due == self._due.row:
                self._row(due, [seat.axis.sync(rest, None, no_sync=True) for seat in self._seats])
                settled = all(seat.axis.settled for seat in self._seats)
                self._due.row, self._due.idle = (NEVER, due + IDLE_NS) if settled else (due + self.cycle_ns, NEVER)
            elif due == self._due.idle:
                self._due.idle = due + IDLE_NS
        self._soonest = self._next_due()

    def _sync_lost(self, due: Ns) -> None:
        self.counters.sync_losses += 1
        self._due.sync, self._due.row = NEVER, due
        self._events.append(SyncLost(due))
        for seat in self._seats:
            if seat.axis.supervised:
                seat.axis.fail(Fault.SYNC_LOST)
            else:
                seat.axis.bus_lost = True

    def _advance(self, stamp: Ns) -> int:
        """Advance all axes to the last full step before `stamp`; return the nanoseconds that remain."""
        step, rest = self._clock.steps(stamp)
        news = False
        for seat in self._seats:
            seat.axis.advance(step)
            news = news or bool(seat.axis.faulted_at)
        if news:
            self._report_faults(None)
        return rest

    def _report_faults(self, stamp: Ns | None) -> None:
        """Spontaneous actual values of axes that fell into fault, in order of time, then of axes; stamp None: that of the step."""
        found: list[tuple[int, int, ActualValue]] = []
        for seat in self._seats:
            found += [(step, seat.number, value) for step, value in seat.axis.faulted_at]
            seat.axis.faulted_at.clear()
        for step, number, value in sorted(found):
            self._events.append(FaultRaised(number, value.fault_code, self._clock.of_step(step) if stamp is None else stamp))
            self._send(self._seat(number), value)

    # -- telegrams ------------------------------------------------------------------------------

    def _set_value(self, seat: _Seat, frame: Frame, stamp: Ns) -> None:
        if seat.drop_set:
            seat.drop_set -= 1
            self.counters.dropped += 1
            return
        try:
            _, value = self._codec.decode_set(frame)
        except DecodeError:
            self.counters.undecodable += 1
            return
        self.counters.set_values += 1
        seat.pending = value
        if value.life != seat.life:
            seat.life, seat.life_due = value.life, stamp + self.supervision_ns

    def _parameter(self, seat: _Seat, frame: Frame, stamp: Ns) -> None:
        self._advance(stamp)
        try:
            _, request = decode_request(frame)
        except DecodeError:
            self.counters.undecodable += 1
            return
        answer = seat.axis.parameter(request)
        if answer is not None:
            self._output.append(encode_answer(seat.number, answer))

    def _sync(self, stamp: Ns) -> None:
        self.counters.syncs += 1
        rest = self._advance(stamp)
        rows = []
        for seat in self._seats:
            axis, before = seat.axis, seat.axis.supervised
            rows.append(axis.sync(rest, seat.pending))
            seat.pending = None
            if axis.supervised and not before:
                seat.life_due = stamp + self.supervision_ns
            for _, value in axis.faulted_at:  # found on activation: the telegram below reports it
                self._events.append(FaultRaised(seat.number, value.fault_code, stamp))
            axis.faulted_at.clear()
            self._send(seat, axis.actual())
        self._row(stamp, rows)
        self._clock.last_sync = stamp
        self._due.sync, self._due.row, self._due.idle = stamp + self.supervision_ns, NEVER, NEVER
        self._soonest = self._next_due()

    def _send(self, seat: _Seat, value: ActualValue) -> None:
        if seat.axis.state is State.OFFLINE:
            return
        if seat.drop_actual:
            seat.drop_actual -= 1
            self.counters.dropped += 1
            return
        self._output.append(self._codec.encode_actual(seat.number, value))

    def _row(self, stamp: Ns, rows: list[record.AxisRow]) -> None:
        self._rows += record.pack(stamp, self.counters.syncs, rows)

    def _take_events(self) -> list[Event]:
        events, self._events = self._events, []
        return events
