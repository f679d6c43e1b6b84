"""The edge of a robot file: TOML in mm, deg and s, checked by pydantic, converted to the plain `motion.robot.Robot`.

`load_robot` is the only way in.  RobotFaults lists every fault: file, key, value, expected form.
"""

import math
import pathlib
import tomllib
from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, Field, ValidationError

from gateway.files.find import beside, find_config, read_text
from gateway.files.table_model import Table, plain_number
from motion import robot as plain
from motion.errors import MotionError
from motion.geometry.conventions import convention
from motion.geometry.frames import IDENTITY, Pose, Vector
from motion.geometry.limits import limits_from
from motion.kinematics.arm6 import ArmGeometry
from motion.kinematics.group import Role

MM = 1e-3
Six = Annotated[list[float], Field(min_length=6, max_length=6)]
Three = Annotated[list[float], Field(min_length=3, max_length=3)]
NOWHERE = [0.0] * 6
UPWARDS = [0.0, 0.0, 1.0]
NO_SIGNS: list[Literal[1, -1]] = [1, 1, 1, 1, 1, 1]


class RobotFaults(Exception):
    """A robot file that cannot be used; `faults`: (key, fault) in the order of the file."""

    def __init__(self, path: str, faults: Sequence[tuple[str, str]]) -> None:
        self.path, self.faults = path, tuple(faults)
        super().__init__("\n".join(f"{path}: {key}: {what}" for key, what in faults))


class Head(Table):
    name: str = Field(min_length=1)
    kind: Literal["identity", "portal", "scara", "arm6", "urdf"]
    angles: Literal["rho3", "val3", "reis", "reis-xyz"] = "val3"
    source: str = Field(min_length=1)
    base: Six = NOWHERE  # mm, deg in the convention `angles`
    coupling: list[list[float]] = Field(default_factory=list)
    shape: Literal["jerk", "sin2"] = "jerk"
    too_fast: Annotated[Literal["slow", "abort", "error", 0, 1, 2, 3], BeforeValidator(plain_number)] = "slow"


class ArmTable(Table):
    """mm and deg."""

    height: float
    arm: float = Field(gt=0)
    forearm: float = Field(gt=0)
    flange: float
    delta: float = 0.0
    elbow: float = 0.0
    side: float = 0.0
    signs: Annotated[list[Literal[1, -1]], Field(min_length=6, max_length=6)] = NO_SIGNS
    offsets: Six = NOWHERE


class ScaraTable(Table):
    """mm."""

    arm: float = Field(gt=0)
    forearm: float = Field(gt=0)
    height: float
    down: bool = True


class PortalTable(Table):
    letters: str = Field(pattern=r"^[xyz]{1,3}[abc]{0,3}$")
    flange: Six = NOWHERE  # mm, deg


class UrdfTable(Table):
    file: str = Field(min_length=1)
    frame: str = Field(min_length=1)


class AxisTable(Table):
    name: str = Field(min_length=1)
    unit: Literal["mm", "deg"]
    lower: float
    upper: float
    speed: float = Field(gt=0)
    accel: float = Field(gt=0)
    jerk: float = Field(gt=0)
    source: str = Field(min_length=1)


class AdditionalTable(AxisTable):
    role: Literal["free", "carrier", "table"] = "free"
    direction: Three = UPWARDS
    origin: Six = NOWHERE


class RobotFile(Table):
    format: Literal[1]
    robot: Head
    arm6: ArmTable | None = None
    scara: ScaraTable | None = None
    portal: PortalTable | None = None
    urdf: UrdfTable | None = None
    axis: Annotated[list[AxisTable], Field(min_length=1, max_length=24)]
    additional: list[AdditionalTable] = Field(default_factory=list)


def load_robot(name: str, text: str | None = None) -> plain.Robot:
    """The robot of a file (found by `find_config`).  RobotFaults names all faults; FileNotFoundError: no such file."""
    path = name
    if text is None:
        path = str(find_config(name, "robots"))
        text = read_text(pathlib.Path(path))
    try:
        raw = tomllib.loads(text)
        robot = _robot(path, RobotFile.model_validate(raw))
        plain.kinematics_of(robot)
    except tomllib.TOMLDecodeError as error:
        raise RobotFaults(path, [("file", str(error))]) from None
    except ValidationError as error:
        raise RobotFaults(path, [(_key(raw, each["loc"]), _words(each["msg"], each["input"])) for each in error.errors()]) from None
    except MotionError as error:
        raise RobotFaults(path, [("robot", str(error))]) from None
    return robot


