"""The edge of [rho3]: pydantic models of gateway.pure.cell.rho3."""

from typing import Annotated, Any, Literal

from pydantic import Field

from gateway.files.table_model import Table, unit


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


class OfKinematic(Table):
    monitoring: int = Field(default=0, ge=0, le=3)


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
    P303: list[Annotated[int, Field(ge=0, le=4)]] = []
    P306: list[OfKinematic] = []
    P311: Ways = []
    P313: list[Annotated[list[Annotated[int, Field(ge=0, le=24)]], Field(min_length=6, max_length=6)]] = []
    P401: list[MeasuringSystem] = []
    P601: bool = False
    others: dict[str, Any] = {}
