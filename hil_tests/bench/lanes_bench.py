"""Lanes and streams: what a period costs with four lanes compared with one, how many blocks of a stream the planner takes in a second, how
soon the first set value and the answer to a block come.

Periods are those of the core on emulated drives, processor time with garbage collection as in the product.  Times of streams are virtual:
a turn of the planner each period, one record of the stream a turn or many.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

from drivers.drives.family import Actual
from gateway.assembly.axes import core_axes
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.records.cell import InputImage, Motion, OrderRecord
from gateway.pure.image.records.planner import BlockRecord, PieceRecord, Say
from hil_tests.bench.figure_row import EMPTY_LOOP, Figure, loop_turns, row
from hil_tests.lab.cells.arm_and_scara import CELL
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.cell_bench import ENABLING
from hil_tests.lab.virtual.stream_bench import StreamBench

AXES, LANES = 12, 4
WAY, SPEED = 80.0, 0.2  # mm of each axis; share of its speed
BLOCKS, STEP = 200, 2.0  # of a stream; mm
ORDERS = 12
SHORT = "planner's processor time"
ONE = CELL.axis[0]
MANY = replace(
    CELL,
    axis=tuple(replace(ONE, name=f"A{n}", drive=replace(ONE.drive, node=n)) for n in range(1, AXES + 1)),
    robot=(),
    program=(),
    plant=None,
)


class Timed(Cell402Bench):
    """Twelve axes in `lanes` lanes; `costs`: ns of processor time of each step of the core."""

    def __init__(self, lanes: int) -> None:
        self.lanes, self.costs = lanes, list[int]()
        super().__init__(cell=MANY)
        self.permit(*ENABLING)
        self.run(0.3)
        for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
            job = self.settle(self.give(code, (1 << AXES) - 1 if code is Code.ENABLE else 0))
            assert job.state.name == "DONE", (code.name, job)

    def _new_core(self) -> CycleLogic:
        own = AXES // self.lanes
        axes = [replace(axis, kinematic=1 + n // own) for n, axis in enumerate(core_axes(self.cell, self.p5_ms))]
        core = CycleLogic(axes, self.period_ns / 1e9, self.generation)
        step = core.step

        def timed(
            actuals: Sequence[Actual | None], inputs: InputImage, orders: Sequence[OrderRecord], services_ns: int, now: int
        ) -> Sequence[object]:
            began = time.process_time_ns()
            values = step(actuals, inputs, orders, services_ns, now)
            self.costs.append(time.process_time_ns() - began)
            return values

        setattr(core, "step", timed)  # noqa: B010 - of this one alone
        return core

    def moving(self, there: float) -> list[int]:
        """Costs while all axes move."""
        own = AXES // self.lanes
        for lane in range(self.lanes):
            mask = sum(1 << n for n in range(lane * own, lane * own + own))
            job = self.give(Code.PTP_ABSOLUTE, mask, SPEED, (there,) * AXES)
            assert job.open, job
        self.cycle(5)
        self.costs.clear()
        while self.core.state.motion is not Motion.IDLE:
            self.cycle()
        return self.costs[: len(self.costs) * 3 // 4]


def step_ratio(rounds: int) -> tuple[float, float]:
    """Medians of a period, us: of one lane, of four."""
    found: dict[int, list[int]] = {1: [], LANES: []}
    benches = {lanes: Timed(lanes) for lanes in found}
    for n in range(rounds):
        for lanes, bench in benches.items():
            found[lanes] += bench.moving(10.0 + WAY * ((n + 1) % 2))
    medians = [sorted(costs)[len(costs) // 2] / 1e3 for costs in found.values()]
    return medians[0], medians[1]


def line(bench: StreamBench, blocks: int, *, whole: bool) -> tuple[float, float, int]:
    """A row of short blocks with corners: s of virtual time from its first to its last set value, s of processor time of the planner,
    periods in which it rested on the way.  whole: all of it is known before anything moves."""
    wave = [(100 + STEP * n, 100 + 20 * math.sin(n / 25)) for n in range(1, blocks + 1)]
    texts = [f"linear pose {x:.6g} {y:.6g} 50 0 0 0 leave=0.9 reach=0.9 path=200" for x, y in wave]
    bench.begin()
    if whole:
        bench.planner.lines.appendleft(BlockRecord(Say.WHOLE, bench.job.id))
    bench.say(*texts, finish=False)
    bench.order_of(Say.END)
    turn, feed, spent = bench.planner.turn, bench.core.feed, [0]

    def timed(*given: Any) -> None:
        began = time.process_time_ns()
        for _ in range(4 if bench.planner.lines else 1):  # a thousand blocks a second
            turn(*given)
        spent[0] += time.process_time_ns() - began

    def cycles(record: PieceRecord) -> None:
        """What the cycle calculates with a record that it takes from the ring is not the planner's."""
        began = time.process_time_ns()
        feed(record)
        spent[0] -= time.process_time_ns() - began

    setattr(bench.planner, "turn", timed)  # noqa: B010 - of this one alone
    setattr(bench.core, "feed", cycles)  # noqa: B010
    bench.settle(bench.job, 120.0)
    delattr(bench.planner, "turn")
    delattr(bench.core, "feed")
    assert not bench.state().fault, bench.state().fault
    places = [(s.axes[0].set, s.axes[1].set) for s in bench.seen]
    moved = [n for n, (a, b) in enumerate(pairwise(places)) if a != b]
    stood = sum(places[n] == places[n + 1] for n in range(moved[0], moved[-1]))
    return (moved[-1] - moved[0]) * bench.period_ns / 1e9, spent[0] / 1e9, stood


