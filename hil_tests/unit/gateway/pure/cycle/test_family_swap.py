"""One line swaps the family: the same cell and script with SERVODYN-GC and with CiA 402 drives, by the emulated drives' own records."""

import pathlib
import re

import pytest

import configs
from drivers.emulator.servo.record import Record, read
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import AxisFlag
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.cell_bench import CellBench

CELLS = pathlib.Path(configs.__path__[0]) / "cells"
FAR = (500.0, 420.0, 220.0, 60.0, -40.0, 120.0)
BACK = (120.0, 200.0, 80.0, -20.0, 10.0, -60.0)
Path = list[tuple[tuple[int, ...], tuple[int, ...]]]  # (set, position) of all axes at each SYNC, relative to where the script began


def played(cell: CellBench) -> Path:
    """Referenced, there and back with an override and a stop on the path; the rows from the first command to the last."""
    cell.ready()
    cell.run(0.5)
    cell.slave.take_record()
    cell.run(0.2)
    assert cell.settle(cell.give(Code.PTP_ABSOLUTE, targets=FAR)).state is CommandState.DONE
    move = cell.give(Code.PTP_ABSOLUTE, velocity=0.6, targets=BACK)
    cell.run(0.4)
    cell.settle(cell.give(Code.STOP))
    cell.run(0.2)
    cell.settle(cell.give(Code.OVERRIDE, velocity=0.5))
    cell.settle(cell.give(Code.RESUME))
    cell.settle(move)
    cell.run(0.5)
    return relative(read(cell.slave.header() + cell.slave.take_record()))


def relative(record: Record) -> Path:
    zero = [axis.set_inc for axis in record.rows[0].axes]
    return [
        (
            tuple(axis.set_inc - start for axis, start in zip(row.axes, zero, strict=True)),
            tuple(axis.position_inc - start for axis, start in zip(row.axes, zero, strict=True)),
        )
        for row in record.rows
    ]


def from_motion(path: Path) -> Path:
    """From the SYNC at which the first set value moves."""
    first = next(n for n, (set_, _) in enumerate(path) if any(set_))
    return path[first:]


def test_both_families_run_the_same_path_within_one_increment_at_every_sync() -> None:
    old, new = from_motion(played(CellBench())), from_motion(played(Cell402Bench()))
    common = min(len(old), len(new))
    assert common > 900
    worst_set = max(abs(a - b) for x, y in zip(old[:common], new[:common], strict=True) for a, b in zip(x[0], y[0], strict=True))
    worst = max(abs(a - b) for x, y in zip(old[:common], new[:common], strict=True) for a, b in zip(x[1], y[1], strict=True))
    assert (worst_set, worst) <= (1, 1), (worst_set, worst)


def test_the_two_cells_differ_in_drive_and_bus_lines_only() -> None:
    old, new = ((CELLS / name).read_text().splitlines() for name in ("demo.toml", "demo-402.toml"))
    keep = re.compile(r"^(drive|protocol|layout|axes|heartbeat_ms)\b|^#")
    assert [line for line in old if not keep.match(line)] == [line for line in new if not keep.match(line)]


def test_an_axis_its_own_drive_referenced_is_masked_meanwhile_and_supervised_from_the_first_cycle_on() -> None:
    cell = Cell402Bench(8, cell=load_cell("s5-rk512"))
    cell.run(0.3)
    for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
        assert cell.settle(cell.give(code, mask=7)).state is CommandState.DONE
    homing = 0

    def note() -> None:
        nonlocal homing
        homing += bool(cell.core.state.axes[0].flags & AxisFlag.HOMING)

    cell.each = note
    assert cell.settle(cell.give(Code.REFERENCE, mask=7)).state is CommandState.DONE
    cell.run(0.1)
    assert homing > 50 and cell.core.state.stop_cause == 0, "the jump of the drive's zero is not a following error"
    assert cell.actual()[:3] == pytest.approx([12.35, 3.10, 20.0], abs=0.1), (
        "home.offset where the drive found its home, Z as its encoder says"
    )
    cell.slave.jump_encoder(1, -200_000)
    cell.run(0.3)
    assert cell.core.state.stop_cause in (Reason.FOLLOWING_ERROR, Reason.DRIVE_FAULT)
