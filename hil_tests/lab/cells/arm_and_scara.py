"""The cell of a six-axis arm and a SCARA: the shipped arm with a second robot whose four axes follow its own;
and the judge of the shipped program of both: geometry of its points alone."""

import numpy as np

from gateway.assembly.programs import machines_of_cell
from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.carried_cell import ARM, AXIS, PLANT
from hil_tests.lab.virtual.planned_bench import Driven, off_segment
from motion.geometry.conventions import convention
from motion.geometry.frames import IDENTITY

ROBOTS = """[[robot]]
kinematics = "arm6"
model      = "tx60-like"
name       = "arm"

[[robot]]
kinematics = "scara"
model      = "sr60-like"
name       = "scara"

"""
SHIPPED = (ARM.parents[1] / "programs" / "arm-and-scara.txt").read_text()
PROGRAMS = """[[program]]
number = 1
file   = "arm-and-scara"

[[program]]
number     = 2
file       = "scara-pick-and-place"
kinematics = "scara"

"""
TURNING = {"unit": "deg", "feed": 360.0, "gear": "50:1", "warn": 4.4, "trip": 5.7}
AXES = (
    TURNING | {"name": "S1", "node": 7, "low": -132.0, "high": 132.0, "speed": 180.0, "accel": 900.0, "jerk": 9000.0, "start": 0.0},
    TURNING | {"name": "S2", "node": 8, "low": -141.0, "high": 141.0, "speed": 180.0, "accel": 900.0, "jerk": 9000.0, "start": 90.0},
    {"name": "S3", "unit": "mm", "node": 9, "feed": 20.0, "gear": "1:1", "low": -400.0, "high": 0.0, "speed": 300.0, "accel": 1500.0}
    | {"jerk": 30000.0, "warn": 8.0, "trip": 10.0, "start": -200.0},
    TURNING | {"name": "S4", "node": 10, "low": -360.0, "high": 360.0, "speed": 270.0, "accel": 900.0, "jerk": 9000.0, "start": 0.0},
)


def cell_text(more: str = "", robots: str = ROBOTS) -> str:
    """Return the text as a file next to the shipped one would have it."""
    return _with_scara(ARM.read_text(), f"{robots}{PROGRAMS}{more}")


def both(text: str) -> str:
    """The shipped cell with other programs, and the SCARA in addition to the arm."""
    return _with_scara(text, ROBOTS + text[text.index("[[program]]") : text.index("# ---- drives")])


def _with_scara(text: str, robots_and_programs: str) -> str:
    begin, end = text.index("[robot]"), text.index("# ---- drives")
    head, plant = f"{text[:begin]}{robots_and_programs}{text[end:]}".split("# ---- the emulated machine", 1)
    axes = "".join(AXIS.format(**axis) for axis in AXES)
    return f"{head}{axes}# ---- the emulated machine{plant.rstrip()}\n" + "".join(PLANT.format(**axis) for axis in AXES)


def arm_and_scara() -> Cell:
    """Checked."""
    return load_cell(str(ARM), cell_text())


CELL = arm_and_scara()
HEAD = """kinematic arm tx60-like
axes deg deg deg deg deg deg
start 0 30 90 0 60 0
kinematic scara sr60-like
axes deg deg mm deg
start 0 90 -200 0
"""
MACHINES = machines_of_cell(CELL)
TOOLS = (convention("val3").pose((0, 0, 100, 0, 0, 0)), IDENTITY)
POINTS = (  # PART, OVER, PLACE of arm and SCARA
    ((0.35, -0.15, 0.2), (0.35, 0.0, 0.25), (0.35, 0.15, 0.2)),
    ((0.35, -0.15, 0.08), (0.35, 0.0, 0.12), (0.35, 0.15, 0.08)),
)
ROUND = (0.03, 0.02)
OWN = (slice(0, 6), slice(6, 10))
ROUNDED = 25e-6  # m: half an increment of each axis
FOLLOWED = 1e-3


def tips(rows: Array, n: int) -> Array:
    """(rows, 3) m of one robot's tool."""
    return np.array([(MACHINES[n].forward(tuple(float(v) for v in row[OWN[n]])) @ TOOLS[n]).position for row in rows])


def carried(rows: Array) -> slice:
    """Rows from PART to PLACE: the arm is at neither before or after them."""
    arm = tips(rows, 0)
    first, last = (int(np.argmin(np.linalg.norm(arm - POINTS[0][n], axis=1))) for n in (0, 2))
    return slice(first, last + 1)


def judge_lines(made: Driven) -> None:
    """Both tools on their own lines between the points, rounded at OVER, by set values and mechanics of the emulator's record."""
    for rows, close in ((made.sets, ROUNDED), (made.actual, FOLLOWED)):
        part = rows[carried(rows)]
        assert len(part) > 100
        for n, (a, b, c) in enumerate(POINTS):
            places = tips(part, n)
            on = np.minimum(off_segment(places, a, b), off_segment(places, b, c))
            beside = np.linalg.norm(places - b, axis=1) > ROUND[n]
            assert float(on[beside].max()) < close
            assert 1e-3 < float(np.linalg.norm(places - b, axis=1).min()) < 0.1875 * 2.0 * ROUND[n] + close, "rounded"
            for place in (a, c):
                assert float(np.linalg.norm(places - place, axis=1).min()) < close
