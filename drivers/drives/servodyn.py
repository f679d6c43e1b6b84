"""Gateway's side of a SERVODYN-GC drive: the set value of each cycle for switching on, following and switching off in order.

Source: AX-001 (telegrams), AX-105..110 (order of the bits, refusals, losses).  Once per SYNC, after the actual values of that SYNC:
Drive.step.  It never raises on a message of the drive.
"""

from dataclasses import dataclass
from enum import Enum, auto

from drivers.drives.family import Actual, Demand, Event, Homing, Power
from drivers.drives.limits import INT16_MAX, INT32_MAX, INT32_MIN, fits_int32, saturated_rpm
from protocols.servodyn.codec import ActualValue, SetValue

__all__ = ["LOST_AFTER", "Demand", "Drive", "DriveSettings", "Event", "Phase", "Power"]

LOST_AFTER = 2  # actual values missing in a row
_new = tuple.__new__  # of a record without counting its fields again: once an axis and cycle
RESET_CYCLES = 5  # cycles the reset bit is set for one edge of the demand: one lost telegram does not hide it


class Phase(Enum):
    """Step of the sequence."""

    OFF = auto()
    POWERING = auto()  # drive on sent; waits for power on
    ENABLING = auto()  # enable sent; waits for enabled
    RELEASING = auto()  # in control; waits for the brake
    ENABLED = auto()
    DISABLING = auto()  # enable cleared: the drive stops by its own ramp and closes the brake
    UNPOWERING = auto()  # drive on cleared
    FAULT = auto()
    LOST = auto()


@dataclass(frozen=True, slots=True)
class Row:
    """One phase: the state shown outside, the bits sent, the condition that ends it and the next phase."""

    power: Power
    drive_on: bool = False
    enable: bool = False  # with it the request to open the brake
    waits_for: tuple[str, bool] | None = None  # actual bit and its value
    then: Phase | None = None
    on_off: Phase | None = None  # where a demand to go off, or a time-out, leads


ROWS = {
    Phase.OFF: Row(Power.OFF),
    Phase.POWERING: Row(Power.SWITCHING_ON, True, False, ("power_on", True), Phase.ENABLING, Phase.UNPOWERING),
    Phase.ENABLING: Row(Power.SWITCHING_ON, True, True, ("enabled", True), Phase.RELEASING, Phase.DISABLING),
    Phase.RELEASING: Row(Power.SWITCHING_ON, True, True, ("brake_open", True), Phase.ENABLED, Phase.DISABLING),
    Phase.ENABLED: Row(Power.ENABLED, True, True, None, None, Phase.DISABLING),
    Phase.DISABLING: Row(Power.SWITCHING_OFF, True, False, ("enabled", False), Phase.UNPOWERING),
    Phase.UNPOWERING: Row(Power.SWITCHING_OFF, False, False, ("power_on", False), Phase.OFF),
    Phase.FAULT: Row(Power.FAULT),
    Phase.LOST: Row(Power.LOST),
}
IN_CONTROL = (Phase.RELEASING, Phase.ENABLED)
ON_REACHING = {Phase.ENABLED: Event.ENABLED, Phase.OFF: Event.OFF}


@dataclass(frozen=True, slots=True)
class DriveSettings:
    """Increments and cycles; the assembly computes them from the cell."""

    jump_inc: int = 8192  # first demanded position: so close to the held one
    step_inc: int = 32768  # every later one: so close to the one before
    timeout_cycles: int = 1250  # for one phase (5 s at P5 = 4 ms)
    brake: bool = True  # False: the drive reports no brake

    def make(self) -> "Drive":
        """A drive that is off."""
        return Drive(self)


