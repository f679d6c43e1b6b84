"""An endless belt in a cell of two robots: an arm, and five turntables behind its axes, the first of which goes along with the belt.

Judged by the emulator's own record of set values and by what the encoder said (AX-573, AX-1745)."""

import numpy as np
import pytest

from gateway.assembly.belts import belt_facts
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.planner import ProgramFacts
from hil_tests.lab.cells.arm_and_scara import TURNING
from hil_tests.lab.cells.carried_cell import ARM, AXIS, PLANT
from hil_tests.lab.cells.two_on_belts import FIRST_ID, OnBelts

FACTOR, SPEED = 0.36, 0.1  # deg of M for one mm of belt; m/s
EVERY = (1 << 11) - 1
NAMES = ("M", "R1", "R2", "R3", "R4")
ROBOTS = """[[robot]]
kinematics = "arm6"
model      = "tx60-like"
name       = "arm"

[[robot]]
kinematics = "identity"
model      = "turntables"
name       = "tables"

"""
BELT = f'[[belt]]\nname = "B1"\nincrement = 0.1\nbus = "drives"\nid = {FIRST_ID + 1}\nrobot = "tables"\naxis = "M"\nfactor = {FACTOR}\n\n'
HEAD = """kinematic arm tx60-like
start 0 30 90 0 60 0
kinematic tables turntables
start 0 0 0 0 0
"""
BOTH = "move arm ptp joints {} 30 90 0 60 0 and tables ptp joints {} 0 0 0 0"


def cell_text() -> str:
    """As a file beside the shipped arm would have it."""
    text = ARM.read_text()
    begin, end = text.index("[robot]"), text.index("# ---- drives")
    head, plant = f"{text[:begin]}{ROBOTS}{BELT}{text[end:]}".split("# ---- the emulated machine", 1)
    limits = {"low": 0.0, "high": 360.0, "speed": 360.0, "accel": 1800.0, "jerk": 18000.0, "start": 0.0}
    axes = [TURNING | limits | {"name": name, "node": node} for node, name in enumerate(NAMES, 7)]
    endless = "".join(AXIS.format(**axis) for axis in axes).replace('unit   = "deg"\n', 'unit   = "deg"\nmodulo = 360.0\n')
    belt = "\n[plant.belt.B1]\naccel = 2000.0\n"
    return f"{head}{endless}# ---- the emulated machine{plant.rstrip()}\n" + "".join(PLANT.format(**axis) for axis in axes) + belt


CELL = load_cell(str(ARM), cell_text())


class Tables(OnBelts):
    """Program 1 moves both robots."""

    def __init__(self) -> None:
        super().__init__(CELL)
        self.bench.dispatcher.programs = {1: ProgramFacts("both", EVERY)}


def ordered(tables: Tables, *lines: str) -> tuple[CommandState, int, str]:
    """A program through to its outcome."""
    tables.text = HEAD + "\n".join(lines)
    job = tables.bench.dispatcher.command(1, Command(Code.PROGRAM, 1, 1.0, 1.0), tables.bench.now)
    tables.bench._hand_over()
    tables.finished(job)
    return job.state, job.reason, job.detail


@pytest.fixture(scope="module")
def tables() -> Tables:
    return Tables()


@pytest.mark.parametrize("streams", [False, True], ids=["program", "stream"])
def test_an_axis_of_the_second_robot_rides_along_while_sync_waits_inside_the_part(tables: Tables, streams: bool) -> None:
    tables.planner.streams = streams
    tables.started(1, SPEED)
    tables.driven()
    tables.robots.counted.clear()
    part = ("ptp rel joints 10 0 0 0 0", "sync B1 >= 300mm", "ptp rel joints -30 5 0 0 0", "sync B1 >= 300mm", "synchron_end")
    outcome = ordered(tables, BOTH.format(10, 0), "kinematic tables", "synchron B1 at=200mm", *part, BOTH.format(0, 0))
    assert outcome[0] is CommandState.DONE, outcome
    made, way = tables.driven(), tables.belt(1)
    off = np.degrees(made.sets[: len(way), 6]) - FACTOR * 1e3 * way
    riding = np.flatnonzero(np.ptp(np.lib.stride_tricks.sliding_window_view(off, 26), axis=1) < 0.1) + 12
    levels = sorted({round(float(each)) for each in off[riding]})
    assert len(levels) == 2 and levels[1] - levels[0] == 30, "two places beside the belt, 30 deg apart"
    ahead = riding[np.abs(off[riding] - levels[0]) < 1.0]
    assert float(np.ptp(off[ahead])) < 0.06, "it stays there within an increment of the belt"
    assert float(np.ptp(made.sets[ahead][:, :6], axis=0).max()) < 4e-6, "the arm stands meanwhile"
    speed, accel = made.shares()
    assert 0.1 < speed <= 1.0 and accel <= 1.02, (speed, accel)
    assert tables.bench.set() == pytest.approx([0, 30, 90, 0, 60, 0, 0, 0, 0, 0, 0], abs=1e-6)


def test_an_absolute_place_of_the_parallel_axis_is_refused_before_anything_moves(tables: Tables) -> None:
    tables.planner.streams = False
    state, reason, words = ordered(tables, "kinematic tables", "synchron B1", "ptp joints 10 0 0 0 0", "synchron_end")
    assert (state, reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT)
    assert "kinematic tables: Belt-sync. n.possible: an absolute place of M" in words and "(rho 3 20)" in words, words


def test_the_axis_is_counted_among_those_of_its_robot_and_belongs_to_it_alone() -> None:
    (facts,) = belt_facts(CELL)
    assert {number: carrier.joint for number, carrier in facts.carriers.items()} == {2: 0}
    for robots, name in (('"arm"', "arm (tx60-like)"), ('["arm", "tables"]', "arm (tx60-like)")):
        with pytest.raises(CellFaults) as told:
            load_cell(str(ARM), cell_text().replace('robot = "tables"', f"robot = {robots}"))
        assert f"belt B1: axis M does not belong to robot {name}, whose axes are J1, J2, J3, J4, J5, J6" in str(told.value)
