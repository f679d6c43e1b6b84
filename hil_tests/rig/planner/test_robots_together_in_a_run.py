"""A six-axis arm and a SCARA on one clock as real processes: PLC, services, planner, cycle, ten emulated CiA 402 drives on one bus.

The shipped program of both, slowed down, stopped and resumed where they carry their parts side by side; judged by the emulator's own
record.  Their limits, where no SYNC is ever late: hil_tests/unit/program.
"""

import pathlib
from dataclasses import replace

import numpy as np

from gateway.pure.records import Motion
from hil_tests.lab.arm_and_scara import SHIPPED, both, judge_lines, tips
from hil_tests.lab.cell_running import P5_MS
from hil_tests.lab.planned_bench import Driven
from hil_tests.lab.plc2 import DONE, OVERRIDE, RESUME, STOP
from hil_tests.lab.program_run import PROGRAM, ProgramRun, program_run


def carrying(robots: ProgramRun) -> bool:
    """The arm is on its first line, and so is the SCARA."""
    places = [tips(np.array([robots.sets()]), n)[0] for n in (0, 1)]
    return places[0][2] > 0.205 and all(-0.14 < place[1] < -0.04 for place in places)


def test_both_keep_their_lines_through_a_slow_stretch_a_stop_and_the_rest_of_the_way(tmp_path: pathlib.Path) -> None:
    with program_run(tmp_path, "arm6", {1: SHIPPED}, "together", change=both) as robots:
        robots.ready()
        assert robots.command(OVERRIDE, 0, 0.3).state == DONE
        since = robots.run.record().rows[-1].stamp_ns
        robots.plc.send(PROGRAM, 1)
        robots.watch("both carry", lambda s: s.piece > 0 and carrying(robots), 60.0)
        assert robots.command(STOP).state == DONE
        robots.watch("stopped on the path", lambda s: s.motion is Motion.STOPPED)
        assert robots.still() and carrying(robots), "on their lines"
        assert robots.command(OVERRIDE, 0, 0.6).state == DONE
        assert robots.command(RESUME).state == DONE
        assert robots.command(OVERRIDE, 0, 1.0).state == DONE
        robots.watch("at rest", lambda s: s.motion is Motion.IDLE, 60.0)
        assert robots.still() and not robots.state().failed_job
        record = robots.run.record()
        record = replace(record, rows=tuple(row for row in record.rows if row.stamp_ns >= since))
        made = Driven(robots.cell, record, P5_MS / 1e3)
    judge_lines(made)
