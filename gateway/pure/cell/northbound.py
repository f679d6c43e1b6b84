"""[northbound] of a cell: values for systems above, by a process of its own that only reads (AX-427); no table, no process."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Le

from gateway.pure.cell.marks import Bind, Pattern, Unit

LOOPBACK = ("127.0.0.1", "::1", "localhost")


def place_of(bind: str) -> tuple[str, int]:
    """Host and port of "address:port"."""
    host, _, port = bind.rpartition(":")
    return host.strip("[]"), int(port)


@dataclass(frozen=True, slots=True)
class NorthMqtt:
    """[northbound.mqtt]: changed values to a broker, stored while it is away."""

    broker: Bind = "127.0.0.1:1883"
    topic: Annotated[str, Pattern(r"^[^#+\s]+$", "a topic without # and +")] = "axisgate"
    keep: Annotated[int, Ge(1), Le(1_000_000), Unit("messages")] = 10000  # messages stored; the oldest is dropped and counted
    user: str = ""
    password_file: str = ""  # next to the cell file
    tls_ca: str = ""  # PEM next to the cell file; required beyond loopback


@dataclass(frozen=True, slots=True)
class NorthOpcua:
    """[northbound.opcua]: a server of read-only nodes; unencrypted, so on loopback only."""

    bind: Bind = "127.0.0.1:4840"


@dataclass(frozen=True, slots=True)
class NorthMetrics:
    """[northbound.metrics]: /metrics, /health and /ready; on loopback unless `open`."""

    bind: Bind = "127.0.0.1:9480"
    open: bool = False  # reachable from other computers, unencrypted: written on purpose


@dataclass(frozen=True, slots=True)
class Northbound:
    """What goes out, and how often it is looked at."""

    period_ms: Annotated[int, Ge(100), Le(3_600_000), Unit("ms")] = 1000
    mqtt: NorthMqtt | None = None
    opcua: NorthOpcua | None = None
    metrics: NorthMetrics | None = None
    journald: bool = False  # the journal of the run also to journald, with its fields
