"""Short form of `axisgate bench lanes`: every figure is there, and those in virtual time keep their goals on any machine."""

import cProfile
import math
from collections.abc import Sequence

import numpy as np
import pytest

from gateway.pure.image.records.planner import BlockRecord, PieceRecord
from gateway.pure.planning.cycle_view import CycleView
from hil_tests.bench.lanes_bench import back, line, run
from hil_tests.lab.virtual.stream_bench import StreamBench
from motion.timing import topp

TIMED = {"stream.starved", "stream.speed", "stream.first_ms", "stream.answer_ms"}
BLOCKS, MOST_CALLS = 100, 1800
COSTS = {"lanes.step_ratio", "stream.blocks_per_s"}


def test_every_figure_is_measured_and_a_stream_runs_as_the_same_program_does() -> None:
    figures = {str(figure["figure"]): figure for figure in run(rounds=1, blocks=25)}
    assert figures.keys() == TIMED | COSTS
    assert all(math.isfinite(float(figures[name]["value"])) and float(figures[name]["value"]) > 0.0 for name in COSTS)
    assert all(figures[name]["met"] for name in TIMED), [figures[name] for name in TIMED]


def test_a_short_block_of_a_stream_costs_the_planner_few_calls() -> None:
    """What stream.blocks_per_s rests on, counted instead of timed: nothing of a row is made again for each block of it."""
    bench, counted = StreamBench(), cProfile.Profile()
    bench.end()
    back(bench)
    turn = bench.programs.turn

    def watched(records: Sequence[BlockRecord], view: CycleView) -> list[PieceRecord]:
        return counted.runcall(turn, records, view)

    setattr(bench.programs, "turn", watched)  # noqa: B010 - of this one alone
    line(bench, BLOCKS, whole=False)
    calls = sum(entry.callcount for entry in counted.getstats())
    assert calls / BLOCKS < MOST_CALLS, calls / BLOCKS


def test_a_law_of_a_row_at_the_programmed_speed_is_not_worked_out_place_by_place(monkeypatch: pytest.MonkeyPatch) -> None:
    s = np.linspace(0.0, 2.0, 1601)
    first, second = np.stack([np.cos(0.8 * s), np.sin(0.8 * s)], axis=1), 0.8 * np.stack([-np.sin(0.8 * s), np.cos(0.8 * s)], axis=1)
    looked: list[int] = []
    at = topp._Listed.at

    def watched(self: topp._Listed, i: int) -> object:
        looked.append(i)
        return at(self, i)

    monkeypatch.setattr(topp._Listed, "at", watched)
    made = topp.solve(first, second, float(s[1]), np.full(2, 5.0), np.full(len(s), 0.04))
    assert 0 < len(looked) < len(s) // 8
    assert np.count_nonzero(made.b == 0.04) > 0.9 * len(s)
    assert np.all(np.abs(np.diff(made.b)) <= 2 * float(s[1]) * 5.0 * 1.5)
