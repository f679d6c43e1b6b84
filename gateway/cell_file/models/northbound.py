"""The edge of [northbound]: pydantic models of gateway.pure.cell.northbound."""

from typing import Annotated

from pydantic import Field

from gateway.files.table_model import Table

Bind = Annotated[str, Field(pattern=r"^\S+:\d{1,5}$", json_schema_extra={"allowed": "address:port"})]


class NorthMqtt(Table):
    broker: Bind = "127.0.0.1:1883"
    topic: str = Field(default="axisgate", pattern=r"^[^#+\s]+$", json_schema_extra={"allowed": "a topic without # and +"})
    keep: int = Field(default=10000, ge=1, le=1_000_000, json_schema_extra={"unit": "messages"})
    user: str = ""
    password_file: str = ""
    tls_ca: str = ""


class NorthOpcua(Table):
    bind: Bind = "127.0.0.1:4840"


class NorthMetrics(Table):
    bind: Bind = "127.0.0.1:9480"
    open: bool = False


class Northbound(Table):
    period_ms: int = Field(default=1000, ge=100, le=3_600_000, json_schema_extra={"unit": "ms"})
    mqtt: NorthMqtt | None = None
    opcua: NorthOpcua | None = None
    metrics: NorthMetrics | None = None
    journald: bool = False
