"""A six-axis arm as real processes: PLC, services, planner, cycle, emulated CiA 402 drives on a bus of their own.

One program with a tool, a frame, a PTP, lines with corners and an arc, slowed down, stopped and resumed on the way; what it did is judged
by the emulator's own record against geometry of the programmed points.  Its limits, where no SYNC is ever late:
hil_tests/unit/motion/program.
And programs that measure by the touch probe of the first drive: what they have measured is judged by the record, too.
"""

from collections.abc import Iterator

import numpy as np
import pytest

from gateway.assembly.axis_scaling import scaling_of
from gateway.assembly.limits import limits_of
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.judges.probe_record import Edge, edges
from hil_tests.lab.judges.tool_path import HEADS, judge_end, judge_path, places_of, program
from hil_tests.lab.partners.plc2 import DONE
from hil_tests.lab.running.program_run import PROGRAM, ProgramRun, program_run

ROBOT = "arm"
AT, BEYOND = 20.0, 100.0  # deg of J1: the probe of its drive is actuated between
BACK, UNTIL, FLYING = 2, 3, 4
OWN_INC, OTHER_INC = 1.0, 10.0  # what the drive latches is exact; another axis lies between two SYNCs
PROGRAMS = {
    1: program(ROBOT),
    BACK: HEADS[ROBOT] + "ptp joints 10 30 90 0 60 0\n",
    UNTIL: HEADS[ROBOT] + "ptp joints 50 40 90 0 60 0 until=ch610\nptp mpos\n",
    FLYING: HEADS[ROBOT] + "ptp joints 40 38 90 0 60 0\nmeasure_on ch610 edge=0\nptp joints 10 30 90 0 60 0\n",
}


def probed(text: str) -> str:
    """The shipped cell, a touch probe on the drive of J1."""
    table = "[plant.axis.J1]\n"
    assert table in text
    return text.replace(table, f"{table}probe = {{ from = {AT}, to = {BEYOND} }}\n") + '\n[[measuring]]\nchannel = 610\ndrives = ["J1"]\n'


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ProgramRun]:
    with program_run(tmp_path_factory.mktemp("cell"), "arm6", PROGRAMS, "arm", change=probed) as run:
        yield run


def tip(arm: ProgramRun) -> tuple[float, float, float]:
    """Of the tool in the frame, from set values; m."""
    tool, frame = places_of(ROBOT)
    return (frame.inverse() @ arm.machine.kinematics.forward(arm.sets()) @ tool).position


def test_a_6r_program_keeps_its_path_through_a_slow_stretch_a_stop_and_the_rest_of_the_way(arm: ProgramRun) -> None:
    made = arm.slowed_stopped_resumed(
        lambda: abs(tip(arm)[2] - 0.03) < 1e-4 and abs(tip(arm)[0]) < 0.03,
        lambda: abs(tip(arm)[2] - 0.03) < 1e-4 and abs(tip(arm)[0]) < 0.06,
    )
    judge_path(made, ROBOT)
    judge_end(made, ROBOT, [(axis.lower, axis.upper) for axis in map(limits_of, made.axes)])


def ran(arm: ProgramRun, number: int) -> list[Edge]:
    """Where the record says the probe switched meanwhile; the axes rest before and afterwards."""
    since = arm.run.record().rows[-1].stamp_ns
    assert arm.command(PROGRAM, number).state == DONE, arm.run.words()
    arm.watch("at rest", lambda s: s.motion is Motion.IDLE)
    return edges(arm.run.record(), since)


def judge(arm: ProgramRun, edge: Edge) -> None:
    """What the control has stored is what the record says: J1 as its drive counts, J2 between two SYNCs."""
    state = arm.state()
    assert state.measured_mask == arm.all
    scalings = [scaling_of(axis) for axis in arm.cell.axis]
    away = [abs(state.axes[n].measured * scalings[n].inc_per_unit - edge.places[n]) for n in (0, 1)]
    assert away[0] <= OWN_INC and away[1] <= OTHER_INC, away


def test_programs_measure_by_a_drives_touch_probe_where_the_record_says_it_switched(arm: ProgramRun) -> None:
    arm.ready()
    ran(arm, BACK)  # beyond the edge there is none on the way
    first, *_ = ran(arm, UNTIL)
    judge(arm, first)
    assert first.rising and np.degrees(arm.sets()[0]) == pytest.approx(AT, abs=1e-3), "MOVE TO @MPOS"
    *_, last = ran(arm, FLYING)
    judge(arm, last)
    assert not last.rising and np.degrees(arm.sets()[0]) == pytest.approx(10.0, abs=1e-6), "the axes go on"
