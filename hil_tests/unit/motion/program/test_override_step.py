"""RDELTA_OV_MAX of the Reis in a cell: override_step, judged by the emulator's own record.  AX-388."""

from dataclasses import replace

import numpy as np
import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.faults import CellFaults
from gateway.pure.cycle.enabling_inputs import AS_SHIPPED
from gateway.pure.image.reasons import CommandState
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.virtual.belt_bench import CELL, PORTAL
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot
from motion.geometry.units import to_si

HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\n"
PATH = 100.0  # mm/s
CYCLES_S = 0.004


def speeds(step: float) -> Array:
    """mm/s of X in every cycle from the order of override 100 % on; 20 % before."""
    cell = Planned(ServodynRobot(cell=replace(CELL, cell=replace(CELL.cell, override_step=step))))
    assert cell.bench.settle(cell.order(HEAD + "ptp joints 100 100 50 0")).state is CommandState.DONE
    cell.done(Code.OVERRIDE, 0.2)
    cell.bench.run(2.0)  # it is there
    cell.order(HEAD + f"linear pose 500 100 50 0 0 0 path={PATH:g}")
    cell.until(lambda state: state.axes[0].set > to_si(120.0, "mm"))
    cell.driven()
    cell.done(Code.OVERRIDE, 1.0)
    cell.bench.run(2.5)
    return np.asarray(np.diff(cell.driven().sets[:, 0]) * 1e3 / CYCLES_S)


@pytest.mark.requirement("RSV-MOT-20", by="gateway.pure.cycle.core:CycleLogic._apply_override")
def test_override_20_to_100_percent_at_0_2_percent_a_cycle_takes_400_cycles_and_at_once_where_nothing_is_said() -> None:
    slow, quick = speeds(0.002), speeds(1.0)
    fine = 1.0  # mm/s: what rounding to increments does
    for seen, least, most in ((slow, 385, 405), (quick, 1, 60)):
        from_here = int(np.argmax(seen > 0.2 * PATH + fine))
        there = int(np.argmax(seen > PATH - fine))
        assert seen[:from_here] == pytest.approx(0.2 * PATH, abs=fine)
        assert least <= there - from_here <= most and seen[there:].max() < PATH + fine
    begin = int(np.argmax(slow > 0.2 * PATH + fine))
    assert slow[begin : begin + 380] == pytest.approx(0.2 * PATH + 0.002 * PATH * np.arange(380), abs=3.0), "in even steps"


def test_feed_hold_and_stop_do_not_wait_for_it() -> None:
    cell = Planned(ServodynRobot(cell=replace(CELL, cell=replace(CELL.cell, override_step=0.002))))
    assert cell.bench.settle(cell.order(HEAD + "ptp joints 100 100 50 0")).state is CommandState.DONE
    cell.order(HEAD + f"linear pose 500 100 50 0 0 0 path={PATH:g}")
    cell.until(lambda state: state.axes[0].set > to_si(120.0, "mm"))
    for held in (True, False):
        cell.bench.permit(AS_SHIPPED.feed, value=not held)
        cell.bench.run(0.3)
        cell.driven()
        cell.bench.run(0.02)
        assert np.ptp(cell.driven().sets[:, 0]) * 1e3 == pytest.approx(0.0 if held else 0.016 * PATH, abs=0.02 if held else 0.5)


@pytest.mark.parametrize("value", ["0.0", "1.5", "-0.1"])
def test_what_is_outside_is_refused_with_its_range(value: str) -> None:
    text = PORTAL.read_text().replace("[cell]\n", f"[cell]\noverride_step = {value}\n", 1)
    with pytest.raises(CellFaults, match=r"cell.override_step = .*: allowed"):
        load_cell(str(PORTAL), text)
