"""VAL 3 applications under a debugger, in virtual time: position, variables and stepping of each task."""

from collections.abc import Iterator
from dataclasses import dataclass

from gateway.pure.languages.base.debug import Debugger, Step
from gateway.pure.languages.base.process import Process, ProcessState
from gateway.pure.languages.val3.instance import Instance, Program
from gateway.pure.languages.val3.scope import slots_of
from gateway.pure.languages.val3.tasks import Frame, Task
from gateway.pure.languages.val3.tasks import Step as Line
from gateway.pure.languages.val3.values import Grid, places
from gateway.pure.languages.val3.virtual import Run, shown, shown_container

LOOK_NS = 20_000_000  # virtual time between two looks for messages


@dataclass(frozen=True, slots=True)
class Place:
    """One call of a task, the innermost first.  line: of its program, from `begin`."""

    program: Program
    line: int
    own: dict[str, object]
    everywhere: dict[str, object]  # data of its application


def key_of(program: Program) -> str:
    """Name of a program among all."""
    return f"{program.text.file}#{program.name}".lower()


class DebugRun:
    """A run whose tasks can be held before any line."""

    def __init__(self, run: Run) -> None:
        self.run, self.machine, self.debugger = run, run.machine, Debugger()
        self._processes: dict[Task, Process] = {}
        self._lines: dict[Frame, int] = {}  # in which each call is
        self._held: Task | None = None
        self._skips: Task | None = None  # the task whose line it was held before
        self._pausing = False
        self.machine.watched = self._watched

    def begin(self) -> None:
        """Begin with start() before its first line."""
        self.run.begin()

    def go_on(self) -> bool:
        """Some virtual time; False: nothing can happen any more."""
        return self.run.once(LOOK_NS)

    @property
    def held(self) -> int | None:
        """Number of the task that is held."""
        return None if self._held is None else self._process(self._held).number

    def resume(self, how: Step) -> None:
        """Continue it in this way."""
        if self._held is not None:
            self.debugger.go_on(self._process(self._held), how, len(self._held.frames))
            self._held, self._skips, self.machine.halted = None, self._held, False

    def pause(self) -> None:
        """Hold the task that is the next to run, before its line."""
        self._pausing = True

    def tasks(self) -> list[tuple[int, Task]]:
        """All that are there, by number."""
        return [(self._process(task).number, task) for task in self.machine.tasks]

    def places(self, task: Task) -> Iterator[Place]:
        """Its calls, the innermost first."""
        self._lines = {frame: line for frame, line in self._lines.items() if any(frame in each.frames for each in self.machine.tasks)}
        for depth, frame in enumerate(reversed(task.frames)):
            program = frame.program
            assert isinstance(program, Program)
            line = program.line_of(frame.pc) if depth == 0 else self._lines.get(frame, program.line_of(frame.pc))
            yield Place(program, line, self._locals(program, frame), self._globals(program.owner))

    def _process(self, task: Task) -> Process:
        found = self._processes.get(task)
        if found is None:
            found = self._processes[task] = Process(len(self._processes) + 1, task.name)
        return found

    def _globals(self, own: Instance) -> dict[str, object]:
        return {label: value for name, each in sorted(own.data.items()) for label, value in flat(name, shown_container(self.machine, each))}

    def _locals(self, program: Program, frame: Frame) -> dict[str, object]:
        found: dict[str, object] = {}
        for name, slot in slots_of(program.text)[0].items():
            held = frame.v[slot.index]
            if slot.reference and not slot.whole:
                found.update(flat(name, shown(self.machine, places(held)[frame.v[slot.index + 1]])))
            elif isinstance(held, list | dict | Grid):
                found.update(flat(name, shown_container(self.machine, held)))
        return found

    def _watched(self, program: object, at: int, step: Line) -> Line:
        """The step, asked before whether its task is held."""
        assert isinstance(program, Program)
        line = program.line_of(at)
        if program.code.lines.index(line) != at:  # of a line with several steps the first one is watched
            return step
        key, machine = key_of(program), self.machine

        def guarded(v: list[object]) -> int:
            task = machine.current
            assert task is not None
            if self._skips is task:
                self._skips = None
            elif self._pausing or self.debugger.stops(self._process(task), key, line, len(task.frames)):
                self._hold(task)
                return at
            self._lines[task.frames[-1]] = line
            return step(v)

        return guarded

    def _hold(self, task: Task) -> None:
        machine = self.machine
        self._held, self._pausing, machine.halted = task, False, True
        self._process(task).state = ProcessState.HELD
        machine.turn -= machine.left + 1  # the line has not been run
        machine.left = 0


def flat(name: str, value: object) -> Iterator[tuple[str, object]]:
    """A value, and each of its elements and fields by its own name."""
    yield name, value
    if isinstance(value, dict):
        for inner, each in value.items():
            yield from flat(f"{name}.{inner}", each)
    elif isinstance(value, list):
        for at, each in enumerate(value):
            yield from flat(f"{name}[{at}]", each)
