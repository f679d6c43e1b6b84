"""A cell and the planner's core in virtual time: programs ordered by a command source, no process, no clock."""

from dataclasses import replace

from gateway.assembly.limits import limits_of
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cell.cell import Home, Plant
from gateway.pure.cycle.enabling_inputs import AS_SHIPPED, free_outputs
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion
from gateway.pure.image.records.planner import ProgramFacts
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.planner import Programs
from hil_tests.lab.virtual.cell_bench import ALL, DEMO, CellBench
from hil_tests.lab.virtual.planner_beside import PlannerBeside
from motion.errors import MotionError
from motion.kinematics.identity import Identity
from motion.planner.robot import Machine

LIMITS = tuple(limits_of(axis) for axis in DEMO.axis)
UNITS = " ".join(axis.unit for axis in DEMO.axis)
# The demo's axes with absolute encoders, a little above 0: nothing has to be searched.
CELL = replace(
    DEMO,
    axis=tuple(replace(axis, home=Home(by="none")) for axis in DEMO.axis),
    plant=replace(DEMO.plant or Plant(), axis={name: replace(axis, start=2.0) for name, axis in (DEMO.plant or Plant()).axis.items()}),
)
FACTS = {1: ProgramFacts("there", ALL), 2: ProgramFacts("back", ALL)}


class WithPlanner:
    """A cell and the planner's core in virtual time: one turn a cycle."""

    def __init__(self, cell: CellBench | None = None) -> None:
        self.cell = cell or CellBench(cell=CELL)
        self.cell.dispatcher = CommandDispatcher(self.cell.dispatcher.axes, self.cell.dispatcher._plan, 1, FACTS)
        self.cell.run(0.1)
        for code in (Code.REQUEST_CONTROL, Code.OVERRIDE, Code.ENABLE):
            assert self.cell.settle(self.cell.give(code)).state is CommandState.DONE
        self.texts: dict[int, str] = {}
        free = free_outputs(AS_SHIPPED, len(LIMITS))
        self.programs = Programs(CellPrograms(lambda *_: Machine(Identity(LIMITS), LIMITS), lambda _: ALL, self.text, free))
        self.planner = PlannerBeside(self.programs, len(LIMITS))
        self.cell.each = self.turn
        self.cell.dispatcher.planner = self.programs.state

    def text(self, number: int) -> str:
        try:
            return self.texts[number]
        except KeyError:
            raise MotionError(f"program {number}: no such file") from None

    def turn(self) -> None:
        self.planner.turn(self.cell.core, self.cell.dispatcher)

    def program(self, *lines: str, number: int = 1) -> None:
        self.texts[number] = "\n".join([f"axes {UNITS}", *lines])

    def order(self, *lines: str, velocity: float = 1.0, source: int = 1) -> Job:
        """Command source 1 orders a program of these lines."""
        if lines:
            self.program(*lines)
        job = self.cell.dispatcher.command(source, Command(Code.PROGRAM, 1, velocity, 1.0), self.cell.now)
        self.cell._hand_over()
        return job

    def finished(self, job: Job) -> Job:
        """Runs until the job has an outcome and the axes rest."""
        self.cell.settle(job)
        for _ in range(100):
            if self.cell.core.state.motion is Motion.IDLE:
                return job
            self.cell.run(0.2)
        raise AssertionError(f"never at rest: {self.cell.core.state}")

    def places(self) -> list[float]:
        return [axis.set / fact.si for axis, fact in zip(self.cell.core.state.axes, self.cell.dispatcher.axes, strict=False)]

    def at(self, place: float, within: float = 0.01) -> bool:
        return all(abs(each - place) < within for each in self.places())

    def still(self, seconds: float = 1.0) -> bool:
        """Nothing moves meanwhile."""
        before = self.places()
        self.cell.run(seconds)
        return max(abs(a - b) for a, b in zip(self.places(), before, strict=True)) < 1e-9


def joints(step: float) -> str:
    """All axes a little further than where referencing left them."""
    return " ".join(f"{step:g}" for _ in LIMITS)
