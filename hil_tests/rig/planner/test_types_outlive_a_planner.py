"""AX-394: a planner process that takes over goes on with the types of belts its predecessor published; regions and rings are real."""

import os
import pathlib
import time
from collections.abc import Callable

from gateway.assembly.programs import ProgramPlan
from gateway.assembly.run import RunPlan, make_regions
from gateway.processes.planner import PlannerProcess
from gateway.pure.image.records.cell import CellState, cell_state_packer
from gateway.pure.image.records.planner import ProgramOrder, pack_block, run_record
from gateway.runtime.regions import RegionWriter, RingWriter
from hil_tests.lab.virtual.belt_bench import ALL, CELL, HEAD
from motion.sync.belts import STANDARD_TOLERANCE

JOB, CYCLE = 5, 7
PACK = cell_state_packer(len(CELL.axis))


def until(planner: PlannerProcess, holds: Callable[[], bool]) -> bool:
    """Turn after turn, as the process would."""
    for _ in range(200):
        planner.turn()
        if holds():
            return True
    return False


def test_the_next_planner_knows_what_programs_have_set_until_the_cycle_starts_anew(tmp_path: pathlib.Path) -> None:
    program = tmp_path / "p.txt"
    program.write_text(HEAD + "belt_type 1 73\n")
    plan = RunPlan("types", CELL, True, tmp_path, 4, {}, {}, {}, (), programs={1: ProgramPlan("it", str(program), ALL)})
    fds = make_regions(plan)
    axes, blocks = RegionWriter(fds["axes"]), RingWriter(fds["blocks"])

    def says(generation: int = CYCLE, parts: int = 0) -> None:
        axes.write(PACK(CellState(generation=generation, taken=JOB, parts=parts)), time.monotonic_ns())

    says()
    first = PlannerProcess(plan, fds)
    first.turn()
    blocks.put(pack_block(run_record(ProgramOrder(JOB, 1, 1.0, 1.0))))
    assert until(first, lambda: first.programs.lanes[0]._job.handed), "the statement is a part of its own"
    says(parts=1)
    assert until(first, lambda: first.programs.state.types[:1] == ((3, 7),))
    second = PlannerProcess(plan, fds)
    second.turn()
    assert second.programs.state.types[0] == (3, 7)
    says(parts=1, generation=CYCLE + 1)
    second.turn()
    assert second.programs.state.types[0] == (1, STANDARD_TOLERANCE), "a start-up of the control"
    for planner in (first, second):
        planner.journal.close()
    for fd in fds.values():
        os.close(fd)
