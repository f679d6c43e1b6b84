"""The edge of [[modbus]]: pydantic models of gateway.pure.cell.modbus."""

from typing import Annotated, Literal

from pydantic import Field

from gateway.files.table_model import BAUDS, Name, OnLoss, Table
from gateway.files.table_model import unit as in_unit

OWN_NAME = r"[a-z]\w*(\.\w+)+"  # as gateway.pure.image.addresses reads it
Order = Literal["ABCD", "CDAB", "BADC", "DCBA"]
Spans = list[Annotated[str, Field(pattern=r"^\d{1,5}(\.\.\d{1,5})?$", json_schema_extra={"allowed": '"0..63" or "7"'})]]
View = Literal["rho3", "registers", "reis", "val3"]


class ModbusRegisters(Table):
    at: int = Field(ge=0, le=65535)
    from_: str = Field(alias="from")
    type: Literal["", "INT16", "UINT16", "INT32", "UINT32", "REAL"] = ""


class ModbusUnit(Table):
    unit: int = Field(ge=1, le=247)
    view: View


class ModbusWriter(Table):
    from_: str = Field(alias="from")
    coils: Spans = []
    holding: Spans = []
    files: Spans = []


class ModbusRole(Table):
    role: str = Field(min_length=1)
    read: bool = True
    write: bool = False
    coils: Spans | None = None
    holding: Spans | None = None
    files: Spans | None = None


class ModbusTls(Table):
    certificate: str
    key: str
    ca: str


class ModbusLimits(Table):
    clients: int = Field(default=32, ge=1, le=1024)
    per_address: int = Field(default=16, ge=1, le=1024)
    receive_ms: int = Field(default=2000, ge=50, le=60_000, json_schema_extra=in_unit("ms"))
    stall_ms: int = Field(default=10_000, ge=100, le=600_000, json_schema_extra=in_unit("ms"))
    idle_ms: int = Field(default=0, ge=0, le=86_400_000, json_schema_extra=in_unit("ms"))


class ModbusDevice(Table):
    name: Name
    unit: int = Field(default=1, ge=0, le=255)
    timeout_ms: int = Field(default=500, ge=10, le=60_000, json_schema_extra=in_unit("ms"))
    pause_ms: int = Field(default=0, ge=0, le=60_000, json_schema_extra=in_unit("ms"))
    retries: int = Field(default=2, ge=0, le=20)
    busy_retries: int = Field(default=20, ge=0, le=1000)
    busy_pause_ms: int = Field(default=100, ge=1, le=60_000, json_schema_extra=in_unit("ms"))
    repeat_writes: bool = True
    demote_after: int = Field(default=2, ge=1, le=100)
    probe_ms: int = Field(default=2000, ge=100, le=3_600_000, json_schema_extra=in_unit("ms"))
    order: Order = "ABCD"
    most_words: int = Field(default=125, ge=1, le=125)
    most_bits: int = Field(default=2000, ge=1, le=2000)


class ModbusValue(Table):
    device: Name
    table: Literal["coil", "discrete", "input", "holding"]
    at: int = Field(ge=0, le=65535)
    type: Literal["bit", "INT16", "UINT16", "INT32", "UINT32", "INT64", "UINT64", "REAL", "LREAL"]
    to: str = Field(default="", pattern=rf"^({OWN_NAME})?$", json_schema_extra={"allowed": "a name of the cell's own, as tank.level"})
    from_: str = Field(
        default="", alias="from", pattern=rf"^({OWN_NAME})?$", json_schema_extra={"allowed": "a name of the cell's own, as tank.level"}
    )
    every_ms: int = Field(default=100, ge=5, le=3_600_000, json_schema_extra=in_unit("ms"))
    scale: float = 1.0


class Modbus(Table):
    name: Name
    role: Literal["server", "client"] = "server"
    framing: Literal["tcp", "rtu"] = "tcp"
    port_: str = Field(
        default="",
        alias="port",
        pattern=r"^(sim|/dev/\S+|COM\d+|pty:\S+|tcp://\S+:\d+|rfc2217://\S+:\d+)?$",
        json_schema_extra={"allowed": "sim | /dev/... | pty:/path | tcp://host:port (clients) | rfc2217://host:port"},
    )
    format: str = Field(
        default="9600 8E1", pattern=rf"^({BAUDS}) 8[NEO][12]$", json_schema_extra={"allowed": '"9600 8E1": baud, bits, parity, stop'}
    )
    patience_ms: int = Field(default=50, ge=0, le=1000, json_schema_extra=in_unit("ms"))
    bind: str = Field(default="127.0.0.1:1502", pattern=r"^\S+:\d{1,5}$", json_schema_extra={"allowed": "address:port"})
    unit: int = Field(default=1, ge=1, le=247)
    allow: list[str] = []
    view: View = "rho3"
    command_block: bool = False
    float: Order = "ABCD"
    first_address: int = Field(default=0, ge=0, le=1)
    max_silence_ms: int = Field(default=500, ge=50, le=60000, json_schema_extra={"unit": "ms"})
    on_loss: OnLoss = "stop_on_path"
    registers: list[ModbusRegisters] = []
    units: list[ModbusUnit] = []
    writers: list[ModbusWriter] = []
    roles: list[ModbusRole] = []
    tls: ModbusTls | None = None
    limits: ModbusLimits = ModbusLimits()
    device: list[ModbusDevice] = []
    value: list[ModbusValue] = []
