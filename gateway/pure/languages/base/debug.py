"""Breakpoints and single step, the same for all languages.  A translated program calls `stops` before a line that it has to watch.

A program asks only at lines whose flag is set.  The flag of a line where nothing is held is cleared, so that the line then costs no call;
all flags are set again when a breakpoint or a step is set.
"""

from collections.abc import Iterable, MutableMapping
from dataclasses import dataclass, field
from enum import Enum

from gateway.pure.languages.base.process import Process, ProcessState


class Step(Enum):
    """How a held process continues."""

    RUN = "run"
    INTO = "into"  # to the next line, in a subroutine too
    OVER = "over"  # to the next line of this routine
    OUT = "out"  # to the caller


@dataclass(slots=True)
class Debugger:
    """Breakpoints by program and line; how each process is stepped."""

    breakpoints: dict[str, frozenset[int]] = field(default_factory=dict)
    _steps: dict[int, tuple[Step, int]] = field(default_factory=dict)  # process -> how, depth of calls at the order
    _cleared: list[tuple[MutableMapping[str, object], str]] = field(default_factory=list)  # flags of programs

    def set_breakpoints(self, program: str, lines: Iterable[int]) -> None:
        """Replaces the breakpoints of a program."""
        self.breakpoints[program] = frozenset(lines)
        self._ask_again()

    def passes(self, flags: MutableMapping[str, object], flag: str) -> None:
        """Nothing is held at a line: clears its flag, unless a process is stepped."""
        if not self._steps:
            flags[flag] = False
            self._cleared.append((flags, flag))

    def _ask_again(self) -> None:
        for flags, flag in self._cleared:
            flags[flag] = True
        self._cleared.clear()

    def stops(self, process: Process, program: str, line: int, depth: int) -> bool:
        """Return whether to hold the process before this line.  `depth`: open calls."""
        step, since = self._steps.get(process.number, (Step.RUN, 0))
        if step is Step.INTO or (step is Step.OVER and depth <= since) or (step is Step.OUT and depth < since):
            self._steps.pop(process.number, None)
            return True
        return line in self.breakpoints.get(program, frozenset())

    def go_on(self, process: Process, step: Step, depth: int = 0) -> None:
        """Continue a held process."""
        self._steps.pop(process.number, None)
        if step is not Step.RUN:
            self._steps[process.number] = (step, depth)
            self._ask_again()
        if process.state is ProcessState.HELD:
            process.state = ProcessState.READY

    def forget(self, process: Process) -> None:
        """The process is over."""
        self._steps.pop(process.number, None)

    def hold(self, process: Process) -> None:
        """Hold a running process before its next line."""
        self._steps[process.number] = (Step.INTO, 0)
        self._ask_again()
