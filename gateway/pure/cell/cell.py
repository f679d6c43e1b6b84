"""The cell as plain frozen data: one dataclass per table of the cell file, one attribute per key.

Attribute = key, class = table; `from` is spelled `from_` because Python keeps the word. Values are in the units of the file (deg, mm, ms,
%); `drivers.drives.scaling` converts them to internal units. Source of the shapes: users.md 3.4, 3.5; design.md 5.
"""

import datetime
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le, MinLen

from gateway.pure.cell.alter import Alter
from gateway.pure.cell.axes import Axis, Defaults, FollowingError, Home, Plant, PlantAxis
from gateway.pure.cell.belts import Belt, Measuring, PathOutput
from gateway.pure.cell.buses import Bus, Io, IoDevice
from gateway.pure.cell.controller import Controller
from gateway.pure.cell.lines import Choices, Db, Entry, Handshake, Line, Rk512, Telegram, TelegramField, TelegramMatch, TelegramPart, Times
from gateway.pure.cell.marks import Name, Pattern, Spelled, plain_number
from gateway.pure.cell.modbus import Modbus
from gateway.pure.cell.northbound import Northbound
from gateway.pure.cell.positions import Position
from gateway.pure.cell.programs import Program
from gateway.pure.cell.retain import Retain
from gateway.pure.cell.rho3 import IoBlock, IoBus, ParamValue, Rho3
from gateway.pure.cell.routes import Route
from gateway.pure.cell.shared_outputs import SharedOutput
from gateway.pure.cell.val3 import Val3
from gateway.pure.cell.web import Web

# fmt: off
__all__ = [  # who reads a cell finds its tables here
    "Axis", "Bus", "Cell", "CheckPosition", "Choices", "Db", "Entry", "FollowingError", "Handshake", "Home", "Io", "IoBlock", "IoBus",
    "IoDevice", "Line", "Notice", "ParamValue", "Plant", "PlantAxis", "Rho3", "Rk512", "Source", "Telegram", "TelegramField",
    "TelegramMatch", "TelegramPart", "Times",
]
# fmt: on


@dataclass(frozen=True, slots=True)
class CellHead:
    """[cell]: name of the plant and mode of operation."""

    name: Annotated[str, MinLen(1)]
    replaces: str = ""
    software: str = ""  # version of the replaced software: decides numbers that changed between versions
    language: Literal["de", "en"] = "en"
    target: Literal["machine", "simulation"] = "simulation"
    on_services_loss: Literal["stop_on_path", "finish_move"] = "stop_on_path"
    override_step: Annotated[float, Gt(0), Le(1)] = 1.0  # most the override changes in a cycle (Reis RDELTA_OV_MAX); 1: at once


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


def byte_number(key: object) -> object:
    """Keys of a file are texts: "11" is byte 11."""
    return int(key) if isinstance(key, str) and re.fullmatch("[0-9]{1,3}", key) else key


@dataclass(frozen=True, slots=True)
class RcInputs:
    """[rc_inputs]: RC input byte (PIC byte = N div 8) -> the command source that owns it; enabling inputs taken as 1; feed inputs of
    single kinematics that this cell has (AX-1787)."""

    owner: Mapping[Annotated[int, Spelled(byte_number)], Name] = field(default_factory=dict)
    assume: tuple[str, ...] = ()
    wired: tuple[str, ...] = ()


PLANNED_KINEMATICS = ("identity", "portal", "scara", "arm6", "urdf")


@dataclass(frozen=True, slots=True)
class Robot:
    """[robot]: kinematics, as robot files name them (PLANNED_KINEMATICS: those the planner runs programs for)."""

    kinematics: str
    model: str = ""
    name: str = ""
    zero: str = ""
    shape: Literal["jerk", "sin2", "robot"] = "robot"  # as set in the robot file, or jerk, sin2
    # as set in the robot file, or a word, or P306 sub-query 6, 0..3
    too_fast: Annotated[Literal["slow", "abort", "error", 0, 1, 2, 3, "robot"], Spelled(plain_number)] = "robot"
    # components of world points a workpiece system corrects (P313)
    corrects: Annotated[str, Pattern("^x?y?z?a?b?c?$", "letters of xyzabc in this order")] = "xyzabc"


@dataclass(frozen=True, slots=True)
class CheckPosition:
    """[[check_position]]: a known position, by axis names (`at`) or as joints."""

    name: str
    tolerance: Annotated[float, Gt(0)]
    at: Mapping[str, float] = field(default_factory=dict)
    joints: tuple[float, ...] = ()


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


@dataclass(frozen=True, slots=True, kw_only=True)
class CellTables:
    """The entire file, table by table; the loader has applied P numbers and defaults."""

    format: Literal[1]
    cell: CellHead
    safety: Safety | None = None
    rc_inputs: RcInputs = RcInputs()
    # [signals]: axisgate's own signals on other bit numbers (AX-002)
    signals: Mapping[Name, Annotated[int, Ge(0), Le(1023)]] = field(default_factory=dict)
    rho3: Rho3 | None = None
    line: tuple[Line, ...] = ()
    db: tuple[Db, ...] = ()
    handshake: Mapping[str, Handshake] = field(default_factory=dict)
    position: tuple[Position, ...] = ()
    io: tuple[Io, ...] = ()
    bus: tuple[Bus, ...] = ()
    defaults: Defaults = Defaults()
    axis: tuple[Axis, ...] = ()
    modbus: tuple[Modbus, ...] = ()
    robot: tuple[Robot, ...] = ()  # one table [robot] is a list of one
    program: tuple[Program, ...] = ()
    belt: tuple[Belt, ...] = ()
    measuring: tuple[Measuring, ...] = ()
    path_output: tuple[PathOutput, ...] = ()
    alter: Alter | None = None
    shared_output: tuple[SharedOutput, ...] = ()
    check_position: tuple[CheckPosition, ...] = ()
    telegram: tuple[Telegram, ...] = ()
    retain: Retain | None = None
    plant: Plant | None = None
    web: Web | None = None
    northbound: Northbound | None = None
    route: tuple[Route, ...] = ()
    controller: Controller | None = None
    val3: Val3 | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell(CellTables):
    """A complete, checked cell file."""

    file: str
    sources: Mapping[str, Source] = field(default_factory=dict)  # "axis.1.limits.speed" -> P103[1], line 34
    notices: tuple[Notice, ...] = ()

    @property
    def cycle_ms(self) -> int:
        """The clock of the cell: P5 where the P list sets it, else the drive bus."""
        if self.rho3 is not None and self.rho3.P5 is not None:
            return self.rho3.P5
        return next((bus.cycle_ms for bus in self.bus if bus.protocol != "rho3-io"), 4)

    @property
    def warnings(self) -> tuple[Notice, ...]:
        return tuple(notice for notice in self.notices if notice.level == "warning")

    @property
    def notes(self) -> tuple[Notice, ...]:
        return tuple(notice for notice in self.notices if notice.level == "note")

    def axis_named(self, name: str) -> Axis:
        """The axis of that name; KeyError names those that exist."""
        for axis in self.axis:
            if axis.name == name:
                return axis
        raise KeyError(f"axis {name!r}; this cell has {', '.join(axis.name for axis in self.axis)}")
