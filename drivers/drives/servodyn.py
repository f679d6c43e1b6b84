"""Gateway's side of a SERVODYN-GC drive: the set value of each cycle for switching on, following and switching off in order.

Source: AX-001 (telegrams), AX-105..110 (order of the bits, refusals, losses).  Once per SYNC, after the actual values of that SYNC:
Drive.step.  It never raises on a message of the drive.
"""

from dataclasses import dataclass
from enum import Enum, auto

from drivers.drives.demand_edges import DemandEdges
from drivers.drives.family import Actual, Demand, Event, Homing, Power
from drivers.drives.held import HeldPosition
from drivers.drives.limits import INT16_MAX, INT32_MAX, INT32_MIN, saturated_rpm
from protocols.servodyn.codec import ActualValue, SetValue

__all__ = ["LOST_AFTER", "Demand", "Drive", "DriveSettings", "Event", "Phase", "Power"]

LOST_AFTER = 2  # actual values missing in a row
_new = tuple.__new__  # of a record without counting its fields again: once an axis and cycle


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
        "_cycles", "_edges", "_held", "_life", "_phase", "_row", "_settings", "epoch", "events", "fault_code", "follows", "missing",
        "position_inc", "torque_permille", "warning",
    )  # fmt: skip
    configured = True  # a booster keeps its parameters

    def __init__(self, settings: DriveSettings | None = None) -> None:
        self._settings = settings or DriveSettings()
        self._phase = Phase.OFF
        self._row = ROWS[Phase.OFF]  # of the present phase
        self.follows = False  # takes the demanded position; kept: it is read many times a cycle
        self._cycles = 0  # in the present phase
        self._edges = DemandEdges()
        self._held = HeldPosition(self._settings.jump_inc, self._settings.step_inc)
        self._life = 0
        self.position_inc = 0  # last actual
        self.torque_permille = 0
        self.fault_code = 0
        self.warning = False
        self.missing = 0  # actual values missing in a row
        self.epoch = 0  # +1 whenever increments may have lost their meaning: references of another epoch are void (AX-110)
        self.events: list[Event] = []  # of the last step

    @property
    def phase(self) -> Phase:
        """Exactly."""
        return self._phase

    @property
    def power(self) -> Power:
        """Seen from outside."""
        return self._row.power

    @property
    def set_inc(self) -> int:
        """Last position sent."""
        return self._held.inc

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
        edges, held = self._edges, self._held
        if self.events:
            self.events = []
        if edges.asked or edges.reset_left or on is not edges.on_before or reset is not edges.reset_before:  # nothing to note otherwise
            edges.note(demand, fault=self._phase is Phase.FAULT, lost=self._phase is Phase.LOST)
        if not isinstance(actual, ActualValue):
            self._miss()
        elif self.follows and on and actual.enabled and not actual.fault:  # nothing to judge, nothing to wait for
            self.missing, self.position_inc, self.torque_permille = 0, actual.position_inc, actual.torque_permille
            self.fault_code, self.warning = actual.fault_code, actual.warning
        else:
            self._judge(actual, demand)
        row, speed, self._life = self._row, 0, self._life + 1 & 0xFF
        if self.follows:
            if not held.fresh and -held.step <= wanted_inc - held.inc <= held.step and INT32_MIN <= wanted_inc <= INT32_MAX:
                held.inc, held.refused = wanted_inc, False  # as `take`, which is for what is left
            elif (refused := held.take(wanted_inc)) is not None:
                self.events.append(refused)
            if not held.refused:
                speed = round(wanted_rpm) if -INT16_MAX <= wanted_rpm <= INT16_MAX else saturated_rpm(wanted_rpm)
        elif self._phase is not Phase.RELEASING:
            held.follow(self.position_inc)
        enable = row.enable
        return _new(SetValue, (enable, row.drive_on, limit_switch, edges.reset_left > 0, enable, self._life, held.inc, speed))

    def _miss(self) -> None:
        self.missing += 1
        if self.missing >= LOST_AFTER and self._phase is not Phase.LOST:
            self.epoch += 1
            self._edges.asked = False
            self._go(Phase.LOST, Event.LOST)

    def _judge(self, actual: ActualValue, demand: Demand) -> None:
        """Fault and loss first, then demand, then the condition of the phase."""
        self.missing = 0
        self.position_inc, self.torque_permille = actual.position_inc, actual.torque_permille
        self.fault_code, self.warning = actual.fault_code, actual.warning
        edges = self._edges
        if self._phase is Phase.LOST:
            self._go(Phase.OFF, Event.RETURNED)
        if actual.fault and self._phase is not Phase.FAULT:
            edges.asked = False
            self._go(Phase.FAULT, Event.FAULT)
        elif self._phase is Phase.FAULT and not actual.fault:
            edges.reset_left = 0
            self._go(Phase.OFF, Event.FAULT_CLEARED)
        elif self._phase is Phase.OFF and edges.asked:
            edges.asked = False
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
        self._phase, self._row, self._cycles = phase, ROWS[phase], 0
        self.follows, self._held.refused = phase is Phase.ENABLED, False
        if event is not None:
            self.events.append(event)
        if phase in ON_REACHING:
            self.events.append(ON_REACHING[phase])
