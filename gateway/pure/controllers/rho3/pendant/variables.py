"""Reads and writes PHG 2000 variables of a running control.  Source: rho 3 Releases L9288-9470; rho3 3.8, AX-486.

Positions are in mm and degrees, as the control shows them; `Machine` is the state of one moment, a write is an order for the
part that owns the value written.  Processes and files come from gateway.pure.controllers.rho3.functions.system_variables.
"""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from gateway.pure.controllers.rho3.functions.system_variables import SystemVariables, VariableError
from gateway.pure.controllers.rho3.pendant.catalogue import CODED, TABLE, TEXT_LISTS, Base, Variable, split_index
from motion.program.factors import FULL, Factors

Value = int | float | str
SIZES = {Base.BYTE: 1, Base.WORD: 2, Base.DOUBLE: 4}
T = TypeVar("T")
ONLY_CODED = (33540, 33541)  # tool, WC system
FACTORS = ("velocity", "acceleration", "deceleration")  # V, A, D: the order of 33793..33795 and 33802..33804


@dataclass(frozen=True, slots=True)
class AxisView:
    """One axis as a pendant shows it: mm or degrees; limits of the software limit switches."""

    name: str
    set: float = 0.0
    actual: float = 0.0
    lag: float = 0.0
    in_position: bool = False
    positive: float = 0.0
    negative: float = 0.0
    offset: float = 0.0
    end_point: float = 0.0


@dataclass(frozen=True, slots=True)
class KinematicView:
    """One kinematic; coordinates: names, object and base values, limits (positive, negative), in the control's units."""

    axes: tuple[AxisView, ...]
    coordinates: tuple[str, ...] = ()
    object_position: tuple[float, ...] = ()
    base_position: tuple[float, ...] = ()
    limits: tuple[tuple[float, float], ...] = ()
    belts: tuple[tuple[str, float], ...] = ()
    tool_name: str = ""
    tool: tuple[float, ...] = (0.0,) * 6
    wc_system: tuple[float, ...] = (0.0,) * 6
    factors: Factors = FULL


@dataclass(frozen=True, slots=True)
class Message:
    """A pending warning or error: code, bit mask of its axes, text."""

    code: int
    axes: int
    text: str


@dataclass(frozen=True, slots=True)
class Machine:
    """The control at one moment.  Areas: bytes as the PIC numbers them, 128 each."""

    pic_inputs: bytes = bytes(128)
    rci: bytes = bytes(128)
    flags: bytes = bytes(128)
    boards: Mapping[str, bytes] = field(default_factory=dict)  # "SB1 inputs", "SB1 outputs" ...: two bytes
    analog_inputs: tuple[float, ...] = ()
    analog_outputs: tuple[float, ...] = ()
    kinematics: tuple[KinematicView, ...] = ()
    factors: Factors = FULL
    clock_ms: int = 0
    texts: Mapping[int, str] = field(default_factory=dict)  # 34050..34059: time, date, versions, PIC program
    warnings: tuple[Message, ...] = ()
    errors: tuple[Message, ...] = ()
    text_lists: Mapping[int, Sequence[str]] = field(default_factory=dict)  # number of VTLnnn.DAT -> its lines


@dataclass(frozen=True, slots=True)
class SetFactor:
    """A global factor (kinematic 0) or that of one kinematic; which: velocity, acceleration, deceleration; 0 .. 1."""

    kinematic: int
    which: str
    value: float


@dataclass(frozen=True, slots=True)
class SetBits:
    """Bits of the signal area, from bit `first` on, lowest first; the numbers are those of the variable's index."""

    first: int
    bits: tuple[bool, ...]


@dataclass(frozen=True, slots=True)
class SetClock:
    """34050 time, 34051 date, 34052 both, as typed."""

    code: int
    text: str


Order = SetFactor | SetBits | SetClock


