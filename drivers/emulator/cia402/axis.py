"""One CiA 402 servo drive: power states, options, brake, limits, supervision and faults around the servo model.

Source: CiA 402-2 and 402-3 (IEC 61800-7-201); choices where they are open: AX-285..AX-290.  Never imports the gateway's side.
Time is counted in steps of the model from the bus' first stamp; call `advance` before reading or acting.
"""

from drivers.emulator.canopen.node import CanopenNode
from drivers.emulator.canopen.objects import OK, Objects
from drivers.emulator.cia402 import objects as od
from drivers.emulator.cia402.errors import BLIND, KINDS, RAMPLESS, Error
from drivers.emulator.cia402.modes import CODES, MODES, Mode
from drivers.emulator.cia402.motion import DriveMotion
from drivers.emulator.cia402.states import HALT_BIT, RESET_BIT, TRANSITIONS, Command, State, command_of
from drivers.emulator.servo.model import NEVER, STEP_NS, STEPS_PER_SLOW, Trip, steps
from drivers.emulator.servo.record import AxisRow
from drivers.emulator.servo.settings import DriveSettings
from protocols.base.machine import Ns
from protocols.canopen.sdo import Abort
from protocols.canopen.types import Value

IDLE_STEPS = 5 * STEPS_PER_SLOW  # how often an axis with power looks around when nothing else wakes it
HARDEST = 1e12  # inc/s2: as the torque limit allows
I2T_COOL = 0.9
_TRIPS = {Trip.FOLLOWING: Error.FOLLOWING, Trip.OVERSPEED: Error.OVERSPEED, Trip.I2T: Error.I2T, Trip.WINDING: Error.WINDING}
_POWERED = frozenset((State.ENABLED, State.QUICK_STOP, State.REACTION))


