"""The points of a BNR file as a timed path: the form in which a MOVE_FILE block reaches the axes.

One point belongs to one cycle, and at full speed each is a set value, unchanged.  Between them the path is a quintic, so that stop,
override and retrace keep to it as to any other path (AX-576).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.execution.timed import TimedPiece, most_nodes
from motion.files.move_file import Playback
from motion.geometry.limits import AxisLimits

Array = NDArray[np.float64]
NO_LIMIT = 1e9  # limit of the way; only the limits of the axes apply
ROOM = 1.05  # above what the file itself asks of an axis: the law of a stop has to live with it
MOST_PIECES = 900  # of one file: they are handed on together, and the ring and the follower hold a thousand


@dataclass(frozen=True)
class FilePath:
    """rows: (n + 1, axes) m or rad, where the axes are and then every point; period: s from one to the next."""

    rows: Array
    period: float

    @property
    def duration(self) -> float:
        """s at full speed."""
        return (len(self.rows) - 1) * self.period

    @property
    def end(self) -> tuple[float, ...]:
        """Where the axes will be."""
        return tuple(float(place) for place in self.rows[-1])

    def begun_at(self, position: Sequence[float]) -> "FilePath":
        """The same points from where the axes really are."""
        return FilePath(np.concatenate([np.array([position]), self.rows[1:]]), self.period)

    @cached_property
    def states(self) -> Array:
        """(n + 1, axes, 3) position, speed, acceleration; at rest at both ends."""
        q, h = self.rows, self.period
        found = np.zeros((*q.shape, 3))
        found[:, :, 0] = q
        found[1:-1, :, 1] = (q[2:] - q[:-2]) / (2 * h)
        found[1:-1, :, 2] = (q[2:] - 2 * q[1:-1] + q[:-2]) / h**2
        return found

    def at(self, t: Array) -> Array:
        """(m, axes) at these times, from 0 to the end."""
        steps = len(self.rows) - 1
        k = np.minimum((t / self.period).astype(int), steps - 1)
        u = np.clip(t / self.period - k, 0.0, 1.0)[:, None]
        left, right, h = self.states[k], self.states[k + 1], self.period
        a, b, c = left[:, :, 0], left[:, :, 1] * h, 0.5 * left[:, :, 2] * h * h
        gap, lean, curl = right[:, :, 0] - a - b - c, right[:, :, 1] * h - b - 2 * c, right[:, :, 2] * h * h - 2 * c
        d, e, f = 10 * gap - 4 * lean + 0.5 * curl, -15 * gap + 7 * lean - curl, 6 * gap - 3 * lean + 0.5 * curl
        return np.asarray(a + u * (b + u * (c + u * (d + u * (e + u * f)))))

    def check_size(self) -> None:
        """MotionError for more points than one block can have in a cell."""
        (points, axes), most = self.rows.shape, MOST_PIECES * (most_nodes(self.rows.shape[1]) - 1)
        if points - 1 > most:
            raise MotionError(f"a file of {points - 1} points: one block has at most {most} of {axes} axes; divide it into several files")

    def pieces(self, limits: Sequence[AxisLimits], *, first_id: int, mask: int, block: int) -> list[TimedPiece]:
        """All of it."""
        most = most_nodes(self.rows.shape[1])
        asked = np.abs(np.diff(self.rows, n=2, axis=0, prepend=self.rows[:1], append=self.rows[-1:])) / self.period**2
        jumps = np.abs(np.diff(self.rows, n=3, axis=0, prepend=self.rows[:1], append=self.rows[-1:])) / self.period**3
        accel = (*(max(axis.accel, ROOM * float(top)) for axis, top in zip(limits, asked.max(axis=0), strict=True)), NO_LIMIT)
        jerk = (*(max(axis.jerk, ROOM * float(top)) for axis, top in zip(limits, jumps.max(axis=0), strict=True)), NO_LIMIT)
        nodes = np.concatenate([self.states, self._way], axis=1).reshape(len(self.rows), -1).tolist()
        found: list[TimedPiece] = []
        for begin in range(0, len(nodes) - 1, most - 1):
            part = nodes[begin : begin + most]
            times = tuple(k * self.period for k in range(len(part)))
            last = begin + most >= len(nodes)
            found.append(TimedPiece(first_id + len(found), mask, block, times, tuple(map(tuple, part)), accel, jerk, ends_at_rest=last))
        return found

    @cached_property
    def _way(self) -> Array:
        """(n + 1, 1, 3) of the way, which grows with whatever axis moves."""
        steps = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.rows, axis=0), axis=1))])
        return FilePath(steps[:, None], self.period).states


def path_of(run: Playback, position: Sequence[float], rounds: Sequence[float], period_s: float) -> FilePath:
    """Start where the axes are; they reach the first point one period later.  rounds: added to the points of endless axes, which keep
    counting within a program.
    """
    rows = [tuple(position)]
    while not run.ended:
        rows.append(tuple(place + way for place, way in zip(run.step(), rounds, strict=True)))
    return FilePath(np.array(rows), period_s)
