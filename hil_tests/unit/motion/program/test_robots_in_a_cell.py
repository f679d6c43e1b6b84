"""A six-axis arm (CiA 402 drives) and a portal (SERVODYN): tool, frame, PTP, lines with corners, an arc; slowed down, stopped, resumed.

Judged by the emulator's own record, against geometry of the programmed points.  As real processes: hil_tests/rig/planner.
"""

import functools
import pathlib

import pytest

from gateway.assembly.limits import limits_of
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.judges.tool_path import judge_end, judge_limits, judge_path, places_of, program
from hil_tests.lab.virtual.belt_bench import CELL as PORTAL
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Driven, Planned, ServodynRobot

ARM = load_cell(str(pathlib.Path(__file__).parents[4] / "configs" / "cells" / "arm6.toml"))


@functools.cache
def run(robot: str) -> Driven:
    """Slowly to the long line, a stop there, the rest of the line faster and faster."""
    planned = Planned(Cell402Bench(cell=ARM) if robot == "arm" else ServodynRobot(cell=PORTAL))
    tool, frame = places_of(robot)
    planned.done(Code.OVERRIDE, 0.3)
    planned.driven()
    job = planned.order(program(robot))

    def tip() -> tuple[float, float, float]:
        sets = tuple(axis.set for axis in planned.state.axes[: planned.machine.arm])
        return (frame.inverse() @ planned.machine.kinematics.forward(sets) @ tool).position

    planned.until(lambda s: s.piece > 0 and tip()[2] > 0.0299 and abs(tip()[0]) < 0.045)
    planned.done(Code.STOP)
    planned.until(lambda s: s.motion is Motion.STOPPED)
    stands = tip()
    planned.bench.run(0.3)
    assert tip() == stands
    planned.done(Code.OVERRIDE, 0.6)
    planned.done(Code.RESUME)
    planned.done(Code.OVERRIDE, 1.0)
    planned.bench.settle(job)
    assert job.state is CommandState.DONE
    planned.bench.run(0.3)
    return planned.driven()


@pytest.mark.parametrize("robot", ["arm", "portal"])
def test_the_tool_keeps_lines_corners_and_arc_through_a_slow_stretch_a_stop_and_the_rest_of_the_way(robot: str) -> None:
    judge_path(run(robot), robot)


@pytest.mark.parametrize("robot", ["arm", "portal"])
def test_no_axis_is_beyond_its_limits_and_all_arrive(robot: str) -> None:
    made = run(robot)
    judge_limits(made)
    judge_end(made, robot, [(axis.lower, axis.upper) for axis in map(limits_of, made.axes)])
