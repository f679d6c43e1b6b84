"""LINEAR of a kinematic without transformation: main and manual axes, P303.  Judged by the emulator's own record.  AX-588."""

from dataclasses import replace

import numpy as np
import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell
from gateway.pure.image.reasons import CommandState
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.turning_cell import PORTAL, turning_cell
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot
from hil_tests.unit.motion.program.test_endless import rho3

CELL = turning_cell()
HEAD = "robot turntables\naxes deg deg deg deg deg\nstart 0 0 0 0 0\n"
SLAVES = replace(CELL, axis=tuple(replace(axis, manual=axis.name != "M") for axis in CELL.axis))
POINTS = ("100 0 0 60 0", "200 40 0 0 0", "300 -40 0 0 50", "400 0 30 100 0")
V, STEP_S = 60.0, 0.004  # deg/s
TURNS = 3.0  # deg/s2: what rounding to increments makes of a steady speed in 0.1 s


def run(cell: Cell, *lines: str) -> Array:
    """(cycles, 5) deg/s, from the first to the last cycle something moves in; means of 10 cycles."""
    planned = Planned(ServodynRobot(cell=cell))
    job = planned.bench.settle(planned.order(HEAD + "\n".join(lines)))
    assert job.state is CommandState.DONE, job
    planned.bench.run(0.05)
    made = planned.driven()
    speed, accel = made.shares()
    assert speed <= 1.0 and accel <= 1.02
    sets = np.degrees(made.sets)
    rates = (sets[10:] - sets[:-10]) / (10 * STEP_S)
    moving = np.flatnonzero(np.abs(rates).max(axis=1) > 0.1)
    return np.asarray(rates[moving[0] : moving[-1]])


def passing(keys: str) -> list[str]:
    """The points one behind the other."""
    return [f"linear rel joints {point} turn={V:g} {keys}" for point in differences()]


def differences() -> list[str]:
    rows = np.array([[float(word) for word in point.split()] for point in ("0 0 0 0 0", *POINTS)])
    return [" ".join(f"{value:g}" for value in row) for row in np.diff(rows, axis=0)]


@pytest.mark.requirement("RHO-MOT-30", by="motion.planner.untransformed:axes_line")
@pytest.mark.requirement("RHO-MOT-30", by="motion.planner.untransformed:along_axes")
def test_the_master_keeps_the_programmed_speed_over_all_points_and_the_slaves_adapt() -> None:
    keys = "zone=15,15,15,15,15 blend=joint"
    rates = run(SLAVES, *passing(keys))
    steady = rates[60:-60, 0]
    assert len(steady) > 1400 and np.abs(steady - V).max() < 0.02 * V
    slaves = np.abs(rates[60:-60, 1:]).max(axis=0)
    assert slaves.max() > 0.9 * V and slaves.min() > 10.0
    all_mains = run(CELL, *passing(keys))
    master = all_mains[60:-60, 0]
    assert master.min() < 0.75 * V and np.linalg.norm(all_mains, axis=1).max() < 1.02 * V, "as before TO04: its speed changes"


def test_manual_axes_alone_make_the_speed_themselves_and_all_arrive_together() -> None:
    rates = run(SLAVES, f"linear joints 0 30 40 0 0 turn={V:g}")
    assert np.linalg.norm(rates, axis=1).max() == pytest.approx(V, rel=0.02)
    assert rates[:, 1] == pytest.approx(0.75 * rates[:, 2], abs=TURNS)


def test_p303_says_which_axes_are_manual() -> None:
    cell = load_cell(str(PORTAL), rho3("[3, 0, 1, 4, 3]", "[360, 0, 0, 360, 180]"))
    assert [axis.manual for axis in cell.axis] == [False, False, True, True, False]
