"""The edge of [alter]: the pydantic model of gateway.pure.cell.alter."""

from typing import Literal

from pydantic import Field

from gateway.files.table_model import Robots, Table, unit


class Alter(Table):
    input: int = Field(ge=0, le=1023)
    type: Literal["INT", "REAL"] = "INT"
    length: float = Field(default=0.01, gt=0.0, le=10.0, json_schema_extra=unit("mm"))
    angle: float = Field(default=0.01, gt=0.0, le=1.0, json_schema_extra=unit("deg"))
    life: int | None = Field(default=None, ge=0, le=1023)
    silence_ms: int = Field(default=100, ge=10, le=10000, json_schema_extra=unit("ms"))
    every_ms: int = Field(default=4, ge=1, le=1000, json_schema_extra=unit("ms"))
    status: int | None = Field(default=None, ge=0, le=1023)
    robot: Robots = []
