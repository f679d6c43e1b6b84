"""Dry run of a program: set values on a grid of 1 ms, what the tool does, loads of the axes, how corners are missed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motion.geometry.frames import Pose
from motion.planner.corner_choice import quicker
from motion.planner.law_cache import KnownLaws
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.planner.runs import make_run, runs
from motion.planner.stretch import Kind, Stretch
from motion.planner.team import Team
from motion.program.blocks import Block, PoseTarget, Program
from motion.program.errors import BlockError
from motion.program.factors import FULL, Factors
from motion.timing.slices import whole

Array = NDArray[np.float64]
PERIOD_S = 1e-3


@dataclass(frozen=True)
class CornerReport:
    """How far the path misses the end point of a block (m)."""

    block: int
    line: int
    missed: float
    begins: float  # m before the point
    ends: float  # m after it


@dataclass(frozen=True)
class BeltWay:
    """What a belt did while blocks lay on it.  t: (n,) s; value: (n,) of its counter, m or rad; unit: its own, for showing."""

    name: str
    unit: str
    t: Array
    value: Array


@dataclass(frozen=True)
class Trace:
    """t: (n,) s; q: (n, axes); tool: (n, 3) m; block: (n,) numbers; speeds by central differences on the grid."""

    t: Array
    q: Array
    tool: Array
    block: NDArray[np.int64]
    period: float
    corners: tuple[CornerReport, ...]
    ends: tuple[tuple[int, float], ...]  # (block, s at which it is left)
    belts: tuple[BeltWay, ...] = ()
    cuts: tuple[int, ...] = ()  # rows at which the numbers of the resting axes change (SF 3)

    def rate(self, values: Array, order: int) -> Array:
        """Differences by time, at rest before and after; same length."""
        found = self._differences(values, order)
        for cut in self.cuts:
            found[max(cut - 2, 0) : cut + 2] = 0.0
        return found

    def _differences(self, values: Array, order: int) -> Array:
        padded = np.concatenate([np.repeat(values[:1], 2, axis=0), values, np.repeat(values[-1:], 2, axis=0)])
        h = self.period
        if order == 1:
            return np.asarray((padded[3:-1] - padded[1:-3]) / (2 * h))
        if order == 2:
            return np.asarray((padded[3:-1] - 2 * padded[2:-2] + padded[1:-3]) / h**2)
        return np.asarray((padded[4:] - 2 * padded[3:-1] + 2 * padded[1:-3] - padded[:-4]) / (2 * h**3))

    def tool_speed(self) -> Array:
        """(n,) m/s."""
        return np.asarray(np.linalg.norm(self.rate(self.tool, 1), axis=1))

    def loads(self, machine: Machine, order: int) -> Array:
        """(n, axes) share of the limit of speed (1), acceleration (2) or jerk (3)."""
        name = {1: "speed", 2: "accel", 3: "jerk"}[order]
        return np.asarray(np.abs(self.rate(self.q, order)) / np.array([getattr(axis, name) for axis in machine.limits]))

    def later(self, blocks: int, seconds: float = 0.0) -> "Trace":
        """Return the same trace, shifted by these blocks and seconds."""
        return replace(
            self,
            t=self.t + seconds,
            block=self.block + blocks,
            corners=tuple(replace(corner, block=corner.block + blocks) for corner in self.corners),
            ends=tuple((block + blocks, at + seconds) for block, at in self.ends),
            belts=tuple(replace(way, t=way.t + seconds) for way in self.belts),
        )


def joined(parts: Sequence[Trace]) -> Trace:
    """One after the other, each beginning where the one before rests."""
    found, clock = [], 0.0
    for part in parts:
        found.append(part.later(0, clock))
        clock += len(part.t) * part.period
    begins = np.cumsum([0, *(len(part.t) for part in found)])[:-1].tolist()
    return Trace(
        np.concatenate([part.t for part in found]),
        np.concatenate([part.q for part in found]),
        np.concatenate([part.tool for part in found]),
        np.concatenate([part.block for part in found]),
        found[0].period,
        tuple(corner for part in found for corner in part.corners),
        tuple(end for part in found for end in part.ends),
        tuple(way for part in found for way in part.belts),
        tuple(begin + cut for begin, part in zip(begins, found, strict=True) for cut in part.cuts),
    )


@dataclass(frozen=True)
class Findings:
    """stretches up to the first fault; faults: of every block, each looked at from where the last good one ended."""

    stretches: tuple[Stretch, ...]
    faults: tuple[BlockError, ...]


def route_of(program: Program, machine: Machine) -> Findings:
    """All blocks, nothing moved."""
    route, faults, out, good = Route(machine, program.start), [], [], True
    for number, block in enumerate(program.blocks, 1):
        try:
            route.add(block)
        except BlockError as error:
            faults.append(numbered(error, number))
            good = False
        if good:
            out += route.take()
    try:
        route.finish()
    except BlockError as error:
        faults.append(error)
    return Findings(tuple(out + (route.take() if good else [])), tuple(faults))


def numbered(error: BlockError, number: int) -> BlockError:
    """The same fault under another number of its block."""
    return BlockError(error.what, code=error.code, block=number, axis=error.axis, source=error.source)


def trace(
    stretches: Sequence[Stretch], machine: Machine, factors: Factors = FULL, period: float = PERIOD_S, start: Sequence[float] = ()
) -> Trace:
    """Run all complete runs; `start`: position of the axes when there is none.  Raise MotionError where a path cannot be run at all."""
    rows, q, blocks, ends = sampled(stretches, machine, factors, period, start)
    return seen(rows, stretches, machine, q, blocks, ends, period)


def sampled(
    stretches: Sequence[Stretch], machine: Machine | Team, factors: Factors = FULL, period: float = PERIOD_S, start: Sequence[float] = ()
) -> tuple[list[list[Stretch]], Array, list[int], list[tuple[int, float]]]:
    """Stretches from rest to rest as they are run, set values (n, axes), block of each, (block, s at which it is left)."""
    parts, blocks, ends, clock = [], [], [], 0.0
    laws = KnownLaws()
    taken = laws.seconds(factors)
    rows = [row for run in runs(stretches, machine, factors) for row in whole(quicker(run.stretches, machine, taken, factors))]
    for run in (make_run(row, machine, factors) for row in rows):
        law = whole(laws.law(run, factors))
        count = math.ceil(law.duration / period)
        s = law.at(np.arange(count + 1, dtype=np.float64) * period)
        parts.append(run.path.at(s)[:, : machine.axes])
        blocks += [run.place(float(x))[0] for x in s]
        clock += (count + 1) * period
        ends.append((run.stretches[-1].block, clock))
    q = np.concatenate(parts) if parts else np.array([tuple(start) or (0.0,) * machine.axes])
    return rows, q, blocks or [1 if start else 0], ends


def seen(
    rows: Sequence[Sequence[Stretch]],
    stretches: Sequence[Stretch],
    machine: Machine,
    q: Array,
    blocks: Sequence[int],
    ends: Sequence[tuple[int, float]],
    period: float,
) -> Trace:
    """What one robot's tool does meanwhile."""
    tools = _tools(stretches)
    places, tool = [], next(iter(tools.values()), None)
    for row, block in zip(q, blocks, strict=True):
        tool = tools.get(block, tool)  # one of a team that rests keeps its tool
        places.append(tool_at(machine, row, tool))
    return Trace(
        np.arange(len(q), dtype=np.float64) * period,
        q,
        np.array(places),
        np.array(blocks),
        period,
        tuple(corner_report(stretch, machine) for row in rows for stretch in row if stretch.kind is Kind.CORNER),
        tuple(ends),
    )


