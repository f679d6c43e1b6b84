"""sioCtrl: which parameter takes which value on which channel.  Source: VAL 3 manual, 3.7.3, sioCtrl."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum

from gateway.pure.val3_sio.channel import ANY, SOCKETS, TCP, Channel, Kind, is_ipv4, timeout_is_legal

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
class Parameter:
    """One row of the manual's table."""

    field: str  # of Channel
    kinds: frozenset[Kind]
    type: type[float] | type[str] | type[bool]
    takes: Callable[[float], bool] | Callable[[str], bool] | None = None  # None: every value of the type
    whole: bool = True  # a num that must be an integer
    stopped: bool = False  # only while the channel rests


SERIAL = frozenset({Kind.SERIAL})
EVERY = SOCKETS | SERIAL


def _one_of(*words: str) -> Callable[[str], bool]:
    return lambda text: text in words


def _from_to(low: int, high: int) -> Callable[[float], bool]:
    return lambda number: low <= number <= high


PARAMETERS = {
    "port": Parameter("port", TCP, float, _from_to(1, 65535), stopped=True),
    "target": Parameter("address", frozenset({Kind.TCP_CLIENT}), str, lambda text: is_ipv4(text) and text != ANY, stopped=True),
    "clients": Parameter("clients", frozenset({Kind.TCP_SERVER}), float, _from_to(1, 64), stopped=True),
    "endOfString": Parameter("end_of_string", EVERY, float, _from_to(0, 255)),  # UDP too: doubt D38, AX-182
    "timeout": Parameter("timeout_s", EVERY, float, timeout_is_legal, whole=False),
    "baudRate": Parameter("baud_rate", SERIAL, float, _from_to(50, 4_000_000), stopped=True),
    "parity": Parameter("parity", SERIAL, str, _one_of("none", "even", "odd"), stopped=True),
    "bits": Parameter("bits", SERIAL, float, _from_to(5, 8), stopped=True),
    "stopBits": Parameter("stop_bits", SERIAL, float, _from_to(1, 2), stopped=True),
    "mode": Parameter("mode", SERIAL, str, _one_of("rs232"), stopped=True),
    "flowControl": Parameter("flow_control", SERIAL, str, _one_of("none", "hardware"), stopped=True),
    "nagle": Parameter("nagle", TCP, bool),
}


def judge(channel: Channel, name: str, value: Value, busy: bool) -> tuple[Code, Channel]:
    """The code sioCtrl returns, and the channel as it is afterwards; asked in the order unknown, not here, type, value, busy (AX-183)."""
    row = PARAMETERS.get(name)
    if row is None:
        return Code.UNKNOWN, channel
    if channel.kind not in row.kinds:
        return Code.NOT_HERE, channel
    if not _fits_type(row, value):
        return Code.WRONG_TYPE, channel
    if not _fits_range(row, value):
        return Code.UNSUPPORTED, channel
    if row.stopped and busy:
        return Code.BUSY, channel
    kept = int(value) if row.type is float and row.whole else value
    return Code.CHANGED, replace(channel, **{row.field: kept})  # type: ignore[arg-type]  # the table pairs field and type


def _fits_type(row: Parameter, value: Value) -> bool:
    if row.type is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    return isinstance(value, row.type)


def _fits_range(row: Parameter, value: Value) -> bool:
    if row.type is float and row.whole and not float(value).is_integer():
        return False
    return row.takes is None or row.takes(value)  # type: ignore[arg-type]  # the type has been looked at
