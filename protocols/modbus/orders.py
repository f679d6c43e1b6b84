"""Requests and events of a Modbus client: devices with their properties, polled groups, events.

Sources: V1.1b3, section 7 (05 and 06); serial line guide, 2.4.1.
"""

from dataclasses import dataclass
from enum import Enum, auto

from protocols.base.machine import Ns, ms
from protocols.modbus.view import Kind

READ_FUNCTIONS = {Kind.COILS: 1, Kind.DISCRETE_INPUTS: 2, Kind.HOLDING_REGISTERS: 3, Kind.INPUT_REGISTERS: 4}
READS = (1, 2, 3, 4, 7, 11, 12, 17, 20, 24, 43)
MOST = {Kind.COILS: 2000, Kind.DISCRETE_INPUTS: 2000, Kind.HOLDING_REGISTERS: 125, Kind.INPUT_REGISTERS: 125}


@dataclass(frozen=True, slots=True)
class Device:
    """One device and its limits."""

    name: str
    unit: int = 1
    timeout: Ns = ms(500)  # from the last byte of the request to the answer
    pause: Ns = 0  # after its answer or time-out before its next request
    retries: int = 2  # after a time-out or a damaged answer; the first attempt does not count
    busy_retries: int = 20  # after 05 or 06
    busy_pause: Ns = ms(100)
    repeat_writes: bool = True  # False: a write without an answer is never sent again, it may have been done
    demote_after: int = 2  # requests in a row that failed with all their retries
    probe_every: Ns = ms(2000)  # so a device is back 2 s after it answers again
    most_words: int = 125  # of one read: some devices accept fewer
    most_bits: int = 2000


@dataclass(frozen=True, slots=True)
class Group:
    """Values read together, again and again."""

    name: str
    device: str
    kind: Kind
    address: int
    count: int
    every: Ns


class Failure(Enum):
    """Why an order has no answer."""

    TIMEOUT = auto()
    SPOILED = auto()
    LOST = auto()  # the connection or line went away
    DEAD = auto()  # the device is demoted and was not polled
    FULL = auto()  # too many orders wait for this device


@dataclass(frozen=True, slots=True)
class Done:
    """An order was answered; `pdu` is the answer (b"" to a broadcast)."""

    order: int
    device: str
    pdu: bytes


@dataclass(frozen=True, slots=True)
class Refused:
    """An order was answered by an exception (05 to a write: accepted, not finished yet)."""

    order: int
    device: str
    code: int


@dataclass(frozen=True, slots=True)
class Failed:
    """An order was not answered."""

    order: int
    device: str
    why: Failure


@dataclass(frozen=True, slots=True)
class Polled:
    """A group was read completely; bits are 0 and 1."""

    group: str
    values: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class PollFailed:
    """A group could not be read: a failure, or the exception the device answered."""

    group: str
    why: Failure | int


@dataclass(frozen=True, slots=True)
class DeviceLost:
    """Demoted."""

    device: str


@dataclass(frozen=True, slots=True)
class DeviceBack:
    """Answers (again, or for the first time)."""

    device: str


Event = Done | Refused | Failed | Polled | PollFailed | DeviceLost | DeviceBack


def read_pdu(kind: Kind, address: int, count: int) -> bytes:
    """The request to read `count` values from `address` on."""
    return bytes((READ_FUNCTIONS[kind], *address.to_bytes(2, "big"), *count.to_bytes(2, "big")))


def values_of(pdu: bytes, count: int) -> tuple[int, ...] | None:
    """The values of an answer to FC 1 to 4; None when it does not hold just that many."""
    bits = pdu[0] in (1, 2)
    size = (count + 7) // 8 if bits else 2 * count
    if len(pdu) != 2 + size or pdu[1] != size:
        return None
    data = pdu[2:]
    if bits:
        return tuple(data[n >> 3] >> (n & 7) & 1 for n in range(count))
    return tuple(data[2 * n] << 8 | data[2 * n + 1] for n in range(count))
