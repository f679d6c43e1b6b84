"""[[modbus]] of a cell file as plain frozen data: servers (command sources) and clients (devices of others that we ask)."""

from dataclasses import dataclass

from gateway.pure.cell.web import LOOPBACK


@dataclass(frozen=True, slots=True)
class ModbusRegisters:
    """One [[modbus.registers]] table: values beside the view, readable as holding and as input registers."""

    at: int
    from_: str
    type: str = ""  # INT16 UINT16 INT32 UINT32 REAL; "": REAL for measured values, else UINT16 (AX-347)


@dataclass(frozen=True, slots=True)
class ModbusUnit:
    """One [[modbus.units]] table: a further unit id of the same server and what it shows."""

    unit: int
    view: str


@dataclass(frozen=True, slots=True)
class ModbusWriter:
    """One [[modbus.writers]] table: who may write where; "first..last" or "n"."""

    from_: str  # an address or a network
    coils: tuple[str, ...] = ()
    holding: tuple[str, ...] = ()
    files: tuple[str, ...] = ()  # data blocks, FC 21


@dataclass(frozen=True, slots=True)
class ModbusRole:
    """One [[modbus.roles]] table: what a role in a client's certificate may do."""

    role: str
    read: bool = True
    write: bool = False
    coils: tuple[str, ...] | None = None  # None: all
    holding: tuple[str, ...] | None = None
    files: tuple[str, ...] | None = None  # None: all where coils and holding are left out too, else none


@dataclass(frozen=True, slots=True)
class ModbusTls:
    """[modbus.tls]: Modbus/TCP Security; PEM files, looked for beside the cell file."""

    certificate: str
    key: str
    ca: str  # of the clients: without a certificate it signed nobody is heard


@dataclass(frozen=True, slots=True)
class ModbusLimits:
    """[modbus.limits]: what one server and each of its clients may use (AX-073)."""

    clients: int = 32
    per_address: int = 16  # connections of one address
    receive_ms: int = 2000  # a frame's first byte to its last
    stall_ms: int = 10_000  # answers waiting and nobody taking them
    idle_ms: int = 0  # no byte at all; 0: idle clients stay


@dataclass(frozen=True, slots=True)
class ModbusDevice:
    """One [[modbus.device]] table of a client."""

    name: str
    unit: int = 1
    timeout_ms: int = 500
    pause_ms: int = 0
    retries: int = 2
    busy_retries: int = 20
    busy_pause_ms: int = 100
    repeat_writes: bool = True
    demote_after: int = 2
    probe_ms: int = 2000
    order: str = "ABCD"  # word and byte order of its wide values
    most_words: int = 125
    most_bits: int = 2000


@dataclass(frozen=True, slots=True)
class ModbusValue:
    """One [[modbus.value]] table of a client: a value of a device and the named value it goes to or comes from."""

    device: str
    table: str  # coil | discrete | input | holding
    at: int  # protocol address, base 0
    type: str  # bit INT16 UINT16 INT32 UINT32 INT64 UINT64 REAL LREAL
    to: str = ""  # read every `every_ms` into this name
    from_: str = ""  # written when this name changes, and every `every_ms`
    every_ms: int = 100
    scale: float = 1.0  # value = number x scale

    @property
    def name(self) -> str:
        return self.to or self.from_


@dataclass(frozen=True, slots=True)
class Modbus:
    """[[modbus]]: a server (one command source) or a client."""

    name: str
    role: str = "server"  # server | client
    framing: str = "tcp"  # tcp | rtu: RTU on a serial port, or over TCP where there is none
    port_: str = ""  # serial port of RTU; client: "tcp://host:port" as well
    format: str = "9600 8E1"
    patience_ms: int = 50
    # server
    bind: str = "127.0.0.1:1502"
    unit: int = 1
    allow: tuple[str, ...] = ()  # clients that may write; empty: everybody who reaches the bound address
    view: str = "rho3"
    command_block: bool = False
    float: str = "ABCD"
    first_address: int = 0
    max_silence_ms: int = 500
    on_loss: str = "stop_on_path"
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
