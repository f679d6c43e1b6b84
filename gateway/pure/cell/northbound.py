"""[northbound] of a cell: values for systems above, by a process of its own that only reads (AX-427); no table, no process."""

from dataclasses import dataclass

LOOPBACK = ("127.0.0.1", "::1", "localhost")


def place_of(bind: str) -> tuple[str, int]:
    """Host and port of "address:port"."""
    host, _, port = bind.rpartition(":")
    return host.strip("[]"), int(port)


@dataclass(frozen=True, slots=True)
class NorthMqtt:
    """[northbound.mqtt]: changed values to a broker, stored while it is away."""

    broker: str = "127.0.0.1:1883"
    topic: str = "axisgate"
    keep: int = 10000  # messages stored; the oldest is dropped and counted
    user: str = ""
    password_file: str = ""  # beside the cell file
    tls_ca: str = ""  # PEM beside the cell file; asked for beyond loopback


@dataclass(frozen=True, slots=True)
class NorthOpcua:
    """[northbound.opcua]: a server of read-only nodes; unencrypted, so on loopback alone."""

    bind: str = "127.0.0.1:4840"


@dataclass(frozen=True, slots=True)
class NorthMetrics:
    """[northbound.metrics]: /metrics, /health and /ready; on loopback unless `open`."""

    bind: str = "127.0.0.1:9480"
    open: bool = False  # reachable from other computers, unencrypted: written on purpose


@dataclass(frozen=True, slots=True)
class Northbound:
    """What goes out, and how often it is looked at."""

    period_ms: int = 1000
    mqtt: NorthMqtt | None = None
    opcua: NorthOpcua | None = None
    metrics: NorthMetrics | None = None
    journald: bool = False  # the journal of the run also to journald, with its fields
