"""Breakpoints and single step, the same for all languages.  A translated program asks `stops` in front of a line that it has to watch."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum

from gateway.pure.languages.base.process import Process, ProcessState


class Step(Enum):
    """How a held process goes on."""

    RUN = "run"
    INTO = "into"  # to the next line, in a subroutine too
    OVER = "over"  # to the next line of this routine
    OUT = "out"  # to the caller


@dataclass(slots=True)
class Debugger:
    """Breakpoints by program and line; how each process is stepped."""

    breakpoints: dict[str, frozenset[int]] = field(default_factory=dict)
    _steps: dict[int, tuple[Step, int]] = field(default_factory=dict)  # process -> how, depth of calls at the order

    def set_breakpoints(self, program: str, lines: Iterable[int]) -> None:
        """Replaces the breakpoints of a program."""
        self.breakpoints[program] = frozenset(lines)

    def stops(self, process: Process, program: str, line: int, depth: int) -> bool:
        """Whether the process is to be held in front of this line.  `depth`: calls open."""
        step, since = self._steps.get(process.number, (Step.RUN, 0))
        if step is Step.INTO or (step is Step.OVER and depth <= since) or (step is Step.OUT and depth < since):
            self._steps.pop(process.number, None)
            return True
        return line in self.breakpoints.get(program, frozenset())

    def go_on(self, process: Process, step: Step, depth: int = 0) -> None:
        """Lets a held process go on."""
        self._steps.pop(process.number, None)
        if step is not Step.RUN:
            self._steps[process.number] = (step, depth)
        if process.state is ProcessState.HELD:
            process.state = ProcessState.READY

    def hold(self, process: Process) -> None:
        """Holds a running process in front of its next line."""
        self._steps[process.number] = (Step.INTO, 0)
