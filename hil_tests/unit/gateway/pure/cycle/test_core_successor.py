"""Services that died and were replaced before their life counter was old: the move ends as configured all the same (design 4)."""

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.web import PAGE_SOURCE
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.virtual.cell_bench import CellBench

FAR = (600.0, 500.0, 300.0, 90.0, 50.0, 90.0)


@pytest.mark.parametrize("finishes, ends", [(False, Motion.STOPPED), (True, Motion.IDLE)])
def test_a_quick_successor_does_not_hide_the_death(finishes: bool, ends: Motion) -> None:
    cell = CellBench(finish_without_services=finishes).ready()
    cell.give(Code.PTP_ABSOLUTE, targets=FAR)
    cell.run(0.5)
    assert cell.core.state.motion is Motion.RUNNING
    cell.core.services_lost()
    cell.run(4.0)
    assert cell.core.state.motion is ends
    assert cell.core.state.stop_cause == (0 if finishes else Reason.SERVICES_LOST)
    assert cell.core.state.services_lost == 1


def test_a_jog_of_the_page_stops_without_the_services_even_where_moves_are_finished() -> None:
    """Hold-to-run: without the services the release of the key is not received."""
    cell = CellBench(finish_without_services=True).ready()
    cell.settle(cell.give(Code.RELEASE_CONTROL))
    cell.settle(cell.give(Code.REQUEST_CONTROL, source=PAGE_SOURCE))
    cell.give(Code.PTP_ABSOLUTE, targets=FAR, source=PAGE_SOURCE)
    cell.run(0.5)
    assert cell.core.state.motion is Motion.RUNNING
    cell.core.services_lost()
    cell.run(4.0)
    assert (cell.core.state.motion, cell.core.state.stop_cause) == (Motion.STOPPED, Reason.SERVICES_LOST)
