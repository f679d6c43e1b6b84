"""The edge of the cell file: pydantic models with ranges and units; `gateway.config` turns them into `gateway.cell` data.

Strict, frozen, unknown keys forbidden. Field names are the keys of the file (`from` by alias); a test compares both sides.
"""

import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from gateway.cellmodels_controller import Controller
from gateway.cellmodels_modbus import Modbus
from gateway.cellmodels_northbound import Northbound

BAUDS = "300|600|1200|2400|4800|9600|19200|38400|57600|115200"
STEP5_TYPES = ("bit", "KF", "DH", "KH", "KM", "KY", "KC", "KT", "KZ", "KG", "REAL", "BCD")
OnLoss = Literal["hold", "finish_move", "stop_on_path", "quick_stop"]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$", json_schema_extra={"allowed": "letters, digits, _ and -"})]
Percent = Annotated[str, Field(pattern=r"^(100|\d{1,2})(\.\d+)? %$", json_schema_extra={"allowed": '"0 %".."100 %"'})]


ENGLISH = {"I": "E", "Q": "A", "F": "M", "C": "Z", "DB": "D", "DX": "X"}  # S7 and English STEP 5; users.md 3.2


def german(letter: object) -> object:
    """I Q F C are E A M Z."""
    return ENGLISH.get(letter, letter) if isinstance(letter, str) else letter


AreaLetter = Annotated[Literal["D", "X", "E", "A", "M", "T", "Z"], BeforeValidator(german)]


def unit(text: str) -> dict[str, Any]:
    """Marks a field with its unit; {u} stands for the unit of the axis."""
    return {"unit": text}


