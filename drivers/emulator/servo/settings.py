"""Parameters of an emulated servo axis.  All values refer to the motor shaft, in SI units (rad, Nm, kg m2, s).

A gear, a spindle or an axis direction is the caller's arithmetic: reflect inertia, friction and gravity to the motor shaft first.
The defaults are a plausible 1.9 kW axis with a resolver of 16384 increments a turn (AX-084); none of them is measured on a machine.

As a plain dict (and so as JSON): {"cycle_ms": 4.0, "seed": 1, "axes": {"1": {field: value, ...}, "3": {}}}; a missing field has its
default, an unknown one is an error.  The keys of "axes" are the SERVODYN modules 1..6 on the bus; "nodes" are CiA 402 drives by their node
numbers 1..127, with the fields of ServoSettings and those of DriveSettings in one table: {"nodes": {"5": {"serial": 17}}}.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields
from math import inf, pi
from typing import TypeVar

INC_PER_TURN = 16384  # AX-084; P401 "pulses/rotation" 1 = 16384 (rho 3 Releases part 1, L7586)

S = TypeVar("S")


class SettingsError(ValueError):
    """Settings that cannot be; `faults` names every field with its value, range, unit and a hint."""

    def __init__(self, faults: list[str]) -> None:
        super().__init__("; ".join(faults))
        self.faults = tuple(faults)


@dataclass(frozen=True, slots=True)
class Range:
    unit: str
    low: float
    high: float
    hint: str


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """One axis: motor, load, loops, limits, switches, brake, thermal model, start position."""

    motor_inertia_kgm2: float = 0.0008
    load_inertia_kgm2: float = 0.0012  # reflected to the motor shaft, coupled rigidly
    coulomb_nm: float = 0.30  # sliding friction
    stiction_nm: float = 0.36  # torque that breaks the axis loose from standstill; never below coulomb_nm
    viscous_nms_per_rad: float = 0.0008
    gravity_nm: float = 0.0  # constant torque of a vertical linear axis; positive pulls towards negative positions
    gravity_arm_nm: float = 0.0  # amplitude of a rotary arm's gravity: gravity_arm_nm * sin(position / gravity_arm_gear + phase)
    gravity_arm_gear: float = 1.0  # motor turns for one turn of the arm
    gravity_arm_phase_rad: float = 0.0
    torque_noise_nm: float = 0.0  # amplitude of a disturbance torque, new every 1 ms, from the seed

    rated_torque_nm: float = 6.0  # continuous; 1000 in the actual value's torque
    torque_limit_nm: float = 18.0
    speed_limit_rad_s: float = 100.0 * pi  # 3000 rpm
    overspeed_rad_s: float = 120.0 * pi  # fault
    current_time_constant_s: float = 0.0005  # first-order current loop
    speed_gain_nms_per_rad: float | None = None  # None: total inertia * 2 pi 100 Hz
    speed_integral_s: float = 0.020
    kv_per_s: float = 80.0  # position loop gain: steady lag = speed / kv
    speed_feed_forward: float = 0.0  # share of the telegram's speed that is added to the position loop's
    following_error_rad: float = 2.0 * pi  # trip; also the largest jump of a set position
    quick_stop_rad_s2: float = 2000.0  # slope of the emergency-stop ramp (P608)
    stop_timeout_s: float = 2.0  # a ramp that has not ended by then: torque off, brake

    brake: bool = True
    brake_torque_nm: float = 15.0
    brake_open_s: float = 0.040  # from command to free shaft
    brake_close_s: float = 0.020  # from command to full torque
    brake_lock_speed_rad_s: float = 1.0  # slower is standstill: the brake may close (P609)
    brake_release: bool = False  # brake open request (set value bit 4) honoured without control; off: vertical axes would fall
    boot_s: float = 0.050  # power on to ready
    charge_s: float = 0.020  # drive on to power on

    start_rad: float = 0.0  # mechanical position at power-up
    resolver_offset_inc: int = 0  # resolver reading at mechanical position 0, 0..16383
    reference_switch_from_rad: float = -inf  # actuated between the two; from = to = -inf: never
    reference_switch_to_rad: float = -inf
    hard_limit_min_rad: float = -inf
    hard_limit_max_rad: float = inf
    soft_limit_min_inc: int = -(2**31)  # n_RMC_L, from the booster's own zero; act once ENABLE LIMIT SWITCH has found it
    soft_limit_max_inc: int = 2**31 - 1  # p_RMC_L

    i2t_time_constant_s: float = 20.0  # first-order model of (torque/rated)^2, trips at 1: t = -T ln(1 - 1/r^2)
    ambient_c: float = 25.0
    winding_rise_k: float = 80.0  # steady rise at rated torque
    winding_time_constant_s: float = 600.0
    winding_warning_c: float = 125.0
    winding_trip_c: float = 140.0

    def __post_init__(self) -> None:
        faults = _range_faults(self, RANGES) + _cross_faults(self)
        if faults:
            raise SettingsError(faults)

    @property
    def inertia_kgm2(self) -> float:
        return self.motor_inertia_kgm2 + self.load_inertia_kgm2

    @property
    def speed_gain(self) -> float:
        """Nm per rad/s of the speed loop; see speed_gain_nms_per_rad."""
        return self.inertia_kgm2 * 2.0 * pi * 100.0 if self.speed_gain_nms_per_rad is None else self.speed_gain_nms_per_rad


@dataclass(frozen=True, slots=True)
class DriveSettings:
    """Settings of a CiA 402 drive in addition to its servo: data sheet, SYNC tolerance, answer times, probe inputs, encoder turns."""

    servo: ServoSettings = field(default_factory=ServoSettings)
    eds: str = "axisgate_402.eds"
    serial: int = 1  # 1018h:04
    sync_tolerance_us: float | None = None  # phase error a SYNC may have; None: a quarter of its period (AX-287)
    sync_faults: int = 3  # SYNCs outside the tolerance in a row that raise 8700h; 0: never
    tpdo_delay_us: float = 0.0  # from SYNC to the TPDOs
    tpdo_spread_us: float = 0.0  # up to this much later, different every time, from the seed
    probe_1_from_rad: float = -inf  # probe input actuated between the two; from = to = -inf: never
    probe_1_to_rad: float = -inf
    probe_2_from_rad: float = -inf
    probe_2_to_rad: float = -inf
    multiturn_turns: int = 0  # encoder turns kept without power; 0: one turn only, as a resolver
    dc_link_v: float = 560.0
    own_feed_forward: float = 0.0  # CSP: share of the set positions' own speed that goes where 60B1h goes (then speed_feed_forward acts)

    def __post_init__(self) -> None:
        faults = _range_faults(self, DRIVE_RANGES)
        if faults:
            raise SettingsError(faults)


@dataclass(frozen=True, slots=True)
class BusSettings:
    """The drives of one bus: SERVODYN modules, CiA 402 nodes, or both."""

    cycle_ms: float = 4.0  # P5: nominal SYNC period; supervision is 2 x P5 (AX-001, AX-081)
    seed: int = 1
    axes: Mapping[int, ServoSettings] = field(default_factory=lambda: {module: ServoSettings() for module in range(1, 7)})
    nodes: Mapping[int, DriveSettings] = field(default_factory=dict)

    def __post_init__(self) -> None:
        faults = _bound("cycle_ms", self.cycle_ms, Range("ms", 1.0, 32.0, "P5 of a CAN bus is 2..32 ms"))
        faults += _bound("seed", self.seed, Range("", 0, 2**31 - 1, "a whole number"))
        faults += [f"axes: module {module} is outside 1..6" for module in self.axes if not 1 <= module <= 6]
        faults += [f"nodes: node {node} is outside 1..127" for node in self.nodes if not 1 <= node <= 127]
        if not self.axes and not self.nodes:
            faults.append("axes: empty; name at least one module 1..6")
        if faults:
            raise SettingsError(faults)


F = TypeVar("F", ServoSettings, DriveSettings)

RANGES: Mapping[str, Range] = {
    "motor_inertia_kgm2": Range("kg m2", 1e-6, 10.0, "data sheet of the motor, rotor inertia"),
    "load_inertia_kgm2": Range("kg m2", 0.0, 100.0, "at the motor shaft: load / gear^2"),
    "coulomb_nm": Range("Nm", 0.0, 1000.0, "at the motor shaft"),
    "stiction_nm": Range("Nm", 0.0, 1000.0, "at the motor shaft, not below coulomb_nm"),
    "viscous_nms_per_rad": Range("Nm s/rad", 0.0, 10.0, "at the motor shaft"),
    "gravity_nm": Range("Nm", -1000.0, 1000.0, "at the motor shaft"),
    "gravity_arm_nm": Range("Nm", -1000.0, 1000.0, "at the motor shaft"),
    "gravity_arm_gear": Range("", 1e-3, 1e5, "motor turns per turn of the arm"),
    "gravity_arm_phase_rad": Range("rad", -10.0, 10.0, ""),
    "torque_noise_nm": Range("Nm", 0.0, 100.0, ""),
    "rated_torque_nm": Range("Nm", 1e-3, 1000.0, "data sheet of the motor, continuous torque"),
    "torque_limit_nm": Range("Nm", 1e-3, 5000.0, "peak torque"),
    "speed_limit_rad_s": Range("rad/s", 0.1, 5000.0, "rpm * 2 pi / 60"),
    "overspeed_rad_s": Range("rad/s", 0.1, 10000.0, "above speed_limit_rad_s"),
    "current_time_constant_s": Range("s", 1e-5, 0.1, ""),
    "speed_gain_nms_per_rad": Range("Nm s/rad", 1e-6, 1000.0, "leave out: inertia * 2 pi 100 Hz"),
    "speed_integral_s": Range("s", 1e-4, 100.0, ""),
    "kv_per_s": Range("1/s", 0.1, 500.0, "well below the speed loop's 2 pi 100 Hz"),
    "speed_feed_forward": Range("", 0.0, 1.0, "0: lag = speed / kv; 1: no lag"),
    "following_error_rad": Range("rad", 1e-3, 1e4, "at the motor shaft; above speed / kv"),
    "quick_stop_rad_s2": Range("rad/s2", 1.0, 1e6, ""),
    "stop_timeout_s": Range("s", 0.01, 60.0, ""),
    "brake_torque_nm": Range("Nm", 0.0, 5000.0, "data sheet of the brake"),
    "brake_open_s": Range("s", 0.0, 2.0, ""),
    "brake_close_s": Range("s", 0.0, 2.0, ""),
    "brake_lock_speed_rad_s": Range("rad/s", 1e-3, 100.0, ""),
    "boot_s": Range("s", 0.0, 60.0, ""),
    "charge_s": Range("s", 0.0, 60.0, ""),
    "start_rad": Range("rad", -6e5, 6e5, ""),
    "resolver_offset_inc": Range("inc", 0, INC_PER_TURN - 1, "within one turn"),
    "reference_switch_from_rad": Range("rad", -inf, inf, "at the motor shaft"),
    "reference_switch_to_rad": Range("rad", -inf, inf, "at the motor shaft"),
    "hard_limit_min_rad": Range("rad", -inf, inf, "at the motor shaft"),
    "hard_limit_max_rad": Range("rad", -inf, inf, "at the motor shaft"),
    "soft_limit_min_inc": Range("inc", -(2**31), 2**31 - 1, "n_RMC_L"),
    "soft_limit_max_inc": Range("inc", -(2**31), 2**31 - 1, "p_RMC_L"),
    "i2t_time_constant_s": Range("s", 0.01, 1e5, ""),
    "ambient_c": Range("deg C", -40.0, 100.0, ""),
    "winding_rise_k": Range("K", 0.1, 300.0, ""),
    "winding_time_constant_s": Range("s", 0.01, 1e5, ""),
    "winding_warning_c": Range("deg C", 0.0, 300.0, ""),
    "winding_trip_c": Range("deg C", 0.0, 300.0, ""),
}

DRIVE_RANGES: Mapping[str, Range] = {
    "serial": Range("", 0, 2**32 - 1, "1018h:04"),
    "sync_tolerance_us": Range("us", 1.0, 1e6, "leave out: a quarter of the SYNC period"),
    "own_feed_forward": Range("", 0.0, 1.0, "1: the drive feeds the speed of the set positions forward"),
    "sync_faults": Range("", 0, 255, "0: never a fault"),
    "tpdo_delay_us": Range("us", 0.0, 1e6, "from SYNC to the TPDOs"),
    "tpdo_spread_us": Range("us", 0.0, 1e6, ""),
    "probe_1_from_rad": Range("rad", -inf, inf, "at the motor shaft"),
    "probe_1_to_rad": Range("rad", -inf, inf, "at the motor shaft"),
    "probe_2_from_rad": Range("rad", -inf, inf, "at the motor shaft"),
    "probe_2_to_rad": Range("rad", -inf, inf, "at the motor shaft"),
    "multiturn_turns": Range("", 0, 65536, "4096 for a 12-bit multi-turn encoder"),
    "dc_link_v": Range("V", 10.0, 2000.0, ""),
}


def to_dict(settings: BusSettings) -> dict[str, object]:
    """Plain dict for JSON; infinite limits become None."""
    axes: dict[str, dict[str, object]] = {}
    for module, axis in sorted(settings.axes.items()):
        values: dict[str, object] = asdict(axis)
        axes[str(module)] = {name: None if value in (inf, -inf) else value for name, value in values.items()}
    whole: dict[str, object] = {"cycle_ms": settings.cycle_ms, "seed": settings.seed, "axes": axes}
    if settings.nodes:
        whole["nodes"] = {str(node): _drive_dict(drive) for node, drive in sorted(settings.nodes.items())}
    return whole


def _drive_dict(drive: DriveSettings) -> dict[str, object]:
    """One table of both classes' fields."""
    values: dict[str, object] = asdict(drive)
    values.pop("servo")
    values |= asdict(drive.servo)
    return {name: None if value in (inf, -inf) else value for name, value in values.items()}


