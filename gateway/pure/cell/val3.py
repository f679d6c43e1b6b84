"""[val3] of a cell: the application of a CS8 that its interpreter runs (AX-930)."""

from dataclasses import dataclass
from typing import Annotated, Literal

from annotated_types import Ge, Le, MaxLen, MinLen

from gateway.pure.cell.marks import Unit

MODES = ("manual", "test", "local", "remote")


@dataclass(frozen=True, slots=True)
class Val3Channel:
    """[[val3.channel]]: a serial line or socket that sio variables link to."""

    name: Annotated[str, MinLen(1)]
    kind: Literal["serial", "client", "server", "udp"]
    address: str = "0.0.0.0"  # client: the server; server: the allowed client, 0.0.0.0 all; udp: the partner
    port: Annotated[int, Ge(0), Le(65535)] = 0
    bind: str = "0.0.0.0"  # local interface of a server or of UDP
    clients: Annotated[int, Ge(1), Le(64)] = 1
    end_of_string: Annotated[int, Ge(0), Le(255)] = 13
    timeout_s: Annotated[float, Ge(-1.0), Le(1e6)] = 0.0  # 0 waits for ever, -1 does not wait
    nagle: bool = True
    description: Annotated[str, MaxLen(200)] = ""
    # serial lines only; sioCtrl changes them
    baud_rate: Annotated[int, Ge(50), Le(4_000_000)] = 9600
    bits: Annotated[int, Ge(5), Le(8)] = 8
    parity: Literal["none", "even", "odd"] = "none"
    stop_bits: Annotated[int, Ge(1), Le(2)] = 1
    flow_control: Literal["none", "hardware"] = "none"


@dataclass(frozen=True, slots=True)
class Val3:
    """[val3]."""

    application: Annotated[str, MinLen(1)]  # its folder on the disk, or its .pjx file
    disk: str = "usrapp"  # folder that is Disk:// (on a CS8 usr/usrapp); relative to the cell file
    autostart: bool = False  # with the run, never again by itself
    mode: Literal["manual", "test", "local", "remote"] = "remote"
    system: str = ""  # getVersion("system"): s8.1cs9_B123, s7.9
    auto_connect: bool = False  # autoConnectMove as an application starts
    prompts: Literal["answered", "page"] = "answered"  # at once with OK or CANCEL, or by the operator on the page VAL 3
    watchdog_s: Annotated[float, Ge(0.0), Le(3600.0), Unit("s")] = 0.0  # val3WatchdogPeriod; 0: there is none, wdgRefresh is error 45
    strict_priorities: bool = False  # a priority for each operator, as the tables of the manual list them
    channel: tuple[Val3Channel, ...] = ()
