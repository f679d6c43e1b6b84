"""One SERVODYN-GC booster as AX-001 describes it: its power states, brake, limits and faults, around the servo model.

Written from AX-001 and the notes of AX-080..089, never from the gateway's side of the same protocol.

State      | leaves it                                                                                        | for
OFFLINE    | power returns                                                                                    | BOOTING
BOOTING    | boot_s over; counter = resolver within the turn                                                   | READY
READY      | drive on, seen 0 since boot or fault                                                             | CHARGING
CHARGING   | charge_s over; drive on gone                                                                     | POWERED; READY
POWERED    | enable; drive on gone                                                                            | OPENING; READY
OPENING    | brake open; enable or drive on gone                                                              | ENABLED; CLOSING
ENABLED    | enable or drive on gone, or a fault that stops along the ramp                                     | STOPPING
STOPPING   | standstill; stop_timeout_s                                                                       | CLOSING; fault
CLOSING    | brake closed                                                                                     | FAULT, POWERED or READY
FAULT      | fault reset edge, standstill, cause gone                                                         | READY
any        | fault that cannot trust its feedback (torque off, brake at once)                                  | FAULT
any        | power gone (silent, brake falls)                                                                  | OFFLINE
"""

from collections.abc import Mapping
from enum import IntEnum
from math import pi

from drivers.emulator.servo.model import NEVER, STEPS_PER_SLOW, Servo, Trip, steps
from drivers.emulator.servo.record import AxisRow, Flag
from drivers.emulator.servo.settings import INC_PER_TURN, ServoSettings
from drivers.emulator.servodyn.brake import BoosterBrake
from drivers.emulator.servodyn.commanded import Commanded, wrap
from drivers.emulator.servodyn.parameters import ParameterStore
from drivers.emulator.servodyn.travel import BoosterTravel
from protocols.servodyn.codec import ActualValue, SetValue
from protocols.servodyn.parameters import Answer, Request, Status

RPM = 2.0 * pi / 60.0
I2T_WARNING, I2T_COOL = 0.8, 0.9


class State(IntEnum):
    OFFLINE, BOOTING, READY, CHARGING, POWERED, OPENING, ENABLED, STOPPING, CLOSING, FAULT = range(10)


class Fault(IntEnum):
    """Codes in byte 1 of the actual value: axisgate's own (AX-082); 0 = none."""

    NONE = 0
    SYNC_LOST = 1  # no SYNC for 2 x P5 and its tolerance (AX-081)
    LIFE_LOST = 2  # life counter unchanged for as long
    FOLLOWING_ERROR = 3
    SET_JUMP = 4  # set position jumped by more than the following error window
    SOFTWARE_LIMIT = 5
    HARD_LIMIT = 6
    OVERSPEED = 7
    I2T = 8
    WINDING = 9
    STOP_TIMEOUT = 10  # the ramp did not end in stop_timeout_s
    UNDERVOLTAGE = 11
    PHASE_LOSS = 12  # of the motor cable
    TEMPERATURE = 13  # of the booster's heat sink
    ENCODER = 14  # resolver signals
    BRAKE = 15  # it did not open
    FORCED = 99  # by the tester


CAUSES: Mapping[str, Fault] = {  # faults that a test may hold active
    "undervoltage": Fault.UNDERVOLTAGE,
    "phase_loss": Fault.PHASE_LOSS,
    "over_temperature": Fault.TEMPERATURE,
    "motor_over_temperature": Fault.WINDING,
    "encoder_fault": Fault.ENCODER,
}
_POWER = frozenset((State.POWERED, State.OPENING, State.ENABLED, State.STOPPING, State.CLOSING))
_CONTROLLED = frozenset((State.OPENING, State.ENABLED, State.STOPPING, State.CLOSING))
_SUPERVISED = _POWER | {State.CHARGING}
# Feedback or power is not to be trusted: torque off
_BLIND = frozenset(
    (Fault.FOLLOWING_ERROR, Fault.OVERSPEED, Fault.STOP_TIMEOUT, Fault.UNDERVOLTAGE, Fault.PHASE_LOSS, Fault.ENCODER, Fault.BRAKE)
)
_TRIPS = {Trip.FOLLOWING: Fault.FOLLOWING_ERROR, Trip.OVERSPEED: Fault.OVERSPEED, Trip.I2T: Fault.I2T, Trip.WINDING: Fault.WINDING}


