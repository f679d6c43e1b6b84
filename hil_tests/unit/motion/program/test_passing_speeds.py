"""rho 3 Releases part 1, 6.1.1 (L1773-1790): passing of a PTP point in a cell, judged by the emulator's own record of set values."""

import numpy as np
import pytest

from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.image.reasons import CommandState
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot

HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\n"
PATH = find_config("portal", "cells")


@pytest.fixture(scope="module")
def cell() -> Planned:
    shipped = read_text(PATH).replace('by = "gateway", mode = 0', 'by = "none", mode = 0')
    return Planned(ServodynRobot(cell=load_cell(str(PATH), shipped)))


def ptp(cell: Planned, zone: float) -> tuple[Array, float]:
    """X and Y of the set values, mm, over X 100 -> 300, then Y 100 -> 300, passed within `zone` mm of each axis; the clock in s."""
    assert cell.bench.settle(cell.order(HEAD + "ptp joints 100 100 50 0")).state is CommandState.DONE
    cell.driven()
    passed = f" zone={zone:g},{zone:g},{zone:g},{zone:g}" if zone else ""
    assert cell.bench.settle(cell.order(HEAD + f"ptp joints 300 100 50 0{passed}\nptp joints 300 300 50 0")).state is CommandState.DONE
    made = cell.driven()
    assert max(made.shares()) <= 1.02
    return made.sets[:, :2] * 1e3, made.period


@pytest.mark.requirement("RHO-MOT-01", by="motion.planner.ranges:axis_range")
def test_the_range_doubles_with_its_factor_and_no_axis_stops_or_changes_its_speed_in_a_step(cell: Planned) -> None:
    begins, deviations = [], []
    for zone in (20.0, 40.0):  # P213 = 20 mm, R_PTP = 1 and 2
        places, period = ptp(cell, zone)
        off = np.flatnonzero((places[:, 1] > 100.002) & (places[:, 0] < 299.998))
        begins.append(300.0 - places[off[0] - 1, 0])
        assert places[off[-1] + 1, 1] - 100.0 == pytest.approx(zone, abs=2.5), "it ends as far behind the point"
        deviations.append(np.min(np.hypot(places[:, 0] - 300.0, places[:, 1] - 100.0)))
        speeds = np.diff(places, axis=0) / period
        moving = np.flatnonzero(np.linalg.norm(speeds, axis=1) > 1.0)
        through = np.linalg.norm(speeds[off[0] : off[-1]], axis=1)
        assert np.min(through) > 10.0, "soft block transition: no stop at the point"
        steps = np.abs(np.diff(speeds[moving[0] : moving[-1]], axis=0)).max()
        assert steps < 0.1 * np.max(np.abs(speeds)), "from clock to clock"
    assert begins == pytest.approx([20.0, 40.0], abs=2.5)
    assert deviations[1] == pytest.approx(2 * deviations[0], rel=0.15), "a larger range, a larger stretch that deviates"


def test_without_a_range_the_point_is_met_at_rest(cell: Planned) -> None:
    places, period = ptp(cell, 0.0)
    nearest = int(np.argmin(np.hypot(places[:, 0] - 300.0, places[:, 1] - 100.0)))
    assert places[nearest] == pytest.approx((300.0, 100.0), abs=0.02)
    assert np.linalg.norm(np.diff(places[nearest - 1 : nearest + 1], axis=0) / period) < 1.0
