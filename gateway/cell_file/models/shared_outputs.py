"""The edge of [[shared_output]]: the pydantic model of gateway.pure.cell.shared_outputs."""

from typing import Annotated

from pydantic import Field

from gateway.files.table_model import Name, OneRobot, Table, unit


class SharedOutput(Table):
    name: Name
    axes: Annotated[list[str], Field(min_length=2, max_length=32)]
    output: int = Field(ge=0, le=1023)
    select: int | None = Field(default=None, ge=0, le=1023)
    correction_ms: int = Field(default=0, ge=0, le=10000, json_schema_extra=unit("ms"))
    gain: float = Field(default=16.7, ge=0.0, le=1000.0, json_schema_extra=unit("1/s"))
    keep_last: bool = False
    robot: OneRobot = []
