"""A six-axis arm as real processes: PLC, services, planner, cycle, emulated CiA 402 drives on a bus of their own.

One program with a tool, a frame, a PTP, lines with corners and an arc, slowed down, stopped and resumed on the way; what it did is judged
by the emulator's own record against geometry of the programmed points.  Its limits, where no SYNC is ever late: hil_tests/unit/program.
"""

import pathlib
from dataclasses import replace

from gateway.axes import limits_of
from gateway.pure.records import Motion
from hil_tests.lab.cell_running import P5_MS
from hil_tests.lab.planned_bench import Driven
from hil_tests.lab.plc2 import DONE, OVERRIDE, RESUME, STOP
from hil_tests.lab.program_run import PROGRAM, ProgramRun, program_run
from hil_tests.lab.tool_path import judge_end, judge_path, places_of, program

ROBOT = "arm"


def tip(arm: ProgramRun) -> tuple[float, float, float]:
    """Of the tool in the frame, from set values; m."""
    tool, frame = places_of(ROBOT)
    return (frame.inverse() @ arm.machine.kinematics.forward(arm.sets()) @ tool).position


def test_a_6r_program_keeps_its_path_through_a_slow_stretch_a_stop_and_the_rest_of_the_way(tmp_path: pathlib.Path) -> None:
    with program_run(tmp_path, "arm6", {1: program(ROBOT)}, "arm") as arm:
        arm.ready()
        assert arm.command(OVERRIDE, 0, 0.3).state == DONE
        since = arm.run.record().rows[-1].stamp_ns
        arm.plc.send(PROGRAM, 1)
        arm.watch("on the long line", lambda s: s.piece > 0 and abs(tip(arm)[2] - 0.03) < 1e-4 and abs(tip(arm)[0]) < 0.03, 60.0)
        assert arm.command(STOP).state == DONE
        arm.watch("stopped on the path", lambda s: s.motion is Motion.STOPPED)
        assert arm.still() and abs(tip(arm)[0]) < 0.06 and abs(tip(arm)[2] - 0.03) < 1e-4, "on the line"
        assert arm.command(OVERRIDE, 0, 0.6).state == DONE
        assert arm.command(RESUME).state == DONE
        assert arm.command(OVERRIDE, 0, 1.0).state == DONE
        arm.watch("at rest", lambda s: s.motion is Motion.IDLE, 60.0)
        assert arm.still() and not arm.state().failed_job
        record = arm.run.record()
        record = replace(record, rows=tuple(row for row in record.rows if row.stamp_ns >= since))
        made = Driven(arm.cell, record, P5_MS / 1e3)
    judge_path(made, ROBOT)
    judge_end(made, ROBOT, [(axis.lower, axis.upper) for axis in map(limits_of, made.axes)])
