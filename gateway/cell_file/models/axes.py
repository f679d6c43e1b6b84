"""The edge of [[axis]], [defaults.axis] and [plant]: pydantic models of gateway.pure.cell.axes."""

from typing import Literal

from pydantic import Field

from gateway.cell_file.models.belts import PlantBelt
from gateway.files.table_model import Name, Percent, Table, unit


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
    stop_evidence: str = ""
    brake: Literal["drive", "gateway", "none"] = "drive"
    following_error: FollowingError | None = None
    home: Home = Home()
    first_enable: FirstEnable = FirstEnable()


_IN_UNITS = unit("{u}")


class Axis(AxisDefaults):
    name: Name
    unit: Literal["mm", "deg"]
    drive: Drive
    limits: AxisLimits
    mechanics: Mechanics = Mechanics()
    manual: bool = False
    modulo: float = Field(default=0.0, ge=0, json_schema_extra=_IN_UNITS)


class Defaults(Table):
    axis: AxisDefaults = AxisDefaults()


class Span(Table):
    from_: float = Field(alias="from", json_schema_extra=unit("{u}"))
    to: float = Field(json_schema_extra=unit("{u}"))


class PlantAxis(Table):
    start: float = Field(default=0.0, json_schema_extra=unit("{u}"))
    reference_switch: Span | None = None
    hard_limits: Span | None = None
    probe: Span | None = None
    settings: dict[str, float | bool] = {}


class Plant(Table):
    seed: int = Field(default=1, ge=0)
    axis: dict[str, PlantAxis] = {}
    belt: dict[str, PlantBelt] = {}
    absent: list[str] = []