class Cia402Axis(DriveMotion):
    """The application of a CanopenNode."""

    def __init__(self, settings: DriveSettings, cycle_ns: Ns, seed: int, objects: Objects, node: CanopenNode, substeps: int = 1) -> None:
        super().__init__(settings, cycle_ns, seed, objects, node, substeps)
        self.start: Ns = 0
        self.controlword = 0
        self.new_set = False
        self.row: AxisRow | None = None  # of the last SYNC
        self.modes: dict[int, Mode] = {mode.code: mode(self) for mode in MODES}
        self.mode = self.modes[0]
        self._sync_due = self._tick_due = NEVER
        self._boot_due = steps(settings.servo.boot_s + settings.servo.charge_s)
        self._hook()
        self.reset(0)
        self.due = 0
        self._plan()

    # -- objects --------------------------------------------------------------------------------

    def _hook(self) -> None:
        objects, written, checks = self.objects, self.objects.written, self.objects.checks
        checks[od.CONTROLWORD] = lambda value: Abort.LOCAL_CONTROL if self.site.local else OK
        checks[od.MODE] = lambda value: OK if value in CODES else Abort.VALUE
        written[od.CONTROLWORD] = self._controlled
        written[od.MODE] = self._mode_written
        written[od.CLEAR_COUNTERS] = lambda value: self.sync_watch.clear()
        for key in (od.FOLLOWING_WINDOW, od.MAX_TORQUE, od.LIMIT_MIN, od.LIMIT_MAX):
            written[key] = lambda value: self._limits()
        for key in (od.CYCLE_PERIOD, od.PERIOD_VALUE, od.PERIOD_EXPONENT, od.SYNC_TOLERANCE):
            written[key] = lambda value: self._timing()
        written[od.PROBE_FUNCTION] = self._probe_written
        objects.may_store = lambda: self.state is not State.ENABLED

    # -- time -----------------------------------------------------------------------------------

    @property
    def due_ns(self) -> Ns:
        """When the next event of its own is due."""
        due = self.start + self.due * STEP_NS if self.due < NEVER else NEVER
        return due if due < self._sync_due else self._sync_due

    def begin(self, start: Ns) -> None:
        """The bus' time begins."""
        self.start = self.now = start

    def advance(self, now: Ns) -> None:
        step, rest_ns = divmod(now - self.start, STEP_NS)
        self.now = now
        self.place.at(rest_ns)
        servo = self.servo
        while True:
            trip = servo.run_to(step if step < self.due else self.due)
            if trip:
                self._tripped(trip)
            elif self.due <= step:
                self._timed(self.due)
            else:
                break
        if now >= self._sync_due:
            self._sync_due = NEVER
            self.fail(Error.SYNC)

    def prepare(self, step: int) -> None:
        """Runs the model ahead as far as nothing can be due; changes no result."""
        if step < self.due:
            self.servo.prepare(step)

    def _plan(self) -> None:
        due = self._tick_due if self._tick_due < self.brake.due else self.brake.due
        self.due = due if due < self._boot_due else self._boot_due

    def _schedule(self) -> None:
        """When to look again: every millisecond in motion, now and then with power, never at rest without."""
        busy = self.mode.busy or self.stop.active or self._follow_since is not None
        step = self.servo.step
        if busy:
            self._tick_due = (step // STEPS_PER_SLOW + 1) * STEPS_PER_SLOW
        elif (self._sync_due == NEVER or not self.mode.synchronous) if self.state in _POWERED else self.servo.speed_rad_s != 0.0:
            self._tick_due = (step // IDLE_STEPS + 1) * IDLE_STEPS
        else:
            self._tick_due = NEVER
        self._plan()

    def _timed(self, due: int) -> None:
        self.place.look_again()
        if self._boot_due <= due:
            self._boot_due = NEVER
            if self.state is State.NOT_READY:
                self.state = State.DISABLED  # transition 1
        if self.brake.due <= due:
            self._brake_moved()
        if self._tick_due <= due:
            self._tick()
        self._schedule()

    def _tick(self) -> None:
        if self.stop.active:
            self._stopped()
        elif self.mode.busy and self.state is State.ENABLED:
            self.mode.tick()
        if self._follow_since is not None:
            self._following()

    @property
    def settled(self) -> bool:
        return self.due == NEVER and self.servo.speed_rad_s == 0.0

    # -- SYNC -----------------------------------------------------------------------------------

    def sample(self, now: Ns) -> None:
        """Positions are latched; the record's row is the state before the new set values act."""
        self.advance(now)
        self._watch_sync(now)
        self.row = self.make_row()
        self.new_set = False

    def activate(self, now: Ns) -> None:
        if self.state is State.ENABLED and not self.stop.active:
            self.mode.sync(self.new_set)
        if self._tick_due == NEVER or self.mode.busy:
            self._schedule()

    def _watch_sync(self, now: Ns) -> None:
        watch = self.sync_watch
        watch.heard(now)
        if self.state is State.ENABLED and self.mode.synchronous:
            self._sync_due = now + watch.time_out
            if watch.in_a_row >= self.value(od.SYNC_FAULTS) > 0:
                self.fail(Error.SYNC)
        else:
            self._sync_due = NEVER

    # -- controlword ----------------------------------------------------------------------------

    def _controlled(self, value: Value) -> None:
        word = int(value) if isinstance(value, int) else 0
        before, self.controlword = self.controlword, word
        self.new_set = True
        if self.state is State.FAULT:
            if word & RESET_BIT and not before & RESET_BIT:
                self._reset_fault()
        elif self.state not in (State.NOT_READY, State.REACTION):
            self._command(command_of(word))
            if self.state is State.ENABLED and not self.stop.leads_out:
                self._halt(word)
                if not self.mode.halted or self.mode.code == 1:
                    self.mode.control(word, before)
        self._schedule()

    def _command(self, command: Command) -> None:
        if self.stop.leads_out and command is not Command.DISABLE_VOLTAGE and self.state is State.ENABLED:
            return  # on its way out already
        hit = TRANSITIONS.get((self.state, command))
        if hit is not None:
            self._transit(*hit)
            if self.state is State.ON and command is Command.ENABLE and hit[0] == 3:
                self._transit(4, State.ENABLED)
        elif self.brake.opening and command is not Command.ENABLE:
            self._release(State.ON)

    def _transit(self, number: int, state: State) -> None:
        """The transitions of the standard by their numbers."""
        match number:
            case 3 if self.site.no_power:
                return  # no power, no power stage
            case 4:
                self._enable()
            case 5:
                self._leave(self.value(od.DISABLE_OPTION), state)
            case 8:
                self._leave(self.value(od.SHUTDOWN_OPTION), state)
            case 11:
                self._quick_stop()
            case 16:
                self._back_to_work()
            case 6 | 7 | 10:
                self._release(state)
            case 9 | 12:
                self._coast(state)
            case _:
                self.state = state

    def _enable(self) -> None:
        """Transition 4: torque on, brake opens, then operation is enabled (AX-289)."""
        if self.brake.opening:
            return
        self.servo.arm(True)
        self.servo.hold()
        self.sync_watch.unlock()
        self._block()
        self.brake.opening = True
        self._brake(True)

    def _enabled(self) -> None:
        self.brake.opening = False
        self.state = State.ENABLED
        self._choose_mode()
        self.mode.enter()
        self._window()
        self._schedule()

    def _release(self, state: State) -> None:
        """Power stage off; nothing moves.  A brake that was on its way shut no longer ends a stop."""
        self.stop.active = False
        self.brake.nothing_waits()
        self.servo.off()
        self._window()
        self._brake(False)
        self.state = state

    def _coast(self, state: State) -> None:
        """Torque off at once, brake falls."""
        self.mode.leave()
        self._follow_since, self._sync_due = None, NEVER
        self._release(state)

    def _leave(self, option: int, state: State) -> None:
        """Out of operation enabled: at once, or along the slow-down ramp."""
        if option == 0:
            self._coast(state)
        else:
            self._ramp(float(self.value(od.DECELERATION)), state)

    def _quick_stop(self) -> None:
        option = self.value(od.QUICK_STOP_OPTION)
        if option == 0:
            self._coast(State.DISABLED)
            return
        self.state = State.QUICK_STOP
        self._sync_due = NEVER
        self._ramp(self._slope(option), State.DISABLED if option <= 4 else None)

    def _slope(self, option: int) -> float:
        """Deceleration of options 1..8: slow-down ramp, quick-stop ramp, current limit, voltage limit."""
        kind = (option - 1) % 4
        return float(self.value((od.DECELERATION, od.QUICK_STOP_DECELERATION)[kind])) if kind < 2 else HARDEST

    def _back_to_work(self) -> None:
        """Transition 16, only where quick stop stays in its state."""
        if self.value(od.QUICK_STOP_OPTION) >= 5:
            self.stop.active, self.state = False, State.ENABLED
            self.sync_watch.unlock()
            self.mode.enter()
            self._window()

    def _halt(self, word: int) -> None:
        if word & HALT_BIT and not self.mode.halted:
            self.mode.halt()
            self._ramp(self._slope(max(self.value(od.HALT_OPTION), 1)), None)
        elif not word & HALT_BIT and self.mode.halted:
            self.stop.active = False
            self.mode.resume()

    def _mode_written(self, value: Value) -> None:
        if self.state is State.ENABLED and not self.stop.active:
            before = self.mode
            self._choose_mode()
            if self.mode is not before:
                before.leave()
                self.mode.enter()
                self._window()
                self._sync_due = NEVER
        elif self.state not in _POWERED:
            self._choose_mode()
        self._schedule()

    def _choose_mode(self) -> None:
        self.mode = self.modes.get(self.value(od.MODE), self.modes[0])

    # -- stopping, brake --------------------------------------------------------------------------

    def _ramp(self, deceleration: float, after: State | None) -> None:
        """Decelerate to standstill; then `after`, or hold."""
        if self.state is not State.ENABLED or after is not None:
            self.mode.leave()
        self._follow_since = None
        self.stop.begin(after, self.servo.step + steps(self.settings.servo.stop_timeout_s))
        self.servo.stop(max(deceleration, 1.0))
        self._window()
        self._schedule()

    def _stopped(self) -> None:
        servo, still = self.servo, self.settings.servo.brake_lock_speed_rad_s
        if servo.speed_demand_rad_s == 0.0 and abs(servo.measured_speed_rad_s) < still:
            if self.brake.closing:
                return  # at standstill; the brake is moving
            servo.hold()
            if self.stop.after is None:
                self.stop.active = False
                self._window()
            else:
                self.brake.closing = True
                self._brake(False)
        elif servo.step >= self.stop.by and not self.brake.closing:
            self._lost_control()

    def _lost_control(self) -> None:
        """The ramp did not end in its time: torque off."""
        after = State.FAULT if self.state is State.REACTION else self.stop.after or State.DISABLED
        self._coast(after)
        if after is not State.FAULT:
            self.fail(Error.STOP_TIME_OUT)

    def _brake(self, open_it: bool) -> None:
        s = self.settings.servo
        self.brake.command(open_it, self.servo.step, s)
        if not s.brake:
            self.servo.open_brake() if open_it else self.servo.close_brake()
        self._plan()

    def _brake_moved(self) -> None:
        brake = self.brake
        brake.moved()
        if brake.is_open and not brake.stuck:
            self.servo.open_brake()
        else:
            self.servo.close_brake()
        if brake.opening and brake.is_open:
            self._enabled()
        elif brake.closing and not brake.is_open:
            brake.closing = self.stop.active = False
            self.servo.off()
            self.state = self.stop.after if self.stop.after is not None else State.DISABLED

    # -- supervision ------------------------------------------------------------------------------

    def _following(self) -> None:
        """Outside the window since a while."""
        if self.servo.mode != 1 or abs(self.demand - self.position) <= self.value(od.FOLLOWING_WINDOW):
            self._follow_since = None
            self._window()
        elif self._follow_since is not None and self.servo.step - self._follow_since >= self.value(od.FOLLOWING_TIME) * STEPS_PER_SLOW:
            self.fail(Error.FOLLOWING)

    def _tripped(self, trip: Trip) -> None:
        self.place.look_again()
        if trip is Trip.WINDOW:
            for edge in self.switches.crossed(self.servo):
                self._edge(edge)
        elif trip is Trip.FOLLOWING and self.value(od.FOLLOWING_TIME):
            self._follow_since = self.servo.step
            self._window()
        elif trip is Trip.OVERSPEED and self.state not in _POWERED:
            self.servo.arm(False)  # turned from outside without control: nothing the drive could do
        else:
            self.fail(_TRIPS[trip])
        self._schedule()

    def fail(self, error: int) -> None:
        """Transition 13: error code, emergency, reaction as in 605Eh; then 14."""
        if self.state is State.NOT_READY:
            return
        self.node.emergencies.raise_(error, KINDS.get(error, KINDS[Error.GENERIC]), self.now)
        if self.state in (State.REACTION, State.FAULT):
            return
        self.servo.arm(False)
        self.objects.values[od.ERROR_CODE] = error
        self._sync_due = NEVER
        powered = self.state in _POWERED or self.brake.opening
        option = self.value(od.FAULT_OPTION)
        self.brake.nothing_waits()
        self.state = State.REACTION
        if not powered or option == 0 or error in BLIND or error in RAMPLESS:
            self._coast(State.FAULT)
        else:
            self._ramp(self._slope(option), State.FAULT)
        self._schedule()

    def _reset_fault(self) -> None:
        """Transition 15: only when the cause is gone and the axis is at rest."""
        servo, s = self.servo, self.settings.servo
        cool = servo.i2t < I2T_COOL and servo.winding_c < s.winding_warning_c
        if self.site.causes or not cool or abs(servo.speed_rad_s) >= s.brake_lock_speed_rad_s:
            return
        self.state = State.DISABLED
        self.objects.values[od.ERROR_CODE] = 0
        servo.arm(True)
        self.node.emergencies.clear([code for code in self.node.emergencies.active if code in KINDS], self.now)

    # -- communication ----------------------------------------------------------------------------

    def connection_lost(self, now: Ns) -> None:
        """6007h; matters only with power."""
        self.advance(now)
        if self.state not in (State.ON, State.ENABLED, State.QUICK_STOP):
            return
        match self.value(od.ABORT_CONNECTION):
            case 1:
                self.fail(Error.CONNECTION)
            case 2:
                self._command(Command.DISABLE_VOLTAGE)
            case 3:
                self._command(Command.QUICK_STOP)
        self._schedule()

    def reset(self, now: Ns) -> None:
        """Reset node: everything as after power-up, but encoder and homing, which the device does not lose (AX-290)."""
        self._coast(State.NOT_READY)
        self.stop.active = False
        self.brake.nothing_waits()
        self.controlword = 0
        self.servo.arm(True)
        self.mode = self.modes[0]
        self._choose_mode()
        self._limits()
        self._timing()
        self.probe.arm(0)
        self.watch_switches()
        self._block()
        self._boot_due = self.servo.step + steps(self.settings.servo.boot_s + self.settings.servo.charge_s)
        self._schedule()