class ServodynAxis:
    """Moves on in steps of 62.5 us; `advance` first, then look or act."""

    def __init__(self, settings: ServoSettings, cycle_ns: int, seed: int = 1, substeps: int = 1) -> None:
        self.settings, self.servo = settings, Servo(settings, seed, substeps)
        self.parameters = ParameterStore(settings)
        self._cycle_ns = cycle_ns
        self.state, self.fault_code = State.BOOTING, 0
        self.brake, self.travel, self.commanded = BoosterBrake(), BoosterTravel(), Commanded()
        self.bus_lost = False  # warning only: SYNC went while no power was on
        self.faulted_at: list[tuple[int, ActualValue]] = []  # (step, actual value that reports it), to be read by the bus
        self._due, self._stop_by = steps(settings.boot_s), NEVER
        self.causes: set[Fault] = set()  # faults that stay active until their cause is gone
        self._latched = int(self.servo.counter_inc // 1.0)
        self._look_around()

    # -- time -----------------------------------------------------------------------------------

    @property
    def supervised(self) -> bool:
        return self.state in _SUPERVISED

    @property
    def settled(self) -> bool:
        """No event of its own is pending."""
        waits = self._due == NEVER and self.brake.due == NEVER
        return waits and self.state not in _CONTROLLED and self.servo.speed_rad_s == 0.0

    def advance(self, step: int) -> None:
        """Up to and including everything that is due at `step`."""
        servo = self.servo
        while True:
            due = self._due if self._due < self.brake.due else self.brake.due
            trip = servo.run_to(step if step < due else due)
            if trip:
                self._tripped(trip)
            elif due <= step:
                self._timed(due)
            else:
                return

    def prepare(self, step: int) -> None:
        """Runs the model ahead as far as nothing can be due; changes no result."""
        if step < self._due and step < self.brake.due:
            self.servo.prepare(step)

    def _timed(self, due: int) -> None:
        if self.brake.due <= due:
            self.brake.due = NEVER
            self._brake_moved()
        if self._due > due:
            return
        self._due = NEVER
        match self.state:
            case State.BOOTING:
                self.state = State.READY
                for cause in sorted(self.causes):
                    self._fail(cause)
            case State.CHARGING:
                self.state = State.POWERED
            case State.STOPPING:
                self._stopping(due)

    def _stopping(self, step: int) -> None:
        servo = self.servo
        if servo.speed_demand_rad_s == 0.0 and abs(servo.measured_speed_rad_s) < self.settings.brake_lock_speed_rad_s:
            self.state = State.CLOSING
            self._command_brake(False)
        elif step >= self._stop_by:
            self._fail(Fault.STOP_TIMEOUT)
        else:
            self._due = (step // STEPS_PER_SLOW + 1) * STEPS_PER_SLOW

    # -- brake ----------------------------------------------------------------------------------

    @property
    def brake_open(self) -> bool:
        return self.brake.is_open

    def _command_brake(self, open_it: bool) -> None:
        self.brake.command(open_it, self.servo.step, self.settings, waited_for=self.state in (State.OPENING, State.CLOSING))

    def _brake_moved(self) -> None:
        if not self.brake.moved(self.settings):
            self._fail(Fault.BRAKE)
            return
        if self.brake_open:
            self.servo.open_brake()
        else:
            self.servo.close_brake()
        if self.state is State.OPENING and self.brake_open:
            self.state = State.ENABLED
        elif self.state is State.CLOSING and not self.brake_open:
            self.servo.off()
            self.state = State.FAULT if self.fault_code else State.POWERED if self.commanded.value.drive_on else State.READY

    # -- faults ---------------------------------------------------------------------------------

    def fail(self, code: int) -> None:
        """A fault from outside (supervision, tester)."""
        if self.state is not State.OFFLINE and self.state is not State.BOOTING:
            self._fail(code)

    def _tripped(self, trip: Trip) -> None:
        if trip is Trip.WINDOW:
            self._crossed()
        elif trip is Trip.OVERSPEED and self.state not in _CONTROLLED:
            self.servo.arm(False)  # turned from outside without control: nothing the booster could do
        elif self.state is not State.OFFLINE:
            self._fail(_TRIPS[trip])

    def _fail(self, code: int) -> None:
        self.servo.arm(False)
        first = not self.fault_code
        self.fault_code = self.fault_code or int(code)
        if self.state in _CONTROLLED and code not in _BLIND:
            if self.state is not State.CLOSING:
                self._stop()
        else:
            self.servo.off()
            self._due = NEVER
            self.state = State.FAULT
            self._command_brake(False)
        if first:
            self.faulted_at.append((self.servo.step, self.actual()))

    def _stop(self) -> None:
        if self.state is State.STOPPING:
            return
        self.servo.ramp()
        self.state = State.STOPPING
        self._stop_by = self.servo.step + steps(self.settings.stop_timeout_s)
        self._due = (self.servo.step // STEPS_PER_SLOW + 1) * STEPS_PER_SLOW

    # -- the bus --------------------------------------------------------------------------------

    def sync(self, rest_ns: int, value: SetValue | None, no_sync: bool = False) -> AxisRow:
        """SYNC (or a row without one) `rest_ns` after the step reached: latch, then activate the set value received since the last one."""
        servo = self.servo
        position, counter = servo.latch(rest_ns)
        demand = int(servo.demand_inc(rest_ns) // 1.0) if self.state in (State.OPENING, State.ENABLED) else counter
        row_state, flags = self.state, self._flags(value is not None, no_sync)
        row = AxisRow(wrap(counter), wrap(demand), position, servo.speed_rad_s, servo.torque_nm, row_state, self.fault_code, flags)
        if not no_sync:
            self._latched = counter
            self.bus_lost = False
            if value is not None and self.state is not State.OFFLINE:
                self._activate(value, rest_ns)
            elif self.state is State.ENABLED:  # nothing new: stay where the last one pointed
                self.commanded.stay()
                servo.follow(float(self.commanded.target), rest_ns, self._cycle_ns, 0.0)
        return row

    def actual(self) -> ActualValue:
        """Present actual-value telegram; the position is the one latched at the last SYNC."""
        s, servo, state = self.settings, self.servo, self.state
        torque = round(servo.torque_nm / s.rated_torque_nm * 1000.0)
        return ActualValue(
            state is not State.BOOTING and not self.fault_code,
            state in _POWER,
            state is State.ENABLED,
            self.fault_code != 0,
            self.warning,
            self.limit_active,
            self.reference_switch,
            self.brake.is_open,
            self.fault_code,
            wrap(self._latched // self.commanded.scale),
            min(max(torque, -32768), 32767),
        )

    @property
    def warning(self) -> bool:
        return self.bus_lost or self.servo.i2t > I2T_WARNING or self.servo.winding_c > self.settings.winding_warning_c

    @property
    def limit_active(self) -> bool:
        return self.travel.beyond != 0

    @property
    def reference_switch(self) -> bool:
        return self.settings.reference_switch_from_rad < self.servo.position_rad < self.settings.reference_switch_to_rad

    def _flags(self, new_set: bool, no_sync: bool) -> int:
        flags = Flag.NO_SYNC * no_sync | Flag.NEW_SET * new_set | Flag.ENABLED * (self.state is State.ENABLED)
        flags |= Flag.BRAKE_OPEN * self.brake.is_open | Flag.REFERENCE_SWITCH * self.reference_switch
        return int(flags | Flag.LIMIT * self.limit_active | Flag.WARNING * self.warning | Flag.POWER_ON * (self.state in _POWER))

    def _activate(self, value: SetValue, rest_ns: int) -> None:
        before = self.commanded.take(value)
        if value.limit_switch and not before.limit_switch:
            self.travel.seek_zero(self.servo, self.settings)
        match self.state:
            case State.READY:
                if value.drive_on and self.commanded.may_switch_on:
                    self.state, self._due = State.CHARGING, self.servo.step + steps(self.settings.charge_s)
            case State.CHARGING | State.POWERED:
                self._powered(value)
            case State.OPENING if not (value.enable and value.drive_on):
                self.state = State.CLOSING
                self._command_brake(False)
            case State.ENABLED:
                if value.enable and value.drive_on:
                    self._follow(value, rest_ns)
                else:
                    self._stop()
            case State.FAULT if value.fault_reset and not before.fault_reset:
                self._reset()

    def _powered(self, value: SetValue) -> None:
        if not value.drive_on:
            self.state, self._due = State.READY, NEVER
        elif self.state is State.POWERED and value.enable:
            self.servo.hold()
            self.servo.block(self.travel.beyond)
            self.servo.arm(True)
            self.commanded.begin(int(self.servo.counter_inc // 1.0))
            self.state = State.OPENING
            self._command_brake(True)
            return
        if self.settings.brake_release and self.state is State.POWERED and value.brake_open is not self.brake_open:
            self._command_brake(value.brake_open)
        elif self.brake_open and self.state is State.READY:
            self._command_brake(False)

    def _follow(self, value: SetValue, rest_ns: int) -> None:
        window = self.settings.following_error_rad * INC_PER_TURN / (2.0 * pi)
        if not self.commanded.lead(value.position_inc, window):
            self._fail(Fault.SET_JUMP)
            return
        self.servo.follow(float(self.commanded.target), rest_ns, self._cycle_ns, value.speed_rpm * RPM)

    def _reset(self) -> None:
        servo = self.servo
        cool = servo.i2t < I2T_COOL and servo.winding_c < self.settings.winding_warning_c
        if cool and not self.causes and abs(servo.speed_rad_s) < self.settings.brake_lock_speed_rad_s:
            self.fault_code, self.state = 0, State.READY
            self.commanded.may_switch_on = not self.commanded.value.drive_on
            servo.arm(True)

    # -- limits ---------------------------------------------------------------------------------

    def _look_around(self) -> None:
        self.travel.look_around(self.servo, self.settings)

    def _crossed(self) -> None:
        """The watched window was left."""
        if not self.travel.crossed(self.servo, self.settings):
            return
        if not self.travel.beyond:
            self.servo.block(0)
        elif self.state in _CONTROLLED:
            s, position = self.settings, self.servo.position_rad
            hard = position > s.hard_limit_max_rad or position < s.hard_limit_min_rad
            self._fail(Fault.HARD_LIMIT if hard else Fault.SOFTWARE_LIMIT)

    # -- parameters -----------------------------------------------------------------------------

    def parameter(self, request: Request) -> Answer | None:
        """A parameter from the bus (AX-266); None: no such drive."""
        if self.state is State.OFFLINE:
            return None
        answer = self.parameters.take(request, power_on=self.state in _SUPERVISED or self.servo.speed_rad_s != 0.0)
        if answer.status is Status.TAKEN:
            self._tune()
            self._look_around()
        return answer

    def _tune(self) -> None:
        self.settings, self.commanded.scale = self.parameters.settings(), self.parameters.scale
        self.servo.retune(self.settings)

    # -- to order --------------------------------------------------------------

    def encoder(self, factor: int) -> None:
        """1 true, -1 counts backwards, 0 stuck."""
        self.servo.encoder(factor)
        self._look_around()

    def cause(self, fault: Fault, present: bool) -> None:
        """A fault whose cause remains until it is removed; until then a reset has no effect."""
        if not present:
            self.causes.discard(fault)
            return
        self.causes.add(fault)
        self.fail(fault)

    def stick_brake(self, stuck: bool) -> None:
        """The brake does not open any more."""
        self.brake.stuck = stuck

    def jump_encoder(self, increments: int) -> None:
        """Shift the counter by so many increments."""
        self.servo.jump(increments)
        self._look_around()

    def power_off(self) -> None:
        """The booster loses its supply: silent, no torque, the brake closes; the shaft coasts."""
        self.servo.off()
        self.state, self.fault_code, self._due = State.OFFLINE, 0, NEVER
        self._command_brake(False)

    def power_on(self) -> None:
        if self.state is State.OFFLINE:
            self.servo.power_up()
            self.commanded.restart()
            self.travel.forget()
            self.parameters.restart()
            self._tune()
            self.servo.block(0)
            self._look_around()
            self.state, self._due = State.BOOTING, self.servo.step + steps(self.settings.boot_s)