class Drive:
    """One drive.  A new object starts off, and a demand already present then is not a command (design 1)."""

    __slots__ = (
        "_asked", "_cycles", "_following", "_life", "_on_before", "_phase", "_refused", "_reset_before", "_reset_left", "_row", "_settings",
        "configured", "epoch", "events", "fault_code", "follows", "missing", "position_inc", "power", "saturated", "set_inc",
        "torque_permille", "warning",
    )  # fmt: skip

    def __init__(self, settings: DriveSettings | None = None) -> None:
        self._settings = settings or DriveSettings()
        self._phase = Phase.OFF
        self._row = ROWS[Phase.OFF]  # of the present phase; kept, as the next two: they are read many times a cycle
        self.power = Power.OFF  # seen from outside
        self.follows = False  # takes the demanded position
        self._cycles = 0  # in the present phase
        self._on_before = self._reset_before = True
        self._asked = False  # an edge of `on` that waits for OFF
        self._reset_left = 0
        self._following = True  # no demanded position accepted yet since control began
        self._refused = False
        self._life = 0
        self.position_inc = 0  # last actual
        self.set_inc = 0  # last sent
        self.torque_permille = 0
        self.fault_code = 0
        self.warning = False
        self.missing = 0  # actual values missing in a row
        self.epoch = 0  # +1 whenever increments may have lost their meaning: references of another epoch are void (AX-110)
        self.saturated = 0  # speeds cut to int16, counted
        self.events: list[Event] = []  # of the last step
        self.configured = True  # a booster keeps its parameters

    @property
    def phase(self) -> Phase:
        """Exactly."""
        return self._phase

    @property
    def homing(self) -> Homing:
        """A booster never references on its own."""
        return Homing.NONE

    def idle(self) -> SetValue:
        """Before the first SYNC: no demand."""
        return SetValue()

    def step(self, actual: Actual | None, demand: Demand) -> SetValue:
        """actual: of this SYNC, None when none came.  The set value for the next SYNC.

        Its position is the actual one until control is reported, then held, then the demanded one if it may be sent.
        """
        on, reset, wanted_inc, wanted_rpm, limit_switch, _ = demand
        if self.events:
            self.events = []
        if self._asked or self._reset_left or on is not self._on_before or reset is not self._reset_before:
            self._note_edges(demand)  # nothing to note otherwise
        if not isinstance(actual, ActualValue):
            self._miss()
        elif self.follows and on and actual.enabled and not actual.fault:  # nothing to judge, nothing to wait for
            self.missing, self.position_inc, self.torque_permille = 0, actual.position_inc, actual.torque_permille
            self.fault_code, self.warning = actual.fault_code, actual.warning
        else:
            self._judge(actual, demand)
        speed, self._life = 0, self._life + 1 & 0xFF
        if self.follows:
            step = self._settings.step_inc
            if not self._following and -step <= wanted_inc - self.set_inc <= step and INT32_MIN <= wanted_inc <= INT32_MAX:
                self.set_inc, self._refused = wanted_inc, False  # as _take, which is for what is left
            else:
                self._take(wanted_inc)
            if not self._refused:
                if -INT16_MAX <= wanted_rpm <= INT16_MAX:
                    speed = round(wanted_rpm)
                else:
                    speed, cut = saturated_rpm(wanted_rpm)
                    self.saturated += cut
        elif self._phase is not Phase.RELEASING:
            self._following = True
            self.set_inc = self.position_inc
        row = self._row
        enable = row.enable
        return _new(SetValue, (enable, row.drive_on, limit_switch, self._reset_left > 0, enable, self._life, self.set_inc, speed))

    def _note_edges(self, demand: Demand) -> None:
        rising = demand.on and not self._on_before
        self._on_before = demand.on
        self._asked = demand.on and (self._asked or rising) and self._phase not in (Phase.FAULT, Phase.LOST)
        if demand.reset and not self._reset_before and self._phase is Phase.FAULT:
            self._reset_left = RESET_CYCLES + 1
        self._reset_before = demand.reset
        self._reset_left = max(self._reset_left - 1, 0)

    def _miss(self) -> None:
        self.missing += 1
        if self.missing >= LOST_AFTER and self._phase is not Phase.LOST:
            self.epoch += 1
            self._asked = False
            self._go(Phase.LOST, Event.LOST)

    def _judge(self, actual: ActualValue, demand: Demand) -> None:
        """Fault and loss first, then demand, then the condition of the phase."""
        self.missing = 0
        self.position_inc, self.torque_permille = actual.position_inc, actual.torque_permille
        self.fault_code, self.warning = actual.fault_code, actual.warning
        if self._phase is Phase.LOST:
            self._go(Phase.OFF, Event.RETURNED)
        if actual.fault and self._phase is not Phase.FAULT:
            self._asked = False
            self._go(Phase.FAULT, Event.FAULT)
        elif self._phase is Phase.FAULT and not actual.fault:
            self._reset_left = 0
            self._go(Phase.OFF, Event.FAULT_CLEARED)
        elif self._phase is Phase.OFF and self._asked:
            self._asked = False
            self._go(Phase.POWERING)
        else:
            self._follow(actual, demand)

    def _follow(self, actual: ActualValue, demand: Demand) -> None:
        row = self._row
        self._cycles += 1
        if not demand.on and row.on_off is not None:
            self._go(row.on_off)
        elif self._phase in IN_CONTROL and not actual.enabled:
            self._go(Phase.DISABLING, Event.DROPPED)
        elif row.waits_for is not None and row.then is not None:
            name, value = row.waits_for
            if bool(getattr(actual, name)) is value or (name == "brake_open" and not self._settings.brake):
                self._go(row.then)
            elif self._cycles >= self._settings.timeout_cycles:
                self._go(row.on_off or row.then, Event.TIMEOUT)

    def _go(self, phase: Phase, event: Event | None = None) -> None:
        self._phase, self._cycles, self._refused = phase, 0, False
        self._row = ROWS[phase]
        self.power, self.follows = self._row.power, phase is Phase.ENABLED
        if event is not None:
            self.events.append(event)
        if phase in ON_REACHING:
            self.events.append(ON_REACHING[phase])

    def _take(self, inc: int) -> None:
        """The demanded set position, if it may be sent."""
        window = self._settings.jump_inc if self._following else self._settings.step_inc
        if -window <= inc - self.set_inc <= window and INT32_MIN <= inc <= INT32_MAX:
            self.set_inc, self._following, self._refused = inc, False, False
        else:
            self._refuse(Event.JUMP if fits_int32(inc) else Event.RANGE)

    def _refuse(self, why: Event) -> None:
        """The last position stays; reported once until a good one comes."""
        if not self._refused:
            self.events.append(why)
        self._refused = True
