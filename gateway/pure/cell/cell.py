"""The cell as plain frozen data: one dataclass per table of the cell file, one attribute per key.

Attribute = key, class = table; `from` is spelled `from_` because Python keeps the word. Values stand in the units of the
file (deg, mm, ms, %); inside units are made by `drivers.drives.scaling`. Source of the shapes: users.md 3.4, 3.5; design.md 5.
"""

import datetime
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from gateway.pure.cell.alter import Alter
from gateway.pure.cell.axes import Axis, FollowingError, Home, Plant, PlantAxis
from gateway.pure.cell.belts import Belt, Measuring, PathOutput
from gateway.pure.cell.buses import Bus, Io, IoDevice
from gateway.pure.cell.controller import Controller
from gateway.pure.cell.lines import Choices, Db, Entry, Handshake, Line, Rk512, Telegram, TelegramField, TelegramMatch, TelegramPart, Times
from gateway.pure.cell.modbus import Modbus
from gateway.pure.cell.northbound import Northbound
from gateway.pure.cell.positions import Position
from gateway.pure.cell.programs import Program
from gateway.pure.cell.retain import Retain
from gateway.pure.cell.rho3 import IoBlock, IoBus, ParamValue, Rho3
from gateway.pure.cell.routes import Route
from gateway.pure.cell.shared_outputs import SharedOutput
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
    """[cell]: what this plant is and how it is played."""

    name: str
    replaces: str = ""
    software: str = ""  # version of the replaced software: decides numbers that changed between versions
    language: str = "en"  # de | en
    target: str = "simulation"  # machine | simulation
    on_services_loss: str = "stop_on_path"  # stop_on_path | finish_move
    override_step: float = 1.0  # most the override changes in a cycle (Reis RDELTA_OV_MAX); 1: at once


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
    """[rc_inputs]: RC input byte (PIC byte = N div 8) -> the command source that owns it; enabling inputs taken as 1."""

    owner: Mapping[int, str] = field(default_factory=dict)
    assume: tuple[str, ...] = ()


PLANNED_KINEMATICS = ("identity", "portal", "scara", "arm6", "urdf")


@dataclass(frozen=True, slots=True)
class Robot:
    """[robot]: kinematics, as robot files name them (PLANNED_KINEMATICS: those the planner runs programs for)."""

    kinematics: str
    model: str = ""
    name: str = ""
    zero: str = ""
    shape: str = "robot"  # as the robot file says, or jerk, sin2
    too_fast: str | int = "robot"  # as the robot file says, or a word, or P306 sub-query 6, 0..3
    corrects: str = "xyzabc"  # components of world points a workpiece system corrects (P313)


@dataclass(frozen=True, slots=True)
class CheckPosition:
    """[[check_position]]: a known position, by axis names (`at`) or as joints."""

    name: str
    tolerance: float
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
    robot: tuple[Robot, ...] = ()
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
    sources: Mapping[str, Source] = field(default_factory=dict)  # "axis.1.limits.speed" -> P103[1], line 34
    notices: tuple[Notice, ...] = ()

    @property
    def cycle_ms(self) -> int:
        """The clock of the cell: P5 where the P list says it, else the drive bus."""
        if self.rho3 is not None and self.rho3.P5 is not None:
            return self.rho3.P5
        return next((bus.cycle_ms for bus in self.bus if bus.protocol != "rho3-io"), 4)

    @property
    def first_robot(self) -> Robot | None:
        """The only one, or the one on the first axes."""
        return self.robot[0] if self.robot else None

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
        unknown = [robot.kinematics for robot in self.robot if self.program and robot.kinematics not in PLANNED_KINEMATICS]
        reasons += [f"robot.kinematics = {kinematics}" for kinematics in unknown]  # nothing else asks for them
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
