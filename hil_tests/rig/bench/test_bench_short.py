"""Short forms of the benchmarks: every figure is there and was measured; whether it meets its goal is for `make bench`, not for a timer."""

import json
import math
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
KEYS = {"figure", "value", "unit", "reference", "reference_value", "ratio", "goal", "met"}
FIGURES = {
    "cycle": {"skipped", "incomplete", "sync_error_p99", "sync_error_p999", "compute_p999", "drives_in_fault", "modbus_rate"},
    "3964r": {"wire_ratio", "blocks_per_s", "decode_MBps", "sim_telegrams_per_s"},
    "route": {"one_way", "both_ways", "one_way_io", "both_ways_io"},
    "emulator": {"six_axes_cpu"},
    "program": {
        "statements_s", "loops_cpu", "blocks_s", "parse_s", "breakpoints_ratio", "input_statement_ms", "input_output_ms", "start_ms",
        "lanes_ratio", "editor_ms",
    },
    "drives": {"skipped_2ms", "incomplete_2ms", "cycle_cpu", "skipped_2ms_12", "incomplete_2ms_12", "emulated_24"},
}  # fmt: skip


@pytest.mark.cref
@pytest.mark.timeout(240)
@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_is_measured(name: str) -> None:
    command = [sys.executable, "-m", "gateway", "bench", name, "--json", "--blocks", "1", "--seconds", "1"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode in (0, 1), done.stderr[-4000:]
    figures = json.loads(done.stdout)
    assert {figure["figure"] for figure in figures} == {f"{name}.{figure}" for figure in FIGURES[name]}
    for figure in figures:
        assert figure.keys() == KEYS
        # Nothing is measured where the twin in C itself failed both of its turns: that says nothing about ours.
        measured = figure["value"] is not None and math.isfinite(figure["value"])
        assert measured or "the reference failed, once more (2)" in done.stderr, done.stderr


def test_an_unknown_bench_is_a_usage_error() -> None:
    done = subprocess.run([sys.executable, "-m", "gateway", "bench", "speed"], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 2
