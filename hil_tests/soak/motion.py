"""`python -m hil_tests.soak.motion [PROGRAMS [SEGMENTS [SEED [PROCESSES]]]]`: random programs and a stream of short segments; exit
code 1 when a limit, the path or the stream was lost.  PROCESSES 0: one on each core.

Programs of a six-axis arm, a SCARA and a portal in equal parts (hil_tests.soak.robots).  Each is driven twice by the stepper at 1 ms:
as it is, and with random overrides, stops and ways back (looking ahead in C where that was built, as a cell does).  Its set values are
judged by differences: speed 1.00, acceleration 1.02, jerk 1.05 of the limits (1.10 while speed changes), never 1 um or urad off the
path as it is driven without orders; and on paper the tool keeps the speeds of its blocks.  A fifth as many programs have parts on belts
(hil_tests.soak.belts).
"""

import math
import multiprocessing
import os
import random
import sys
import time
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gateway.cycle.native.quick import NativeParts
from gateway.tools.progress import Progress
from hil_tests.bench.motion_bench import random_program
from hil_tests.bench.path_figures import corner_dev
from hil_tests.lab.cells import arms
from hil_tests.lab.judges.tool_speed import sampled
from hil_tests.lab.virtual.contour import SPEED, Streamed, stream
from hil_tests.soak.belts import rides
from hil_tests.soak.robots import drawn
from motion.execution.stepper import State, Stepper
from motion.execution.timed import TimedPiece
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.program.blocks import Block, Program
from motion.timing.foresight import Foresight

Array = NDArray[np.float64]
MS, FINE = 1e-3, 1e-4  # s: of the set values; of the curve they are compared with (its chords are 0.3 urad off at 250 rad/s2)
TOPS = (1.0, 1.02, 1.05)  # speed, acceleration, jerk as shares of the limits
TOPS_CHANGING = (1.0, 1.02, 1.10)
OFF = 1e-6  # m or rad
TOOL = (1.002, 1.002, 1.02)  # path speed, turning speed, acceleration along the path, of those programmed
ORIGIN = (0.0, 0.0, 0.0)
MOST = 400_000  # periods
RIDES = 5  # of so many programs there is one more with a part on a belt


class Judged(NamedTuple):
    """Of one program: worst shares as driven plainly and with orders, the largest distance from the path, and shares of the tool."""

    seed: int
    robot: str
    plain: tuple[float, float, float]
    ordered: tuple[float, float, float]
    off: float
    tool: tuple[float, float, float]

    @property
    def good(self) -> bool:
        pairs = ((self.plain, TOPS), (self.ordered, TOPS_CHANGING), (self.tool, TOOL))
        return self.off <= OFF and all(share <= top for shares, tops in pairs for share, top in zip(shares, tops, strict=True))


def pieces_of(seed: int) -> list[TimedPiece]:
    """A random program of a portal without rotation, planned whole."""
    machine = arms.portal()
    return planned(machine, ORIGIN, random_program(random.Random(seed), machine))


def planned(machine: Machine, start: Sequence[float], blocks: Iterable[Block]) -> list[TimedPiece]:
    """All pieces of a program that is known whole."""
    planner = Planner(machine, start, ahead_s=math.inf)
    for block in blocks:
        planner.add(block)
    planner.finish()
    pieces: list[TimedPiece] = []
    while fresh := planner.plan(0.0, hurry=True):
        pieces += fresh
    return pieces


def loaded(pieces: Sequence[TimedPiece], period_s: float, foresight: type[Foresight] = Foresight) -> Stepper:
    start = pieces[0].start()
    stepper = Stepper(len(start), period_s, start, foresight)
    for piece in pieces:
        stepper.load(piece)
    return stepper


def driven(stepper: Stepper, start: Sequence[float] = ORIGIN) -> list[tuple[float, ...]]:
    """To the end of the program; where it started first."""
    rows: list[tuple[float, ...]] = [tuple(start)]
    while stepper.state is not State.IDLE and len(rows) < MOST:
        rows.append(stepper.step().q)
    assert stepper.state is State.IDLE, "the program does not end"
    return rows


def ordered(stepper: Stepper, dice: random.Random, start: Sequence[float] = ORIGIN, orders: int = 12) -> list[tuple[float, ...]]:
    """The same with orders in between."""
    rows: list[tuple[float, ...]] = [tuple(start)]
    for _ in range(orders):
        match dice.randint(0, 3):
            case 0:
                stepper.stop()
            case 1 if stepper.state is State.STOPPED:
                stepper.retrace()
            case 2:
                stepper.set_override(dice.choice((0.05, 0.3, 0.6, dice.random())))
            case _:
                stepper.resume()
        rows += [stepper.step().q for _ in range(dice.randint(20, 300))]
    stepper.set_override(1.0)
    stepper.resume()
    return rows + driven(stepper)[1:]


