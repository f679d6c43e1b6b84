"""VAL 3 applications for the debug adapter."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from gateway.files.find import ConfigNotFound
from gateway.files.robots import load_robot
from gateway.files.val3_disk import DiskUnreadable, place_of, read_disk
from gateway.pure.languages.base.debug import Step
from gateway.pure.languages.val3.debugging import DebugRun, key_of
from gateway.pure.languages.val3.instance import Instance, Program
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.moves import Moves
from gateway.pure.languages.val3.virtual import Run, declare_links
from gateway.pure.languages.val3.virtual_events import Event, EventFault, event_of
from gateway.tools.editor.debugged import AdapterFault, Call, Row, next_lines
from gateway.tools.editor.val3 import begin_of

LONGEST_S = 86_400.0


class Val3Debugged:
    """`axisgate val3 run` of the application a program or project file belongs to."""

    def __init__(self, path: Path, arguments: Row) -> None:
        """`arguments` of launch: `disk`, `robot`, `at` (a list), `until`.  AdapterFault."""
        project = next((each for each in path.parents if any(one.suffix.lower() == ".pjx" for one in each.iterdir())), path.parent)
        try:
            disk = Path(str(arguments["disk"])) if arguments.get("disk") else None
            self._root, folder, name = place_of(path if path.suffix.lower() == ".pjx" else project, disk)
            robot = load_robot(str(arguments.get("robot") or "tx60-like"))
            events = [_event(str(each)) for each in arguments.get("at") or ()]
            self._machine = Machine(read_disk(self._root), Moves(robot))
        except (DiskUnreadable, EventFault, ConfigNotFound) as fault:
            raise AdapterFault(str(fault)) from fault
        own = self._machine.instance(folder, name, "")
        if own is None or "start" not in own.programs:
            raise AdapterFault(self._machine.log[-1].partition("VAL3:")[2] if self._machine.log else f"{name} has no start()")
        declare_links(self._machine, own.data.values())
        until = min(float(arguments.get("until") or LONGEST_S), LONGEST_S)
        self._run = DebugRun(Run(self._machine, own, round(until * 1e9), events))
        self._entry = False

    def begin(self, *, entry: bool) -> None:
        self._run.begin()
        if entry:
            self._run.pause()

    def go_on(self) -> bool:
        return self._run.go_on()

    def held(self) -> int | None:
        return self._run.held

    def resume(self, thread: int, how: Step) -> None:
        self._run.resume(how)

    def pause(self) -> None:
        self._run.pause()

    def breakpoints(self, path: Path, lines: Sequence[int]) -> tuple[list[int | None], str]:
        path = path.resolve()
        begins = dict(self._programs(path))
        there = sorted({begin + line - 1 for program, begin in begins.items() for line in _steps(program)})
        found = next_lines(there, lines)
        for program, begin in begins.items():
            self._run.debugger.set_breakpoints(key_of(program), [each - begin + 1 for each in found if each is not None])
        return found, "no line with an instruction here or below" if there else f"{path.name} is not a program of this application"

    def _programs(self, path: Path) -> Iterator[tuple[Program, int]]:
        for instance in self._instances():
            for program in instance.programs.values():
                if (self._root / program.text.file).resolve() == path:
                    yield program, self._begin(program)

    def _instances(self) -> list[Instance]:
        return list(self._machine.shared.values())

    def _begin(self, program: Program) -> int:
        """Line of its file that is its line 1."""
        text = (self._machine.disk.read(program.text.file) or b"").decode("utf-8-sig", "replace")
        return begin_of(text, program.text.line)

    def threads(self) -> list[tuple[int, str]]:
        return [(number, f"{task.owner.prefix}:{task.name}" if task.owner.prefix else task.name) for number, task in self._run.tasks()]

    def calls(self) -> Iterator[Call]:
        for number, task in self._run.tasks():
            for depth, place in enumerate(self._run.places(task)):
                line = self._begin(place.program) + place.line - 1
                scopes = {"Local": place.own, "Global": place.everywhere}
                yield Call(number * 1000 + depth, number, place.program.name, line, self._root / place.program.text.file, scopes)

    def output(self) -> list[str]:
        lines, self._machine.log = self._machine.log, []
        popups, self._machine.popups = self._machine.popups, []
        return [*lines, *(f"popup: {text}" for text in popups)]


def _event(text: str) -> Event:
    """S NAME=VALUE."""
    seconds, _, what = text.strip().partition(" ")
    return event_of(seconds, what)


def _steps(program: Program) -> list[int]:
    """Lines of a program with something to run."""
    return [line for at, line in enumerate(program.code.lines) if f"def L{at}(" in program.code.text]
