"""Short form of `axisgate bench lanes`: every figure is there, and those in virtual time keep their goals on any machine."""

import math

from hil_tests.bench.lanes_bench import run

TIMED = {"stream.starved", "stream.speed", "stream.first_ms", "stream.answer_ms"}
COSTS = {"lanes.step_ratio", "stream.blocks_per_s"}


def test_every_figure_is_measured_and_a_stream_runs_as_the_same_program_does() -> None:
    figures = {str(figure["figure"]): figure for figure in run(rounds=1, blocks=25)}
    assert figures.keys() == TIMED | COSTS
    assert all(math.isfinite(float(figures[name]["value"])) and float(figures[name]["value"]) > 0.0 for name in COSTS)
    assert all(figures[name]["met"] for name in TIMED), [figures[name] for name in TIMED]
