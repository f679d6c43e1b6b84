"""The edge of [controller]: pydantic models of gateway.pure.cell.controller."""

from typing import Annotated, Literal

from pydantic import Field

from gateway.files.table_model import Percent, Table, unit

PointName = Annotated[str, Field(pattern=r"^[A-Za-z]\w*$", json_schema_extra={"allowed": "letters, digits and _"})]
BoardName = Literal[
    "servo-3/5/8-wide", "servo-abs-5/8", "servo-inc6/poti", "servo-3/5-narrow", "servo-3is/4is/6is", "servo-abs-3i", "modular-i"
]  # fmt: skip
OutputByte = Annotated[int, Field(ge=0, le=39)]


class ProcessStep(Table):
    to: dict[str, float] = {}
    program: int | None = Field(default=None, ge=0, le=65535)
    speed: Percent = "100 %"
    output: int | None = Field(default=None, ge=1, le=804, json_schema_extra=unit("binary output"))
    input: int | None = Field(default=None, ge=1, le=804, json_schema_extra=unit("binary input"))
    value: bool = True
    wait_ms: int | None = Field(default=None, ge=0, le=3_600_000, json_schema_extra=unit("ms"))


class ControllerProcess(Table):
    name: str = Field(pattern=r"^[A-Za-z0-9_]{1,8}$", json_schema_extra={"allowed": "up to 8 letters, digits and _"})
    steps: list[ProcessStep] = []
    kind: Literal["normal", "permanent"] = "normal"
    priority: int = Field(default=140, ge=0, le=255)
    kinematics: list[Annotated[int, Field(ge=1, le=10)]] = [1]
    repeat: bool = False


class ControllerPoint(Table):
    name: PointName
    board: str = Field(min_length=1)
    module: str = Field(min_length=1)
    address: str = Field(min_length=1)
    output: bool = False
    bit: int | None = Field(default=None, ge=0, le=1023)
    byte: int | None = Field(default=None, ge=0, le=126)
    steps: int = Field(default=0, ge=0, le=32767, json_schema_extra=unit("steps per unit"))
    min: float = 0.0
    max: float = 0.0
    integer: bool = False
    description: str = Field(default="", max_length=200)


class Controller(Table):
    kind: Literal["rho3", "reis", "val3"] = "rho3"
    files: str = ""
    code_page: Literal["cp437", "cp850", "latin-1", "utf-8"] = "cp437"
    hardware: Literal["rho3.0", "rho3.1", "rho3.2"] = "rho3.1"
    kinematics: int = Field(default=1, ge=1, le=10)
    phg_option: bool = True
    plc_silence_ms: int = Field(default=0, ge=0, le=600_000, json_schema_extra=unit("ms"))
    pic_timeout_ms: int = Field(default=0, ge=0, le=200, json_schema_extra=unit("ms"))
    boards: list[BoardName] = Field(default=[], max_length=3)
    remote: bool = False
    door: str = ""
    first_byte: int = Field(default=88, ge=0, le=88, json_schema_extra=unit("PIC byte"))
    plc_only: list[OutputByte] = []
    robot_only: list[OutputByte] = []
    process: list[ControllerProcess] = []
    point: list[ControllerPoint] = []
