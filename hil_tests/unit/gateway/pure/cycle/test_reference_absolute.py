"""Referencing where there is nothing to reference: refused at once without a zero, done at once with one."""

from dataclasses import replace

import pytest

from gateway.assembly.axes import core_axes
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.reasons import CommandState, Reason
from hil_tests.lab.virtual.cell_bench import ALL, DEMO, CellBench

ABSOLUTE = replace(DEMO, axis=(replace(DEMO.axis[0], home=replace(DEMO.axis[0].home, by="none")), *DEMO.axis[1:]))


class Metal(CellBench):
    """As on metal: an absolute axis counts only from its known zero on."""

    zeros: dict[str, float] = {}  # noqa: RUF012  # a constant of the class

    def _new_core(self) -> CycleLogic:
        axes = core_axes(self.cell, self.p5_ms, self.zeros, simulated=False)
        return CycleLogic(axes, self.p5_ms / 1000.0, self.generation)


class Zeroed(Metal):
    zeros = {DEMO.axis[0].name: 0.0}  # noqa: RUF012


def enabled(kind: type[CellBench], cell: Cell) -> CellBench:
    bench = kind(cell=cell)
    bench.run(0.3)
    bench.settle(bench.give(Code.REQUEST_CONTROL))
    bench.settle(bench.give(Code.OVERRIDE))
    assert bench.settle(bench.give(Code.ENABLE, mask=ALL)).state is CommandState.DONE
    return bench


def test_an_absolute_axis_without_a_zero_says_so_at_once() -> None:
    bench = enabled(Metal, ABSOLUTE)
    job = bench.give(Code.REFERENCE, mask=1)
    assert (job.state, job.reason) == (CommandState.REFUSED, Reason.NOT_REFERENCED)
    assert job.detail.startswith('A1: home.by = "none" and no zero is known; set it: axisgate axis zero')


@pytest.mark.parametrize("mask", [0b1, 0b11])
def test_one_with_a_zero_has_nothing_to_do_and_the_others_are_referenced(mask: int) -> None:
    bench = enabled(Zeroed, ABSOLUTE)
    job = bench.give(Code.REFERENCE, mask=mask)
    if mask == 1:
        bench.run(0.1)
        assert job.state is CommandState.DONE, "not one axis has to move"
    assert bench.settle(job).state is CommandState.DONE
