"""Switches, index pulse and probe inputs along the shaft: where they act, and which edges were crossed.

Every edge has an exact place, so a position captured there (homing, touch probe) does not depend on how the time is divided into steps.
"""

from collections.abc import Sequence
from enum import IntEnum
from math import inf, isfinite
from typing import NamedTuple

from drivers.emulator.cia402.servo import DriveServo
from drivers.emulator.servo.settings import INC_PER_TURN


class Signal(IntEnum):
    """Bits of 60FDh; the index pulse has none."""

    NEGATIVE_LIMIT = 0
    POSITIVE_LIMIT = 1
    HOME = 2
    PROBE_1 = 16
    PROBE_2 = 17
    INDEX = 32


class Edge(NamedTuple):
    signal: Signal
    rising: bool
    direction: int  # of the counter: +1, -1
    counter: int  # where it is, in increments of the counter


class _Place(NamedTuple):
    shaft_rad: float
    signal: Signal
    rises_upwards: bool  # moving towards positive shaft angles switches it on


class Switches:
    """Windows in rad at the shaft; an infinite end has no edge."""

    def __init__(self, windows: Sequence[tuple[Signal, float, float]]) -> None:
        self._windows = tuple(window for window in windows if window[1] < window[2])
        places = [_Place(low, signal, True) for signal, low, high in windows if isfinite(low) and low < high]
        places += [_Place(high, signal, False) for signal, low, high in windows if isfinite(high) and low < high]
        self._places = sorted(places)
        self.index_wanted = False
        self._at = 0.0
        self._turn = 0

    def inputs(self, shaft_rad: float) -> int:
        """Bits 0..2, 16, 17 of 60FDh."""
        bits = 0
        for signal, low, high in self._windows:
            if low < shaft_rad < high:
                bits |= 1 << signal
        return bits

    def active(self, signal: Signal, shaft_rad: float) -> bool:
        return bool(self.inputs(shaft_rad) >> signal & 1)

    def look_around(self, servo: DriveServo) -> None:
        """Sets the window the model watches to the nearest edges."""
        at = self._at = servo.position_rad
        low, high = -inf, inf
        for place in self._places:
            if place.shaft_rad <= at:
                low = place.shaft_rad
            else:
                high = place.shaft_rad
                break
        if self.index_wanted:
            self._turn, lower, upper = servo.turn_bounds_rad()
            low, high = max(low, lower), min(high, upper)
        servo.watch(low, high)

    def crossed(self, servo: DriveServo) -> list[Edge]:
        """The edges since the last look, in their order; looks around again."""
        before, now = self._at, servo.position_rad
        low, high, up = min(before, now), max(before, now), now > before
        found: list[tuple[float, Edge]] = []
        for place in self._places:
            if low < place.shaft_rad <= high if up else low <= place.shaft_rad < high:
                counter = _counter(servo, place.shaft_rad)
                found.append((place.shaft_rad, Edge(place.signal, place.rises_upwards is up, _direction(servo, up), counter)))
        if self.index_wanted and not servo.stuck:
            turn = int(servo.counter_inc // INC_PER_TURN)
            for number in range(min(turn, self._turn) + 1, max(turn, self._turn) + 1):
                counter = number * INC_PER_TURN
                found.append((servo.shaft_rad(counter), Edge(Signal.INDEX, True, 1 if turn > self._turn else -1, counter)))
        found.sort(key=lambda item: item[0], reverse=not up)
        self.look_around(servo)
        return [edge for _, edge in found]


def _counter(servo: DriveServo, shaft_rad: float) -> int:
    """The counter at that position."""
    return int((servo.counter_inc + (shaft_rad - servo.position_rad) * servo.slope) // 1.0)


def _direction(servo: DriveServo, up: bool) -> int:
    return 1 if up is (servo.slope >= 0.0) else -1
