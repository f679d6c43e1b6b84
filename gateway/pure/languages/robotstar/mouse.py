"""The 6D mouse: dead zone, standardisation, calibration, direction.  Pure.  Source: robotstar 8.4, L3003-3168; AX-1051."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.values import Array, Structure

NOT_POSSIBLE = "Calibration not possible"
AXES = 6
Matrix = tuple[tuple[float, float, float], ...]
NONE: Matrix = ((0.0,) * 3,) * 3  # not calibrated: nothing moves


@dataclass(frozen=True, slots=True)
class MouseData:
    """Machine data (L3145-3168).  minimum: IMOUSE_MIN; maxima: IMOUSE_MAX[1..6]."""

    minimum: float = 30
    maxima: tuple[float, ...] = (520, 400, 440, 520, 400, 450)

    def shares(self, raw: Sequence[float]) -> tuple[float, ...]:
        """Return shares of the highest hand speed, by coordinate: 0 in the dead zone, at most 1."""
        return tuple(
            0.0 if abs(value) < self.minimum else min(max(value / most, -1.0), 1.0) for value, most in zip(raw, self.maxima, strict=True)
        )


@dataclass(slots=True)
class Mouse:
    """raw: coordinates as last read; translation, rotation: _RMOUSE_T and _RMOUSE_R."""

    data: MouseData = field(default_factory=MouseData)
    raw: tuple[float, ...] = (0.0,) * AXES
    translation: Matrix = NONE
    rotation: Matrix = NONE

    def reading(self, number: int) -> int:
        """Coordinate 1..6; 0 in the dead zone."""
        value = self.raw[number - 1]
        return 0 if abs(value) < self.data.minimum else round(value)

    def calibrate(self, vectors: Array) -> None:
        """MAUS_KALIB: V[1..3] are the readings for X, Y, Z, V[4..6] those for turning about the hand's X, Y, Z."""
        if len(vectors.items) != AXES:
            raise StepFault(f"MAUS_KALIB: a field of {AXES} vectors is needed, this one has {len(vectors.items)}")
        rows = [item for item in vectors.items if isinstance(item, Structure)]
        moves = [self._standard(row, "XYZ", 0) for row in rows[:3]]
        turns = [self._standard(row, "ABC", 3) for row in rows[3:]]
        self.translation, self.rotation = inverse(moves), inverse(turns)

    def _standard(self, row: Structure, names: str, first: int) -> tuple[float, ...]:
        values = [row.number(name) if row.parts[name] is not None else 0.0 for name in names]
        length = math.hypot(*(value / most for value, most in zip(values, self.data.maxima[first:], strict=False)))
        if not length:
            raise StepFault(NOT_POSSIBLE)
        return tuple(value / most / length for value, most in zip(values, self.data.maxima[first:], strict=False))

    def push(self, *, moves: bool, turns: bool, hand: bool) -> tuple[float, ...]:
        """Shares of the highest speeds along and about X, Y, Z, at most 1 in all; a calibration for the world was guided along with the
        movement in the negative direction, one for the hand held against it (L3061-3090)."""
        shares, side = self.data.shares(self.raw), 1.0 if hand else -1.0
        along = limited([side * value for value in times(self.translation, shares[:3])]) if moves else (0.0,) * 3
        about = limited([side * value for value in times(self.rotation, shares[3:])]) if turns else (0.0,) * 3
        return *along, *about


def limited(vector: Sequence[float]) -> tuple[float, ...]:
    """Not longer than 1."""
    length = math.hypot(*vector)
    return tuple(value / max(length, 1.0) + 0.0 for value in vector)


def times(matrix: Matrix, vector: Sequence[float]) -> list[float]:
    """Matrix by column."""
    return [sum(a * b for a, b in zip(row, vector, strict=True)) for row in matrix]


def inverse(columns: Sequence[Sequence[float]]) -> Matrix:
    """Of the matrix of these columns; StepFault where two directions gave the same reading."""
    (a, d, g), (b, e, h), (c, f, i) = columns
    whole = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    if abs(whole) < 1e-3:
        raise StepFault(NOT_POSSIBLE)
    rows = (
        (e * i - f * h, c * h - b * i, b * f - c * e),
        (f * g - d * i, a * i - c * g, c * d - a * f),
        (d * h - e * g, b * g - a * h, a * e - b * d),
    )
    return tuple((x / whole, y / whole, z / whole) for x, y, z in rows)
