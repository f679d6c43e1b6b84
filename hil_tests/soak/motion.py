"""`python -m hil_tests.soak.motion [PROGRAMS [SEGMENTS [SEED [PROCESSES]]]]`: random programs and a stream of short segments; exit
code 1 when a limit, the path or the stream was lost.  PROCESSES 0: one on each core.

Each program of a portal (lines, PTP, corners of all sizes, all speeds) is driven twice by the stepper at 1 ms: as it is, and with
random overrides, stops and ways back (looking ahead in C where that was built, as a cell does).  Its set values are judged by
differences: speed 1.00, acceleration 1.02, jerk 1.05 of the limits (1.10 while speed changes), and never 1 um off the path as it is
driven without orders.
"""

import math
import multiprocessing
import os
import random
import sys
import time
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gateway.cycle.native.quick import NativeParts
from gateway.tools.progress import Progress
from hil_tests.bench.motion_bench import random_program
from hil_tests.bench.path_figures import corner_dev
from hil_tests.lab.cells import arms
from hil_tests.lab.virtual.contour import SPEED, Streamed, stream
from motion.execution.stepper import State, Stepper
from motion.execution.timed import TimedPiece
from motion.planner.planner import Planner
from motion.timing.foresight import Foresight

Array = NDArray[np.float64]
MS, FINE = 1e-3, 2e-4  # s: of the set values; of the curve they are compared with (its chords are 0.1 um off at 20 m/s2)
TOPS = (1.0, 1.02, 1.05)  # speed, acceleration, jerk as shares of the limits
TOPS_CHANGING = (1.0, 1.02, 1.10)
OFF = 1e-6  # m
MOST = 400_000  # periods


class Judged(NamedTuple):
    """Of one program: worst shares as driven plainly and with orders, and the largest distance from the path."""

    seed: int
    plain: tuple[float, float, float]
    ordered: tuple[float, float, float]
    off: float

    @property
    def good(self) -> bool:
        kept = all(share <= top for share, top in zip(self.plain, TOPS, strict=True))
        return kept and all(share <= top for share, top in zip(self.ordered, TOPS_CHANGING, strict=True)) and self.off <= OFF


def pieces_of(seed: int) -> list[TimedPiece]:
    """A random program, planned whole."""
    machine = arms.portal()
    planner = Planner(machine, (0.0, 0.0, 0.0), ahead_s=math.inf)
    for block in random_program(random.Random(seed), machine):
        planner.add(block)
    planner.finish()
    pieces: list[TimedPiece] = []
    while fresh := planner.plan(0.0, hurry=True):
        pieces += fresh
    return pieces


def loaded(pieces: Iterable[TimedPiece], period_s: float, foresight: type[Foresight] = Foresight) -> Stepper:
    stepper = Stepper(3, period_s, (0.0, 0.0, 0.0), foresight)
    for piece in pieces:
        stepper.load(piece)
    return stepper


def driven(stepper: Stepper) -> list[tuple[float, ...]]:
    """To the end of the program; where it started first."""
    rows: list[tuple[float, ...]] = [(0.0, 0.0, 0.0)]
    while stepper.state is not State.IDLE and len(rows) < MOST:
        rows.append(stepper.step().q)
    assert stepper.state is State.IDLE, "the program does not end"
    return rows


def ordered(stepper: Stepper, dice: random.Random, orders: int = 12) -> list[tuple[float, ...]]:
    """The same with orders in between."""
    rows: list[tuple[float, ...]] = [(0.0, 0.0, 0.0)]
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
    machine, pieces = arms.portal(), pieces_of(seed)
    plain = np.array(driven(loaded(pieces, MS)))
    other = np.array(ordered(loaded(pieces, MS, NativeParts().foresight), random.Random(seed)))
    moved = other[np.concatenate([[True], np.any(np.diff(other, axis=0) != 0.0, axis=1)])]
    return Judged(seed, arms.shares(machine, plain, MS), arms.shares(machine, other, MS), away(moved[::23], curve_of(pieces)))


def programs(count: int, seed: int, processes: int) -> tuple[list[str], list[str]]:
    """(figures in words, what was wrong)."""
    with multiprocessing.Pool(processes, os.nice, (10,)) as pool:
        found, seeds = [], range(seed * 1_000_000, seed * 1_000_000 + count)
        with Progress("motion programs", count) as shown:
            for one in pool.imap(judged, seeds, chunksize=1):
                found.append(one)
                shown(len(found))
    plain, orders = (
        tuple(max(values) for values in zip(*(getattr(one, name) for one in found), strict=True)) for name in ("plain", "ordered")
    )
    off = max(one.off for one in found)
    words = [
        f"programs: {count}; v {plain[0]:.4f}, a {plain[1]:.4f}, jerk {plain[2]:.4f} x limit",
        f"  with orders: v {orders[0]:.4f}, a {orders[1]:.4f}, jerk {orders[2]:.4f} x limit, {off * 1e6:.3f} um off the path",
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
    lines, wrong = programs(count, seed, processes or os.cpu_count() or 1)
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
