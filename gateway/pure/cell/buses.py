"""[[bus]] and [[io]] of a cell: CAN buses, and real contacts at the gateway.  Shapes: users.md 3.4."""

from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Le

from gateway.pure.cell.marks import Name, Pattern, Registered, Unit

ADAPTER = r"[a-z][a-z0-9_-]*:[^@?]+(@\d+)?(\?[^?]+)?"  # drivers.ports.can.adapter_url
PORTS = "sim | socketcan:can0 | broker:NAME | slcan:/dev/ttyACM0, pcan:PCAN_USBBUS1, ... (python-can)"
BusPort = Annotated[str, Pattern(rf"^(sim|{ADAPTER})$", PORTS)]  # of our own kinds the rest is judged in checks.buses


@dataclass(frozen=True, slots=True)
class IoDevice:
    """Inline table `device` of [[io]]."""

    type: Literal["canopen-401", "modbus", "gpiochip"]
    bus: str = ""  # canopen-401
    node: Annotated[int | None, Ge(1), Le(127)] = None
    input: Annotated[int | None, Ge(0), Le(65535)] = None  # channel; of a gpiochip its line
    output: Annotated[int | None, Ge(0), Le(65535)] = None
    # modbus: tcp://host:502, or rtu:/dev/ttyUSB0
    url: Annotated[str, Pattern(r"^(tcp://\S+:\d+|rtu:\S+)?$", "tcp://host:502 | rtu:/dev/ttyUSB0")] = ""
    unit: Annotated[int, Ge(0), Le(255)] = 1
    poll_ms: Annotated[int, Ge(5), Le(60000), Unit("ms")] = 50
    chip: str = ""  # gpiochip: /dev/gpiochip0, or its label
    active_low: bool = False


@dataclass(frozen=True, slots=True)
class Io:
    """[[io]]: a real contact at the gateway."""

    name: Name
    device: IoDevice
    signal: str  # an output's `io.NAME` leaves it to a route
    on_loss: Annotated[int | None, Ge(0), Le(1)] = None
    toggle_ms: Annotated[int, Ge(2), Le(10000), Unit("ms")] = 20  # cell.watchdog: time between two toggles


@dataclass(frozen=True, slots=True)
class Bus:
    """[[bus]]: a CAN bus."""

    name: Name
    port: BusPort
    protocol: Annotated[str, Registered("bus protocols")]
    bitrate: Literal["1 Mbit/s", "500 kbit/s", "250 kbit/s", "125 kbit/s"] = "1 Mbit/s"
    cycle_ms: Annotated[int, Ge(2), Le(32), Unit("ms")] = 4
    heartbeat_ms: Annotated[int, Ge(10), Le(1000), Unit("ms")] = 50
    layout: str = "servodyn_gc.dbc"
    layout_evidence: str = ""
    axes: Annotated[str, Pattern(r"^([1-6](\.\.[1-6])?)?$", '"1..6"')] = ""  # "1..6": module numbers on this bus
    on_loss: Literal["zero", "hold"] = "zero"
    # rho3-io: a coupled control silent for this long is an error; 0: not supervised (rho3 2.5)
    coupling_ms: Annotated[int, Ge(0), Le(60000), Unit("ms")] = 300

    @property
    def simulated(self) -> bool:
        """True where no metal can hang on the bus."""
        return self.port == "sim" or self.port.startswith(("broker:", "memory:", "socketcan:vcan"))

    @property
    def bits_per_s(self) -> int:
        """1 Mbit/s -> 1000000."""
        number, unit = self.bitrate.split()
        return int(number) * (1_000_000 if unit == "Mbit/s" else 1000)
