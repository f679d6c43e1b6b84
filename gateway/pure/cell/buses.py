"""[[bus]] and [[io]] of a cell: CAN buses, and real contacts at the gateway.  Shapes: users.md 3.4."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class IoDevice:
    """Inline table `device` of [[io]]."""

    type: str  # canopen-401 | modbus | gpiochip
    bus: str = ""  # canopen-401
    node: int | None = None
    input: int | None = None  # channel; of a gpiochip its line
    output: int | None = None
    url: str = ""  # modbus: tcp://host:502, or rtu:/dev/ttyUSB0
    unit: int = 1
    poll_ms: int = 50
    chip: str = ""  # gpiochip: /dev/gpiochip0, or its label
    active_low: bool = False


@dataclass(frozen=True, slots=True)
class Io:
    """[[io]]: a real contact at the gateway."""

    name: str
    device: IoDevice
    signal: str  # an output's `io.NAME` leaves it to a route
    on_loss: int | None = None
    toggle_ms: int = 20  # cell.watchdog: time between two toggles


@dataclass(frozen=True, slots=True)
class Bus:
    """[[bus]]: a CAN bus."""

    name: str
    port: str
    protocol: str  # servodyn | canopen | rho3-io
    bitrate: str = "1 Mbit/s"
    cycle_ms: int = 4
    heartbeat_ms: int = 50
    layout: str = "servodyn_gc.dbc"
    layout_evidence: str = ""
    axes: str = ""  # "1..6": module numbers on this bus
    on_loss: str = "zero"
    coupling_ms: int = 300  # rho3-io: a coupled control silent for so long is an error; 0: not supervised (rho3 2.5)

    @property
    def simulated(self) -> bool:
        """True where no metal can hang on the bus."""
        return self.port == "sim" or self.port.startswith(("broker:", "memory:", "socketcan:vcan"))

    @property
    def bits_per_s(self) -> int:
        """1 Mbit/s -> 1000000."""
        number, unit = self.bitrate.split()
        return int(number) * (1_000_000 if unit == "Mbit/s" else 1000)
