"""A whole simulated run with the planner process: a program through the rings to the emulated drives, and the planner's death."""

import contextlib
import os
import pathlib
import time
from collections.abc import Callable, Iterator

import pytest

from gateway.image import RegionReader, RingWriter, recv_fds
from gateway.processes.supervisor import ask
from gateway.pure.plannerrecords import SAY_LAYOUT, BlockRecord, PlannerState, Say, pack_block, unpack_planner
from gateway.pure.reasons import Reason
from gateway.pure.records import CellState, Motion, unpack_cell_state
from hil_tests.lab.cell_running import CellRun, running_cell

DEMO = pathlib.Path(__file__).parents[3] / "configs" / "cells" / "demo.toml"
UNITS = "mm mm mm deg deg deg"
ROBOT = """format = 1
[robot]
name = "gantry"
kind = "identity"
angles = "val3"
source = "test"
""" + "".join(
    f'[[axis]]\nname = "A{n}"\nunit = "{unit}"\nlower = -100\nupper = 1500\nspeed = 500\naccel = 1500\njerk = 15000\nsource = "test"\n'
    for n, unit in enumerate(UNITS.split(), 1)
)


class Tool:
    """What orders programs: the writer of the blocks ring, and eyes on cycle and planner."""

    def __init__(self, run: CellRun, robot: pathlib.Path) -> None:
        with ask(run.name, "regions") as connection:
            self.fds = recv_fds(connection)
        self.blocks = RingWriter(self.fds["blocks"], "blocks", SAY_LAYOUT)
        self.axes = RegionReader(self.fds["axes"], "axes")
        self.planner = RegionReader(self.fds["planner"], "planner")
        self.robot, self.run = robot, run

    def say(self, job: int, *lines: str, end: bool = True) -> None:
        head = [BlockRecord(Say.BEGIN, job, f"robot {self.robot}"), BlockRecord(Say.LINE, job, f"axes {UNITS}")]
        for record in [*head, *(BlockRecord(Say.LINE, job, line) for line in lines), *([BlockRecord(Say.END, job)] if end else [])]:
            self.blocks.put(pack_block(record))

    def state(self) -> CellState:
        payload = self.axes.read()
        assert payload is not None
        return unpack_cell_state(payload)

    def planned(self) -> PlannerState:
        payload = self.planner.read()
        assert payload is not None
        return unpack_planner(payload)

    def wait(self, what: str, seconds: float, test: Callable[[CellState], bool]) -> CellState:
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            state = self.state()
            if test(state):
                return state
            time.sleep(0.01)
        words = self.run.words()[-2000:]
        raise AssertionError(f"{what}: {self.state()} {self.planned()} {words}")

    def close(self) -> None:
        self.blocks.close()
        for fd in self.fds.values():
            os.close(fd)


@pytest.fixture
def playing(tmp_path: pathlib.Path) -> Iterator[tuple[CellRun, Tool]]:
    cell, robot = tmp_path / "cell.toml", tmp_path / "gantry.toml"
    cell.write_text(DEMO.read_text() + '\n[robot]\nkinematics = "identity"\nmodel = "gantry"\n')
    robot.write_text(ROBOT)
    with running_cell(str(cell), "planner") as run:
        run.ready()
        with contextlib.closing(Tool(run, robot)) as tool:
            yield run, tool


def test_a_program_reaches_the_drives_and_a_dead_planner_leaves_them_at_rest(playing: tuple[CellRun, Tool]) -> None:
    run, tool = playing
    tool.say(9001, "ptp joints 60 40 30 10 10 10 blend=joint leave=2 reach=2", "ptp joints 100 40 30 10 10 10")
    done = tool.wait("the program is done", 20, lambda s: s.done_job == 9001)
    assert done.motion is Motion.IDLE
    assert done.axes[0].actual == pytest.approx(0.100, abs=2e-3) and done.axes[1].actual == pytest.approx(0.040, abs=2e-3)

    tool.say(9002, "ptp joints 600 300 30 10 10 10", end=False)
    tool.wait("it moves", 5, lambda s: s.motion is Motion.RUNNING and s.axes[0].actual > 0.15)
    dead, _ = run.kill("planner")
    run.back("planner", dead)
    rest = tool.wait("at rest", 10, lambda s: s.motion is Motion.IDLE)
    assert (rest.failed_job, rest.failed_reason) == (9002, Reason.PLANNER_LOST)
    time.sleep(0.3)
    still = tool.state()
    assert abs(still.axes[0].set - rest.axes[0].set) < 1e-12
    share = (still.axes[0].set - 0.1) / 0.5
    assert still.axes[1].set == pytest.approx(0.04 + share * 0.26, abs=1e-6), "on the path"

    tool.say(9003, "ptp joints 0 0 1e5 0 0 0")
    tool.wait("refused", 5, lambda _: tool.planned().failed_job == 9003)
    assert tool.planned().fault_block == 1 and tool.planned().fault_code == 520 and "A3" in tool.planned().fault
    tool.say(9004, "ptp joints 100 40 30 10 10 10")
    tool.wait("goes on with a fresh program", 20, lambda s: s.done_job == 9004)
