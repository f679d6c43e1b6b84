"""getJointForce in a cell: what the drives report of their motors, as forces of the joints (L5982-5992, AX-1140)."""

import math
from dataclasses import replace

import pytest

from gateway.assembly.val3_application import rated_force
from gateway.pure.cell.axes import Mechanics
from hil_tests.lab.virtual.val3_cell_bench import CELL, Val3Cell
from hil_tests.unit.languages.val3.apps import App, datum, error_of, globals_of, value
from hil_tests.unit.languages.val3.test_in_a_cell import DATA, POWER

RATED_NM, RATIO, GRAVITY_NM, COULOMB_NM = 6.0, 100.0, 0.3, 0.2  # of J2 of the shipped cell
FORCES = datum("nRest", "num", "6") + datum("nMoves", "num", "7") + datum("nOff", "num", "6", value("0", value=1))


def test_forces_are_those_of_the_drives_in_newton_metres() -> None:
    code = "getJointForce(nOff)\nmovej(jA,tHand,mStop)\nwaitEndMove()\ndelay(0.5)\ngetJointForce(nRest)\n"
    code += "movej(jB,tHand,mSlow)\ndelay(0.7)\ngetJointForce(nMoves[1])\nnOne=1\nwait(diPart)"
    cell = Val3Cell(App(data=DATA + FORCES, programs={"start": POWER + code}).files(), "demo")
    cell.start()
    cell.until(lambda: cell.language.own is not None and cell.value("nOne") == 1.0)
    assert cell.language.own is not None
    rest, moves = cell.language.own.data["nRest"], cell.language.own.data["nMoves"]
    assert isinstance(rest, list) and isinstance(moves, list)
    weight = GRAVITY_NM * RATIO
    assert rest[1] == pytest.approx(weight, abs=1.25 * COULOMB_NM * RATIO), "J2 carries the arm, within its friction"
    assert moves[1] == pytest.approx(COULOMB_NM * RATIO, rel=0.3), "J1 turns against its friction"
    states = cell.bench.core.state.axes
    assert moves[1:] == pytest.approx([axis.torque * RATED_NM * own.mechanics.ratio for axis, own in zip(states, CELL.axis, strict=False)])


def test_the_force_of_a_joint_follows_gear_direction_and_unit() -> None:
    turns = CELL.axis[0]
    assert rated_force(turns) == pytest.approx(600.0)
    back = replace(turns, mechanics=Mechanics(360.0, "100:1", "-"))
    assert rated_force(back) == pytest.approx(-600.0), "the motor turns against the axis"
    slide = replace(turns, unit="mm", mechanics=Mechanics(20.0, "2:1"))
    assert rated_force(slide) == pytest.approx(6.0 * 2.0 * 2.0 * math.pi / 0.020), "N of a screw of 20 mm a turn"
    unknown = replace(turns, drive=replace(turns.drive, rated_torque=None))
    assert rated_force(unknown) == 0.0


def test_an_arm_without_drives_has_no_load_and_a_small_array_is_refused() -> None:
    assert globals_of("getJointForce(nOff)", FORCES, arm=True)["nOff"] == [0] * 6
    assert error_of("getJointForce(nSmall)", datum("nSmall", "num", "5"), arm=True) == 70
