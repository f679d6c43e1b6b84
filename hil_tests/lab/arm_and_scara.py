"""The cell of a six-axis arm and a SCARA: the shipped arm with a second robot and its four axes behind its own."""

from gateway.cell import Cell
from gateway.config import load_cell
from hil_tests.lab.carried_cell import ARM, AXIS, PLANT

ROBOTS = """[[robot]]
kinematics = "arm6"
model      = "tx60-like"
name       = "arm"

[[robot]]
kinematics = "scara"
model      = "sr60-like"
name       = "scara"

"""
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
    """As a file beside the shipped one would have it."""
    text = ARM.read_text()
    begin, end = text.index("[robot]"), text.index("# ---- drives")
    head, plant = f"{text[:begin]}{robots}{PROGRAMS}{more}{text[end:]}".split("# ---- the emulated machine", 1)
    axes = "".join(AXIS.format(**axis) for axis in AXES)
    return f"{head}{axes}# ---- the emulated machine{plant.rstrip()}\n" + "".join(PLANT.format(**axis) for axis in AXES)


def arm_and_scara() -> Cell:
    """Checked."""
    return load_cell(str(ARM), cell_text())
