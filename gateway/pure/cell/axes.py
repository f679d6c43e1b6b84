"""[[axis]] of a cell and [plant]: an axis, its drive and mechanics, and the emulated machine it moves.  Shapes: users.md 3.4."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from gateway.pure.cell.belts import PlantBelt


@dataclass(frozen=True, slots=True)
class Drive:
    """Inline table `drive` of [[axis]]."""

    type: str  # servodyn | cia402
    bus: str
    module: int | None = None  # servodyn: 1..6 on its bus
    node: int | None = None  # cia402: 1..127
    eds: str = ""
    serial: str = ""
    inc_per_turn: int = 16384


@dataclass(frozen=True, slots=True)
class Mechanics:
    """Inline table `mechanics` of [[axis]]: axis way in `unit` per turn of the output side of the gear."""

    feed_per_turn: float = 360.0
    gear: str = "1:1"  # motor turns : output turns
    direction: str = "+"
    vertical: bool = False

    @property
    def ratio(self) -> float:
        """Motor turns per output turn."""
        motor, output = self.gear.split(":")
        return float(motor) / float(output)


@dataclass(frozen=True, slots=True)
class AxisLimits:
    """Inline table `limits` of [[axis]], in unit, unit/s, unit/s^2, unit/s^3."""

    min: float
    max: float
    speed: float
    accel: float
    jerk: float  # default of the loader: 10 x accel per second (AX-123)


@dataclass(frozen=True, slots=True)
class FollowingError:
    """Inline table `following_error` of [[axis]], in unit."""

    warn: float
    trip: float
    standstill: float | None = None  # so far a standing axis may be off; None: as far as a moving one


@dataclass(frozen=True, slots=True)
class Home:
    """Inline table `home` of [[axis]]."""

    by: str = "gateway"  # gateway | drive | none
    mode: int = 0  # gateway: rho3 2.8, 0..3
    method: int | None = None  # drive: CiA 402 homing method
    speed: float = 0.0  # P108, unit/s
    slow_speed: float = 0.0  # P109, unit/s; 0: a fifth of speed
    direction: str = "-"  # side on which the switch is searched
    position: float = 0.0  # P207: actual value at the reference point, unit
    offset: float = 0.0  # P208: way moved after it, unit
    timeout_s: float = 60.0


@dataclass(frozen=True, slots=True)
class FirstEnable:
    """Inline table `first_enable` of [[axis]]."""

    torque: str = "20 %"
    speed: str = "5 %"
    travel: float = 2.0  # unit


@dataclass(frozen=True, slots=True)
class Axis:
    """[[axis]]: one axis; [defaults.axis] and [rho3] are already worked in."""

    name: str
    unit: str  # mm | deg
    drive: Drive
    limits: AxisLimits
    mechanics: Mechanics = Mechanics()
    manual: bool = False  # P303 = 1, 4: it does not make the speed of a path without transformation
    modulo: float = 0.0  # P311 of an endless axis (P303 = 3), unit; 0: an axis with ends
    following_error: FollowingError | None = None  # None: only the drive supervises the lag
    home: Home = Home()
    first_enable: FirstEnable = FirstEnable()
    mode: str = "csp"
    stop_on_bus_loss: str = "quick_stop"
    stop_evidence: str = ""  # of a drive without 6007h: report of the loss test, or "untested" in the cell that makes it
    brake: str = "drive"  # drive | gateway | none


@dataclass(frozen=True, slots=True)
class Span:
    """`reference_switch = { from = .., to = .. }` in axis units: the switch is 1 between both."""

    from_: float
    to: float


@dataclass(frozen=True, slots=True)
class PlantAxis:
    """[plant.axis.NAME]: the emulated axis; places in axis units, all else as `drivers.emulator.servo.settings` names it.

    `settings` holds the keys of ServoSettings the file gives (motor_inertia_kgm2, kv_per_s, ..): at the motor shaft, SI.
    """

    start: float = 0.0  # axis position at power-up, unit
    reference_switch: Span | None = None
    hard_limits: Span | None = None
    probe: Span | None = None  # touch probe inputs of a CiA 402 drive are actuated between these places
    settings: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Plant:
    """[plant]: the emulated machine of `run --sim`, `emulate` and the demo."""

    seed: int = 1
    axis: Mapping[str, PlantAxis] = field(default_factory=dict)
    belt: Mapping[str, PlantBelt] = field(default_factory=dict)
    absent: tuple[str, ...] = ()  # buses whose I/O modules and couplers are not emulated: something else stands there
