"""Set values and actual values of SERVODYN-GC drives; the layouts define the bits (default AX-001, not verified on hardware)."""

import struct
from collections.abc import Callable, Mapping
from typing import NamedTuple

from protocols.base.errors import DecodeError, EncodeError
from protocols.base.layout import Layout, Packer
from protocols.base.machine import Frame
from protocols.servodyn.plan import SLOTS, SYNC_ID

SYNC = Frame(SYNC_ID)


class SetValue(NamedTuple):
    """Gateway to drive, once per SYNC."""

    enable: bool = False
    drive_on: bool = False
    limit_switch: bool = False  # ENABLE LIMIT SWITCH
    fault_reset: bool = False  # edge
    brake_open: bool = False  # request
    life: int = 0  # 0..255, +1 per SYNC
    position_inc: int = 0
    speed_rpm: int = 0  # feed-forward


class ActualValue(NamedTuple):
    """Drive to gateway, after every SYNC."""

    ready: bool = False
    power_on: bool = False
    enabled: bool = False
    fault: bool = False
    warning: bool = False
    limit_active: bool = False
    reference_switch: bool = False
    brake_open: bool = False
    fault_code: int = 0
    position_inc: int = 0  # latched at SYNC
    torque_permille: int = 0  # of rated torque


SET_SIGNALS = SetValue._fields
ACTUAL_SIGNALS = ActualValue._fields
ACTUAL_FLAGS = ACTUAL_SIGNALS.index("fault_code")  # so many come first; in a layout from a file they may have more bits than one


class Codec:
    """Compiled for the modules 1..6 the layouts name as messages SET_1.. and ACT_1.. (and SYNC)."""

    def __init__(self, layouts: Mapping[str, Layout]) -> None:
        """Raises EncodeError with everything that is missing."""
        faults: list[str] = []
        sync = layouts.get("SYNC")
        if sync is None:
            faults.append("message SYNC is missing")
        elif sync.length or sync.identifier != SYNC_ID:
            faults.append(f"message SYNC ({sync.identifier}, {sync.length} bytes): expected identifier {SYNC_ID} and 0 bytes")
        self._set_packers, self._set_ids = _side(layouts, "SET", SET_SIGNALS, faults)
        self._actual_packers, self._actual_ids = _side(layouts, "ACT", ACTUAL_SIGNALS, faults)
        self.axes = tuple(sorted(self._set_packers))
        if not faults and self.axes != tuple(sorted(self._actual_packers)):
            faults.append(f"SET_n of {list(self.axes)} but ACT_n of {sorted(self._actual_packers)}: every axis needs both")
        self._readers = {axis: _reader(packer) for axis, packer in self._actual_packers.items()}
        identifiers = [SYNC_ID, *self._set_ids.values(), *self._actual_ids.values()]
        if len(set(identifiers)) != len(identifiers):
            faults.append("an identifier is used twice among SYNC, SET_n and ACT_n")
        if faults:
            raise EncodeError("; ".join(faults))
        self._set_axes = {number: (axis, self._set_packers[axis]) for axis, number in self._set_ids.items()}
        self._actual_axes = {number: (axis, self._actual_packers[axis]) for axis, number in self._actual_ids.items()}

    def encode_set(self, axis: int, value: SetValue) -> Frame:
        """Raises EncodeError naming signal, value and range."""
        return Frame(self._set_ids[axis], self._set_packers[axis].pack(value))

    def writer(self, axis: int) -> Callable[[SetValue], Frame]:
        """Encodes for this module; EncodeError as `encode_set`."""
        packer, make = self._set_packers[axis], tuple.__new__
        identifier, words, plain, flags = self._set_ids[axis], packer.words, packer.plain, packer.flags

        def write(value: SetValue) -> Frame:
            word = words.get(value[:flags])
            if plain is not None and word is not None:  # as Packer.pack, a call less: once an axis and cycle
                try:
                    return make(Frame, (identifier, plain.pack(word, *value[flags:]), 0))
                except struct.error:
                    pass
            return make(Frame, (identifier, packer.pack(value), 0))

        return write

    def encode_actual(self, axis: int, value: ActualValue) -> Frame:
        """Raises EncodeError naming signal, value and range."""
        return Frame(self._actual_ids[axis], self._actual_packers[axis].pack(value))

    def decode_set(self, frame: Frame) -> tuple[int, SetValue]:
        """Axis and values.  Raises DecodeError for another identifier, length or a value out of range."""
        place = self._set_axes.get(frame.identifier)
        if place is None:
            raise DecodeError(f"identifier {frame.identifier} is not a set value of this bus: {frame.data.hex(' ')}")
        enable, on, limit, reset, brake, life, position, speed = place[1].unpack(frame.data)
        return place[0], SetValue(enable == 1, on == 1, limit == 1, reset == 1, brake == 1, life, position, speed)

    def decode_actual(self, frame: Frame) -> tuple[int, ActualValue]:
        """Axis and values.  Raises DecodeError for another identifier, length or a value out of range."""
        place = self._actual_axes.get(frame.identifier)
        if place is None:
            raise DecodeError(f"identifier {frame.identifier} is not an actual value of this bus: {frame.data.hex(' ')}")
        return place[0], self._readers[place[0]](frame.data)

    def actual_id(self, axis: int) -> int:
        """Identifier of the actual values of module 1..6; KeyError where there is none."""
        return self._actual_ids[axis]

    def set_id(self, axis: int) -> int:
        """Identifier of the set values of module 1..6; KeyError where there is none."""
        return self._set_ids[axis]

    def packers(self, axis: int) -> tuple[Packer, Packer]:
        """Packers of the set values and the actual values of module 1..6: for code that replaces them (gateway.cycle.native)."""
        return self._set_packers[axis], self._actual_packers[axis]

    def reader(self, axis: int) -> Callable[[bytes], ActualValue]:
        """Decodes the telegram of this module; DecodeError as `decode_actual`."""
        return self._readers[axis]


def _reader(packer: Packer) -> Callable[[bytes], ActualValue]:
    unpack, make = packer.unpack, tuple.__new__  # _make would only count the values again
    plain, seen, bits = packer.plain, packer.seen, packer.flag_bits

    def read(data: bytes) -> ActualValue:
        if plain is not None and len(data) == plain.size:  # as Packer.unpack, a call less: once an axis and cycle
            numbers = plain.unpack(data)
            flags = seen.get(numbers[0] & bits)
            if flags is not None:
                return make(ActualValue, flags + numbers[1:])
        return make(ActualValue, unpack(data))

    def read_wider(data: bytes) -> ActualValue:
        """A layout from a file with flags of more bits than one: 1 counts."""
        values = unpack(data)
        return ActualValue._make([*(value == 1 for value in values[:ACTUAL_FLAGS]), *values[ACTUAL_FLAGS:]])

    return read if packer.flags >= ACTUAL_FLAGS else read_wider


def _side(
    layouts: Mapping[str, Layout], prefix: str, names: tuple[str, ...], faults: list[str]
) -> tuple[dict[int, Packer], dict[int, int]]:
    packers: dict[int, Packer] = {}
    identifiers: dict[int, int] = {}
    for axis in range(1, SLOTS + 1):
        layout = layouts.get(f"{prefix}_{axis}")
        if layout is None:
            continue
        try:
            packers[axis], identifiers[axis] = Packer(layout, names), layout.identifier
        except EncodeError as error:
            faults.append(str(error))
    if not packers and not faults:
        faults.append(f"no message {prefix}_1..{prefix}_{SLOTS}")
    return packers, identifiers
