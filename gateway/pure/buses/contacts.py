"""Real contacts at the gateway: the value of each output from the cycle's state, and the received inputs (AX-400).

A signal the cycle knows itself (ready, drives on, brakes, RC outputs, the watchdog) is shown by the process that drives the contact; every
other one comes from the services and falls to `on_loss` when they are gone.  The watchdog is a function of the number of completed
cycles and of nothing else, so it stops with the cycle.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple

from gateway.pure.image.records.cell import AxisFlag, CellState, Quality, get_bit

WATCHDOG = "cell.watchdog"
CONTACTS = 64  # [[io]] tables of a cell
FORCED = 0x80  # in the byte of the quality


class Source(Enum):
    """Who knows an output's signal."""

    READY = auto()
    DRIVES_ON = auto()
    EMERGENCY = auto()
    WATCHDOG = auto()
    BRAKE = auto()  # 1: open
    FLAG = auto()  # of one axis
    RC_OUTPUT = auto()
    SERVICES = auto()


FLAGS = {
    "enabled": AxisFlag.ENABLED,
    "referenced": AxisFlag.REFERENCED,
    "in_position": AxisFlag.IN_POSITION,
    "fault": AxisFlag.FAULT | AxisFlag.LOST,
}
OWN = {
    "cell.ready": Source.READY,
    "cell.drives_on": Source.DRIVES_ON,
    "cell.emergency_stop": Source.EMERGENCY,
    WATCHDOG: Source.WATCHDOG,
}


class Said(NamedTuple):
    """A contact as passed between processes."""

    value: bool = False
    quality: Quality = Quality.BAD
    forced: bool = False  # by `io test`: overrides the signal


@dataclass(frozen=True, slots=True)
class Output:
    """One output contact; `number` is its place among the [[io]] tables of the cell."""

    number: int
    source: Source
    axis: int = 0
    flag: AxisFlag = AxisFlag(0)
    bit: int = 0  # RC output
    half: int = 1  # watchdog: cycles between two toggles
    on_loss: int | None = None  # None: the last value stays


def source_of(signal: str, axes: Sequence[str], rc_output: int | None) -> tuple[Source, int, AxisFlag, int]:
    """(source, axis, flag, bit) of a signal; `rc_output`: its bit where the signal list has it as RC output."""
    if rc_output is not None:
        return Source.RC_OUTPUT, 0, AxisFlag(0), rc_output
    if signal in OWN:
        return OWN[signal], 0, AxisFlag(0), 0
    match signal.split("."):
        case ["axis", name, "brake"] if name in axes:
            return Source.BRAKE, axes.index(name), AxisFlag(0), 0
        case ["axis", name, key] if name in axes and key in FLAGS:
            return Source.FLAG, axes.index(name), FLAGS[key], 0
    return Source.SERVICES, 0, AxisFlag(0), 0


class Outputs:
    """All outputs one process drives; `show` once per completed cycle."""

    def __init__(self, outputs: Sequence[Output], axes: int) -> None:
        self._outputs, self._axes = tuple(outputs), axes
        self._last = dict.fromkeys((output.number for output in outputs), False)

    def show(self, state: CellState, rc_outputs: bytes | bytearray, said: Sequence[Said]) -> dict[int, bool]:
        """Return contact number -> value; `said`: values from the services, empty when they are gone."""
        for output in self._outputs:
            self._last[output.number] = self._value(output, state, rc_outputs, said)
        return self._last

    def _value(self, output: Output, state: CellState, rc_outputs: bytes | bytearray, said: Sequence[Said]) -> bool:
        axes = state.axes[: self._axes]
        if output.number < len(said) and said[output.number].forced and output.source is not Source.WATCHDOG:
            return said[output.number].value
        match output.source:
            case Source.READY:
                return state.ready
            case Source.DRIVES_ON:
                return bool(axes) and all(axis.flags & AxisFlag.ENABLED for axis in axes)
            case Source.EMERGENCY:
                return state.emergency
            case Source.WATCHDOG:
                return bool(state.cycle // output.half & 1)
            case Source.BRAKE:
                flags = axes[output.axis].flags
                return bool(flags & AxisFlag.ENABLED) and not flags & (AxisFlag.FAULT | AxisFlag.LOST)
            case Source.FLAG:
                return bool(axes[output.axis].flags & output.flag)
            case Source.RC_OUTPUT:
                return get_bit(rc_outputs, output.bit)
            case Source.SERVICES:
                return self._of_services(output, said)

    def _of_services(self, output: Output, said: Sequence[Said]) -> bool:
        sample = said[output.number] if output.number < len(said) else Said()
        if sample.quality == Quality.GOOD:
            return sample.value
        return self._last[output.number] if output.on_loss is None else bool(output.on_loss)


def pack_said(said: Sequence[Said]) -> bytes:
    """2 x CONTACTS bytes: value, quality."""
    octets = bytes(value for each in said for value in (each.value, each.quality | FORCED * each.forced))
    return octets.ljust(2 * CONTACTS, b"\0")


def unpack_said(data: bytes) -> list[Said]:
    """The reverse of pack_said."""
    return [Said(bool(data[n]), Quality(data[n + 1] & ~FORCED), bool(data[n + 1] & FORCED)) for n in range(0, 2 * CONTACTS, 2)]


SAID_BYTES, SAID_LAYOUT = 2 * CONTACTS, f"contacts/1 {CONTACTS} x value, quality"
