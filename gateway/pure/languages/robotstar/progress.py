"""How far the robot is on its way to the position in force: _RPATH_DIST, _RTIME_DIST, M1464 to M1479.  Source: L2973-2980; AX-1833."""

import math
from dataclasses import dataclass

from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.lines import arc_length
from gateway.pure.languages.robotstar.path import Target
from protocols.base.machine import Ns

FIRST = 1464  # four double words: done and left in 0.01 mm, done and left in 0.01 s
HIGHEST = 2**31 - 1
REPORT_NS: Ns = 50_000_000


@dataclass(frozen=True, slots=True)
class Progress:
    """length: of the tool's way, mm; seconds: programmed duration at an override of 100 %; share: the part done, 0 .. 1."""

    length: float = 0.0
    seconds: float = 0.0
    share: float = 1.0

    def values(self) -> tuple[float, float, float, float]:
        """Length done and left in mm, time done and left in s."""
        done = self.share
        return self.length * done, self.length * (1 - done), self.seconds * done, self.seconds * (1 - done)

    def numbers(self) -> tuple[int, ...]:
        """The same as the markers have it."""
        return tuple(min(round(value * 100), HIGHEST) for value in self.values())


class Reports:
    """What the markers are given of it, as often as a page or a PLC can follow."""

    def __init__(self) -> None:
        self._last: tuple[int, ...] = ()  # after a memory was read anew the markers hold the numbers of the previous one
        self._at: Ns = 0

    def due(self, progress: Progress, now: Ns) -> str:
        """The numbers to send, separated by blanks; empty: they have not changed, or the last ones are too young."""
        if now - self._at < REPORT_NS or (numbers := progress.numbers()) == self._last:
            return ""
        self._last, self._at = numbers, now
        return " ".join(str(number) for number in numbers)


def length_of(start: Target, target: Target, via: Target | None = None) -> float:
    """The way of the tool in mm: straight, or on the arc through `via`; 0 where one of them is given by its axes."""
    if not start.pose or not target.pose:
        return 0.0
    if via is not None and via.pose:
        try:
            return arc_length(start.pose, via.pose, target.pose)
        except StepFault:
            return 0.0  # no circle: the planner refuses it
    return math.dist(start.pose[:3], target.pose[:3])
