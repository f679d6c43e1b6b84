"""A channel as it is declared at the controller: kind and parameters.  Source: VAL 3 manual, 3.7.1.2 and table of sioCtrl."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum, auto

from protocols.base.machine import Ns

ANY = "0.0.0.0"
LONGEST_S = 1_000_000.0  # longest time-out taken, eleven days; 0 waits for ever
READ_BUFFER = 65536  # bytes a connection keeps for its readers (AX-184)


class Kind(Enum):
    SERIAL, TCP_CLIENT, TCP_SERVER, UDP = auto(), auto(), auto(), auto()


SOCKETS = frozenset({Kind.TCP_CLIENT, Kind.TCP_SERVER, Kind.UDP})
TCP = frozenset({Kind.TCP_CLIENT, Kind.TCP_SERVER})


@dataclass(frozen=True, slots=True)
class Channel:
    """One system I/O that sio variables link to; a parameter another kind would need is simply not looked at."""

    name: str  # the link, usually "Socket\\name" or "Serial\\name"
    kind: Kind
    description: str = ""
    address: str = ANY  # client: the server; server: the allowed client, 0.0.0.0 all; UDP: the partner, 0.0.0.0, x.x.255.255
    port: int = 0  # IP port; UDP: ours and the partner's
    bind: str = ANY  # local interface of a server or UDP socket; not in the manual (AX-186)
    clients: int = 1  # server: clients at the same time
    end_of_string: int = 13  # byte 0..255 that ends a string
    timeout_s: float = 0.0  # 0 waits for ever, > 0 seconds, -1 does not wait
    nagle: bool = True
    device: str = ""  # serial: address for drivers.ports.open
    baud_rate: int = 9600
    parity: str = "none"  # none, even, odd
    bits: int = 8
    stop_bits: int = 1
    mode: str = "rs232"
    flow_control: str = "none"  # none, hardware

    @property
    def broadcasts(self) -> bool:
        """UDP: x.x.255.255 sends and receives broadcasts only (3.7.1.2)."""
        return self.kind is Kind.UDP and self.address.endswith(".255.255")

    @property
    def frame(self) -> str:
        """Serial: "9600 8N1"."""
        return f"{self.baud_rate} {self.bits}{self.parity[0].upper()}{self.stop_bits}"

    def faults(self) -> list[str]:
        """What is wrong with the declaration, in words; [] when it can be played."""
        checks = [
            (not self.name, "name is empty"),
            (not 0 <= self.end_of_string <= 255, f"end_of_string {self.end_of_string}: 0..255 expected"),
            (not timeout_is_legal(self.timeout_s), f"timeout_s {self.timeout_s}: 0, -1 or up to {LONGEST_S:.0f} s expected"),
            (self.kind in SOCKETS and not 1 <= self.port <= 65535, f"port {self.port}: 1..65535 expected"),
            (self.kind in SOCKETS and not is_ipv4(self.address), f'address "{self.address}": IPv4 address expected'),
            (self.kind in SOCKETS and not is_ipv4(self.bind), f'bind "{self.bind}": IPv4 address expected'),
            (self.kind is Kind.TCP_CLIENT and self.address == ANY, "address 0.0.0.0: a client needs the address of its server"),
            (self.kind is Kind.TCP_SERVER and self.clients < 1, f"clients {self.clients}: 1 or more expected"),
            (self.kind is Kind.SERIAL and not self.device, "device is empty: address of the serial port expected"),
        ]
        return [f"sio channel {self.name}: {text}" for wrong, text in checks if wrong]


def is_ipv4(text: str) -> bool:
    """Four decimal numbers 0..255."""
    parts = text.split(".")
    return len(parts) == 4 and all(part.isascii() and part.isdecimal() and len(part) <= 3 and int(part) <= 255 for part in parts)


def timeout_is_legal(seconds: float) -> bool:
    """0, -1 or a positive number (AX-182)."""
    return math.isfinite(seconds) and (seconds == -1 or 0 <= seconds <= LONGEST_S)


def deadline_of(timeout_s: float, now: Ns) -> Ns | None:
    """When an instruction started `now` stops waiting: never for 0, at once for -1 (3.7.1.2, Timeout)."""
    if timeout_s == 0:
        return None
    return now if timeout_s < 0 else now + max(1, round(timeout_s * 1_000_000_000))


def channel_named(channels: Iterable[Channel], link: str) -> str | None:
    """The channel a link leads to: its path or its last name, in any case; of two names that differ in nothing else the one as written."""
    wanted = link.replace("/", "\\")
    names = [channel.name for channel in channels]
    last = wanted.rpartition("\\")[2]
    ways: tuple[Callable[[str], bool], ...] = (
        lambda name: name == wanted,
        lambda name: name.lower() == wanted.lower(),
        lambda name: name.rpartition("\\")[2] == last,
        lambda name: name.lower().rpartition("\\")[2] == last.lower(),
    )
    return next((name for fits in ways for name in names if fits(name)), None)
