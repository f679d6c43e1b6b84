"""The cell as plain frozen data: one dataclass per table of the cell file, one attribute per key.

Attribute = key, class = table; `from` is spelled `from_` because Python keeps the word. Values stand in the units of the
file (deg, mm, ms, %); inside units are made by `drivers.drives.scaling`. Source of the shapes: users.md 3.4, 3.5; design.md 5.
"""

import datetime
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from gateway.cell_controller import Controller
from gateway.cell_modbus import Modbus
from gateway.cell_northbound import Northbound
from gateway.cell_positions import Position
from gateway.cell_program import Program
from gateway.cell_retain import Retain
from gateway.cell_routes import Route
from gateway.cell_web import Web

ParamValue = bool | int | float | str | tuple["ParamValue", ...] | Mapping[str, "ParamValue"]


@dataclass(frozen=True, slots=True)
class CellHead:
    """[cell]: what this plant is and how it is played."""

    name: str
    replaces: str = ""
    software: str = ""  # version of the replaced software: decides numbers that changed between versions
    language: str = "en"  # de | en
    target: str = "simulation"  # machine | simulation
    on_services_loss: str = "stop_on_path"  # stop_on_path | finish_move


@dataclass(frozen=True, slots=True)
class Safety:
    """[safety]: what the plant guarantees in hardware; axisgate only prints it."""

    emergency_stop: str = ""
    sto_wired: bool | None = None
    guard: str = ""
    limit_switches: str = ""
    enabling_device: str = ""
    risk_assessment: str = ""
    last_stop_test: datetime.date | None = None


@dataclass(frozen=True, slots=True)
class RcInputs:
    """[rc_inputs]: RC input byte (PIC byte = N div 8) -> the door that owns it; enabling inputs taken as 1."""

    owner: Mapping[int, str] = field(default_factory=dict)
    assume: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class IoBus:
    """One entry of P30: digital I/O blocks of a bus; baud 0..3 = 1 Mbit/s, 500, 250, 125 kbit/s."""

    inputs: int = 0
    outputs: int = 0
    baud: int = 0


@dataclass(frozen=True, slots=True)
class IoBlock:
    """One entry of P31 or P32: PIC start byte, length in bytes, CAN identifier."""

    bus: int
    start: int
    length: int
    id: int


@dataclass(frozen=True, slots=True)
class MeasuringSystem:
    """One [[rho3.P401]] table."""

    axis: int
    module: int
    ref_mode: int = 0
    gear_factor: float = 1.0
    pulses: int = 1  # 1 = 16384, 2 = 8192, 3 = 4096 increments per turn (rho3 2.6)
    evaluation: float = 16384.0  # negative together with output: direction reversed (rho3 2.9)
    output: int = 0


@dataclass(frozen=True, slots=True)
class Rho3:
    """[rho3]: machine parameters as printed; the ones the gateway uses are attributes, other legal numbers are kept."""

    P2: int = 0
    P5: int | None = None  # clock, ms
    P9: int = 40  # strobe of coded outputs, ms
    P15: tuple[int, ...] = ()
    P20: int | None = None
    P21: tuple[int, ...] = ()
    P24: int | str = "all"
    P30: tuple[IoBus, ...] = ()
    P31: tuple[IoBlock, ...] = ()
    P32: tuple[IoBlock, ...] = ()
    P103: tuple[float, ...] = ()
    P104: tuple[float, ...] = ()
    P108: tuple[float, ...] = ()
    P109: tuple[float, ...] = ()
    P204: tuple[float, ...] = ()
    P205: tuple[float, ...] = ()
    P207: tuple[float, ...] = ()
    P208: tuple[float, ...] = ()
    P401: tuple[MeasuringSystem, ...] = ()
    P601: bool = False
    others: Mapping[str, ParamValue] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Rk512:
    """[line.rk512]: what is served and how addresses are counted."""

    db_address_unit: str = "word"  # word | byte
    reaction: bool = True
    types: tuple[str, ...] = ("D",)
    unknown_block: int = 0x14  # error number for a block that is not listed
    coordination_flag: str = "refuse"  # a job that names one: refuse | ignore | serve | keep (AX-251)
    end_of_follow_on: str = "ETX"  # ETX | ETB, as a switch of BUEP64 has it


@dataclass(frozen=True, slots=True)
class Times:
    """[line.times]: single values of the profile overridden, in ms and in either vocabulary; None: as the profile has it (AX-250)."""

    QVZ: int | None = None  # acknowledgement delay
    ADT: int | None = None  # the same
    ZVZ: int | None = None  # character delay
    CDT: int | None = None  # the same
    BWZ: int | None = None  # block wait time: for the repeat of a refused block
    reaction: int | None = None  # wait for the reaction telegram (VIPA's BWZ)
    pause: int | None = None  # before a repeat
    no_buffer: int | None = None  # STX while no buffer is free: NAK after
    connect_attempts: int | None = None  # the first one counts
    block_attempts: int | None = None

    @property
    def ack_delay(self) -> int | None:
        """QVZ, whichever way it is called."""
        return self.ADT if self.QVZ is None else self.QVZ

    @property
    def char_delay(self) -> int | None:
        """ZVZ, whichever way it is called."""
        return self.CDT if self.ZVZ is None else self.ZVZ