class Table(BaseModel):
    """Base of every table."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class CellHead(Table):
    name: str = Field(min_length=1)
    replaces: str = ""
    software: str = ""
    language: Literal["de", "en"] = "en"
    target: Literal["machine", "simulation"] = "simulation"
    on_services_loss: Literal["stop_on_path", "finish_move"] = "stop_on_path"


class Safety(Table):
    emergency_stop: str = ""
    sto_wired: bool | None = None
    guard: str = ""
    limit_switches: str = ""
    enabling_device: str = ""
    risk_assessment: str = ""
    last_stop_test: datetime.date | None = None


class RcInputs(Table):
    owner: dict[Annotated[str, Field(pattern=r"^\d{1,3}$")], Name] = {}
    assume: list[str] = []


class IoBus(Table):
    inputs: int = Field(default=0, ge=0, le=5, json_schema_extra=unit("blocks"))
    outputs: int = Field(default=0, ge=0, le=4, json_schema_extra=unit("blocks"))
    baud: int = Field(default=0, ge=0, le=3)


class IoBlock(Table):
    bus: int = Field(ge=1, le=2)
    start: int = Field(ge=0, le=127, json_schema_extra=unit("PIC byte"))
    length: int = Field(ge=1, le=8, json_schema_extra=unit("bytes"))
    id: int = Field(ge=471, le=550)


class OutputBlock(IoBlock):
    id: int = Field(ge=471, le=480)


class MeasuringSystem(Table):
    axis: int = Field(ge=1, le=12)
    module: int = Field(ge=1, le=12)
    ref_mode: int = Field(default=0, ge=0, le=3)
    gear_factor: float = Field(default=1.0, gt=0)
    pulses: int = Field(default=1, ge=1, le=3)
    evaluation: float = 16384.0
    output: int = Field(default=0, ge=-20, le=20)


Speeds = list[Annotated[float, Field(gt=0, json_schema_extra=unit("deg/s or mm/s"))]]
Ways = list[Annotated[float, Field(json_schema_extra=unit("deg or mm"))]]


class Rho3(Table):
    P2: int = Field(default=0, ge=0, le=15)
    P5: int | None = Field(default=None, ge=2, le=32, json_schema_extra=unit("ms"))
    P9: int = Field(default=40, ge=1, le=1000, json_schema_extra=unit("ms"))
    P15: list[Annotated[int, Field(ge=0, le=20)]] = []
    P20: int | None = Field(default=None, ge=0, le=99)
    P21: list[Annotated[int, Field(ge=0, le=250, json_schema_extra=unit("byte"))]] = []
    P24: int | Literal["all"] = "all"
    P30: list[IoBus] = Field(default=[], max_length=2)
    P31: list[IoBlock] = []
    P32: list[OutputBlock] = []
    P103: Speeds = []
    P104: Speeds = []
    P108: Speeds = []
    P109: Speeds = []
    P204: Ways = []
    P205: Ways = []
    P207: Ways = []
    P208: Ways = []
    P401: list[MeasuringSystem] = []
    P601: bool = False
    others: dict[str, Any] = {}


class Rk512(Table):
    db_address_unit: Literal["word", "byte"] = "word"
    reaction: bool = True
    types: list[AreaLetter] = ["D"]
    unknown_block: int = Field(default=0x14, ge=1, le=255)
    coordination_flag: Literal["refuse", "ignore", "serve", "keep"] = "refuse"
    end_of_follow_on: Literal["ETX", "ETB"] = "ETX"


def ms_range(low: int = 0, high: int = 65530) -> Any:
    """An optional time in ms."""
    return Field(default=None, ge=low, le=high, json_schema_extra=unit("ms"))


class Times(Table):
    QVZ: int | None = ms_range(10)
    ADT: int | None = ms_range(10)
    ZVZ: int | None = ms_range(10)
    CDT: int | None = ms_range(10)
    BWZ: int | None = ms_range(10)
    reaction: int | None = ms_range(10)
    pause: int | None = ms_range()
    no_buffer: int | None = ms_range()
    connect_attempts: int | None = Field(default=None, ge=1, le=255)
    block_attempts: int | None = Field(default=None, ge=1, le=255)


class Choices(Table):
    connect_counter: Literal["per_job", "per_block", "shared"] | None = None
    stray: Literal["silent", "nak_after_quiet", "nak_at_once"] | None = None
    broken_pair: Literal["nak_at_end", "nak_at_once", "drop_dle"] | None = None
    too_long: Literal["nak_at_end", "nak_at_once"] | None = None
    interruption: Literal["ignore", "back_off"] | None = None
    silence_ends: bool | None = None
    yields_to_second_conflict: bool | None = None
    nak_at_start: bool | None = None
    nak_when_giving_up: bool | None = None
    nesting: bool | None = None


class Supervision(Table):
    max_silence_ms: int = Field(default=1000, ge=0, le=60000, json_schema_extra=unit("ms"))
    life_word: str | None = None
    on_loss: OnLoss = "stop_on_path"
    restart: Literal["new_command"] = "new_command"


class Line(Table):
    name: Name
    port: str = Field(
        pattern=r"^(sim|/dev/\S+|COM\d+|pty:\S+|tcp://\S+:\d+|rfc2217://\S+:\d+)$",
        json_schema_extra={"allowed": "sim | /dev/... | COM5 | pty:/path | tcp://host:port | rfc2217://host:port"},
    )
    format: str = Field(
        default="9600 8E1", pattern=rf"^({BAUDS}) [78][NEO][12]$", json_schema_extra={"allowed": '"9600 8E1": baud, bits, parity, stop'}
    )
    wiring: str = ""
    protocol: Literal["3964R", "3964"] = "3964R"
    profile: str = "rho3"
    priority: Literal["low", "high"] = "low"
    layer: Literal["rk512", "telegrams", "buep64", "program"] = "rk512"
    role: Literal["passive", "active", "both"] = "passive"
    output_timeout: int | None = Field(default=None, ge=-1, le=65535)
    byte_order: Literal["big", "little"] = "big"
    rk512: Rk512 = Rk512()
    times: Times = Times()
    choices: Choices = Choices()
    supervision: Supervision = Supervision()


class Entry(Table):
    at: str
    type: Literal["bit", "KF", "DH", "KH", "KM", "KY", "KC", "KT", "KZ", "KG", "REAL", "BCD"]
    to: str | None = None
    from_: str | None = Field(default=None, alias="from")
    unit: str = Field(
        default="1", pattern=r"^\d+(\.\d+)?( (mm|deg|%|ms|s))?$", json_schema_extra={"allowed": '"0.1 mm", "1 deg", "1 %", "1 ms"'}
    )
    min: float | None = None
    max: float | None = None
    edge: Literal["rising"] | None = None
    comment: str = ""


class Db(Table):
    number: int = Field(ge=0, le=255)
    words: int = Field(ge=1, le=256, json_schema_extra=unit("words"))
    writer: Literal["plc", "axisgate"]
    kind: AreaLetter = "D"
    line: str = ""
    every_ms: int = Field(default=0, ge=0, le=3_600_000, json_schema_extra=unit("ms"))
    on_change: bool = False
    at_partner: str = Field(default="", pattern=r"^(D[BX]\d{1,3}\.DW\d{1,3})?$", json_schema_extra={"allowed": '"DB20.DW0" or "DX20.DW0"'})
    flag: str = Field(default="", pattern=r"^([MF] ?\d{1,3}\.[0-7])?$", json_schema_extra={"allowed": '"M 6.4"'})
    comment: str = ""
    entries: list[Entry] = []


class Handshake(Table):
    pattern: Literal["start-busy-done", "level-ack", "toggle", "strobe-parity", "number-select"]
    start: str = ""
    busy: str = ""
    done: str = ""
    refused: str = ""
    parity: Literal["even", "odd"] = "even"


class Position(Table):
    number: int = Field(ge=1, le=65535)
    at: dict[str, float] = Field(min_length=1)
    speed: float = Field(default=100.0, gt=0, le=100, json_schema_extra=unit("%"))
    comment: str = ""


class IoDevice(Table):
    type: Literal["canopen-401", "modbus", "gpiochip"]
    bus: str = ""
    node: int | None = Field(default=None, ge=1, le=127)
    input: int | None = Field(default=None, ge=0, le=65535)
    output: int | None = Field(default=None, ge=0, le=65535)
    url: str = Field(default="", pattern=r"^(tcp://\S+:\d+|rtu:\S+)?$", json_schema_extra={"allowed": "tcp://host:502 | rtu:/dev/ttyUSB0"})
    poll_ms: int = Field(default=50, ge=5, le=60000, json_schema_extra=unit("ms"))
    chip: str = ""
    active_low: bool = False
    unit: int = Field(default=1, ge=0, le=255)  # last: it hides the function


RouteForm = Literal["", "bit", "u8", "s8", "u16", "s16", "u32", "s32", "KF", "KH", "KM", "DH", "KZ", "KG", "REAL", "BCD"]


class Io(Table):
    name: Name
    device: IoDevice
    signal: str
    on_loss: int | None = Field(default=None, ge=0, le=1)
    toggle_ms: int = Field(default=20, ge=2, le=10000, json_schema_extra=unit("ms"))


class Bus(Table):
    name: Name
    port: str = Field(
        pattern=r"^(sim|socketcan:[\w.-]{1,15}|broker:[\w-]+|memory:[\w-]+)$",
        json_schema_extra={"allowed": "sim | socketcan:can0 | broker:NAME"},
    )
    protocol: Literal["servodyn", "canopen", "rho3-io"]
    bitrate: Literal["1 Mbit/s", "500 kbit/s", "250 kbit/s", "125 kbit/s"] = "1 Mbit/s"
    cycle_ms: int = Field(default=4, ge=2, le=32, json_schema_extra=unit("ms"))
    heartbeat_ms: int = Field(default=50, ge=10, le=1000, json_schema_extra=unit("ms"))
    layout: str = "servodyn_gc.dbc"
    layout_evidence: str = ""
    axes: str = Field(default="", pattern=r"^([1-6](\.\.[1-6])?)?$", json_schema_extra={"allowed": '"1..6"'})
    on_loss: Literal["zero", "hold"] = "zero"
    coupling_ms: int = Field(default=300, ge=0, le=60000, json_schema_extra=unit("ms"))


class Drive(Table):
    type: Literal["servodyn", "cia402"]
    bus: str
    module: int | None = Field(default=None, ge=1, le=6)
    node: int | None = Field(default=None, ge=1, le=127)
    eds: str = ""
    serial: str = ""
    inc_per_turn: int = Field(default=16384, ge=64, le=1 << 24, json_schema_extra=unit("inc"))


class Mechanics(Table):
    feed_per_turn: float = Field(default=360.0, gt=0, json_schema_extra=unit("{u}"))
    gear: str = Field(
        default="1:1", pattern=r"^[1-9]\d*(\.\d+)?:[1-9]\d*(\.\d+)?$", json_schema_extra={"allowed": '"10:1", motor : output turns'}
    )
    direction: Literal["+", "-"] = "+"
    vertical: bool = False


class AxisLimits(Table):
    min: float = Field(json_schema_extra=unit("{u}"))
    max: float = Field(json_schema_extra=unit("{u}"))
    speed: float = Field(gt=0, json_schema_extra=unit("{u}/s"))
    accel: float = Field(gt=0, json_schema_extra=unit("{u}/s^2"))
    jerk: float = Field(gt=0, json_schema_extra=unit("{u}/s^3"))


class FollowingError(Table):
    warn: float = Field(gt=0, json_schema_extra=unit("{u}"))
    trip: float = Field(gt=0, json_schema_extra=unit("{u}"))
    standstill: float | None = Field(default=None, gt=0, json_schema_extra=unit("{u}"))


class Home(Table):
    by: Literal["gateway", "drive", "none"] = "gateway"
    mode: int = Field(default=0, ge=0, le=3)
    method: int | None = Field(default=None, ge=-128, le=37)
    speed: float = Field(default=0.0, ge=0, json_schema_extra=unit("{u}/s"))
    slow_speed: float = Field(default=0.0, ge=0, json_schema_extra=unit("{u}/s"))
    direction: Literal["+", "-"] = "-"
    position: float = Field(default=0.0, json_schema_extra=unit("{u}"))
    offset: float = Field(default=0.0, json_schema_extra=unit("{u}"))
    timeout_s: float = Field(default=60.0, gt=0, le=3600, json_schema_extra=unit("s"))


class FirstEnable(Table):
    torque: Percent = "20 %"
    speed: Percent = "5 %"
    travel: float = Field(default=2.0, gt=0, json_schema_extra=unit("{u}"))


class AxisDefaults(Table):
    """[defaults.axis]: what an axis may take over."""

    mode: Literal["csp", "csv", "pp"] = "csp"
    stop_on_bus_loss: Literal["quick_stop", "coast"] = "quick_stop"
    brake: Literal["drive", "gateway", "none"] = "drive"
    following_error: FollowingError | None = None
    home: Home = Home()
    first_enable: FirstEnable = FirstEnable()


class Axis(AxisDefaults):
    name: Name
    unit: Literal["mm", "deg"]
    drive: Drive
    limits: AxisLimits
    mechanics: Mechanics = Mechanics()


class Defaults(Table):
    axis: AxisDefaults = AxisDefaults()


class Robot(Table):
    kinematics: str
    model: str = ""
    name: str = ""
    zero: str = ""


class Program(Table):
    number: int = Field(ge=1, le=9999)
    file: str = Field(min_length=1)
    kinematics: str = ""


class CheckPosition(Table):
    name: str
    tolerance: float = Field(gt=0)
    at: dict[str, float] = {}
    joints: list[float] = []


Hex = Annotated[str, Field(pattern=r"^\s*([0-9A-Fa-f]{2}\s*)+$", json_schema_extra={"allowed": '"00 4F", two hex digits a byte'})]
Text = Annotated[str, Field(pattern=r"^[\x00-\xff]+$", json_schema_extra={"allowed": "characters 00h..FFh (Latin-1)"})]
TelegramType = Literal["BINARY", "CHARACTER", "BYTE", "WORD", "KF", "INTEGER", "REAL", "POINT", "JC_POINT", "TEXT"]
TelegramUnit = Annotated[
    str, Field(pattern=r"^(\d+(\.\d+)? )?[^\s\d]\S*$", json_schema_extra={"allowed": '"mm" or "0.1 mm" (one count is 0.1 mm)'})
]
OwnName = r"[a-z]\w*(\.\w+)+"  # as gateway.pure.addresses reads it


class TelegramMatch(Table):
    byte: int = Field(ge=0, le=137)
    hex: Hex = ""
    text: Text = ""


class TelegramField(Table):
    byte: int = Field(ge=0, le=137)
    type: TelegramType
    to: str = Field(pattern=rf"^{OwnName}$", json_schema_extra={"allowed": "a name of the cell's own, as order.number"})
    count: int = Field(default=1, ge=1, le=138)
    unit: TelegramUnit = ""
    scale: float = 1.0
    byte_order: Literal["big", "little"] | None = None
    min: float | None = None
    max: float | None = None


class TelegramPart(Table):
    hex: Hex = ""
    text: Text = ""
    type: TelegramType | Literal[""] = ""
    from_: str = Field(default="", alias="from")
    count: int = Field(default=1, ge=1, le=138)
    unit: TelegramUnit = ""
    scale: float = 1.0
    byte_order: Literal["big", "little"] | None = None
    min: float | None = None
    max: float | None = None


class Telegram(Table):
    line: str
    name: Name
    match: list[TelegramMatch] = []
    length: int | None = Field(default=None, ge=1, le=138, json_schema_extra=unit("bytes"))
    fields: list[TelegramField] = []
    then: str = Field(default="", pattern=rf"^signal +{OwnName}$", json_schema_extra={"allowed": '"signal order.new"'})
    when: str = Field(
        default="", pattern=r"^(rising|falling|change) +\S+$", json_schema_extra={"allowed": '"rising order.done", falling, change'}
    )
    build: list[TelegramPart] = []


class Retain(Table):
    values: list[str] = []


class Span(Table):
    from_: float = Field(alias="from", json_schema_extra=unit("{u}"))
    to: float = Field(json_schema_extra=unit("{u}"))


class PlantAxis(Table):
    start: float = Field(default=0.0, json_schema_extra=unit("{u}"))
    reference_switch: Span | None = None
    hard_limits: Span | None = None
    settings: dict[str, float | bool] = {}


class Plant(Table):
    seed: int = Field(default=1, ge=0)
    axis: dict[str, PlantAxis] = {}
    absent: list[str] = []


class Web(Table):
    bind: str = Field(default="127.0.0.1:8480", pattern=r"^\S+:\d{1,5}$", json_schema_extra={"allowed": "address:port"})
    names: list[str] = []
    read_only: bool = False
    tls_certificate: str = ""
    tls_key: str = ""
    data: str = ""


class Route(Table):
    name: Name
    from_: str = Field(alias="from")
    to: str
    type: RouteForm = ""
    to_type: RouteForm = ""
    order: Literal["ABCD", "CDAB", "BADC", "DCBA"] = "ABCD"
    to_order: Literal["ABCD", "CDAB", "BADC", "DCBA"] = "ABCD"
    scale: float = 1.0
    offset: float = 0.0
    edge: Literal["level", "rising", "falling", "change"] = "level"
    pulse_ms: int = Field(default=100, ge=1, le=60000, json_schema_extra=unit("ms"))
    debounce_ms: int = Field(default=0, ge=0, le=60000, json_schema_extra=unit("ms"))
    every_ms: int = Field(default=0, ge=0, le=3_600_000, json_schema_extra=unit("ms"))
    within_ms: int = Field(default=0, ge=0, le=3_600_000, json_schema_extra=unit("ms"))
    on_loss: Literal["hold", "zero", "value"] = "hold"
    loss_value: float = 0.0
    loss_after_ms: int = Field(default=0, ge=0, le=3_600_000, json_schema_extra=unit("ms"))
    valid: str = ""
    life: str = ""
    comment: str = ""


class CellFile(Table):
    """The whole file."""

    format: Literal[1]
    cell: CellHead
    safety: Safety | None = None
    rc_inputs: RcInputs = RcInputs()
    signals: dict[Name, Annotated[int, Field(ge=0, le=1023)]] = {}
    rho3: Rho3 | None = None
    line: list[Line] = []
    db: list[Db] = []
    handshake: dict[str, Handshake] = {}
    position: list[Position] = []
    io: list[Io] = []
    bus: list[Bus] = []
    defaults: Defaults = Defaults()
    axis: list[Axis] = []
    modbus: list[Modbus] = []
    robot: Robot | None = None
    program: list[Program] = []
    check_position: list[CheckPosition] = []
    telegram: list[Telegram] = []
    retain: Retain | None = None
    plant: Plant | None = None
    web: Web | None = None
    northbound: Northbound | None = None
    route: list[Route] = []
    controller: Controller | None = None
