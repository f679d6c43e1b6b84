"""MOVE_FILE, SF 45: the positions of a BNR file as set points, one per cycle, unchanged.

Source: rho 3 Releases part 2 (TO05), sections 5.2, 5.3 (L7078-7212).  READ_BEGIN with a byte offset opens the file, as often as wanted
MOVE_FILE runs it, CLOSE ends it.  Everything that can be known is checked before the first set point; the first position has to
be where the axes are, which the manual leaves to the user (AX-468).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from motion.errors import LimitError, MotionError
from motion.files import bnr
from motion.files.errors import (
    AXES,
    BASE,
    FORMAT,
    MODULO_FLAG,
    NO_ENDLESS_AXIS,
    READ_BEGIN_EXPECTED,
    READ_MARKER,
    REAL_EXPRESSION,
    TIME_BASE,
    VERSION,
    MoveFileError,
)
from motion.geometry.limits import TOUCH, AxisLimits
from motion.geometry.units import from_si, to_si
from motion.kinematics.endless import AxisType, within

SHORTEST = 24  # bytes: the six fields without the reserve
NO_MODULO, BY_FILE, BY_P311 = 0.0, 1.0, 2.0


@dataclass(frozen=True, slots=True)
class Control:
    """What a file is compared with.  period_us: P5 x 1000; divider: of the servo board; types, modulo: P303, P311 (mm or deg)."""

    limits: tuple[AxisLimits, ...]
    period_us: int
    divider: int = 1
    types: tuple[AxisType, ...] = ()  # empty: no endless axes
    modulo: tuple[float, ...] = ()
    version: int = bnr.TO05

    def endless(self, axis: int) -> bool:
        """P303 of this axis (from 0)."""
        return bool(self.types) and self.types[axis].endless

    def cycle_us(self, base: int) -> int:
        """Length of the cycles a base counts in."""
        return self.period_us if base == bnr.INTERPOLATION else self.period_us // self.divider


@dataclass(slots=True)
class OpenFile:
    """A BNR file between READ_BEGIN and CLOSE."""

    data: bytes
    offset: int


@dataclass(slots=True)
class MoveFiles:
    """The BNR files one process has opened."""

    control: Control
    _open: dict[str, OpenFile] = field(default_factory=dict, init=False)

    def read_begin(self, name: str, data: bytes, offset: int = 0) -> None:
        """READ_BEGIN name, offset: the read marker is set after that many bytes."""
        if offset < 0:
            raise MotionError(f"READ_BEGIN {name}, {offset}: an offset from 0 on is needed")
        self._open[name] = OpenFile(data, offset)

    def close(self, name: str) -> None:
        """CLOSE name; without effect on a file that is not open here."""
        self._open.pop(name, None)

    def move_file(self, name: str, base: int, modulo_flag: Sequence[float | None], position: Sequence[float]) -> "Playback":
        """SF 45: all checks, then the set points.  modulo_flag: None for components never set; standing: m or rad.

        Raises MoveFileError by the manual's number, LimitError naming the axis for positions outside its travel.
        """
        file = self._open.get(name)
        if file is None:
            raise MoveFileError(READ_BEGIN_EXPECTED, name)
        header = self._header(name, file, base)
        rows = self._rows(name, file, header)
        flags = self._flags(modulo_flag)
        self._inside(rows, position, base)
        return Playback(self.control, rows, flags)

    def _header(self, name: str, file: OpenFile, base: int) -> bnr.Header:
        try:
            header = bnr.decode_header(file.data)
        except bnr.BnrError as error:
            raise MoveFileError(FORMAT, f"{name}: {error}") from error
        if header.version != self.control.version:
            raise MoveFileError(VERSION, f"{name}: {header.version}, the control has {self.control.version}")
        if header.axes != len(self.control.limits):
            raise MoveFileError(AXES, f"{name}: {header.axes}, the kinematic has {len(self.control.limits)}")
        if header.length < SHORTEST:
            raise MoveFileError(FORMAT, f"{name}: a header of {header.length} bytes has no room for its own fields")
        if file.offset < header.length:
            raise MoveFileError(READ_MARKER, f"{name}: byte {file.offset} lies in the header of {header.length}")
        if base not in (bnr.INTERPOLATION, bnr.POSITION_LOOP):
            raise MoveFileError(BASE, f"BASE {base}: 1 interpolation, 2 position-controller cycles")
        if header.base_check_off != 1:
            fits = self.control.cycle_us(header.base)
            if header.base in (bnr.INTERPOLATION, bnr.POSITION_LOOP) and header.time_base_us != fits:
                raise MoveFileError(TIME_BASE, f"{name}: {header.time_base_us} us, the control has {fits} us")
            if header.base != base:
                raise MoveFileError(BASE, f"{name}: {header.base}, the call has {base}")
        return header

    @staticmethod
    def _rows(name: str, file: OpenFile, header: bnr.Header) -> tuple[tuple[float, ...], ...]:
        size = 4 * header.axes
        if (len(file.data) - header.length) % size or (len(file.data) - file.offset) % size or len(file.data) <= file.offset:
            left = len(file.data) - file.offset
            raise MoveFileError(FORMAT, f"{name}: {left} bytes from byte {file.offset} do not make whole points of {header.axes} axes")
        rows = bnr.points(file.data, header.axes, file.offset)
        for number, row in enumerate(rows, 1):  # the old controller looked at the first and last only
            if not all(map(math.isfinite, row)):
                raise MoveFileError(REAL_EXPRESSION, f"{name}: point {number} is {row}")
        return rows

    def _flags(self, flag: Sequence[float | None]) -> tuple[float, ...]:
        if len(flag) != len(self.control.limits) or any(value is None for value in flag):
            unset = next((axis.name for axis, value in zip(self.control.limits, (*flag, None), strict=False) if value is None), "")
            said = ", ".join("not set" if value is None else f"{value:g}" for value in flag) or "none"
            raise MoveFileError(MODULO_FLAG, f"{said}: {len(self.control.limits)} values, 0.0 where nothing is wanted", unset)
        flags = tuple(value if value in (BY_FILE, BY_P311) else NO_MODULO for value in flag if value is not None)
        for axis, value in enumerate(flags):
            if value == BY_FILE and not self.control.endless(axis):
                raise MoveFileError(NO_ENDLESS_AXIS, "modulo flag 1 is for axes that go round", self.control.limits[axis].name)
        return flags

    def _inside(self, rows: Sequence[Sequence[float]], position: Sequence[float], base: int) -> None:
        """Travel of all points, speed from where the axes are and from point to point: nothing that must fail is begun (AX-468)."""
        period_s = self.control.cycle_us(base) * 1e-6
        for axis, limits in enumerate(self.control.limits):
            column = [position[axis], *(to_si(row[axis], limits.unit) for row in rows)]
            for number, (before, after) in enumerate(pairwise(column), 1):
                if not (self.control.endless(axis) or limits.lower - TOUCH <= after <= limits.upper + TOUCH):
                    raise LimitError(limits.name, f"point {number}", *_shown(limits, after, limits.lower, limits.upper), limits.unit)
                if not abs(after - before) <= limits.speed * period_s * (1 + 1e-12):
                    speeds = _shown(limits, (after - before) / period_s, -limits.speed, limits.speed)
                    raise LimitError(limits.name, f"speed to point {number}", *speeds, f"{limits.unit}/s")


def _shown(limits: AxisLimits, value: float, lower: float, upper: float) -> tuple[float, float, float]:
    return from_si(value, limits.unit), from_si(lower, limits.unit), from_si(upper, limits.unit)


@dataclass(slots=True)
class Playback:
    """The set points of one MOVE_FILE block; `step` once a cycle of its base."""

    control: Control
    rows: tuple[tuple[float, ...], ...]  # mm or deg, as in the file
    flags: tuple[float, ...]
    at: int = 0

    @property
    def ended(self) -> bool:
        """All points were given out; the axes are at `end_position`."""
        return self.at >= len(self.rows)

    def step(self) -> tuple[float, ...]:
        """The next point in m or rad; the last one again at the end."""
        row = self.rows[min(self.at, len(self.rows) - 1)]
        self.at = min(self.at + 1, len(self.rows))
        return tuple(to_si(value, axis.unit) for value, axis in zip(row, self.control.limits, strict=True))

    def end_position(self) -> tuple[float, ...]:
        """Position from which the control continues after the block, mm or deg; endless axes are reduced according to their flags."""
        found = []
        for axis, (value, flag) in enumerate(zip(self.rows[-1], self.flags, strict=True)):
            modulo = value if flag == BY_FILE else self.control.modulo[axis] if flag == BY_P311 and self.control.endless(axis) else 0.0
            found.append(within(value, abs(modulo)) if modulo else value)
        return tuple(found)
