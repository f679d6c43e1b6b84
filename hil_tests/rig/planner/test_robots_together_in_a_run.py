"""A six-axis arm and a SCARA on one clock as real processes: PLC, services, planner, cycle, ten emulated CiA 402 drives on one bus.

The shipped program of both, slowed down, stopped and resumed where they carry their parts side by side; judged by the emulator's own
record.  Their limits, where no SYNC is ever late: hil_tests/unit/motion/program.
"""

import pathlib

import numpy as np

from hil_tests.lab.cells.arm_and_scara import SHIPPED, both, judge_lines, tips
from hil_tests.lab.running.program_run import ProgramRun, program_run


def carrying(robots: ProgramRun) -> bool:
    """The arm is on its first line, and so is the SCARA."""
    places = [tips(np.array([robots.sets()]), n)[0] for n in (0, 1)]
    return places[0][2] > 0.205 and all(-0.14 < place[1] < -0.04 for place in places)


def test_both_keep_their_lines_through_a_slow_stretch_a_stop_and_the_rest_of_the_way(tmp_path: pathlib.Path) -> None:
    with program_run(tmp_path, "arm6", {1: SHIPPED}, "together", change=both) as robots:
        made = robots.slowed_stopped_resumed(lambda: carrying(robots), lambda: carrying(robots))
    judge_lines(made)
