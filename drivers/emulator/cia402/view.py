"""Read-only view of an emulated CiA 402 drive: its objects, positions, statusword, row of the record.

The active part is cia402_axis; nothing here changes anything.
"""

from math import inf, pi

from drivers.emulator.canopen.objects import Objects
from drivers.emulator.cia402 import objects as od
from drivers.emulator.cia402.brake import DriveBrake, DriveStop
from drivers.emulator.cia402.errors import Surroundings
from drivers.emulator.cia402.homing import Homing
from drivers.emulator.cia402.modes import Mode
from drivers.emulator.cia402.pll import SyncWatch
from drivers.emulator.cia402.position import SoftLimits, UserPosition
from drivers.emulator.cia402.probe import TouchProbe
from drivers.emulator.cia402.servo import DriveServo
from drivers.emulator.cia402.states import LIMIT, REMOTE, STATUS, TARGET, VOLTAGE, WARNING, State
from drivers.emulator.cia402.switches import Signal, Switches
from drivers.emulator.servo.model import INC_PER_RAD
from drivers.emulator.servo.record import AxisRow, Flag
from drivers.emulator.servo.settings import DriveSettings
from protocols.base.machine import Ns

I2T_WARNING = 0.8


def wrap(value: float) -> int:
    """As an INTEGER32."""
    return (int(value) + 0x80000000 & 0xFFFFFFFF) - 0x80000000


