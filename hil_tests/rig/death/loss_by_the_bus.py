"""`drive loss-test --running` against the emulator's own record and the broker's log: half a minute, so only `make losses` runs it."""

import itertools
import pathlib

import pytest

from drivers.emulator.servo.record import read as read_record
from gateway.assembly.plant import motor_rad
from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell
from gateway.tools.client import UNHURRIED_MS, simulated
from gateway.tools.drives import loss_test as losstest
from gateway.tools.drives import loss_test_on_bus as losstest_bus
from hil_tests.lab.judges import bus_log as buslog

SECOND = 1_000_000_000
STOLEN_MS = 150  # a shared machine may keep the emulator from speaking; the record, in bus time, is judged without it


def test_what_the_bus_reports_of_the_stops_is_what_the_shafts_did() -> None:
    cell = load_cell("demo-402")
    with simulated("demo-402", UNHURRIED_MS) as (client, folder):
        stops = losstest_bus.measure(client, cell, {"drives": f"broker:{client.run}-drives"}, 0.5)
        judge_by_record(cell, stops, folder)


def judge_by_record(cell: Cell, stops: list[losstest.Stop], folder: pathlib.Path) -> None:
    """What the bus told is what the emulated shafts did from the gateway's last frame in the broker's log."""
    frames = buslog.frames((folder / "bus-drives.log").read_text().splitlines(keepends=True))
    lives = [frame.stamp_ns for frame in frames if frame.identifier in (0x080, 0x77F)]
    lost = next(a for a, b in itertools.pairwise([*lives, lives[-1] + SECOND]) if b - a >= SECOND and a >= lives[-1] - 20 * SECOND)
    rows = read_record((folder / "emulator-drives.rec").read_bytes()).rows
    at, end = (next(row for row in reversed(rows) if row.stamp_ns <= stamp) for stamp in (lost, lost + SECOND))
    for place, (axis, stop) in enumerate(zip(cell.axis, stops, strict=True)):
        per_rad = abs(1.0 / motor_rad(axis, 1.0))
        speed = abs(at.axes[place].speed_rad_s) * per_rad
        way = abs(end.axes[place].position_rad - at.axes[place].position_rad) * per_rad
        assert 0 < stop.reaction_ms < stop.stop_ms < 1000, stop
        assert stop.reaction_ms <= stop.allowed_ms + STOLEN_MS, stop
        assert stop.speed == pytest.approx(speed, rel=0.1), (stop, speed)
        assert stop.way == pytest.approx(way, abs=0.03 * speed + 0.01), (stop, way)
