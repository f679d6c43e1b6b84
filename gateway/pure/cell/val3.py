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
class Val3UserIo:
    """[val3.user_io]: how user boards are refreshed, as cell.cfx has it (AX-1060)."""

    mode: Literal["default", "noJitter"] = "default"
    ratio: Annotated[int, Ge(-1), Le(250)] = -1  # system cycles of 4 ms from one refresh to the next; -1 and 0: each


@dataclass(frozen=True, slots=True)
class Val3Board:
    """[[val3.board]]: a user board with a refresh time."""

    name: Annotated[str, MinLen(1)]
    refresh_us: Annotated[float, Ge(0.0), Le(1e6), Unit("us")]


@dataclass(frozen=True, slots=True)
class Val3Service:
    """[val3.service]: what brakeTest, hibernateRobot and wakeUpRobot answer (AX-1061)."""

    brakes: tuple[Annotated[int, Ge(0), Le(2)], ...] = ()  # of each axis: 0 holds, 1 not tested, 2 does not hold; none: no data
    brake_position: tuple[float, ...] = ()  # in which brakeTest is made, in deg and mm; none: in any
    hibernate: Annotated[int, Ge(-4), Le(0)] = -1  # 0, -1 not supported, -2 safety board, -4 encoders
    wake: Annotated[int, Ge(-3), Le(0)] = 0  # 0, -1 not supported, -2 encoders, -3 safety board


@dataclass(frozen=True, slots=True)
class Val3Profile:
    """[[val3.profile]]: a user profile in addition to "default", for setProfile."""

    name: Annotated[str, MinLen(1)]
    password: str = ""


@dataclass(frozen=True, slots=True)
class Val3Licence:
    """[[val3.licence]]: an OEM licence, for getLicence."""

    name: Annotated[str, MinLen(1)]
    text: str = "enabled"


@dataclass(frozen=True, slots=True)
class Val3Reference:
    """[[val3.reference]]: a joint reference, for getJntRef."""

    name: Annotated[str, MinLen(1)]
    joints: tuple[float, ...]  # in deg and mm


@dataclass(frozen=True, slots=True)
class Val3:
    """[val3]."""

    application: Annotated[str, MinLen(1)]  # its folder on the disk, or its .pjx file
    disk: str = "usrapp"  # folder that is Disk:// (on a CS8 usr/usrapp); relative to the cell file
    autostart: bool = False  # once, with the run
    mode: Literal["manual", "test", "local", "remote"] = "remote"
    system: str = ""  # getVersion("system"): s8.1cs9_B123, s7.9
    auto_connect: bool = False  # autoConnectMove as an application starts
    prompts: Literal["answered", "page"] = "answered"  # at once with OK or CANCEL, or by the operator on the page VAL 3
    watchdog_s: Annotated[float, Ge(0.0), Le(3600.0), Unit("s")] = 0.0  # val3WatchdogPeriod; 0: there is none, wdgRefresh is error 45
    strict_priorities: bool = False  # a priority for each operator, as the tables of the manual list them
    current_profile: str = "default"  # getProfile as the controller starts
    options: tuple[str, ...] = ()  # licences that getVersion(name) calls enabled
    channel: tuple[Val3Channel, ...] = ()
    board: tuple[Val3Board, ...] = ()
    profile: tuple[Val3Profile, ...] = ()
    reference: tuple[Val3Reference, ...] = ()
    licence: tuple[Val3Licence, ...] = ()
    user_io: Val3UserIo | None = None
    service: Val3Service = Val3Service()
