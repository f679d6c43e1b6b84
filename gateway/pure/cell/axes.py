"""[[axis]] of a cell and [plant]: an axis, its drive and mechanics, and the emulated machine it moves.  Shapes: users.md 3.4."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le

from gateway.pure.cell.belts import PlantBelt
from gateway.pure.cell.marks import Loaded, Name, Pattern, Percent, Registered, Unit


@dataclass(frozen=True, slots=True)
class Drive:
    """Inline table `drive` of [[axis]]."""

    type: Annotated[str, Registered("drive families")]
    bus: str
    module: Annotated[int | None, Ge(1), Le(6)] = None  # servodyn: 1..6 on its bus
    node: Annotated[int | None, Ge(1), Le(127)] = None  # cia402: 1..127
    eds: str = ""
    serial: str = ""
    inc_per_turn: Annotated[int, Ge(64), Le(1 << 24), Unit("inc")] = 16384
    rated_torque: Annotated[float | None, Gt(0), Le(10_000), Unit("Nm")] = None  # of the motor (6076h); None: forces of the joint are 0


@dataclass(frozen=True, slots=True)
class Mechanics:
    """Inline table `mechanics` of [[axis]]: axis way in `unit` per turn of the output side of the gear."""

    feed_per_turn: Annotated[float, Gt(0), Unit("{u}")] = 360.0
    # motor turns : output turns
    gear: Annotated[str, Pattern(r"^[1-9]\d*(\.\d+)?:[1-9]\d*(\.\d+)?$", '"10:1", motor : output turns')] = "1:1"
    direction: Literal["+", "-"] = "+"
    vertical: bool = False

    @property
    def ratio(self) -> float:
        """Motor turns per output turn."""
        motor, output = self.gear.split(":")
        return float(motor) / float(output)


@dataclass(frozen=True, slots=True)
class AxisLimits:
    """Inline table `limits` of [[axis]], in unit, unit/s, unit/s^2, unit/s^3."""

    min: Annotated[float, Unit("{u}")]
    max: Annotated[float, Unit("{u}")]
    speed: Annotated[float, Gt(0), Unit("{u}/s")]
    accel: Annotated[float, Gt(0), Unit("{u}/s^2")]
    jerk: Annotated[float, Gt(0), Unit("{u}/s^3")]  # default of the loader: 10 x accel per second (AX-123)


@dataclass(frozen=True, slots=True)
class FollowingError:
    """Inline table `following_error` of [[axis]], in unit."""

    warn: Annotated[float, Gt(0), Unit("{u}")]
    trip: Annotated[float, Gt(0), Unit("{u}")]
    standstill: Annotated[float | None, Gt(0), Unit("{u}")] = None  # so far an axis at rest may be off; None: as far as a moving one


@dataclass(frozen=True, slots=True)
class Home:
    """Inline table `home` of [[axis]]."""

    by: Literal["gateway", "drive", "none"] = "gateway"
    mode: Annotated[int, Ge(0), Le(3)] = 0  # gateway: rho3 2.8, 0..3
    method: Annotated[int | None, Ge(-128), Le(37)] = None  # drive: CiA 402 homing method
    speed: Annotated[float, Ge(0), Unit("{u}/s")] = 0.0  # P108, unit/s
    slow_speed: Annotated[float, Ge(0), Unit("{u}/s")] = 0.0  # P109, unit/s; 0: a fifth of speed
    direction: Literal["+", "-"] = "-"  # side on which the switch is searched
    position: Annotated[float, Unit("{u}")] = 0.0  # P207: actual value at the reference point, unit
    offset: Annotated[float, Unit("{u}")] = 0.0  # P208: way moved after it, unit
    timeout_s: Annotated[float, Gt(0), Le(3600), Unit("s")] = 60.0


@dataclass(frozen=True, slots=True)
class FirstEnable:
    """Inline table `first_enable` of [[axis]]."""

    torque: Percent = "20 %"
    speed: Percent = "5 %"
    travel: Annotated[float, Gt(0), Unit("{u}")] = 2.0  # unit


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisDefaults:
    """[defaults.axis]: values for every axis that does not set them."""

    following_error: FollowingError | None = None  # None: only the drive supervises the lag
    home: Home = Home()
    first_enable: FirstEnable = FirstEnable()
    mode: Literal["csp", "csv", "pp"] = "csp"
    stop_on_bus_loss: Literal["quick_stop", "coast"] = "quick_stop"
    stop_evidence: str = ""  # of a drive without 6007h: report of the loss test, or "untested" in the cell that makes it
    brake: Literal["drive", "gateway", "none"] = "drive"


@dataclass(frozen=True, slots=True)
class Defaults:
    """[defaults]: common values of tables."""

    axis: AxisDefaults = AxisDefaults()


@dataclass(frozen=True, slots=True)
class Axis(AxisDefaults):
    """[[axis]]: one axis; [defaults.axis] and [rho3] are already worked in."""

    name: Name
    unit: Literal["mm", "deg"]
    drive: Drive
    limits: AxisLimits
    mechanics: Mechanics = Mechanics()
    manual: bool = False  # P303 = 1, 4: it does not make the speed of a path without transformation
    modulo: Annotated[float, Ge(0), Unit("{u}")] = 0.0  # P311 of an endless axis (P303 = 3), unit; 0: an axis with ends


@dataclass(frozen=True, slots=True)
class Span:
    """`reference_switch = { from = .., to = .. }` in axis units: the switch is 1 between both."""

    from_: Annotated[float, Unit("{u}")]
    to: Annotated[float, Unit("{u}")]


def plant_settings(given: object) -> object:
    """Numbers as float, yes and no as they are; the loader has judged them."""
    values = given if isinstance(given, Mapping) else {}
    return {key: value if isinstance(value, bool) else float(value) for key, value in values.items()}


@dataclass(frozen=True, slots=True)
class PlantAxis:
    """[plant.axis.NAME]: the emulated axis; places in axis units, all else as `drivers.emulator.servo.settings` names it.

    `settings` holds the keys of ServoSettings set in the file (motor_inertia_kgm2, kv_per_s, ..): at the motor shaft, SI.
    """

    start: Annotated[float, Unit("{u}")] = 0.0  # axis position at power-up, unit
    reference_switch: Span | None = None
    hard_limits: Span | None = None
    probe: Span | None = None  # touch probe inputs of a CiA 402 drive are actuated between these places
    settings: Annotated[Mapping[str, float], Loaded(plant_settings)] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Plant:
    """[plant]: the emulated machine of `run --sim`, `emulate` and the demo."""

    seed: Annotated[int, Ge(0)] = 1
    axis: Mapping[str, PlantAxis] = field(default_factory=dict)
    belt: Mapping[str, PlantBelt] = field(default_factory=dict)
    absent: tuple[str, ...] = ()  # buses whose I/O modules and couplers are not emulated: something else is there