def _robot(path: str, file: RobotFile) -> plain.Robot:
    head = file.robot
    tables: dict[str, BaseModel | None] = {"arm6": file.arm6, "scara": file.scara, "portal": file.portal, "urdf": file.urdf}
    wrong = [kind for kind, table in tables.items() if (table is not None) is not (kind == head.kind)]
    if wrong:
        raise RobotFaults(
            path, [(kind, f"robot.kind is {head.kind}: {'missing' if kind == head.kind else 'not allowed'}") for kind in wrong]
        )
    return plain.Robot(
        name=head.name,
        kind=plain.Kind(head.kind),
        geometry=_geometry(path, file),
        axes=(*(_axis(axis) for axis in file.axis), *(_additional(axis, head.angles) for axis in file.additional)),
        angles=head.angles,
        base=_pose(head.base, head.angles),
        coupling=tuple(tuple(row) for row in head.coupling),
        source=head.source,
        shape=head.shape,
        too_fast=head.too_fast,
    )


def _geometry(path: str, file: RobotFile) -> plain.Geometry:
    if file.arm6 is not None:
        return _arm(file.arm6)
    if file.scara is not None:
        return plain.ScaraGeometry(file.scara.arm * MM, file.scara.forearm * MM, file.scara.height * MM, file.scara.down)
    if file.portal is not None:
        return plain.PortalGeometry(file.portal.letters, _pose(file.portal.flange, file.robot.angles))
    if file.urdf is not None:
        return plain.UrdfGeometry(_urdf_text(path, file.urdf.file), file.urdf.frame)
    return None


def _urdf_text(path: str, name: str) -> str:
    try:
        return read_text(beside(path, name, "robots"))
    except UnicodeDecodeError as error:
        raise RobotFaults(path, [("urdf.file", f"{name} is not UTF-8: byte {error.start} is {error.object[error.start]:02X}h")]) from None


def _arm(table: ArmTable) -> ArmGeometry:
    s, o = table.signs, [math.radians(value) for value in table.offsets]
    return ArmGeometry(
        height=table.height * MM,
        arm=table.arm * MM,
        forearm=table.forearm * MM,
        flange=table.flange * MM,
        delta=table.delta * MM,
        elbow=table.elbow * MM,
        side=table.side * MM,
        signs=(s[0], s[1], s[2], s[3], s[4], s[5]),
        offsets=(o[0], o[1], o[2], o[3], o[4], o[5]),
    )


def _axis(table: AxisTable) -> plain.AxisOfRobot:
    limits = limits_from(
        table.name, table.unit, lower=table.lower, upper=table.upper, speed=table.speed, accel=table.accel, jerk=table.jerk
    )
    return plain.AxisOfRobot(limits, table.source)


def _additional(table: AdditionalTable, angles: str) -> plain.AxisOfRobot:
    own = _axis(table)
    x, y, z = table.direction
    direction: Vector = (x, y, z)
    return plain.AxisOfRobot(own.limits, own.source, Role(table.role), direction, _pose(table.origin, angles))


def _pose(values: list[float], angles: str) -> Pose:
    """mm, deg -> Pose."""
    return convention(angles).pose(values) if any(values) else IDENTITY


def _key(raw: Any, where: tuple[int | str, ...]) -> str:
    """Dotted key; elements of lists by their name where they have one."""
    words: list[str] = []
    here = raw
    for part in where:
        if isinstance(here, list) and isinstance(part, int):
            here = here[part]
            words.append(str(here["name"]) if isinstance(here, dict) and "name" in here else str(part))
        else:
            here = here.get(part) if isinstance(here, dict) else None
            words.append(str(part))
    return ".".join(words) or "file"


def _words(message: str, value: object) -> str:
    shown = "" if isinstance(value, dict | list) else f" (is {value!r})"
    return f"{message}{shown}"
