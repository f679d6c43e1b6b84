"""A six-axis arm on a track before a rotary table, in a cell with emulated CiA 402 drives: a line along the track and an arc on the turning
table, stopped, resumed and slowed down.  Judged by the emulator's own record; the judge knows the arm alone (AX-565)."""

import functools

import numpy as np
import pytest

from gateway.assembly.programs import machine_of_cell
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.cells.carried_cell import ARM, carried_cell, cell_text
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Driven, Planned, off_circle, off_segment
from hil_tests.unit.motion.program.test_carried import HEAD, seen
from motion.planner.trace import route_of
from motion.program.blocks import Interpolation
from motion.program.text.reader import read

ROUNDED, FOLLOWED = 25e-6, 1e-3  # m: half an increment of each axis; a position loop cuts arcs by the square of its lag
A, B, END = (0.4, 0.52, 0.33), (0.4, 0.6, 0.33), (0.4, 0.57, 0.33)
CENTRE, RADIUS = (0.4, 0.585, 0.33), 0.015
PROGRAM = (
    HEAD
    + """set path=300
ptp pose 400 520 330 180 0 180 extra=500mm,0deg
linear pose 400 600 330 180 0 180 extra=560mm,-5deg
circular via pose 415 585 330 180 0 180 to pose 400 570 330 180 0 180 extra=540mm,5deg
"""
)
CELL = carried_cell()
SHIPPED = read((ARM.parents[1] / "programs" / "track-and-table.txt").read_text())


@functools.cache
def driven() -> Driven:
    planned = Planned(Cell402Bench(cell=CELL))
    planned.driven()
    job = planned.order(PROGRAM)

    def along() -> float:
        return float(seen(np.array([[axis.set for axis in planned.state.axes]]))[0, 1])

    planned.until(lambda s: s.piece > 0 and 0.55 < along() < 0.58)
    planned.done(Code.STOP)
    planned.until(lambda s: s.motion is Motion.STOPPED)
    planned.done(Code.OVERRIDE, 0.5)
    planned.done(Code.RESUME)
    planned.bench.settle(job)
    assert job.state is CommandState.DONE
    return planned.driven()


def test_the_tool_keeps_line_and_arc_on_the_workpiece_while_track_and_table_move() -> None:
    made = driven()
    for rows, close in ((made.sets, ROUNDED), (made.actual, FOLLOWED)):
        places = seen(rows)
        first = int(np.argmax(np.linalg.norm(places - A, axis=1) < close))
        path = places[first:]
        on = np.minimum(off_segment(path, A, B), off_circle(path, CENTRE, RADIUS))
        assert first > 20 and float(on.max()) < close
        for place in (B, END):
            assert float(np.linalg.norm(path - place, axis=1).min()) < close
    assert made.sets[-1, 6:] == pytest.approx((0.54, np.radians(5.0)), abs=4e-6)


def test_no_axis_is_beyond_its_limits() -> None:
    speed, accel = driven().shares()
    assert 0.1 < speed <= 1.0 and 0.2 < accel <= 1.02, (speed, accel)


def test_a_belt_in_the_cell_of_a_carried_robot_is_refused_in_words() -> None:
    belt = '[[belt]]\nname = "B1"\ntype = 1\nincrement = 0.1\nbus = "drives"\nid = 497\nsimulated = 50.0\n\n'
    text = cell_text()
    assert machine_of_cell(load_cell(str(ARM), text)).carried
    with pytest.raises(CellFaults, match="T1, D1 carry the robot or the workpiece; no belt can be one of this robot"):
        load_cell(str(ARM), text.replace("# ---- the emulated machine", belt + "# ---- the emulated machine"))


def test_the_shipped_program_can_be_run_in_such_a_cell() -> None:
    found = route_of(SHIPPED, machine_of_cell(CELL))
    assert not found.faults and found.stretches[-1].stop
    rim = next(one for one in found.stretches if one.source.kind is Interpolation.CIRCULAR)
    assert float(off_circle(seen(rim.path.at(np.linspace(0.0, rim.path.length, 50))[:, :8]), (0.55, 0.6, 0.17), 0.15).max()) < 1e-6
