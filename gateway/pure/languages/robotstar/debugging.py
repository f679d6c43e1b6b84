"""ROBOTstar programs under a debugger, in virtual time: position, variables and stepping of the program."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from gateway.pure.languages.base.debug import Debugger, Step
from gateway.pure.languages.base.process import Process, ProcessState
from gateway.pure.languages.robotstar.machine import LOOK, Frame, Machine, Op
from gateway.pure.languages.robotstar.memory import Memory
from gateway.pure.languages.robotstar.program import DEFINITIONS, HEADS, Program
from gateway.pure.languages.robotstar.robot import Mode
from gateway.pure.languages.robotstar.script import Order
from gateway.pure.languages.robotstar.steps import build
from gateway.pure.languages.robotstar.values import Names, flat
from gateway.pure.languages.robotstar.virtual import Plc, VirtualCell

AREAS = (("E", "INPUT"), ("A", "OUTPUT"))
IO_BYTES = 40


@dataclass(frozen=True, slots=True)
class Place:
    """One program of the calls, the innermost first."""

    program: Program
    line: int
    own: dict[str, object]
    everywhere: dict[str, object]  # global variables


class DebugRun:
    """One program of a memory that can be held before any step."""

    def __init__(self, memory: Memory, mode: Mode, plc: Plc | None = None) -> None:
        self.memory = memory
        self.cell = VirtualCell(memory, mode, plc, paused=lambda: self.held)
        self.cell.robot.machine.build = self._watched
        self.debugger = Debugger()
        self.process = Process(1, "")
        self._skips = False  # the step before which it was held
        self._turns: Iterator[None] = iter(())

    @property
    def held(self) -> bool:
        """In front of a step."""
        return self.process.state is ProcessState.HELD

    def begin(self, program: str, script: Iterable[Order], until: int | None) -> None:
        """Power-on; START at 0 with the first `go_on`."""
        self.process.program = program
        self._turns = self.cell.turns(script, until, program)

    def go_on(self) -> bool:
        """One look at the cell; False: nothing can happen any more."""
        return next(self._turns, self) is None

    def resume(self, how: Step) -> None:
        """Continue the held program in this way."""
        self.debugger.go_on(self.process, how, self._depth)
        self._skips = True

    def pause(self) -> None:
        """Holds it before its next step."""
        self.debugger.hold(self.process)

    def lines(self, file: str) -> list[int]:
        """Return the lines with a step that is executed; none where the file is not a program of the memory."""
        found = self.program_of(file)
        return sorted(step.line for step in found.steps if executed(found, step.number)) if found is not None else []

    def program_of(self, file: str) -> Program | None:
        """The program of a file, by its path below the root in any case of letters."""
        return next((each for each in self.memory.all() if each.file.upper() == file.upper()), None)

    def places(self) -> list[Place]:
        """The calls, the innermost first."""
        return [self._place(frame, depth) for depth, frame in enumerate(reversed(self.cell.robot.machine.stack))]

    def channels(self) -> dict[str, object]:
        """Input and output bytes that are not 0."""
        found = ((f"{letter}{byte}", self.cell.byte(area, byte)) for letter, area in AREAS for byte in range(IO_BYTES))
        return {name: value for name, value in found if value}

    @property
    def _depth(self) -> int:
        return len(self.cell.robot.machine.stack)

    def _place(self, frame: Frame, depth: int) -> Place:
        """Return the place of a frame; a caller is at its call, though it continues after it."""
        steps, at = frame.program.steps, max(frame.at - 1, 0) if depth else frame.at
        line = steps[min(at, len(steps) - 1)].line if steps else 1
        return Place(frame.program, line, _shown(self.memory.locals.get(frame.program.key, {})), _shown(self.memory.globals))

    def _watched(self, machine: Machine, program: Program) -> list[Op]:
        """The steps, each asked before whether it is held."""
        return [self._guarded(machine, program, index, op) for index, op in enumerate(build(machine, program))]

    def _guarded(self, machine: Machine, program: Program, index: int, op: Op) -> Op:
        if not executed(program, index + 1):
            return op
        file, line = program.file.upper(), program.steps[index].line

        def guarded() -> int:
            if not self._skips and self.debugger.stops(self.process, file, line, self._depth):
                self.process.state, self.process.line = ProcessState.HELD, line
                machine.idle = True
                return LOOK
            self._skips = False
            return op()

        return guarded


def executed(program: Program, number: int) -> bool:
    """Return whether a step has an effect when the program reaches it."""
    step = program.steps[number - 1]
    return step.valid and (step.macro or (step.word not in HEADS and step.word not in DEFINITIONS and step.word not in ("C", "LABEL", "")))


def _shown(names: Names) -> dict[str, object]:
    return {label: value for name, variable in sorted(names.items()) for label, value in flat(name, variable)}
