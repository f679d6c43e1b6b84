"""What the axes of a Reis were synchronised with outlives power-off without being asked for (robotstar L4734-4740; AX-409)."""

import asyncio
import dataclasses
import pathlib

from gateway.pure.cell.cell import Cell
from gateway.pure.image.records.cell import AxisFlag, AxisState
from gateway.services.retained import RetainedData, known_references
from hil_tests.lab.virtual.source_bench import SourceBench
from hil_tests.unit.gateway.pure.arbitration.controls.bench import ControlBench, cell_with
from hil_tests.unit.gateway.pure.arbitration.controls.test_reis_and_val3 import stepped

REIS = cell_with('kind = "reis"', more='[retain]\nvalues = ["flags.M*"]\n')
ON = AxisFlag.REFERENCED


def started(cell: Cell, folder: pathlib.Path) -> tuple[ControlBench, RetainedData]:
    """Control and retained data as the services join them."""
    robot = ControlBench(cell)
    bench = SourceBench(cell, folder=folder)
    bench.image.control = robot.control
    kept = RetainedData(bench.run, bench.image, bench.values, bench.dispatcher, robot.errors, folder / "retain.sqlite", 0)
    kept.restore(robot.control)
    bench.close()  # its regions are not read here
    return robot, kept


def test_a_reference_point_changed_while_the_control_was_off_is_reported_at_the_start(tmp_path: pathlib.Path) -> None:
    robot, kept = started(REIS, tmp_path)
    stepped(robot, ON, ON)
    kept.look()
    asyncio.run(kept.close())
    first = REIS.axis[0]
    moved = dataclasses.replace(
        REIS, axis=(dataclasses.replace(first, home=dataclasses.replace(first.home, position=12.5)), *REIS.axis[1:])
    )
    for _ in range(2):  # the error stands over a second start as well: nobody has referenced the axis
        robot, kept = started(moved, tmp_path)
        stepped(robot, ON, ON)
        assert robot.reis.markers.number(944) == 677 and not robot.reis.markers.bit(1020, 6)
        kept.look()
        asyncio.run(kept.close())
    robot, kept = started(moved, tmp_path)
    for flag in (ON, AxisFlag(0), ON):
        stepped(robot, flag, ON)
    kept.look()
    asyncio.run(kept.close())
    robot, kept = started(moved, tmp_path)
    stepped(robot, ON, ON)
    assert robot.reis.markers.number(944) == 0 and robot.reis.markers.bit(1020, 6)
    asyncio.run(kept.close())


def test_what_cannot_be_read_was_never_kept() -> None:
    assert known_references({"1": [1.5, 2, -1], "2": "x", "a": [1, 2, 3], "3": [1, 2]}).keys() == {1}
    assert known_references(None) == {} and AxisState().flags == 0
