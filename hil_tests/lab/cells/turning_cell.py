"""A cell of five emulated SERVODYN axes that turn without end: the shipped portal's with its axes replaced, and the shipped turntables."""

import pathlib
import re

from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell
from hil_tests.lab.cells.carried_cell import PLANT

PORTAL = pathlib.Path(__file__).parents[3] / "configs" / "cells" / "portal.toml"
NAMES = ("M", "S1", "S2", "S3", "S4")
AXIS = """[[axis]]
name   = "{name}"
unit   = "deg"
modulo = 360.0
drive  = {{ type = "servodyn", bus = "drives", module = {module}, inc_per_turn = 16384 }}
mechanics       = {{ feed_per_turn = 360.0, gear = "{gear}", direction = "{direction}" }}
limits          = {{ min = 0.0, max = 360.0, speed = 600.0, accel = 3000.0, jerk = 60000.0 }}
following_error = {{ warn = 15.0, trip = 20.0 }}
home            = {{ by = "none" }}

"""


def cell_text(portal: str | None = None) -> str:
    """Return the text as a file next to the shipped one would have it; portal: the text of that one, with other programs.  The second slave
    counts the other way, the third has a gear whose turn is not an integer number of increments."""
    head = (portal or PORTAL.read_text()).split("[[axis]]", 1)[0]
    head = re.sub(r'model      = "portal" .*', 'model      = "turntables"', head).replace(
        'kinematics = "portal"', 'kinematics = "identity"'
    )
    head = head.replace('[[program]]\nnumber = 1\nfile   = "portal-u-cycle"\n', "").replace('axes     = "1..4"', 'axes     = "1..5"')
    gears, ways = ("10:1", "10:1", "10:1", "7.3:1", "10:1"), ("+", "+", "-", "+", "+")
    rows = zip(NAMES, gears, ways, strict=True)
    axes = "".join(AXIS.format(name=name, module=n, gear=gear, direction=way) for n, (name, gear, way) in enumerate(rows, 1))
    return f"{head}{axes}[plant]\nseed = 1\n" + "".join(PLANT.format(name=name, start=0.0) for name in NAMES)


def turning_cell() -> Cell:
    """Checked."""
    return load_cell(str(PORTAL), cell_text())