class Variables:
    """All variables of one control."""

    def __init__(self, machine: Machine, listed: SystemVariables) -> None:
        self.machine = machine  # replaced whenever the state moves on
        self._listed = listed

    def read(self, code: int, index: int = 0) -> Value:
        """Value of a variable; index: running number, or coded (kinematic and component).  Raises VariableError."""
        variable = self._variable(code, index)
        if not variable.readable:
            raise VariableError(f"{code} {variable.name}: is only written")
        if 34305 <= code <= 34570:
            return self._listed.read(code, index or 1)
        if code in TEXT_LISTS:
            lines = self.machine.text_lists.get(code - TEXT_LISTS.start, ())
            return lines[index - 1] if index <= len(lines) else ""
        if code < 33280:
            return self._signal(variable, index)
        if code < 33792:
            return self._of_kinematic(code, index)
        return self._factor(code, index) if code < 34048 else self._information(code, index)

    def write(self, code: int, value: Value, index: int = 0) -> Order | None:
        """What is to be done for it; None: done here (process variables).  Raises VariableError, nothing is done then."""
        variable = self._variable(code, index)
        if not variable.writable:
            raise VariableError(f"{code} {variable.name}: is only read")
        if 34305 <= code <= 34570:
            self._listed.write(code, _whole(variable, value))
            return None
        if code < 33280:
            return _bits(variable, _whole(variable, value), index)
        return self._write_factor(variable, value, index) if code < 34048 else SetClock(code, str(value))

    def _variable(self, code: int, index: int) -> Variable:
        variable = TABLE.get(code)
        if variable is None:
            raise VariableError(f"{code}: no such variable")
        if variable.single or 34305 <= code <= 34570:
            return variable
        if code in ONLY_CODED or (index & CODED and 33281 <= code <= 33300):
            if not index & CODED:
                raise VariableError(f"{code} {variable.name}: index {index}; only 32768 + 256 x kinematic + component")
        elif not variable.first <= index <= variable.last:
            raise VariableError(f"{code} {variable.name}: index {index}; {variable.first} to {variable.last}")
        return variable

    # ---- signals -----------------------------------------------------------------------------------------------------------
    def _signal(self, variable: Variable, index: int) -> Value:
        machine, code = self.machine, variable.code
        if code in (33057, 33058):
            return len(machine.analog_inputs if code == 33057 else machine.analog_outputs)
        if code in (33059, 33060):
            values = machine.analog_inputs if code == 33059 else machine.analog_outputs
            return values[index - 1] if index <= len(values) else 0.0
        area = self._area(variable)
        if variable.base is Base.BIT:
            return area[index // 8] >> index % 8 & 1
        return int.from_bytes(area[index : index + SIZES[variable.base]], "little")

    def _area(self, variable: Variable) -> bytes:
        if variable.code <= 33036:
            return (self.machine.pic_inputs, self.machine.rci, self.machine.flags)[(variable.code - 33025) % 3]
        if variable.code <= 33044:
            return self.machine.pic_inputs  # RC outputs and MTB inputs lie there under their PIC numbers
        return self.machine.boards.get(variable.name.rpartition(" ")[0], bytes(4))

    # ---- kinematics --------------------------------------------------------------------------------------------------------
    def _of_kinematic(self, code: int, index: int) -> Value:
        kinematics = self.machine.kinematics
        if code in (33297, 33298):
            return sum(len(kinematic.axes if code == 33297 else kinematic.belts) for kinematic in kinematics)
        if code in (33537, 33538, 33539):
            kinematic = self._kinematic(index)
            return kinematic.tool_name if code == 33539 else len(kinematic.axes if code == 33537 else kinematic.belts)
        if code in (33540, 33541):
            number, component = split_index(index)
            kinematic = self._kinematic(number)
            return _nth(kinematic.tool if code == 33540 else kinematic.wc_system, component, "component")
        if code in (33299, 33300):
            name, value = self._belt(index)
            return value if code == 33299 else name
        if code in (33285, 33286, 33287, 33288, 33292):
            return self._coordinate(code, index)
        return _of_axis(code, self._axis(index))

    def _kinematic(self, number: int) -> KinematicView:
        return _nth(self.machine.kinematics, number, "kinematic")

    def _axis(self, index: int) -> AxisView:
        number, component = split_index(index)
        axes = self._kinematic(number).axes if number else tuple(axis for kinematic in self.machine.kinematics for axis in kinematic.axes)
        return _nth(axes, component, "axis")

    def _belt(self, index: int) -> tuple[str, float]:
        number, component = split_index(index)
        belts = (
            self._kinematic(number).belts if number else tuple(belt for kinematic in self.machine.kinematics for belt in kinematic.belts)
        )
        return _nth(belts, component, "belt")

    def _coordinate(self, code: int, index: int) -> Value:
        """Of one kinematic by a coded index; a simple one counts the coordinates of all kinematics."""
        number, component = split_index(index)
        chosen = (self._kinematic(number),) if number else self.machine.kinematics
        match code:
            case 33285:
                return _nth(tuple(value for kinematic in chosen for value in kinematic.object_position), component, "coordinate")
            case 33286:
                return _nth(tuple(value for kinematic in chosen for value in kinematic.base_position), component, "coordinate")
            case 33292:
                return _nth(tuple(name for kinematic in chosen for name in kinematic.coordinates), component, "coordinate")
            case _:
                limits = tuple(limit for kinematic in chosen for limit in kinematic.limits)
                return _nth(limits, component, "coordinate")[code - 33287]

    # ---- factors and information -------------------------------------------------------------------------------------------
    def _factor(self, code: int, index: int) -> float:
        """Limits of all factors: 0 and 1 (L2671-2681)."""
        if 33796 <= code <= 33801 or code >= 33805:
            return float((code - 33796) % 2 if code <= 33801 else (code - 33805) % 2)
        if code <= 33795:
            factors = self.machine.factors
        else:
            factors = self._kinematic(index).factors
        return (factors.velocity, factors.acceleration, factors.deceleration)[(code - 33793) % 9]

    def _write_factor(self, variable: Variable, value: Value, index: int) -> SetFactor:
        kinematic = index if variable.code >= 33802 else 0
        if kinematic:
            self._kinematic(kinematic)  # there is one
        if isinstance(value, str) or not 0.0 <= value <= 1.0:
            raise VariableError(f"{variable.code} {variable.name} = {value}: 0 to 1 (1 is 100 %)")
        return SetFactor(kinematic, FACTORS[(variable.code - 33793) % 9], float(value))

    def _information(self, code: int, index: int) -> Value:
        machine = self.machine
        if code == 34049:
            return machine.clock_ms & 0xFFFF
        if code <= 34059:
            return machine.texts.get(code, "")
        if code <= 34061:
            return len(machine.warnings if code == 34060 else machine.errors)
        messages = machine.warnings if code <= 34066 else machine.errors
        column = (code - 34062) % 5
        message = messages[index - 1] if index <= len(messages) else None
        if message is None:
            return "" if column < 3 else 0
        axes = f" {message.axes:04X}h" if message.axes else ""
        texts = (f"{message.text}{axes} {message.code}", f"{message.text}{axes}", message.text)
        return texts[column] if column < 3 else (message.axes, message.code)[column - 3]


def _of_axis(code: int, axis: AxisView) -> Value:
    values: dict[int, Value] = {
        33281: axis.set,
        33282: axis.actual,
        33283: axis.set,  # printed twice
        33289: axis.positive,
        33290: axis.negative,
        33291: axis.name,
        33293: axis.lag,
        33294: "*" if axis.in_position else " ",
        33295: axis.offset,
        33296: axis.end_point,
    }
    return values[code]


def _nth(values: Sequence[T], number: int, what: str) -> T:
    if not 1 <= number <= len(values):
        raise VariableError(f"{what} {number}: 1 to {len(values)}" if values else f"{what} {number}: there is none")
    return values[number - 1]


def _whole(variable: Variable, value: Value) -> int:
    bits = 1 if variable.base is Base.BIT else 8 * SIZES.get(variable.base, 2)
    if not isinstance(value, int) or not 0 <= value < 1 << bits:
        raise VariableError(f"{variable.code} {variable.name} = {value}: a whole number from 0 to {(1 << bits) - 1}")
    return value


def _bits(variable: Variable, value: int, index: int) -> SetBits:
    if variable.base is Base.BIT:
        return SetBits(index, (bool(value),))
    count = 8 * SIZES[variable.base]
    return SetBits(8 * index, tuple(bool(value >> bit & 1) for bit in range(count)))


def real_words(value: float) -> tuple[int, int]:
    """IEEE single as two 16-bit words, low word first: how a Real lies in registers of a view."""
    low, high = struct.unpack("<HH", struct.pack("<f", value))
    return low, high