def curve_of(pieces: Iterable[TimedPiece]) -> Array:
    """(n, axes) of the pieces themselves, FINE apart: where the axes may be at all, whatever the stepper makes of it."""
    rows = []
    for piece in pieces:
        at = np.linspace(0.0, piece.duration, max(math.ceil(piece.duration / FINE), 1) + 1)
        times = np.array(piece.times)
        k = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
        terms, u = np.array(piece.quintics)[k, : len(piece.axes)], (at - times[k])[:, None]
        value = terms[:, :, 0]
        for n in range(1, 6):
            value = value * u + terms[:, :, n]
        rows.append(value)
    return np.concatenate(rows)


def away(points: Array, curve: Array) -> float:
    """Largest distance of points from a polyline."""
    a, step = curve[:-1], np.diff(curve, axis=0)
    length = np.einsum("ij,ij->i", step, step)
    worst = 0.0
    for q in points:
        off = q - a
        u = np.clip(np.einsum("ij,ij->i", off, step) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
        off -= u[:, None] * step
        worst = max(worst, float(np.einsum("ij,ij->i", off, off).min()))
    return math.sqrt(worst)


def judged(seed: int) -> Judged:
    """One program."""
    name, start, blocks = drawn(seed)
    machine = arms.robot(name)
    pieces = planned(machine, start, blocks)
    plain = np.array(driven(loaded(pieces, MS), start))
    other = np.array(ordered(loaded(pieces, MS, NativeParts().foresight), random.Random(seed), start))
    moved = other[np.concatenate([[True], np.any(np.diff(other, axis=0) != 0.0, axis=1)])]
    off, tool = away(moved[::23], curve_of(pieces)), sampled(Program("soak", name, start, tuple(blocks)))
    return Judged(seed, name, arms.shares(machine, plain, MS), arms.shares(machine, other, MS), off, tool)


def programs(count: int, seed: int, processes: int) -> tuple[list[str], list[str]]:
    """(figures in words, what was wrong)."""
    with multiprocessing.Pool(processes, os.nice, (10,)) as pool:
        found, seeds = [], range(seed * 1_000_000, seed * 1_000_000 + count)
        with Progress("motion programs", count) as shown:
            for one in pool.imap(judged, seeds, chunksize=1):
                found.append(one)
                shown(len(found))
    plain, orders, tool = (
        tuple(max(values) for values in zip(*(getattr(one, name) for one in found), strict=True)) for name in ("plain", "ordered", "tool")
    )
    off = max(one.off for one in found)
    words = [
        f"programs: {count}; v {plain[0]:.4f}, a {plain[1]:.4f}, jerk {plain[2]:.4f} x limit",
        f"  with orders: v {orders[0]:.4f}, a {orders[1]:.4f}, jerk {orders[2]:.4f} x limit, {off * 1e6:.3f} um or urad off the path",
        f"  tool: speed {tool[0]:.4f}, turning {tool[1]:.4f}, acceleration {tool[2]:.4f} x programmed",
    ]
    return words, [f"program {one.seed}: {one}" for one in found if not one.good]


def streamed(found: Streamed) -> tuple[list[str], list[str]]:
    """(figures in words, what was wrong)."""
    words = [
        f"stream: {found.blocks} segments, {found.seconds:.0f} s of motion, {found.starved} periods starved, "
        f"slowest {found.slowest / SPEED:.2f} of the speed, {found.waiting} blocks ahead; "
        f"a {found.accel:.3f}, jerk {found.jerk:.3f} x limit"
    ]
    return words, ["stream: starved"] if found.starved or found.slowest < 0.5 * SPEED else []


def main() -> int:
    count, segments, seed, processes = (int(text) for text in (*sys.argv[1:5], *("1000", "150000", "1", "0")[len(sys.argv) - 1 :]))
    begin = time.monotonic()
    processes = processes or os.cpu_count() or 1
    lines, wrong = programs(count, seed, processes)
    more, bad = rides(-(-count // RIDES), seed, processes)
    lines, wrong = lines + more, wrong + bad
    corner = corner_dev(10 * count)
    lines.append(f"corners: {10 * count}, {corner['value']} um beyond their tolerance")
    if not corner["met"]:
        wrong.append("corners: beyond their tolerance")
    if segments:
        more, bad = streamed(stream(segments, 0.004))
        lines, wrong = lines + more, wrong + bad
    print("\n".join([*lines, *wrong[:20], f"motion: seed {seed}, {len(wrong)} wrong, {time.monotonic() - begin:.0f} s"]))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
