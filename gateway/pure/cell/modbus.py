"""[[modbus]] of a cell file as plain frozen data: servers (command sources) and clients (devices of others that we ask)."""

from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Le, MinLen

from gateway.pure.cell.marks import BAUDS, OWN_NAME, Bind, Name, OnLoss, Pattern, Registered, Unit
from gateway.pure.cell.web import LOOPBACK

ByteOrder = Literal["ABCD", "CDAB", "BADC", "DCBA"]
Spans = tuple[Annotated[str, Pattern(r"^\d{1,5}(\.\.\d{1,5})?$", '"0..63" or "7"')], ...]
PORTS = "sim | /dev/... | pty:/path | tcp://host:port (clients) | rfc2217://host:port"
ModbusPort = Annotated[str, Pattern(r"^(sim|/dev/\S+|COM\d+|pty:\S+|tcp://\S+:\d+|rfc2217://\S+:\d+)?$", PORTS)]
ModbusTable = Literal["coil", "discrete", "input", "holding"]
ModbusForm = Literal["bit", "INT16", "UINT16", "INT32", "UINT32", "INT64", "UINT64", "REAL", "LREAL"]
View = Annotated[str, Registered("Modbus views")]


@dataclass(frozen=True, slots=True)
class ModbusRegisters:
    """One [[modbus.registers]] table: values in addition to the view, readable as holding and as input registers."""

    at: Annotated[int, Ge(0), Le(65535)]
    from_: str
    # INT16 UINT16 INT32 UINT32 REAL; "": REAL for measured values, else UINT16 (AX-347)
    type: Literal["", "INT16", "UINT16", "INT32", "UINT32", "REAL"] = ""


@dataclass(frozen=True, slots=True)
class ModbusUnit:
    """One [[modbus.units]] table: a further unit id of the same server and what it shows."""

    unit: Annotated[int, Ge(1), Le(247)]
    view: View


@dataclass(frozen=True, slots=True)
class ModbusWriter:
    """One [[modbus.writers]] table: who may write where; "first..last" or "n"."""

    from_: str  # an address or a network
    coils: Spans = ()
    holding: Spans = ()
    files: Spans = ()  # data blocks, FC 21


@dataclass(frozen=True, slots=True)
class ModbusRole:
    """One [[modbus.roles]] table: what a role in a client's certificate may do."""

    role: Annotated[str, MinLen(1)]
    read: bool = True
    write: bool = False
    coils: Spans | None = None  # None: all
    holding: Spans | None = None
    files: Spans | None = None  # None: all where coils and holding are left out too, else none


@dataclass(frozen=True, slots=True)
class ModbusTls:
    """[modbus.tls]: Modbus/TCP Security; PEM files, searched next to the cell file."""

    certificate: str
    key: str
    ca: str  # of the clients: only clients with a certificate signed by it are accepted


@dataclass(frozen=True, slots=True)
class ModbusLimits:
    """[modbus.limits]: what one server and each of its clients may use (AX-073)."""

    clients: Annotated[int, Ge(1), Le(1024)] = 32
    per_address: Annotated[int, Ge(1), Le(1024)] = 16  # connections of one address
    receive_ms: Annotated[int, Ge(50), Le(60000), Unit("ms")] = 2000  # a frame's first byte to its last
    stall_ms: Annotated[int, Ge(100), Le(600000), Unit("ms")] = 10_000  # how long a client may leave answers unread
    idle_ms: Annotated[int, Ge(0), Le(86_400_000), Unit("ms")] = 0  # no byte at all; 0: idle clients stay


@dataclass(frozen=True, slots=True)
class ModbusDevice:
    """One [[modbus.device]] table of a client."""

    name: Name
    unit: Annotated[int, Ge(0), Le(255)] = 1
    timeout_ms: Annotated[int, Ge(10), Le(60000), Unit("ms")] = 500
    pause_ms: Annotated[int, Ge(0), Le(60000), Unit("ms")] = 0
    retries: Annotated[int, Ge(0), Le(20)] = 2
    busy_retries: Annotated[int, Ge(0), Le(1000)] = 20
    busy_pause_ms: Annotated[int, Ge(1), Le(60000), Unit("ms")] = 100
    repeat_writes: bool = True
    demote_after: Annotated[int, Ge(1), Le(100)] = 2
    probe_ms: Annotated[int, Ge(100), Le(3_600_000), Unit("ms")] = 2000
    order: ByteOrder = "ABCD"  # word and byte order of its wide values
    most_words: Annotated[int, Ge(1), Le(125)] = 125
    most_bits: Annotated[int, Ge(1), Le(2000)] = 2000


@dataclass(frozen=True, slots=True)
class ModbusValue:
    """One [[modbus.value]] table of a client: a value of a device and the named value it goes to or comes from."""

    device: Name
    table: ModbusTable
    at: Annotated[int, Ge(0), Le(65535)]  # protocol address, base 0
    type: ModbusForm
    to: Annotated[str, Pattern(f"^({OWN_NAME})?$", "a name of the cell's own, as tank.level")] = ""  # read every `every_ms` into this name
    # written when this name changes, and every `every_ms`
    from_: Annotated[str, Pattern(f"^({OWN_NAME})?$", "a name of the cell's own, as tank.level")] = ""
    every_ms: Annotated[int, Ge(5), Le(3_600_000), Unit("ms")] = 100
    scale: float = 1.0  # value = number x scale

    @property
    def name(self) -> str:
        return self.to or self.from_


@dataclass(frozen=True, slots=True)
class Modbus:
    """[[modbus]]: a server (one command source) or a client."""

    name: Name
    role: Literal["server", "client"] = "server"
    framing: Literal["tcp", "rtu"] = "tcp"  # tcp | rtu: RTU on a serial port, or over TCP where there is none
    # serial port of RTU; client: "tcp://host:port" as well
    port_: ModbusPort = ""
    format: Annotated[str, Pattern(f"^({BAUDS}) 8[NEO][12]$", '"9600 8E1": baud, bits, parity, stop')] = "9600 8E1"
    patience_ms: Annotated[int, Ge(0), Le(1000), Unit("ms")] = 50
    # server
    bind: Bind = "127.0.0.1:1502"
    unit: Annotated[int, Ge(1), Le(247)] = 1
    allow: tuple[str, ...] = ()  # clients that may write; empty: everybody who reaches the bound address
    view: View = "rho3"
    command_block: bool = False
    float: ByteOrder = "ABCD"
    first_address: Annotated[int, Ge(0), Le(1)] = 0
    max_silence_ms: Annotated[int, Ge(50), Le(60000), Unit("ms")] = 500
    on_loss: OnLoss = "stop_on_path"
    registers: tuple[ModbusRegisters, ...] = ()
    units: tuple[ModbusUnit, ...] = ()
    writers: tuple[ModbusWriter, ...] = ()
    roles: tuple[ModbusRole, ...] = ()
    tls: ModbusTls | None = None
    limits: ModbusLimits = ModbusLimits()
    # client
    device: tuple[ModbusDevice, ...] = ()
    value: tuple[ModbusValue, ...] = ()

    @property
    def host(self) -> str:
        return self.bind.rsplit(":", 1)[0]

    @property
    def port(self) -> int:
        return int(self.bind.rsplit(":", 1)[1])

    @property
    def local(self) -> bool:
        """Only programs of this computer reach it."""
        return self.host.strip("[]") in LOOPBACK or self.host.startswith("127.")

    @property
    def serial(self) -> bool:
        """RTU on a serial port."""
        return self.port_ != "" and not self.port_.startswith("tcp://")