def from_dict(data: Mapping[str, object]) -> BusSettings:
    """The settings a plain dict names.  Raises SettingsError with every fault found, not only the first."""
    known = ("cycle_ms", "seed", "axes", "nodes")
    faults = [f"{name}: unknown; known are {', '.join(known)}" for name in data if name not in known]
    cycle, seed = data.get("cycle_ms", 4.0), data.get("seed", 1)
    axes: dict[int, ServoSettings] = _each(data.get("axes", {}), "axes", "the module is a number 1..6", axis_from_dict, faults)
    nodes: dict[int, DriveSettings] = _each(data.get("nodes", {}), "nodes", "the node is a number 1..127", drive_from_dict, faults)
    if not isinstance(cycle, int | float) or isinstance(cycle, bool):
        faults.append(f"cycle_ms: {cycle!r} is not a number; range 1..32 ms")
    if not isinstance(seed, int) or isinstance(seed, bool):
        faults.append(f"seed: {seed!r} is not a whole number")
    if faults or not isinstance(cycle, int | float) or not isinstance(seed, int):
        raise SettingsError(faults)
    return BusSettings(float(cycle), seed, axes, nodes)


def _each(raw: object, table: str, hint: str, read: Callable[[object], S], faults: list[str]) -> dict[int, S]:
    """The numbered entries of a table; faults are added to `faults`."""
    found: dict[int, S] = {}
    if not isinstance(raw, Mapping):
        faults.append(f"{table}: expected a table of numbers")
        return found
    for name, values in raw.items():
        try:
            found[int(str(name))] = read(values)
        except SettingsError as error:
            faults += [f"{table}.{name}.{fault}" for fault in error.faults]
        except ValueError:
            faults.append(f"{table}.{name}: {hint}")
    return found


