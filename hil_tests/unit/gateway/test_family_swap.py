"""One line swaps the family: the same cell and script with SERVODYN-GC and with CiA 402 drives, by the emulated drives' own records."""

import pathlib
import re

import configs
from drivers.emulator.record import Record, read
from gateway.pure.command_block import Code
from gateway.pure.reasons import CommandState
from hil_tests.lab.cell402bench import Cell402Bench
from hil_tests.lab.cellbench import CellBench

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
