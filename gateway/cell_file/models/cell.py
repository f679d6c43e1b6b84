"""The edge of the cell file: pydantic models with ranges and units; `gateway.cell_file.load` turns them into `gateway.pure.cell.cell` data.

Strict, frozen, unknown keys forbidden. Field names are the keys of the file (`from` by alias); a test compares both sides.
"""

import datetime
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from gateway.cell_file.models.alter import Alter
from gateway.cell_file.models.axes import Axis, Defaults, Plant
from gateway.cell_file.models.belts import Belt, Measuring, PathOutput
from gateway.cell_file.models.buses import Bus, Io
from gateway.cell_file.models.controller import Controller
from gateway.cell_file.models.lines import Db, Handshake, Line, Telegram
from gateway.cell_file.models.modbus import Modbus
from gateway.cell_file.models.northbound import Northbound
from gateway.cell_file.models.rho3 import Rho3
from gateway.cell_file.models.shared_outputs import SharedOutput
from gateway.files.table_model import Name, Table, plain_number, unit


class CellHead(Table):
    name: str = Field(min_length=1)
    replaces: str = ""
    software: str = ""
    language: Literal["de", "en"] = "en"
    target: Literal["machine", "simulation"] = "simulation"
    on_services_loss: Literal["stop_on_path", "finish_move"] = "stop_on_path"
    override_step: float = Field(default=1.0, gt=0, le=1)


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


class Position(Table):
    number: int = Field(ge=1, le=65535)
    at: dict[str, float] = Field(min_length=1)
    speed: float = Field(default=100.0, gt=0, le=100, json_schema_extra=unit("%"))
    comment: str = ""


RouteForm = Literal["", "bit", "u8", "s8", "u16", "s16", "u32", "s32", "KF", "KH", "KM", "DH", "KZ", "KG", "REAL", "BCD"]


class Robot(Table):
    kinematics: str
    model: str = ""
    name: str = ""
    zero: str = ""
    shape: Literal["jerk", "sin2", "robot"] = "robot"
    too_fast: Annotated[Literal["slow", "abort", "error", 0, 1, 2, 3, "robot"], BeforeValidator(plain_number)] = "robot"
    corrects: str = Field(default="xyzabc", pattern=r"^x?y?z?a?b?c?$", json_schema_extra={"allowed": "letters of xyzabc in this order"})


class Program(Table):
    number: int = Field(ge=1, le=9999)
    file: str = Field(min_length=1)
    kinematics: str = ""


class CheckPosition(Table):
    name: str
    tolerance: float = Field(gt=0)
    at: dict[str, float] = {}
    joints: list[float] = []


class Retain(Table):
    values: list[str] = []


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
    robot: list[Robot] = []  # one table [robot] stands for a list of one (gateway.cell_file.load)
    program: list[Program] = []
    belt: list[Belt] = []
    measuring: list[Measuring] = []
    path_output: list[PathOutput] = []
    alter: Alter | None = None
    shared_output: list[SharedOutput] = []
    check_position: list[CheckPosition] = []
    telegram: list[Telegram] = []
    retain: Retain | None = None
    plant: Plant | None = None
    web: Web | None = None
    northbound: Northbound | None = None
    route: list[Route] = []
    controller: Controller | None = None