def _tools(stretches: Sequence[Stretch]) -> dict[int, Pose]:
    found = {stretch.block: stretch.source.tool.pose for stretch in stretches}
    found |= {stretch.block + 1: stretch.following.tool.pose for stretch in stretches if stretch.following is not None}
    return found


def tool_at(machine: Machine, q: Sequence[float] | Array, tool: Pose | None) -> tuple[float, float, float]:
    """m: where the tool is when the axes are at q (axes,)."""
    flange = machine.forward([float(v) for v in q])
    return flange.position if tool is None else (flange @ tool).position


def corner_report(stretch: Stretch, machine: Machine) -> CornerReport:
    """Smallest distance of a corner from the point it rounds, on 200 places of it."""
    block: Block = stretch.source
    places = tool_places(stretch, machine, 201)
    point = _point(stretch, machine)
    away = np.linalg.norm(places - point, axis=1)
    return CornerReport(stretch.block, block.line, float(np.min(away)), float(away[0]), float(away[-1]))


def tool_places(stretch: Stretch, machine: Machine, count: int) -> Array:
    """(count, 3) m: where the tool is on the way of a stretch."""
    s = np.linspace(0.0, stretch.path.length, count)
    return np.array([tool_at(machine, q, stretch.source.tool.pose) for q in stretch.path.at(s)[:, : machine.axes]])


def _point(stretch: Stretch, machine: Machine) -> Array:
    target = stretch.source.target
    if isinstance(target, PoseTarget):
        return np.array((stretch.source.frame.pose @ target.pose).position)
    return np.array((machine.forward(target.q) @ stretch.source.tool.pose).position)
