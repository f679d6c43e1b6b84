"""AX-970: a sender that runs round the ring of the planner has taken statements away, and its stream ends; rings and regions are real."""

import os
import pathlib
import time

import pytest

from gateway.assembly.run import RunPlan, make_regions
from gateway.processes.planner import PlannerProcess
from gateway.pure.image.records.cell import CellState, cell_state_packer
from gateway.pure.image.records.planner import BLOCKS, BlockRecord, ProgramOrder, Say, pack_block, run_record
from gateway.runtime.regions import RegionWriter, RingWriter
from hil_tests.lab.virtual.belt_bench import CELL

JOB = 5


@pytest.mark.parametrize("beyond", [0, 3])
def test_what_runs_round_the_ring_ends_the_stream_with_the_number_of_what_is_lost(tmp_path: pathlib.Path, beyond: int) -> None:
    plan = RunPlan("flood", CELL, True, tmp_path, 4, {}, {}, {}, ())
    fds = make_regions(plan)
    axes, blocks = RegionWriter(fds["axes"]), RingWriter(fds["blocks"])
    axes.write(cell_state_packer(len(CELL.axis))(CellState(generation=7, taken=JOB)), time.monotonic_ns())
    planner = PlannerProcess(plan, fds)
    planner.turn()
    blocks.put(pack_block(run_record(ProgramOrder(JOB, 0, 1.0, 1.0, robot=1))))
    planner.turn()
    for _ in range(BLOCKS - 1 + beyond):
        blocks.put(pack_block(BlockRecord(Say.LINE, JOB, "set path=100")))
    for _ in range(BLOCKS // 64 + 1):
        planner.turn()
    said = planner.programs.state.fault
    assert (said == "") if not beyond else (said.startswith(f"block 1: {beyond} statements of the stream are lost")), said
    planner.journal.close()
    for fd in fds.values():
        os.close(fd)
