"""Path and law -> timed pieces for the ring."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.execution.timed import TimedPiece, most_nodes
from motion.paths.joints import JointPath
from motion.planner.node_reduction import LEFT_S, needed
from motion.timing.law import Law
from motion.timing.limits import LawLimits

Array = NDArray[np.float64]
SPACING_S = 0.8e-3  # between nodes at most: wider ones round the corners of the jerk off and over
CLOSE = 2e-7  # m or rad between pieces and path, looked at between the nodes
NO_LIMIT = 1e9  # a record holds numbers: means none
PLENTY, MOST = 128, 800  # pieces of a law: beyond, only needed nodes stay; capacity of the ring to the cycle
FEW, FEW_S, SHORT_S = 2, 0.08, 8.0  # pieces of a short law that ends for good: beyond, only needed nodes stay; duration of a piece
LONGEST_S, COLUMNS = 0.5, 7  # longest piece up to this many columns (shorter for more): the cycle examines each ms at once


class TooLongError(MotionError):
    """A law of more pieces than the ring holds.  s: on its path, where they end; block: of the path there, once it is known."""

    def __init__(self, seconds: float, possible: float, s: float) -> None:
        self.s, self.block = s, 0
        super().__init__(
            f"a motion of {seconds:.0f} s without a stop is too long, {possible:.0f} s are possible here: run it faster, or stop in between"
        )


def timed_pieces(
    path: JointPath,
    limits: LawLimits,
    law: Law,
    *,
    first_id: int = 1,
    mask: int | None = None,
    blocks: Sequence[tuple[float, int]] = (),
    new_tail: bool = False,
    whole: bool = False,
) -> list[TimedPiece]:
    """Return the pieces of the entire law; the last one ends at rest.

    mask: which axis of the cell each axis of the path is (ascending bits, default the first ones); blocks: (s at its end, block number),
    ascending.  A piece belongs to one block.  whole: no law continues it, it is never cut.  Raise TooLongError.
    """
    whole = whole and law.duration <= SHORT_S
    bits = (1 << path.axes) - 1 if mask is None else mask
    if bits.bit_count() != path.axes:
        raise MotionError(f"mask {bits:#x} does not name {path.axes} axes")
    index, states = _nodes(path, law)
    numbers = _numbers(law.s[index], blocks)
    accel, jerk = (_finite([*limit[: path.axes], limit[-2]]) for limit in (limits.accel, limits.jerk))
    most, longest = most_nodes(path.axes), LONGEST_S * min(COLUMNS / (path.axes + 1), 1.0) / law.step
    if len(index) > (FEW if whole else PLENTY) * (most - 1):
        if whole:
            longest = min(longest, FEW_S / law.step)
        times, left_s = law.step * np.array(index), 0.0 if whole else LEFT_S
        stay = needed(times, states, np.array(numbers), np.array(accel), longest * law.step, left_s=left_s).tolist()
        index, states, numbers = [index[k] for k in stay], states[stay], [numbers[k] for k in stay]
    rows = [tuple(row) for row in states.tolist()]
    pieces: list[TimedPiece] = []
    begin = 0
    while begin < len(index) - 1:
        end = begin + 1
        while (
            end < len(index) - 1 and end - begin < most - 1 and numbers[end] == numbers[begin] and index[end + 1] - index[begin] <= longest
        ):
            end += 1
        if len(pieces) == MOST:
            raise TooLongError(law.duration, index[begin] * law.step, float(law.s[index[begin]]))
        taus = tuple(float(k - index[begin]) * law.step for k in index[begin : end + 1])
        pieces.append(
            TimedPiece(first_id + len(pieces), bits, numbers[begin], taus, tuple(rows[begin : end + 1]), accel, jerk, ends_at_rest=False)
        )
        begin = end
    pieces[-1] = replace(pieces[-1], ends_at_rest=True)
    if new_tail:
        pieces[0] = replace(pieces[0], new_tail=True)
    return pieces


def _numbers(s: Array, blocks: Sequence[tuple[float, int]]) -> list[int]:
    """Block of the interval that begins at each node."""
    if not blocks:
        return [0] * len(s)
    ends = np.array([end for end, _ in blocks])
    return [blocks[min(int(k), len(blocks) - 1)][1] for k in np.searchsorted(ends, s, side="right")]


def _finite(values: Sequence[float]) -> tuple[float, ...]:
    return tuple(min(float(value), NO_LIMIT) for value in values)


def _nodes(path: JointPath, law: Law) -> tuple[list[int], Array]:
    """Points of the law's grid that become nodes, and (n, 3 x (axes + 1)) position, speed, acceleration there; as far apart as
    the path allows."""
    every = max(int(SPACING_S / law.step), 1)
    while True:
        index = [*range(0, len(law.s) - 1, every), len(law.s) - 1]
        states = _states(path, law.s[index], law.speed[index], law.accel[index])
        if every == 1 or _gap(path, law, index, states) <= CLOSE:
            return index, states
        every = max(every // 2, 1)


def _states(path: JointPath, s: Array, speed: Array, accel: Array) -> Array:
    q, first, second = (np.delete(path.at(s, order), -1, axis=1) for order in range(3))
    v, a = speed[:, None], accel[:, None]
    return np.stack([q, first * v, second * v * v + first * a], axis=2).reshape(len(s), -1)


def _gap(path: JointPath, law: Law, index: list[int], states: Array) -> float:
    """Return the largest distance of the quintics from the path at the best s: deviations from the path, not in time."""
    times = law.step * np.array(index)
    left, right = states[:-1].reshape(len(index) - 1, -1, 3), states[1:].reshape(len(index) - 1, -1, 3)
    h = np.diff(times)[:, None]
    worst = 0.0
    for share in (0.25, 0.5, 0.75):
        at = _blend(left, right, h, share)
        s = law.at(times[:-1] + share * h[:, 0])
        first = path.at(s, 1)[:, : path.axes]
        error = at[:, : path.axes] - path.at(s)[:, : path.axes]
        shift = np.sum(error * first, axis=1) / np.maximum(np.sum(first * first, axis=1), 1e-30)
        worst = max(worst, float(np.max(np.abs(error - shift[:, None] * first))))
    return worst


def _blend(left: Array, right: Array, h: Array, u: float) -> Array:
    """Value of the quintic between two nodes at share u."""
    a, b, c = left[:, :, 0], left[:, :, 1] * h, 0.5 * left[:, :, 2] * h * h
    gap, lean, curl = right[:, :, 0] - a - b - c, right[:, :, 1] * h - b - 2 * c, right[:, :, 2] * h * h - 2 * c
    return np.asarray(
        a
        + u
        * (
            b
            + u
            * (c + u * ((10 * gap - 4 * lean + 0.5 * curl) + u * ((-15 * gap + 7 * lean - curl) + u * (6 * gap - 3 * lean + 0.5 * curl))))
        )
    )
