"""The edge of [[bus]] and [[io]]: pydantic models of gateway.pure.cell.buses."""

from typing import Literal

from pydantic import Field

from gateway.files.table_model import Name, Table, unit

ADAPTER = r"[a-z][a-z0-9_-]*:[^@?]+(@\d+)?(\?[^?]+)?"  # drivers.ports.can.adapter_url


class IoDevice(Table):
    type: Literal["canopen-401", "modbus", "gpiochip"]
    bus: str = ""
    node: int | None = Field(default=None, ge=1, le=127)
    input: int | None = Field(default=None, ge=0, le=65535)
    output: int | None = Field(default=None, ge=0, le=65535)
    url: str = Field(default="", pattern=r"^(tcp://\S+:\d+|rtu:\S+)?$", json_schema_extra={"allowed": "tcp://host:502 | rtu:/dev/ttyUSB0"})
    poll_ms: int = Field(default=50, ge=5, le=60000, json_schema_extra=unit("ms"))
    chip: str = ""
    active_low: bool = False
    unit: int = Field(default=1, ge=0, le=255)  # last: it hides the function


class Io(Table):
    name: Name
    device: IoDevice
    signal: str
    on_loss: int | None = Field(default=None, ge=0, le=1)
    toggle_ms: int = Field(default=20, ge=2, le=10000, json_schema_extra=unit("ms"))


class Bus(Table):
    name: Name
    port: str = Field(
        pattern=rf"^(sim|{ADAPTER})$",  # of our own kinds the rest is judged in checks.buses
        json_schema_extra={"allowed": "sim | socketcan:can0 | broker:NAME | slcan:/dev/ttyACM0, pcan:PCAN_USBBUS1, ... (python-can)"},
    )
    protocol: Literal["servodyn", "canopen", "rho3-io"]
    bitrate: Literal["1 Mbit/s", "500 kbit/s", "250 kbit/s", "125 kbit/s"] = "1 Mbit/s"
    cycle_ms: int = Field(default=4, ge=2, le=32, json_schema_extra=unit("ms"))
    heartbeat_ms: int = Field(default=50, ge=10, le=1000, json_schema_extra=unit("ms"))
    layout: str = "servodyn_gc.dbc"
    layout_evidence: str = ""
    axes: str = Field(default="", pattern=r"^([1-6](\.\.[1-6])?)?$", json_schema_extra={"allowed": '"1..6"'})
    on_loss: Literal["zero", "hold"] = "zero"
    coupling_ms: int = Field(default=300, ge=0, le=60000, json_schema_extra=unit("ms"))