def back(bench: StreamBench) -> None:
    bench.begin()
    bench.say("ptp joints 100 100 50 0")
    bench.passed(1)
    bench.end()


def firsts(bench: StreamBench) -> tuple[list[float], list[float]]:
    """ms from the order to the first set value of a stream, and from the end of a block to its answer."""
    first, answers = [], []
    for n in range(ORDERS):
        bench.begin()
        x, began = bench.set()[0], bench.now
        bench.say(f"linear pose {110 if n % 2 else 120} 100 50 0 0 0")
        while bench.set()[0] == x:
            bench.cycle()
        first.append((bench.now - began) / 1e6)
        while bench.core.lanes[0].mover.stepper.state.name != "IDLE":
            bench.cycle()
        over = bench.now
        bench.passed(1)
        answers.append((bench.now - over) / 1e6)
        bench.end()
    return sorted(first), sorted(answers)


def run(rounds: int = 4, blocks: int = BLOCKS) -> list[Figure]:
    """Rows lanes.step_ratio and stream.*."""
    one, four = step_ratio(rounds)
    bench = StreamBench()
    bench.end()
    back(bench)
    whole, _, _ = line(bench, blocks, whole=True)
    back(bench)
    streamed, spent, stood = line(bench, blocks, whole=False)
    back(bench)
    first, answers = firsts(bench)
    return [
        row("lanes.step_ratio", four / one, f"median, {LANES} lanes of {AXES // LANES} axes to one of {AXES}", 1.5, "one lane, us", one),
        row("stream.blocks_per_s", blocks / spent, f"blocks of {STEP:g} mm, {SHORT}", 1000.0, EMPTY_LOOP, loop_turns(), at_least=True),
        row("stream.starved", float(stood), "periods without way between the first block and the last", 0.0),
        row("stream.speed", whole / streamed, "of the same program read whole", 0.95, "whole, s", whole, at_least=True),
        row("stream.first_ms", first[-1], "ms from the order to the first set value, most", 100.0),
        row("stream.answer_ms", answers[-1], "ms from the last set value of a block to its answer, most", 2.0 * bench.p5_ms),
    ]
