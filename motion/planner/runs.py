"""Stretches between two rests -> one path with its limits, the input of a time law."""

import math
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate

import numpy as np

from motion.paths.joints import JointPath
from motion.planner.caps import block_caps, robot_limits
from motion.planner.robot import Machine
from motion.planner.stretch import Kind, Stretch
from motion.planner.team import Team, own_parts
from motion.program.blocks import Interpolation
from motion.program.factors import FULL, Factors
from motion.timing.limits import WAY, Cap, LawLimits

FLYBY_STEPS = 8  # of the speed along a corner with v_flyby
RATE_STEP = 1e-3  # of a corner, to either side of the place its rate is taken at


@dataclass(frozen=True)
class Run:
    """A path from rest to rest.  starts: s at which each stretch begins; limits hold over the whole run."""

    path: JointPath
    stretches: tuple[Stretch, ...]
    starts: tuple[float, ...]
    limits: LawLimits
    tools: int = 0  # columns of the path that only carry limits of a team's tools and no axis

    @property
    def even(self) -> bool:
        """The axes swing somewhere: the parameter is not the way all along."""
        return any(stretch.even for stretch in self.stretches)

    @property
    def driven(self) -> tuple[JointPath, LawLimits]:
        """What the axes get of it."""
        if not self.tools:
            return self.path, self.limits
        hidden = np.s_[self.path.axes - self.tools : self.path.axes]
        speed, accel, jerk = (np.delete(row, hidden) for row in (self.limits.speed, self.limits.accel, self.limits.jerk))
        return JointPath(self.path.knots, np.delete(self.path.coefficients, hidden, axis=2)), LawLimits(speed, accel, jerk)

    def place(self, s: float) -> tuple[int, float]:
        """(block, share of its way that is made) at s; within a corner the block changes in the middle."""
        index = self.index(s)
        return progress(self.stretches[index], s - self.starts[index])

    def index(self, s: float) -> int:
        """Of the stretch at s."""
        return max(bisect_right(self.starts, s) - 1, 0)


def progress(stretch: Stretch, u: float) -> tuple[int, float]:
    """(block, share of its way that is made) u after the start of a stretch.

    The share is that of the programmed way: in the first half of a corner it rises to 1, in the second half from 0 to the place where the
    next block is joined (AX-414).
    """
    part = min(max(_made(stretch.path, u) if stretch.even else u / stretch.path.length, 0.0), 1.0)
    begin, end = stretch.share
    if stretch.kind is Kind.MAIN:
        return stretch.block, begin + (end - begin) * part
    if part < 0.5:
        return stretch.block, begin + (1.0 - begin) * 2 * part
    return stretch.block + 1, end * (2 * part - 1)


def _made(path: JointPath, u: float) -> float:
    """Share of its way that is made there, or of its turning where it has no way."""
    here, end = path.at(np.array([u, path.length]))[:, WAY:]
    column = 0 if end[0] > 0.0 else 1
    return float(here[column] / end[column]) if end[column] > 0.0 else u / path.length


def runs(stretches: Iterable[Stretch], machine: Machine | Team, factors: Factors = FULL) -> list[Run]:
    """Whole runs in their order; a last one that does not stop is left out."""
    found: list[Run] = []
    row: list[Stretch] = []
    for stretch in stretches:
        row.append(stretch)
        if stretch.stop:
            found.append(make_run(row, machine, factors))
            row = []
    return found


def make_run(row: Sequence[Stretch], machine: Machine | Team, factors: Factors = FULL) -> Run:
    """One run of these stretches."""
    starts = [0.0]
    for stretch in row:
        starts.append(starts[-1] + stretch.path.length)
    caps = merged([cap for stretch, start in zip(row, starts, strict=False) for cap in all_caps(stretch, start, machine, factors)])
    tools = 2 * len(machine.machines) if isinstance(machine, Team) else 0
    path = _chained([stretch.path for stretch in row], tools + 2)
    return Run(path, tuple(row), tuple(starts[:-1]), _limits(machine, caps), tools)


def _limits(machine: Machine | Team, caps: Sequence[Cap]) -> LawLimits:
    return machine.law_limits(caps) if isinstance(machine, Team) else robot_limits(machine, caps)


def all_caps(stretch: Stretch, start: float, machine: Machine | Team, factors: Factors) -> list[Cap]:
    """Return the caps of a team: each kinematic's block limits its own columns."""
    if not isinstance(machine, Team):
        return caps_of(stretch, start, machine, factors)
    own = ((n, caps_of(part, start, machine.machines[n], factors)) for n, part in own_parts(stretch))
    return [replace(cap, column=machine.column(n, cap.column)) for n, caps in own for cap in caps]


