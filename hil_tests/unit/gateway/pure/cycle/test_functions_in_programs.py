"""IO logic and PPO called by programs of a cell, from the text to the image."""

import pytest

from gateway.pure.cycle.path_outputs import CoreOutputs, OutputPlace
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import get_bit
from hil_tests.lab.virtual.program_bench import LIMITS, WithPlanner, joints
from motion.kinematics.portal import Portal
from motion.outputs.rho3 import Kind

IOL, WORD = 400, 416
PLACES = {(Kind.IOL, 2): OutputPlace(IOL), (Kind.PPO, 3): OutputPlace(WORD, 16)}


@pytest.fixture(scope="module")
def bench() -> WithPlanner:
    """The demo's first axes as the x, y, z of a portal."""
    made = WithPlanner()
    made.programs.cell.functions = PLACES
    made.cell.core.lanes[0].mover.functions = CoreOutputs(PLACES, {1: Portal("xyz", LIMITS[:3])}, made.cell.period_ns / 1e9)
    return made


@pytest.fixture
def both(bench: WithPlanner) -> WithPlanner:
    """Near the beginning of the travel."""
    reset = ["iol -2 1 1 0 0 0", "ppo -3 1 1 0 0 0"]
    assert bench.finished(bench.order(*reset, f"ptp joints {joints(1.5)}", f"ptp joints {joints(2)}")).state is CommandState.DONE
    return bench


def seen(both: WithPlanner, *lines: str) -> list[tuple[float, bool]]:
    """(x of the set values, IO) of each cycle of a program that is done."""
    rows: list[tuple[float, bool]] = []
    job = both.order(*lines)
    for _ in range(5000):
        both.cell.cycle()
        rows.append((both.places()[0], get_bit(both.cell.core.outputs, IOL)))
        if not job.open:
            break
    assert job.state is CommandState.DONE, job
    return rows


def test_a_function_is_called_where_its_block_begins_and_switches_where_its_coordinate_is(both: WithPlanner) -> None:
    rows = seen(both, f"ptp joints {joints(10)}", "iol 2 1 1 15 1 0", f"ptp joints {joints(20)}")
    assert all(on is (x >= 15.0 - 1e-6) for x, on in rows) and rows[-1][1]


def test_in_a_rounded_corner_it_is_called_in_its_middle(both: WithPlanner) -> None:
    lines = (f"ptp joints {joints(10)} blend=joint leave=2 reach=2", "iol -2 1 1 0 1 0", f"ptp joints {joints(20)}")
    first = next(x for x, on in seen(both, *lines) if on)
    assert 9.0 < first < 11.5, "a negative number acts where it is called"


def test_a_function_still_in_use_ends_the_program_on_its_path_with_its_name(both: WithPlanner) -> None:
    lines = ("iol 2 1 1 500 1 0", f"ptp joints {joints(10)} blend=joint leave=1 reach=1", "iol 2 1 1 600 1 0", f"ptp joints {joints(60)}")
    job = both.finished(both.order(*lines))
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.OUTPUT_IN_USE) and "IOL 2" in job.detail
    assert 9.0 < both.places()[0] < 55.0 and both.still(0.2)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("iol 9 1 1 0 1 0", "IOL 9: no such function; the robot has IOL 2, PPO 3"),
        ("ppo 3 2 1 0 1 0", "kinematic 2"),
        ("ppo 3 1 7 0 1 0", "coordinate 7"),
        ("iol 2 1 1 0 1", "iol: six numbers"),
        ("iol 2.5 1 1 0 1 0", "whole numbers"),
    ],
)
def test_what_the_cell_does_not_have_is_refused_before_anything_moves(both: WithPlanner, line: str, words: str) -> None:
    job = both.order(line, f"ptp joints {joints(20)}")
    assert both.still(0.2) and (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT) and words in job.detail


def test_a_function_behind_the_last_block_is_refused(both: WithPlanner) -> None:
    job = both.order(f"ptp joints {joints(20)}", "iol 2 1 1 0 1 0")
    assert both.still(0.2) and job.state is CommandState.REFUSED and "none follows" in job.detail
