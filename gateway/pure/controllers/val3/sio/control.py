"""sioCtrl: which parameter accepts which value on which channel.  Source: VAL 3 manual, 3.7.3, sioCtrl."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Generic, TypeVar

from gateway.pure.controllers.val3.sio.channel import ANY, SOCKETS, TCP, Channel, Kind, is_ipv4, timeout_is_legal

V = TypeVar("V", float, str, bool)
Value = float | str | bool  # VAL 3 num, string, bool


class Code(IntEnum):
    """What sioCtrl returns."""

    CHANGED = 0
    UNKNOWN = -1
    WRONG_TYPE = -2
    UNSUPPORTED = -3
    BUSY = -4
    NOT_HERE = -5


@dataclass(frozen=True, slots=True)
class Row(Generic[V]):
    """One row of the manual's table."""

    kinds: frozenset[Kind]
    takes: Callable[[V], bool]
    put: Callable[[Channel, V], Channel]
    stopped: bool = False  # only while the channel rests


SERIAL = frozenset({Kind.SERIAL})
CLIENT, SERVER = frozenset({Kind.TCP_CLIENT}), frozenset({Kind.TCP_SERVER})
EVERY = SOCKETS | SERIAL  # endOfString and timeout on UDP too: doubt D38, AX-182


def _integer(low: int, high: int) -> Callable[[float], bool]:
    return lambda number: low <= number <= high and float(number).is_integer()


def _one_of(*words: str) -> Callable[[str], bool]:
    return lambda text: text in words


NUMS: dict[str, Row[float]] = {
    "port": Row(TCP, _integer(1, 65535), lambda channel, number: replace(channel, port=int(number)), stopped=True),
    "clients": Row(SERVER, _integer(1, 64), lambda channel, number: replace(channel, clients=int(number)), stopped=True),
    "endOfString": Row(EVERY, _integer(0, 255), lambda channel, number: replace(channel, end_of_string=int(number))),
    "timeout": Row(EVERY, timeout_is_legal, lambda channel, number: replace(channel, timeout_s=float(number))),
    "baudRate": Row(SERIAL, _integer(50, 4_000_000), lambda channel, number: replace(channel, baud_rate=int(number)), stopped=True),
    "bits": Row(SERIAL, _integer(5, 8), lambda channel, number: replace(channel, bits=int(number)), stopped=True),
    "stopBits": Row(SERIAL, _integer(1, 2), lambda channel, number: replace(channel, stop_bits=int(number)), stopped=True),
}
STRINGS: dict[str, Row[str]] = {
    "target": Row(CLIENT, lambda text: is_ipv4(text) and text != ANY, lambda channel, text: replace(channel, address=text), stopped=True),
    "parity": Row(SERIAL, _one_of("none", "even", "odd"), lambda channel, text: replace(channel, parity=text), stopped=True),
    "mode": Row(SERIAL, _one_of("rs232"), lambda channel, text: replace(channel, mode=text), stopped=True),
    "flowControl": Row(SERIAL, _one_of("none", "hardware"), lambda channel, text: replace(channel, flow_control=text), stopped=True),
}
BOOLS: dict[str, Row[bool]] = {"nagle": Row(TCP, lambda on: True, lambda channel, on: replace(channel, nagle=on))}


def judge(channel: Channel, name: str, value: Value, busy: bool) -> tuple[Code, Channel]:
    """The code sioCtrl returns, and the channel as it is afterwards; order of checks: AX-183."""
    if name in NUMS:
        number = value if isinstance(value, (int, float)) and not isinstance(value, bool) else None
        return _apply(channel, NUMS[name], number, busy)
    if name in STRINGS:
        return _apply(channel, STRINGS[name], value if isinstance(value, str) else None, busy)
    if name in BOOLS:
        return _apply(channel, BOOLS[name], value if isinstance(value, bool) else None, busy)
    return Code.UNKNOWN, channel


def _apply(channel: Channel, row: Row[V], value: V | None, busy: bool) -> tuple[Code, Channel]:
    """`value` None: not of the row's type."""
    if channel.kind not in row.kinds:
        return Code.NOT_HERE, channel
    if value is None:
        return Code.WRONG_TYPE, channel
    if not row.takes(value):
        return Code.UNSUPPORTED, channel
    if row.stopped and busy:
        return Code.BUSY, channel
    return Code.CHANGED, row.put(channel, value)
