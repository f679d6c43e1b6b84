"""Names of channels and how each is read from a record.

axis.A1.actual  set  speed  lag  torque  power  fault_code  enabled  referenced  in_position  fault  lost  homing  warning
cell.override  motion  job  progress  ready  emergency  skipped  incomplete  late  compute_us  stop_cause
rc_in.24  rc_out.67  or the name of a signal: CTRL_ALLOW_RCI
"""

import re
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gateway.pure.image.addresses import Direction
from gateway.pure.image.records.cell import AXIS, RC_BYTES, STATE, AxisFlag
from gateway.pure.image.signals import SignalList
from gateway.pure.scope.records import INPUTS_AT, OUTPUTS_AT
from motion.geometry.units import to_si

Read = Callable[[bytes], float]


class ChannelError(ValueError):
    """No such channel; the message names those there are."""


@dataclass(frozen=True, slots=True)
class Channel:
    """`read` returns the value of one record in `unit`."""

    name: str
    unit: str
    read: Read


@dataclass(frozen=True, slots=True)
class AxisFact:
    """Name and outside unit of an axis, in the order of the cell."""

    name: str
    unit: str


_VALUES = ("actual", "set", "speed", "lag", "torque")
_NUMBERS = ("fault_code", "power")
_CELL = {"override": (100.0, "%"), "progress": (100.0, "%"), "compute_us": (1e-3, "us"), "belt": (1e3, "mm"), "belt_speed": (1e3, "mm/s")}
_CELL_NAMES = {
    "override": "override", "progress": "progress", "compute_us": "compute_ns", "motion": "motion", "job": "job", "ready": "ready",
    "emergency": "emergency", "skipped": "skipped", "incomplete": "incomplete", "late": "late", "stop_cause": "stop_cause",
    "permits": "permits", "piece": "piece", "belt": "belt", "belt_speed": "belt_speed",
}  # fmt: skip
_STAMP = struct.Struct("=q").unpack_from
_STAMP_AT = STATE.offset("sync_ns")
FLAGS = {flag.name.lower(): flag for flag in AxisFlag if flag.name}


def channel(name: str, axes: Sequence[AxisFact], signals: SignalList) -> Channel:
    """The channel of that name; raises ChannelError."""
    parts = name.split(".")
    if parts[0] == "axis" and len(parts) == 3:
        return _axis_channel(name, parts[1], parts[2], axes)
    if parts[0] == "cell" and len(parts) == 2:
        return _cell_channel(name, parts[1])
    if parts[0] in ("rc_in", "rc_out") and len(parts) == 2:
        return _bit_channel(name, parts[0], parts[1])
    signal = signals.named(name)
    if signal is None:
        raise ChannelError(f"{name}: no such channel; axis.NAME.VALUE, cell.VALUE, rc_in.N, rc_out.N, or the name of a signal")
    area = "rc_in" if signal.at.direction is Direction.INPUT else "rc_out"
    return Channel(name, "", _bit_channel(name, area, str(signal.at.number)).read)


def all_names(axes: Sequence[AxisFact]) -> list[str]:
    """What a list of channels offers; single signals are left out, there are 2,048 of them."""
    values = (*_VALUES, *_NUMBERS, *FLAGS)
    return [f"axis.{axis.name}.{value}" for axis in axes for value in values] + [f"cell.{value}" for value in _CELL_NAMES]


def _axis_channel(name: str, axis: str, value: str, axes: Sequence[AxisFact]) -> Channel:
    place = next((number for number, fact in enumerate(axes) if fact.name == axis), None)
    if place is None:
        raise ChannelError(f"{name}: no axis {axis}; {', '.join(fact.name for fact in axes)}")
    at = STATE.size + place * AXIS.size
    if value in _VALUES:
        return _double(name, at + AXIS.offset(value), value, axes[place].unit)
    if value in _NUMBERS:
        return Channel(name, "", _reader(f"={AXIS.code(value)}", at + AXIS.offset(value), 1.0))
    if value in FLAGS:
        return Channel(name, "", _flag(at + AXIS.offset("flags"), int(FLAGS[value])))
    raise ChannelError(f"{name}: no value {value}; {', '.join((*_VALUES, *_NUMBERS, *FLAGS))}")


def _double(name: str, at: int, value: str, unit: str) -> Channel:
    if value == "torque":
        return Channel(name, "%", _reader("=d", at, 100.0))
    outside = f"{unit}/s" if value == "speed" else unit
    return Channel(name, outside, _reader("=d", at, 1.0 / to_si(1.0, unit)))


def _cell_channel(name: str, value: str) -> Channel:
    if value not in _CELL_NAMES:
        raise ChannelError(f"{name}: no value {value}; {', '.join(_CELL_NAMES)}")
    field = _CELL_NAMES[value]
    factor, unit = _CELL.get(value, (1.0, ""))
    return Channel(name, unit, _reader(f"={STATE.code(field)}", STATE.offset(field), factor))


def _bit_channel(name: str, area: str, number: str) -> Channel:
    if not re.fullmatch(r"\d{1,4}", number) or int(number) >= 8 * RC_BYTES:
        raise ChannelError(f"{name}: bit {number}; 0 to {8 * RC_BYTES - 1}")
    at = (INPUTS_AT if area == "rc_in" else OUTPUTS_AT) + int(number) // 8
    mask = 1 << int(number) % 8
    return Channel(name, "", lambda record: float(bool(record[at] & mask)))


def _reader(form: str, at: int, factor: float) -> Read:
    unpack = struct.Struct(form).unpack_from
    return lambda record: float(unpack(record, at)[0]) * factor


def _flag(at: int, mask: int) -> Read:
    unpack = struct.Struct("=H").unpack_from
    return lambda record: float(bool(unpack(record, at)[0] & mask))


def stamp_ns(record: bytes) -> int:
    """When the SYNC of this record left; monotonic."""
    return int(_STAMP(record, _STAMP_AT)[0])
