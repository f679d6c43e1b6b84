"""What one of several kinematics asks for, and no other one, as real processes: an arm and a SCARA on ten emulated CiA 402 drives."""

from collections.abc import Iterator

import numpy as np
import pytest

from gateway.pure.reasons import Reason
from hil_tests.lab.arm_and_scara import both
from hil_tests.lab.arms import Array
from hil_tests.lab.planned_bench import Driven
from hil_tests.lab.plc2 import DONE, REFUSED
from hil_tests.lab.program_run import PROGRAM, ProgramRun, program_run

HEAD = """kinematic arm tx60-like
axes deg deg deg deg deg deg
start 0 30 90 0 60 0
kinematic scara sr60-like
axes deg deg mm deg
start 0 90 -200 0
"""
PROGRAMS = {
    1: HEAD + "move arm ptp joints 10 30 90 0 60 0 and scara ptp joints 20 90 -200 0\n",
    2: HEAD + "kinematic scara\nmach_pos joints 0 80 -200 0\nmove arm ptp joints 15 30 90 0 60 0 and scara ptp joints 10 80 -200 0\n",
    3: HEAD + "kinematic scara\nmach_pos joints 0 80 90 0\nmove arm ptp joints 15 30 90 0 60 0\n",
}
SCARA = 0b1111000000
SI = np.array([np.pi / 180] * 8 + [1e-3, np.pi / 180])


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ProgramRun]:
    with program_run(tmp_path_factory.mktemp("cell"), "arm6", PROGRAMS, "words", change=both) as run:
        run.ready()
        yield run


def asked(robots: ProgramRun) -> Array:
    """What the drives were asked for last, deg and mm: increments, by the emulator's record."""
    return np.asarray(Driven(robots.cell, robots.run.record(), robots.run.p5_ms / 1e3).sets[-1] / SI)


def test_machine_positions_of_one_are_set_and_both_go_on_together_by_their_own_numbers(robots: ProgramRun) -> None:
    assert robots.command(PROGRAM, 1).state == DONE, robots.run.words()
    robots.still()
    before = asked(robots)
    assert robots.command(PROGRAM, 2).state == DONE, robots.run.words()
    robots.still()
    assert asked(robots) - before == pytest.approx([5, 0, 0, 0, 0, 0, 10, 0, 0, 0], abs=0.01)
    assert np.array(robots.sets()) / SI == pytest.approx([15, 30, 90, 0, 60, 0, 10, 80, -200, 0], abs=1e-6)
    assert robots.planner().placed == SCARA
    far = robots.command(PROGRAM, 3)
    assert (far.state, far.reason) == (REFUSED, Reason.PROGRAM_FAULT)
    said = [entry["text"] for entry in robots.run.journal("command") if "cannot be run" in entry["text"]]
    assert "line 9: block 1, axis S3: kinematic scara: mach_pos: target 90 mm is outside -400 .. 0 mm" in said[-1]
