"""A six-axis arm as real processes: PLC, services, planner, cycle, emulated CiA 402 drives on a bus of their own.

One program with a tool, a frame, a PTP, lines with corners and an arc, slowed down, stopped and resumed on the way; what it did is judged
by the emulator's own record against geometry of the programmed points.  Its limits, where no SYNC is ever late: hil_tests/unit/program.
"""

import pathlib

from gateway.axes import limits_of
from hil_tests.lab.program_run import ProgramRun, program_run
from hil_tests.lab.tool_path import judge_end, judge_path, places_of, program

ROBOT = "arm"


def tip(arm: ProgramRun) -> tuple[float, float, float]:
    """Of the tool in the frame, from set values; m."""
    tool, frame = places_of(ROBOT)
    return (frame.inverse() @ arm.machine.kinematics.forward(arm.sets()) @ tool).position


def test_a_6r_program_keeps_its_path_through_a_slow_stretch_a_stop_and_the_rest_of_the_way(tmp_path: pathlib.Path) -> None:
    with program_run(tmp_path, "arm6", {1: program(ROBOT)}, "arm") as arm:
        made = arm.slowed_stopped_resumed(
            lambda: abs(tip(arm)[2] - 0.03) < 1e-4 and abs(tip(arm)[0]) < 0.03,
            lambda: abs(tip(arm)[2] - 0.03) < 1e-4 and abs(tip(arm)[0]) < 0.06,
        )
    judge_path(made, ROBOT)
    judge_end(made, ROBOT, [(axis.lower, axis.upper) for axis in map(limits_of, made.axes)])
