"""Turns of the services: one a cycle where an integrated PLC reacts to inputs that pass here (AX-1767)."""

import pathlib
from dataclasses import replace

from gateway.assembly.run import RunPlan
from gateway.pure.cell.cell import Cell
from gateway.services.loop import tick_ns
from hil_tests.lab.virtual.reis_bench import SHIPPED


def turn_ms(cell: Cell, p5_ms: int) -> float:
    return tick_ns(RunPlan("turns", cell, True, pathlib.Path(), p5_ms, {}, {}, {}, ())) / 1e6


def test_a_turn_lasts_no_longer_than_a_cycle_beside_a_plc() -> None:
    assert SHIPPED.controller is not None and SHIPPED.controller.plc is not None
    assert [turn_ms(SHIPPED, p5_ms) for p5_ms in (1, 2, 4, 8, 10)] == [2, 2, 4, 5, 5]
    without = replace(SHIPPED, controller=replace(SHIPPED.controller, plc=None))
    assert [turn_ms(without, p5_ms) for p5_ms in (1, 4, 10)] == [5, 5, 5]