def _chained(paths: Sequence[JointPath], counting: int) -> JointPath:
    """Join like motion.paths.joints.joined, without checking the joins that the route made.  counting: last columns that keep counting
    from path to path.
    """
    table = np.concatenate([path.coefficients for path in paths])
    counts, lengths = [len(path.coefficients) for path in paths], [path.length for path in paths]
    ends = np.cumsum(counts)
    last, first = table[ends - 1, :, -counting:], table[ends - counts, 0, -counting:]
    u = np.array([path.knots[-1] - path.knots[-2] for path in paths])[:, None]
    grows = ((((last[:, 5] * u + last[:, 4]) * u + last[:, 3]) * u + last[:, 2]) * u + last[:, 1]) * u
    shifts, offsets = np.empty_like(first), list(accumulate(lengths, initial=0.0))
    counted = np.zeros(counting)
    for k in range(len(paths)):
        shifts[k] = counted - first[k]
        counted = grows[k] + (last[k, 0] + shifts[k])
    table[:, 0, -counting:] += np.repeat(shifts, counts, axis=0)
    knots = np.concatenate([np.zeros(1), *(path.knots[1:] for path in paths)])
    knots[1:] += np.repeat(offsets[:-1], counts)
    return JointPath(knots, table)


def merged(caps: Sequence[Cap]) -> list[Cap]:
    """Neighbours that ask the same of a column become one: a thousand short blocks of one speed are one cap."""
    found: list[Cap] = []
    open_: dict[tuple[int, float, float, float], int] = {}
    for cap in caps:
        key = (cap.column, cap.speed, cap.accel, cap.decel)
        at = open_.get(key)
        if at is not None and found[at].end >= cap.start - 1e-12:
            found[at] = Cap(found[at].start, max(found[at].end, cap.end), *key)
        else:
            open_[key] = len(found)
            found.append(cap)
    return found


def caps_of(stretch: Stretch, start: float, machine: Machine, factors: Factors) -> list[Cap]:
    """What the pace of its block demands of a stretch; in a corner the slower of both blocks, unless v_flyby sets another."""
    end = start + stretch.path.length
    found = block_caps(stretch.source, stretch.path, stretch.way, start, end, machine, factors)
    if stretch.following is not None:
        behind = block_caps(stretch.following, stretch.path, stretch.way, 0.5 * (start + end), end, machine, factors)
        if stretch.source.blend.flyby is not None and _both_speeds(stretch) is not None:
            found = [cap for cap in found if cap.column != WAY or not math.isfinite(cap.speed)]
            found += _flyby(stretch, start, end, machine, factors)
            behind = [cap for cap in behind if cap.column != WAY]
        found += behind
    return found


def _both_speeds(stretch: Stretch) -> tuple[float, float] | None:
    following = stretch.following
    if following is None or Interpolation.PTP in (stretch.source.kind, following.kind):
        return None
    one, two = stretch.source.pace.path_speed, following.pace.path_speed
    return None if one is None or two is None else (one, two)


def _flyby(stretch: Stretch, start: float, end: float, machine: Machine, factors: Factors) -> list[Cap]:
    """Reis: (v1 + v2) / 2 * _IV_FLYBY_S / 100 in the middle of the corner, straight to the speeds of both blocks at its ends."""
    both, share = _both_speeds(stretch), stretch.source.blend.flyby
    assert both is not None and share is not None
    middle = max(0.5 * (both[0] + both[1]) * share, 1e-4)  # 0 itself is a stop there (AX-415)
    step = (end - start) / FLYBY_STEPS
    caps = []
    for k in range(FLYBY_STEPS):
        edges = [abs(2 * x / FLYBY_STEPS - 1) for x in (k, k + 1)]
        side = both[0] if k < FLYBY_STEPS // 2 else both[1]
        speed = max(middle + (side - middle) * edge for edge in edges)
        if k in (FLYBY_STEPS // 2 - 1, FLYBY_STEPS // 2):
            speed = middle
        speed /= _rate(stretch, machine, (k + 0.5) / FLYBY_STEPS if speed != middle else 0.5)
        caps.append(Cap(start + k * step, start + (k + 1) * step, WAY, speed * factors.velocity))
    return caps


def _rate(stretch: Stretch, machine: Machine, share: float) -> float:
    """Way of the tool for each of the path's own (AX-380): a corner's parameter is its way only nearly."""
    rows = stretch.path.at(stretch.path.length * np.array([share - RATE_STEP, share + RATE_STEP]))
    a, b = (machine.forward([float(v) for v in q]) for q in rows)
    tool, own = stretch.source.tool.pose, float(rows[1, WAY] - rows[0, WAY])
    made = math.dist((a @ tool).position, (b @ tool).position)
    return made / own if made > 0.0 and own > 0.0 else 1.0