class DriveView:
    """The drive's parts and their visible values."""

    mode: Mode
    new_set: bool  # a controlword came since the last SYNC

    def __init__(self, settings: DriveSettings, cycle_ns: Ns, seed: int, objects: Objects, substeps: int) -> None:
        self.settings, self.objects = settings, objects
        self.servo = DriveServo(settings.servo, seed, substeps, settings.multiturn_turns)
        self.homing = Homing(lambda signal: self.switches.active(signal, self.servo.position_rad))
        self.switches = Switches(_windows(settings))
        self.probe = TouchProbe(objects)
        self.sync_watch = SyncWatch(cycle_ns)
        self.state = State.NOT_READY
        self.site = Surroundings()
        self.brake, self.stop = DriveBrake(), DriveStop()
        self.place = UserPosition(self.servo)
        self.soft_limits = SoftLimits()
        self._follow_since: int | None = None
        self._reported: tuple[int, ...] = ()
        self._readers()
        self._factory()

    # -- objects --------------------------------------------------------------------------------

    def _factory(self) -> None:
        """The data sheet's value for this particular motor."""
        s, factory = self.settings.servo, self.objects.factory
        rpm, top = s.speed_limit_rad_s * 30.0 / pi, s.speed_limit_rad_s * INC_PER_RAD
        factory |= {
            od.SERIAL: self.settings.serial,
            od.FOLLOWING_WINDOW: round(s.following_error_rad * INC_PER_RAD),
            od.MAX_TORQUE: min(round(s.torque_limit_nm / s.rated_torque_nm * 1000.0), 0xFFFF),
            od.RATED_TORQUE: round(s.rated_torque_nm * 1000.0),
            od.MAX_PROFILE_SPEED: round(top),
            od.MAX_MOTOR_RPM: round(rpm),
            od.QUICK_STOP_DECELERATION: round(s.quick_stop_rad_s2 * INC_PER_RAD),
            od.LIMIT_MIN: s.soft_limit_min_inc,
            od.LIMIT_MAX: s.soft_limit_max_inc,
            od.SYNC_TOLERANCE: round(self.settings.sync_tolerance_us or 0),
            od.SYNC_FAULTS: self.settings.sync_faults,
        }
        self.objects.values |= factory
        for key, value in od.WITHOUT_DATA_SHEET.items():
            if not isinstance(self.objects.values.get(key), int):
                self.objects.values[key] = value

    def _readers(self) -> None:
        objects = self.objects
        objects.readers |= {
            od.STATUSWORD: lambda: self.statusword,
            od.MODE_DISPLAY: lambda: self.mode.code,
            od.POSITION: lambda: wrap(self.place.counter + self.place.shift),
            od.POSITION_COUNTER: lambda: wrap(self.place.counter),
            od.POSITION_DEMAND: lambda: wrap(self.demand),
            od.FOLLOWING_ERROR: lambda: wrap(self.demand - self.place.counter - self.place.shift),
            od.SPEED: lambda: wrap(self.servo.measured_inc),
            od.SPEED_DEMAND: lambda: wrap(self.servo.speed_demand_rad_s * INC_PER_RAD),
            od.TORQUE: lambda: self._per_mille(self.servo.torque_nm),
            od.TORQUE_DEMAND: lambda: self._per_mille(self.servo.torque_demand_nm),
            od.DC_LINK: lambda: 0 if self.site.no_power else round(self.settings.dc_link_v * 1000.0),
            od.INPUTS: lambda: self.switches.inputs(self.servo.position_rad),
            od.WINDING_TEMPERATURE: lambda: round(self.servo.winding_c * 10.0),
            od.LOAD_LEVEL: lambda: min(round(self.servo.i2t * 1000.0), 0xFFFF),
            od.REFERENCED: lambda: int(self.place.homed),
            od.SYNC_ERROR: lambda: wrap(self.sync_watch.error // 1000),
            od.SYNC_WORST: lambda: self.sync_watch.worst // 1000,
            od.SYNC_LOCKED: lambda: int(self.sync_watch.locked),
            od.SYNC_OUTSIDE: lambda: self.sync_watch.outside,
        }

    def value(self, key: tuple[int, int]) -> int:
        number = self.objects.values[key]
        return number if isinstance(number, int) else 0

    def _per_mille(self, torque_nm: float) -> int:
        return min(max(round(torque_nm / self.settings.servo.rated_torque_nm * 1000.0), -32768), 32767)

    # -- identity --------------------------------------------------------------------------------

    @property
    def brake_open(self) -> bool:
        return self.brake.is_open

    @property
    def position(self) -> float:
        return float(self.place.counter + self.place.shift)

    @property
    def demand(self) -> float:
        """6062h; without position control where it is."""
        return (self.servo.demand_inc(self.place.rest_ns) + 1e-6) // 1.0 + self.place.shift if self.servo.mode == 1 else self.position

    @property
    def period_ns(self) -> int:
        return self.sync_watch.period

    @property
    def own_feed_forward(self) -> float:
        return self.settings.own_feed_forward

    @property
    def following_error_active(self) -> bool:
        return self._follow_since is not None

    @property
    def warning(self) -> bool:
        return self.servo.i2t > I2T_WARNING or self.servo.winding_c > self.settings.servo.winding_warning_c

    @property
    def statusword(self) -> int:
        state = self.state
        word = STATUS[state] | (0 if self.site.local else REMOTE)
        if not self.site.no_power and state is not State.NOT_READY:
            word |= VOLTAGE
        if self.warning:
            word |= WARNING
        if state is State.ENABLED:
            halted = self.mode.halted
            word |= self.mode.bits() & ~TARGET | TARGET * (not self.stop.active) if halted else self.mode.bits()
            word |= LIMIT * self._internal_limit
        elif state is State.QUICK_STOP and not self.stop.active:
            word |= TARGET
        return word

    @property
    def _internal_limit(self) -> bool:
        return self.soft_limits.active or bool(self.switches.inputs(self.servo.position_rad) & 3)

    def changed(self) -> bool:
        values = (
            self.statusword,
            self.mode.code,
            self.switches.inputs(self.servo.position_rad),
            self.value(od.ERROR_CODE),
            self.probe.status,
        )
        before, self._reported = self._reported, values
        return values != before

    def make_row(self, no_sync: bool = False) -> AxisRow:
        place, servo = self.place, self.servo
        position = wrap(place.counter + place.shift)
        demand = wrap(self.demand) if self.state is State.ENABLED else position
        flags = Flag.NO_SYNC * no_sync | Flag.NEW_SET * self.new_set | Flag.ENABLED * (self.state is State.ENABLED)
        flags |= Flag.BRAKE_OPEN * self.brake.is_open | Flag.POWER_ON * (self.state >= State.ON and self.state is not State.FAULT)
        inputs = self.switches.inputs(servo.position_rad)
        flags |= Flag.REFERENCE_SWITCH * (inputs >> Signal.HOME & 1) | Flag.LIMIT * bool(inputs & 3) | Flag.WARNING * self.warning
        shaft = servo.position_rad + servo.speed_rad_s * place.rest_ns * 1e-9
        fault = self.value(od.ERROR_CODE) >> 8 if self.state in (State.REACTION, State.FAULT) else 0
        return AxisRow(position, demand, shaft, servo.speed_rad_s, servo.torque_nm, self.state, fault, int(flags))


def _windows(settings: DriveSettings) -> list[tuple[Signal, float, float]]:
    s = settings.servo
    return [
        (Signal.NEGATIVE_LIMIT, -inf, s.hard_limit_min_rad),
        (Signal.POSITIVE_LIMIT, s.hard_limit_max_rad, inf),
        (Signal.HOME, s.reference_switch_from_rad, s.reference_switch_to_rad),
        (Signal.PROBE_1, settings.probe_1_from_rad, settings.probe_1_to_rad),
        (Signal.PROBE_2, settings.probe_2_from_rad, settings.probe_2_to_rad),
    ]
