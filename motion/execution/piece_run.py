"""The running polynomial piece: (s, sdot, sddot) and its plan s(t), which is replanned whenever the target changes.

Where no plan exists (too close to the end to slow down, or rounding) the old plan stays active and the next period tries again.
"""

from enum import Enum, auto
from itertools import accumulate
from math import inf, sqrt
from typing import NamedTuple

from motion.execution.pieces import Piece
from motion.execution.profile import Profile

ARRIVED = 1e-12  # of the length: nothing left to go


class Goal(Enum):
    """Where the current plan leads; all but SLOW end at rest."""

    NONE = auto()  # at rest, no plan
    END = auto()  # end of the piece
    REST = auto()  # anywhere on the path
    SLOW = auto()  # down to a lower speed, from where END is planned


NONE, END, REST, SLOW = Goal  # looked up faster than Goal.NONE, in every period


class _Tables(NamedTuple):
    """Tables of a piece: per segment (axis, coefficients, highest power first); per grid interval the highest legal sdot to the end."""

    rows: list[list[tuple[int, tuple[float, ...]]]]
    floor: tuple[float, ...]


def stopping_distance(speed: float, accel: float, jerk: float) -> float:
    """Way from a steady speed to rest, jerk-limited."""
    ramp = accel / jerk
    return speed * (speed / accel + ramp) / 2 if speed >= accel * ramp else speed * sqrt(speed / jerk)


class PieceRun:
    """`piece`: the current piece or None; `stale`: a new plan is due; `running`: True continues the piece, False brings it to rest."""

    def __init__(self, period_s: float) -> None:
        self._period = period_s
        self.piece: Piece | None = None
        self.stale = False
        self._tables = _Tables([], ())
        self._profile = Profile()
        self._motion = (0.0, 0.0, 0.0)  # s, sdot, sddot
        self._time = 0.0  # s since the present plan began
        self._goal = NONE
        self._speed = inf  # sdot limit of the present plan
        self._slow = 0.0  # sdot at the end of SLOW

    @property
    def remaining(self) -> float:
        """Way left, in its s."""
        return self.piece.length - self._motion[0] if self.piece else 0.0

    @property
    def at_rest(self) -> bool:
        """No plan leads it."""
        return self._goal is NONE

    def begin(self, piece: Piece) -> None:
        self.piece = piece
        rows = [[(axis, row[::-1]) for axis, row in zip(piece.axes, segment.coefficients, strict=True)] for segment in piece.segments]
        lowest = list(accumulate(reversed(piece.table), min))[::-1]
        self._tables = _Tables(rows, tuple(sqrt(value) for value in lowest[:-1]))
        self._motion, self._goal, self.stale = (0.0, 0.0, 0.0), NONE, True
        if piece.length > 0:
            self._profile.configure(piece.length, piece.accel, piece.jerk)

    def step(self, piece: Piece, override: float, *, running: bool) -> None:
        """One period along the plan."""
        if self.stale or self._speed < self._legal_speed(override):
            self._plan(piece, override, running=running)
        if self._goal is not NONE:
            self._time += self._period
            if self._time < self._profile.duration or self._goal is SLOW:
                s, speed, accel = self._profile.at(self._time)
                self._motion = (min(max(s, self._motion[0]), piece.length), speed, accel)
                if self._time >= self._profile.duration:
                    self._slowed(piece, override, running=running)
            else:
                s = piece.length if self._goal is END else self._profile.at(self._profile.duration)[0]
                self._motion, self._goal = (min(max(s, self._motion[0]), piece.length), 0.0, 0.0), NONE

    def place(self, piece: Piece, q: list[float], qd: list[float]) -> tuple[float, bool]:
        """Set values of its axes, into both; s, and whether its end is reached."""
        s, sdot, _ = self._motion
        arrived = self._goal is NONE and piece.length - s <= ARRIVED * piece.length
        if arrived:
            s = piece.length
        rows = self._tables.rows
        index = piece.segment_at(s) if len(rows) > 1 else 0
        u = s - piece.segments[index - 1].end_s if index else s
        for axis, row in rows[index]:
            value = slope = 0.0
            for coefficient in row:
                slope = slope * u + value
                value = value * u + coefficient
            q[axis] = value
            qd[axis] = slope * sdot
        return s, arrived

    # ---- plans ---------------------------------------------------------------------------------------------------------
    def _legal_speed(self, override: float) -> float:
        """sdot limit from here to the end at this override (a falling minimum: always legal, AX-104)."""
        floor = self._tables.floor
        if len(floor) == 1 or not self.piece or self.piece.length == 0:
            return floor[0] * override
        index = int(self._motion[0] / self.piece.length * len(floor))
        return floor[min(index, len(floor) - 1)] * override

    def _plan(self, piece: Piece, override: float, *, running: bool) -> None:
        """A new plan from the present state."""
        speed = self._speed = self._legal_speed(override)
        if piece.length == 0:
            planned = True
        elif not running or speed == 0.0:
            planned = self._plan_rest()
        elif self._too_fast(piece, speed):
            planned = self._plan_slow(piece, speed)
        else:
            planned = self._plan_end(speed)
        self.stale = not planned

    def _plan_rest(self) -> bool:
        if self._goal in (NONE, REST):
            return True
        return self._begin(REST, self._profile.to_speed(self._motion, 0.0))

    def _plan_end(self, speed: float) -> bool:
        return self._begin(END, self._profile.to_end(self._motion, speed))

    def _plan_slow(self, piece: Piece, speed: float) -> bool:
        """First down to the speed, then on: in one plan ruckig would dive through zero when the speed is low (AX-102)."""
        latest = piece.length - stopping_distance(speed, piece.accel, piece.jerk) - speed * self._period
        if not self._profile.to_speed(self._motion, speed, latest):
            return False
        self._slow = speed
        return self._begin(SLOW, True)

    def _begin(self, goal: Goal, planned: bool) -> bool:
        if planned:
            self._time, self._goal = 0.0, goal
        return planned

    def _too_fast(self, piece: Piece, speed: float) -> bool:
        """Faster than speed, or about to be even if acceleration is taken back at once."""
        _, sdot, sddot = self._motion
        ahead = sddot * sddot / (2 * piece.jerk) if sddot > 0 else 0.0
        return sdot + ahead > speed * (1 + 1e-9)

    def _slowed(self, piece: Piece, override: float, *, running: bool) -> None:
        """SLOW has ended (steady speed from there): the rest is planned from this sample on."""
        self._motion = (self._motion[0], self._slow, 0.0)
        self._plan(piece, override, running=running)
        if self._goal is SLOW and self.stale and not self._plan_end(self._slow):  # room was kept when SLOW was planned
            self._plan_rest()
