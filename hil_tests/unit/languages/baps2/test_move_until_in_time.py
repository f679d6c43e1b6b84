"""MAX_TIME of MOVE UNTIL in a cell: it limits the movement (AX-1640)."""

from dataclasses import replace

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.belts import Measuring
from hil_tests.lab.virtual.baps2_bench import CELL, FIRST_INPUT, ProgramCell, one

SLOW = "V = 100\nMOVE PTP TO @(60, 60, 40, 12)\n"
WIRE = FIRST_INPUT + 8  # RC input the probe comes to
IO = "INPUT : 1 = PROBE\nOUTPUT : 3 = FOUND, 4 = LOST"


def cell_of(most: float, channel: int = 1) -> ProgramCell:
    cell = ProgramCell(
        one(
            f"{SLOW}MOVE LINEAR UNTIL PROBE = 1 MAX_TIME = {most} ERROR JUMP MISSED TO (300, 60, 40, 12)\nFOUND = 1\nHALT\n"
            "MISSED:\nLOST = 1\nMOVE_REL LINEAR (0, 10, 0, 0)",
            IO.replace("1 = PROBE", f"{channel} = PROBE"),
        ),
        replace(CELL, measuring=(Measuring(610, WIRE), Measuring(611, WIRE + 1))),
    )
    cell.bench.permit(WIRE, WIRE + 1, value=False)
    return cell


@pytest.mark.parametrize(
    ("channel", "most", "low", "high"), [(1, 0.8, 110, 160), (610, 0.8, 110, 160), (611, 0.8, 110, 160), (1, 0.0, 60, 60.001)]
)
def test_the_axes_stop_on_the_path_and_the_error_part_runs(channel: int, most: float, low: float, high: float) -> None:
    cell = cell_of(most, channel)
    assert cell.ends(cell.start("P"))[:2] == ("ended", 0)
    assert [channel for _, channel, _ in cell.outputs] == [4]
    assert low <= cell.at()[0] < high, "V = 100 mm/s"
    assert cell.at()[1:] == pytest.approx((70, 40, 12)), "the next block begins where the axes came to rest"


def test_an_input_in_time_counts_as_without_a_limit() -> None:
    cell = cell_of(2.0)
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 100)
    cell.give(1)
    assert cell.ends(run)[:2] == ("ended", 0)
    assert [channel for _, channel, _ in cell.outputs] == [3] and 100 < cell.at()[0] < 120


def test_an_input_while_the_axes_brake_is_too_late() -> None:
    cell = cell_of(0.8)
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 60.01)
    began = len(cell.places)
    cell.until(lambda: len(cell.places) > began + 100 and _step(cell) < 0.39)
    cell.give(1)
    assert _step(cell) > 0.01, "they still move"
    assert cell.ends(run)[:2] == ("ended", 0)
    assert [channel for _, channel, _ in cell.outputs] == [4]


def test_a_stopped_path_does_not_use_the_time_up() -> None:
    cell = cell_of(3.0)
    run = cell.start("P")
    cell.until(lambda: cell.at()[0] > 100)
    cell.bench.give(Code.STOP)
    cell.bench.run(4.0)
    assert cell.at()[0] < 200
    cell.bench.give(Code.RESUME)
    assert cell.ends(run)[:2] == ("ended", 0)
    assert cell.at()[0] == 300, "2.4 s of movement"


def _step(cell: ProgramCell) -> float:
    """mm of the last cycle."""
    return abs(cell.places[-1][0] - cell.places[-2][0])
