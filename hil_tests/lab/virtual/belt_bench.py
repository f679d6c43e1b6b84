"""A portal with three belts in virtual time: dispatcher, planner's inside, core with belts, emulated drives and encoders; no process."""

import pathlib
from collections.abc import Callable

from drivers.drives.family import BusFamily
from drivers.drives.servodyn_family import ServodynFamily
from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.io.belts import EmulatedBelt, EmulatedBelts
from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.assembly.axes import core_axes
from gateway.assembly.belts import belt_facts
from gateway.assembly.cycle_belts import encoders_of
from gateway.assembly.limits import limits_of
from gateway.assembly.programs import machine_of_cell
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.belts import CoreBelts
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.cycle.core_settings import CoreParts
from gateway.pure.cycle.enabling_inputs import AS_SHIPPED, free_outputs
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import CellState, Motion, pack_cell_state, unpack_cell_state
from gateway.pure.image.records.planner import PlannerState, ProgramFacts
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.planner import Programs
from hil_tests.lab.running.belt_run import INCREMENT, SPEED, with_belts
from hil_tests.lab.virtual.cell_bench import CellBench
from hil_tests.lab.virtual.planner_beside import PlannerBeside
from hil_tests.lab.virtual.servodyn_bus import CODEC
from motion.sync.belts import SET_COUNTER
from protocols.base.machine import Frame
from protocols.servodyn.plan import SYNC_ID

PORTAL = pathlib.Path(__file__).parents[3] / "configs" / "cells" / "portal.toml"
TEXT = with_belts(PORTAL.read_text())
CELL = load_cell(str(PORTAL), TEXT)
MACHINE, FACTS = machine_of_cell(CELL), belt_facts(CELL)
AXES, ALL = 4, 0xF
HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\n"


class BeltBench(CellBench):
    """Command source 1 orders programs; `emulated` are the three belts, of types 1, 2 and 3.  head, home: of every program, and where
    they begin."""

    head, home = HEAD, "ptp joints 100 100 50 0"

    def __init__(self, cell: Cell = CELL) -> None:
        self.machine, self.facts = machine_of_cell(cell), belt_facts(cell)
        self.axes, self.all = len(cell.axis), (1 << len(cell.axis)) - 1
        super().__init__(p5_ms=4, cell=cell)
        self.dispatcher = CommandDispatcher(self.dispatcher.axes, self.dispatcher._plan, 1, {1: ProgramFacts("it", self.all)})
        self.text = ""
        self.another_planner(PlannerState())
        self.seen: list[CellState] = []
        self.each = self._turn
        self.dispatcher.planner = self.programs.state
        self.run(0.1)
        for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
            assert self.settle(self.give(code, self.all)).state is CommandState.DONE
        assert self.finished(self.order(self.home)).state is CommandState.DONE

    def _drives(self) -> tuple[ServodynSlave | Cia402Slave, BusFamily]:
        slave, _ = super()._drives()
        self.emulated = EmulatedBelts(
            [EmulatedBelt(belt.id, accel=2.0 / INCREMENT, byte=belt.byte, size=belt.bytes) for belt in self.cell.belt]
        )
        return slave, ServodynFamily(CODEC, [(n, n + 1) for n in range(self.axes)])

    def _new_core(self) -> CycleLogic:
        period = self.period_ns / 1e9
        self.belts = CoreBelts(self.facts, {1: self.machine.kinematics}, [limits_of(axis) for axis in self.cell.axis], period)
        self.encoders = encoders_of(self.cell, "drives", self.belts)
        return CycleLogic(core_axes(self.cell, self.p5_ms), period, self.generation, parts=CoreParts(self.belts))

    # ---- what happens --------------------------------------------------------------------------------------------------
    def cycle(self, count: int = 1) -> None:
        """The encoders answer the SYNC as the drives do."""
        for _ in range(count):
            self.emulated.receive([Frame(SYNC_ID, stamp_ns=self.now)])
            for frame in self.emulated.take_output():
                self.encoders[frame.identifier].hear(frame.data)
            super().cycle()

    def another_planner(self, before: PlannerState) -> None:
        """`before`: the last record of its predecessor."""
        free = free_outputs(AS_SHIPPED, self.axes)
        self.programs = Programs(CellPrograms(lambda *_: self.machine, lambda _: self.all, lambda _: self.text, free, belts=self.facts))
        self.programs.follows(before)
        self.planner = self._beside()

    def _beside(self) -> PlannerBeside:
        return PlannerBeside(self.programs, self.axes)

    def _turn(self) -> None:
        """One of the planner, and what the ring carries; every state of the cycle is kept."""
        self.seen.append(unpack_cell_state(pack_cell_state(self.core.state)))
        self.planner.turn(self.core, self.dispatcher)

    def drive(self, kind: int, speed: float) -> None:
        """The belt of this type runs at m/s, from now on."""
        self.emulated.all[kind - 1].speed = self.emulated.all[kind - 1].now = speed / INCREMENT

    def zero(self, kind: int) -> None:
        """RC input 376 + n - 1: the counter becomes its reset value, 0."""
        self.permit(SET_COUNTER + kind - 1)
        self.cycle()
        self.permit(SET_COUNTER + kind - 1, value=False)
        self.cycle()

    def started(self, kind: int, speed: float = SPEED) -> None:
        """The belt runs, its counter begins at 0."""
        self.drive(kind, speed)
        self.run(0.1)
        self.zero(kind)

    def order(self, *lines: str) -> Job:
        """Command source 1 orders a program of these lines."""
        self.text = self.head + "\n".join(lines)
        self.seen.clear()
        job = self.dispatcher.command(1, Command(Code.PROGRAM, 1, 1.0, 1.0), self.now)
        self._hand_over()
        return job

    def finished(self, job: Job) -> Job:
        """Runs until the job has an outcome and the axes rest."""
        self.settle(job)
        for _ in range(1000):
            if self.core.state.motion is Motion.IDLE:
                return job
            self.cycle()
        raise AssertionError(f"never at rest: {self.core.state}")

    def until(self, holds: Callable[[CellState], bool], seconds: float = 10.0) -> None:
        """Runs until it holds."""
        for _ in range(round(seconds * 1e9 / self.period_ns)):
            if holds(self.core.state):
                return
            self.cycle()
        raise AssertionError(f"never: {self.core.state}")

    def sets(self) -> list[list[float]]:
        """Set values of every cycle since the order; m and rad."""
        return [[axis.set for axis in state.axes[: self.axes]] for state in self.seen]
