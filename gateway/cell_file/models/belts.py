"""The edge of [[belt]] and [plant.belt]: pydantic models of gateway.pure.cell.belts."""

from typing import Annotated, Literal

from pydantic import Field

from gateway.files.table_model import Name, OneRobot, Robots, Table
from gateway.files.table_model import unit as _unit

U, PER_S, PER_S2, PER_S3 = (_unit(text) for text in ("mm or deg", "mm/s or deg/s", "mm/s2 or deg/s2", "mm/s3 or deg/s3"))

Factors = Annotated[list[float], Field(min_length=3, max_length=3)]


class Belt(Table):
    name: Name
    increment: float = Field(ge=-100.0, le=100.0, json_schema_extra=U)
    unit: Literal["mm", "deg"] = "mm"
    bus: str = ""
    id: int = Field(default=0, ge=0, le=0x7FF)
    byte: int = Field(default=0, ge=0, le=7)
    bytes: Literal[2, 4] = 4
    type: Literal[1, 2, 3] = 1
    tolerance: int = Field(default=5, ge=1, le=12, json_schema_extra=_unit("interpolation cycles"))
    factors: Factors = [1.0, 0.0, 0.0]
    axis: str = ""
    factor: float = Field(default=1.0, ge=-1e6, le=1e6, json_schema_extra=_unit("unit of the axis for one of the belt"))
    simulated: float = Field(default=0.0, ge=-10000.0, le=10000.0, json_schema_extra=PER_S)
    v_stop: float | None = Field(default=None, ge=0.0, le=10000.0, json_schema_extra=PER_S)
    v_run: float | None = Field(default=None, ge=0.0, le=10000.0, json_schema_extra=PER_S)
    patience_ms: int = Field(default=0, ge=0, le=60000, json_schema_extra=_unit("ms"))
    accel: float = Field(default=2000.0, gt=0.0, le=1e6, json_schema_extra=PER_S2)
    jerk: float = Field(default=20000.0, gt=0.0, le=1e9, json_schema_extra=PER_S3)
    robot: Robots = []
    factors_of: dict[str, Factors] = {}


class Measuring(Table):
    channel: int = Field(ge=610, le=699)
    input: int = Field(default=-1, ge=-1, le=1023)
    axes: list[str] = []
    drives: list[str] = []
    probe: Literal[1, 2] = 1
    robot: Robots = []
    latch: Literal["", "fIn0", "fIn1"] = ""


class PathOutput(Table):
    kind: Literal["iol", "ppo"]
    function: int = Field(ge=1, le=299)
    output: int = Field(ge=0, le=1023)
    bits: Literal[8, 16] = 16
    rated: float = Field(default=0.0, ge=0.0, le=1e6)
    volts: float = Field(default=10.0, ge=10.0, le=13.3, json_schema_extra=_unit("V"))
    robot: OneRobot = []


class PlantBelt(Table):
    speed: float = Field(default=0.0, ge=-10000.0, le=10000.0, json_schema_extra=PER_S)
    accel: float = Field(default=1000.0, gt=0.0, le=1e6, json_schema_extra=PER_S2)