@dataclass(frozen=True, slots=True)
class Choices:
    """[line.choices]: what the manuals leave open, set otherwise than the profile has it; None: as the profile (AX-221, AX-250)."""

    connect_counter: str | None = None  # per_job | per_block | shared
    stray: str | None = None  # silent | nak_after_quiet | nak_at_once
    broken_pair: str | None = None  # nak_at_end | nak_at_once | drop_dle
    too_long: str | None = None  # nak_at_end | nak_at_once
    interruption: str | None = None  # ignore | back_off
    silence_ends: bool | None = None
    yields_to_second_conflict: bool | None = None
    nak_at_start: bool | None = None
    nak_when_giving_up: bool | None = None
    nesting: bool | None = None  # RK512: a command that comes while we wait for a reaction is served


@dataclass(frozen=True, slots=True)
class Supervision:
    """[line.supervision]: when the partner counts as silent and what the axes do then."""

    max_silence_ms: int = 1000  # 0 (telegrams only): a quiet partner is no loss; the loader's default there (AX-195)
    life_word: str | None = None  # e.g. DB10.DW31: counts up in every SEND of the PLC
    on_loss: str = "stop_on_path"  # hold | finish_move | stop_on_path | quick_stop
    restart: str = "new_command"


@dataclass(frozen=True, slots=True)
class Line:
    """[[line]]: a serial line to a PLC or host."""

    name: str
    port: str
    format: str = "9600 8E1"
    wiring: str = ""
    protocol: str = "3964R"
    profile: str = "rho3"
    priority: str = "low"
    layer: str = "rk512"  # rk512 | telegrams | buep64 | program
    role: str = "passive"  # passive | active | both
    output_timeout: int | None = None  # the rho 3's name for the priority: -1 = low, all else high (worked into priority)
    byte_order: str = "big"
    rk512: Rk512 = Rk512()
    times: Times = Times()
    choices: Choices = Choices()
    supervision: Supervision = Supervision()

    @property
    def baud(self) -> int:
        """Bits per second out of the frame format."""
        return int(self.format.split()[0])


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of a data block; exactly one of `to` (PLC writes) and `from_` (axisgate writes) is set."""

    at: str
    type: str  # bit KF DH KH KM KY KC KT KZ KG REAL BCD
    to: str | None = None
    from_: str | None = None
    unit: str = "1"  # "0.1 mm": one count is 0.1 mm
    min: float | None = None
    max: float | None = None
    edge: str | None = None  # rising: only the 0 -> 1 edge acts
    comment: str = ""

    @property
    def signal(self) -> str:
        """The signal this entry moves, whichever way."""
        return self.to or self.from_ or ""


@dataclass(frozen=True, slots=True)
class Db:
    """[[db]]: a data block of `words` STEP 5 words; `line` is filled in by the loader when the cell has one RK512 line.

    Other kinds than D are served as their type: X extended block; E A M words of bytes; T Z numbers.  With role active or both a block may
    be sent (writer axisgate) or fetched (writer plc) by us, every so often or when it changed (AX-250, AX-252).
    """

    number: int
    words: int
    writer: str  # plc | axisgate
    kind: str = "D"  # D X E A M T Z
    line: str = ""
    every_ms: int = 0  # our own SEND or FETCH; 0: the partner's business
    on_change: bool = False  # our own SEND when a word has changed
    at_partner: str = ""  # "DB20.DW0": where it lies there; "": same number, from its first word on
    flag: str = ""  # "M 6.4": coordination flag our job names
    comment: str = ""
    entries: tuple[Entry, ...] = ()


@dataclass(frozen=True, slots=True)
class Handshake:
    """[handshake.NAME]: the bits an old program starts a move with, as DBn.Dw.b."""

    pattern: str
    start: str = ""  # request or strobe; number-select needs none
    busy: str = ""
    done: str = ""  # acknowledgement of level-ack, toggle, strobe-parity
    refused: str = ""
    parity: str = "even"  # strobe-parity: ones of code and parity bit together


@dataclass(frozen=True, slots=True)
class IoDevice:
    """Inline table `device` of [[io]]."""

    type: str  # canopen-401 | modbus | gpiochip
    bus: str = ""  # canopen-401
    node: int | None = None
    input: int | None = None  # channel; of a gpiochip its line
    output: int | None = None
    url: str = ""  # modbus: tcp://host:502, or rtu:/dev/ttyUSB0
    unit: int = 1
    poll_ms: int = 50
    chip: str = ""  # gpiochip: /dev/gpiochip0, or its label
    active_low: bool = False


@dataclass(frozen=True, slots=True)
class Io:
    """[[io]]: a real contact at the gateway."""

    name: str
    device: IoDevice
    signal: str  # an output's `io.NAME` leaves it to a route
    on_loss: int | None = None
    toggle_ms: int = 20  # cell.watchdog: time between two toggles


@dataclass(frozen=True, slots=True)
class Bus:
    """[[bus]]: a CAN bus."""

    name: str
    port: str
    protocol: str  # servodyn | canopen | rho3-io
    bitrate: str = "1 Mbit/s"
    cycle_ms: int = 4
    heartbeat_ms: int = 50
    layout: str = "servodyn_gc.dbc"
    layout_evidence: str = ""
    axes: str = ""  # "1..6": module numbers on this bus
    on_loss: str = "zero"
    coupling_ms: int = 300  # rho3-io: a coupled control silent for so long is an error; 0: not supervised (rho3 2.5)

    @property
    def simulated(self) -> bool:
        """True where no metal can hang on the bus."""
        return self.port == "sim" or self.port.startswith(("broker:", "memory:", "socketcan:vcan"))


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
    following_error: FollowingError | None = None  # None: only the drive supervises the lag
    home: Home = Home()
    first_enable: FirstEnable = FirstEnable()
    mode: str = "csp"
    stop_on_bus_loss: str = "quick_stop"
    brake: str = "drive"  # drive | gateway | none


PLANNED_KINEMATICS = ("identity", "portal", "scara", "arm6", "urdf")


@dataclass(frozen=True, slots=True)
class Robot:
    """[robot]: kinematics, as robot files name them (PLANNED_KINEMATICS: those the planner runs programs for)."""

    kinematics: str
    model: str = ""
    name: str = ""
    zero: str = ""


@dataclass(frozen=True, slots=True)
class CheckPosition:
    """[[check_position]]: a known position, by axis names (`at`) or as joints."""

    name: str
    tolerance: float
    at: Mapping[str, float] = field(default_factory=dict)
    joints: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class TelegramMatch:
    """One entry of `match`: exactly one of hex and text stands at `byte`."""

    byte: int
    hex: str = ""
    text: str = ""


@dataclass(frozen=True, slots=True)
class TelegramField:
    """One entry of `fields`: `count` values of `type` from `byte` on, written to a named value."""

    byte: int
    type: str  # BINARY CHARACTER BYTE WORD KF INTEGER REAL POINT JC_POINT TEXT
    to: str
    count: int = 1
    unit: str = ""  # "mm", or "0.1 mm": one count is 0.1 mm
    scale: float = 1.0  # value = count x scale
    byte_order: str | None = None  # little | big; None: as the line
    min: float | None = None
    max: float | None = None


@dataclass(frozen=True, slots=True)
class TelegramPart:
    """One entry of `build`: fixed bytes (hex or text) or a value (type and from)."""

    hex: str = ""
    text: str = ""
    type: str = ""
    from_: str = ""
    count: int = 1
    unit: str = ""
    scale: float = 1.0
    byte_order: str | None = None
    min: float | None = None
    max: float | None = None


@dataclass(frozen=True, slots=True)
class Telegram:
    """[[telegram]]: a raw 3964R block; match, fields, then: the partner sends it; when, build: we do."""

    line: str
    name: str
    match: tuple[TelegramMatch, ...] = ()
    length: int | None = None  # bytes; None: any length that holds matches and fields
    fields: tuple[TelegramField, ...] = ()
    then: str = ""  # "signal order.new"
    when: str = ""  # "rising order.done"
    build: tuple[TelegramPart, ...] = ()


@dataclass(frozen=True, slots=True)
class Span:
    """`reference_switch = { from = .., to = .. }` in axis units: the switch is 1 between both."""

    from_: float
    to: float


@dataclass(frozen=True, slots=True)
class PlantAxis:
    """[plant.axis.NAME]: the emulated axis; places in axis units, all else as `drivers.emulator.settings` names it.

    `settings` holds the keys of ServoSettings the file gives (motor_inertia_kgm2, kv_per_s, ..): at the motor shaft, SI.
    """

    start: float = 0.0  # axis position at power-up, unit
    reference_switch: Span | None = None
    hard_limits: Span | None = None
    settings: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Plant:
    """[plant]: the emulated machine of `run --sim`, `emulate` and the demo."""

    seed: int = 1
    axis: Mapping[str, PlantAxis] = field(default_factory=dict)
    absent: tuple[str, ...] = ()  # buses whose I/O modules and couplers are not emulated: something else stands there


@dataclass(frozen=True, slots=True)
class Source:
    """Where a value comes from: a P number, a default, a line of the file."""

    text: str
    line: int | None = None


@dataclass(frozen=True, slots=True)
class Notice:
    """A warning or note of `check`; it stops nothing."""

    level: str  # warning | note
    where: str
    text: str


@dataclass(frozen=True, slots=True)
class Cell:
    """A whole, checked cell file."""

    file: str
    cell: CellHead
    format: int = 1
    safety: Safety | None = None
    rc_inputs: RcInputs = RcInputs()
    signals: Mapping[str, int] = field(default_factory=dict)  # [signals]: axisgate's own signals on other bit numbers (AX-002)
    rho3: Rho3 | None = None
    line: tuple[Line, ...] = ()
    db: tuple[Db, ...] = ()
    handshake: Mapping[str, Handshake] = field(default_factory=dict)
    position: tuple[Position, ...] = ()
    io: tuple[Io, ...] = ()
    bus: tuple[Bus, ...] = ()
    axis: tuple[Axis, ...] = ()
    modbus: tuple[Modbus, ...] = ()
    robot: Robot | None = None
    program: tuple[Program, ...] = ()
    check_position: tuple[CheckPosition, ...] = ()
    telegram: tuple[Telegram, ...] = ()
    retain: Retain | None = None
    plant: Plant | None = None
    web: Web | None = None
    northbound: Northbound | None = None
    route: tuple[Route, ...] = ()
    controller: Controller | None = None
    sources: Mapping[str, Source] = field(default_factory=dict)  # "axis.1.limits.speed" -> P103[1], line 34
    notices: tuple[Notice, ...] = ()

    @property
    def cycle_ms(self) -> int:
        """The clock of the cell: P5 where the P list says it, else the drive bus."""
        if self.rho3 is not None and self.rho3.P5 is not None:
            return self.rho3.P5
        return next((bus.cycle_ms for bus in self.bus if bus.protocol != "rho3-io"), 4)

    @property
    def warnings(self) -> tuple[Notice, ...]:
        return tuple(notice for notice in self.notices if notice.level == "warning")

    @property
    def notes(self) -> tuple[Notice, ...]:
        return tuple(notice for notice in self.notices if notice.level == "note")

    def not_playable(self) -> list[str]:
        """What this file asks for and `run` cannot play yet, each by its key; empty: all of it runs."""
        reasons = [f"{key} = {value}" for key, value, played in self._choices() if value not in played]
        reasons += [f"db.{db.number}[{entry.at}] = {entry.signal}" for db in self.db for entry in db.entries if not _served(entry.signal)]
        if self.robot is not None and self.program and self.robot.kinematics not in PLANNED_KINEMATICS:  # nothing else asks for them
            reasons.append(f"robot.kinematics = {self.robot.kinematics}")
        return reasons

    def _choices(self) -> Iterator[tuple[str, str | int, tuple[str | int, ...]]]:
        """(key, chosen value, values this version plays) wherever the file's shape allows more than runs."""
        for line in self.line:
            yield f"line.{line.name}.layer", line.layer, ("rk512", "buep64", "telegrams")
            yield (
                f"line.{line.name}.port",
                line.port.split(":")[0],
                ("sim", "pty", "tcp", "rfc2217", line.port if line.port.startswith("/") else "sim"),
            )
        for bus in self.bus:
            yield f"bus.{bus.name}.protocol", bus.protocol, ("servodyn", "canopen", "rho3-io")
        for axis in self.axis:
            yield f"axis.{axis.name}.drive.type", axis.drive.type, ("servodyn", "cia402")
            yield f"axis.{axis.name}.mode", axis.mode, ("csp",)
            contact = any(io.signal == f"axis.{axis.name}.brake" for io in self.io)
            yield f"axis.{axis.name}.brake", axis.brake, ("drive", "none", *(("gateway",) if contact else ()))
            by = ("gateway", "none") if axis.drive.type == "servodyn" else ("gateway", "drive", "none")  # a booster never references itself
            yield f"axis.{axis.name}.home.by", axis.home.by, by
            if axis.home.by == "gateway":
                yield f"axis.{axis.name}.home.mode", axis.home.mode, (0, 1, 2, 3)

    def axis_named(self, name: str) -> Axis:
        """The axis of that name; KeyError names those that exist."""
        for axis in self.axis:
            if axis.name == name:
                return axis
        raise KeyError(f"axis {name!r}; this cell has {', '.join(axis.name for axis in self.axis)}")


def _served(signal: str) -> bool:
    """Names a data block may hold that this version does not serve yet: one axis' own reference, the safety contact."""
    one_axis = signal.startswith("axis.") and signal.endswith(".reference") and signal != "axis.*.reference"
    return not (one_axis or signal == "cell.safety_ok")
