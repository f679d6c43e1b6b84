"""Cut of a path: the stretches after a block, and the remainder of the others from where the axes rest (AX-1080)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from motion.paths.joints import JointPath, joint_part
from motion.planner.route import RouteState
from motion.planner.runs import Run, progress
from motion.planner.stretch import EMPTY, Kind, Stretch

LOOKS, CLOSER = 65, 60  # places looked at for where the axes rest; steps to come closer, each by a third
WAY_COLUMNS = 2  # columns of a path after its axes


def beyond(stretch: Stretch, number: int, state: RouteState) -> bool:
    """Return whether the stretch belongs to the path after this block or depends on it.  state: the route after the block."""
    if stretch.block != number:
        return stretch.block > number
    known = state.known / state.last.length if state.last is not None else 1.0
    return stretch.kind is Kind.CORNER or (known < 1.0 - EMPTY and stretch.share[0] >= known - EMPTY)


def rest_of(ahead: Sequence[Stretch], runs: Sequence[tuple[Run, float, float]], places: Sequence[float]) -> list[Stretch]:
    """ahead: stretches that are still wanted; runs: where the axes may be, between two s of each; places: where they are."""
    found = min((_nearest(run, low, high, places) for run, low, high in runs), key=lambda each: each[0], default=None)
    if found is None:
        return list(ahead)
    _, under_way, u = found
    index = next((k for k, each in enumerate(ahead) if each is under_way), None)
    if index is None:
        return []
    rows = [*_rest(under_way, u, ahead), *ahead[index + 1 :]]
    if rows:
        rows[0] = replace(rows[0], path=begun_at(rows[0].path, places))
    return rows


def _nearest(run: Run, low: float, high: float, places: Sequence[float]) -> tuple[float, Stretch, float]:
    """Distance, stretch and s on it."""
    wanted = np.array(places)

    def gaps(s: Sequence[float]) -> list[float]:
        rows = run.path.at(np.array(s))[:, : len(wanted)] - wanted
        return [float(gap) for gap in np.sqrt(np.sum(rows * rows, axis=1))]

    s = [float(each) for each in np.linspace(low, high, LOOKS)]
    found = gaps(s)
    k = found.index(min(found))
    left, right = s[max(k - 1, 0)], s[min(k + 1, LOOKS - 1)]
    for _ in range(CLOSER):
        one, other = left + (right - left) / 3.0, right - (right - left) / 3.0
        a, b = gaps([one, other])
        left, right = (left, other) if a < b else (one, right)
    here = 0.5 * (left + right)
    index = max(k for k, start in enumerate(run.starts) if start <= here + EMPTY)
    return gaps([here])[0], run.stretches[index], here - run.starts[index]


def _rest(stretch: Stretch, u: float, ahead: Sequence[Stretch]) -> list[Stretch]:
    """Return the remainder of one stretch; a cut corner becomes the end of its block and the beginning of the next."""
    length = stretch.path.length
    if length - u <= EMPTY * length:
        return []
    _, share = progress(stretch, u)
    if stretch.kind is Kind.MAIN:
        return [_part(stretch, u, length, (share, stretch.share[1]))]
    middle = 0.5 * length
    following = stretch.following
    assert following is not None
    way = next((each.way for each in ahead if each.block == stretch.block + 1), stretch.way)
    onward = replace(stretch, kind=Kind.MAIN, block=stretch.block + 1, source=following, following=None, way=way)
    if u >= middle:
        return [_part(onward, u, length, (share, stretch.share[1]))]
    first = replace(stretch, kind=Kind.MAIN, following=None, stop=False)
    return [_part(first, u, middle, (share, 1.0)), _part(onward, middle, length, (0.0, stretch.share[1]))]


def _part(stretch: Stretch, begin: float, end: float, share: tuple[float, float]) -> Stretch:
    source, time = stretch.source, stretch.source.pace.time
    if time is not None:
        source = replace(source, pace=replace(source.pace, time=time * (share[1] - share[0])))
    return replace(stretch, path=joint_part(stretch.path, begin, end), share=share, source=source, clock=None, square=None)


def begun_at(path: JointPath, places: Sequence[float]) -> JointPath:
    """Return the path with its start moved to where the axes rest, a fraction of a micrometre away; its end is unchanged."""
    table, length = path.coefficients.copy(), path.length
    aside = np.array(places) - table[0, 0, : len(places)]
    table[:, 0, : len(places)] += aside * (1.0 - path.knots[:-1] / length)[:, None]
    table[:, 1, : len(places)] -= aside / length
    return JointPath(path.knots, table)