def axis_from_dict(raw: object) -> ServoSettings:
    """One axis; None for a limit or switch means "not there"."""
    if not isinstance(raw, Mapping):
        raise SettingsError(["expected a table of settings"])
    known = {item.name: item.default for item in fields(ServoSettings)}
    return _filled(ServoSettings(), _checked(raw, known))


def drive_from_dict(raw: object) -> DriveSettings:
    """One CiA 402 drive: the fields of its servo and its own in one table."""
    if not isinstance(raw, Mapping):
        raise SettingsError(["expected a table of settings"])
    own = {item.name: item.default for item in fields(DriveSettings) if item.name != "servo"}
    faults: list[str] = []
    servo, values = ServoSettings(), dict[str, object]()
    try:
        servo = axis_from_dict({name: value for name, value in raw.items() if name not in own})
    except SettingsError as error:
        faults += error.faults
    try:
        values = _checked({name: value for name, value in raw.items() if name in own}, own)
    except SettingsError as error:
        faults += error.faults
    if faults:
        raise SettingsError(faults)
    return _filled(DriveSettings(servo), values)


def _checked(raw: Mapping[object, object], known: Mapping[str, object]) -> dict[str, object]:
    """Names and kinds by the defaults; raises SettingsError."""
    faults = [f"{name}: unknown setting" for name in raw if name not in known]
    values: dict[str, object] = {}
    for key, value in raw.items():
        name = str(key)
        if name not in known or value is None:
            continue
        default = known[name]
        if isinstance(default, str):
            wrong = not isinstance(value, str)
        else:
            wrong = not isinstance(value, int | float) or isinstance(value, bool) is not isinstance(default, bool)
        if wrong:
            kind = "true or false" if isinstance(default, bool) else "a text" if isinstance(default, str) else "a number"
            faults.append(f"{name}: {value!r} has the wrong type; expected {kind}")
        elif not isinstance(value, int | str) and (name.endswith("_inc") or (isinstance(default, int) and not isinstance(default, bool))):
            faults.append(f"{name}: {value!r} is not a whole number{' of increments' if name.endswith('_inc') else ''}")
        else:
            values[name] = value
    if faults:
        raise SettingsError(faults)
    return values


