"""The cell of the six-axis arm on a track before a rotary table: the shipped arm with two axes more, and the robot file that has them."""

import pathlib

from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell

ARM = pathlib.Path(__file__).parents[3] / "configs" / "cells" / "arm6.toml"
AXIS = """[[axis]]
name   = "{name}"
unit   = "{unit}"
drive  = {{ type = "cia402", bus = "drives", node = {node}, eds = "axisgate_402.eds", inc_per_turn = 16384 }}
mechanics       = {{ feed_per_turn = {feed}, gear = "{gear}", direction = "+" }}
limits          = {{ min = {low}, max = {high}, speed = {speed}, accel = {accel}, jerk = {jerk} }}
following_error = {{ warn = {warn}, trip = {trip} }}
home            = {{ by = "none" }}

"""
PLANT = """
[plant.axis.{name}]
motor_inertia_kgm2   = 0.0006
load_inertia_kgm2    = 0.0004
coulomb_nm           = 0.2
stiction_nm          = 0.24
viscous_nms_per_rad  = 0.0015
gravity_nm           = 0.0
kv_per_s             = 80.0
start                = {start}
"""
TRACK = {"name": "T1", "unit": "mm", "node": 7, "feed": 20.0, "gear": "1:1", "low": -500.0, "high": 1500.0, "start": 500.0}
TRACK |= {"speed": 300.0, "accel": 1500.0, "jerk": 30000.0, "warn": 8.0, "trip": 10.0}
TABLE = {"name": "D1", "unit": "deg", "node": 8, "feed": 360.0, "gear": "100:1", "low": -360.0, "high": 360.0, "start": 0.0}
TABLE |= {"speed": 90.0, "accel": 450.0, "jerk": 9000.0, "warn": 2.0, "trip": 2.5}


def cell_text() -> str:
    """Return the text as a file next to the shipped one would have it."""
    text = ARM.read_text().replace('model      = "tx60-like" ', 'model      = "tx60-on-track" ')
    text = text.replace('file   = "arm-u-cycle"', 'file   = "track-and-table"')
    head, rest = text.split("# ---- the emulated machine", 1)
    extra = "".join(AXIS.format(**axis) for axis in (TRACK, TABLE))
    return f"{head}{extra}# ---- the emulated machine{rest.rstrip()}\n" + "".join(PLANT.format(**axis) for axis in (TRACK, TABLE))


def carried_cell() -> Cell:
    """Checked."""
    return load_cell(str(ARM), cell_text())