def _filled(settings: F, values: Mapping[str, object]) -> F:
    for name, value in values.items():
        object.__setattr__(settings, name, value)  # frozen for its users; names and kinds were checked one by one above
    settings.__post_init__()
    return settings


def _range_faults(settings: ServoSettings | DriveSettings, ranges: Mapping[str, Range]) -> list[str]:
    faults: list[str] = []
    for name, allowed in ranges.items():
        value = getattr(settings, name)
        if value is not None:
            faults += _bound(name, value, allowed)
    return faults


def _bound(name: str, value: float, allowed: Range) -> list[str]:
    if allowed.low <= value <= allowed.high:  # NaN is in no range
        return []
    unit, hint = f" {allowed.unit}" if allowed.unit else "", f" ({allowed.hint})" if allowed.hint else ""
    return [f"{name}: {value}{unit} is outside {allowed.low:g}..{allowed.high:g}{unit}{hint}"]


def _cross_faults(settings: ServoSettings) -> list[str]:
    rules = (
        (settings.stiction_nm >= settings.coulomb_nm, "stiction_nm: is below coulomb_nm; an axis at rest is never easier to move (Nm)"),
        (settings.torque_limit_nm >= settings.rated_torque_nm, "torque_limit_nm: is below rated_torque_nm (Nm)"),
        (settings.overspeed_rad_s > settings.speed_limit_rad_s, "overspeed_rad_s: has to be above speed_limit_rad_s (rad/s)"),
        (settings.hard_limit_min_rad < settings.hard_limit_max_rad, "hard_limit_min_rad: must be below hard_limit_max_rad (rad)"),
        (settings.soft_limit_min_inc < settings.soft_limit_max_inc, "soft_limit_min_inc: must be below soft_limit_max_inc (inc)"),
        (
            settings.reference_switch_from_rad <= settings.reference_switch_to_rad,
            "reference_switch_from_rad: must be below reference_switch_to_rad (rad)",
        ),
        (settings.winding_warning_c <= settings.winding_trip_c, "winding_warning_c: is above winding_trip_c (deg C)"),
    )
    return [message for holds, message in rules if not holds]
