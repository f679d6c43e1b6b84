"""ROBOTstar programs for the debug adapter."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from gateway.files.robotstar import FolderFault, sources, words
from gateway.pure.languages.base.debug import Step
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.debugging import DebugRun
from gateway.pure.languages.robotstar.memory import Memory
from gateway.pure.languages.robotstar.plc_link import PlcLink
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.script import NS, OrderFault, orders
from gateway.tools.editor.debugged import AdapterFault, Call, Row, next_lines

RUNNING = tuple(name for name, mode in MODES.items() if not mode.single)  # a single step is the debugger's own
THREAD = 1


class RobotstarDebugged:
    """`axisgate robotstar run` of a program; its folder, or `memory`, is the root S:/."""

    def __init__(self, path: Path, arguments: Row) -> None:
        """`arguments` of launch: `memory`, `mode`, `plc`, `at` (a list), `until`.  AdapterFault."""
        self._root = Path(str(arguments["memory"])).resolve() if arguments.get("memory") else path.parent
        if self._root not in path.parents:
            raise AdapterFault(f"{path} is not in {self._root}; memory is a folder above the program")
        mode = str(arguments.get("mode") or "auto")
        if mode not in RUNNING:
            raise AdapterFault(f"mode {mode}: {', '.join(RUNNING)} are known; steps are those of the debugger")
        try:
            self._script = orders([str(each) for each in arguments.get("at") or ()])
            self._memory = Memory.read(sources(str(self._root)), words(), Faults())
        except (OrderFault, FolderFault) as fault:
            raise AdapterFault(str(fault)) from fault
        plc = PlcLink(self._memory.plc, str(arguments["plc"])) if arguments.get("plc") else None
        self._run = DebugRun(self._memory, MODES[mode], plc)
        check(self._memory, Faults(), self._run.cell.system.names())
        until = arguments.get("until")
        self._until = None if until is None else round(float(until) * NS)
        program = self._run.program_of(path.relative_to(self._root).as_posix())
        if program is None:
            raise AdapterFault(f"{path.name} is not a program of {self._root}")
        if program.refused:
            raise AdapterFault(f"{program.file} line {program.refused[0][0]}: {program.refused[0][1]}")
        self._program = program
        self._shown = 0  # events

    def begin(self, *, entry: bool) -> None:
        self._run.begin(self._program.key, self._script, self._until)
        if entry:
            self._run.pause()

    def go_on(self) -> bool:
        return self._run.go_on()

    def held(self) -> int | None:
        return THREAD if self._run.held else None

    def resume(self, thread: int, how: Step) -> None:
        self._run.resume(how)

    def pause(self) -> None:
        self._run.pause()

    def breakpoints(self, path: Path, lines: Sequence[int]) -> tuple[list[int | None], str]:
        path = path.resolve()
        file = path.relative_to(self._root).as_posix() if self._root in path.parents else path.name
        there = self._run.lines(file)
        found = next_lines(there, lines)
        self._run.debugger.set_breakpoints(file.upper(), [each for each in found if each is not None])
        return found, "no step here or below" if there else f"{file} is not a program of this memory"

    def threads(self) -> list[tuple[int, str]]:
        return [(THREAD, self._program.key)]

    def calls(self) -> Iterator[Call]:
        for depth, place in enumerate(self._run.places()):
            scopes = {"Local": place.own, "Global": place.everywhere, "Inputs and outputs": self._run.channels()}
            yield Call(THREAD * 1000 + depth, THREAD, place.program.name, place.line, self._root / place.program.file, scopes)

    def output(self) -> list[str]:
        events = self._run.cell.events[self._shown :]
        self._shown += len(events)
        return [f"{event['at']:>10} s {_words(event)}" for event in events]


def _words(event: dict[str, object]) -> str:
    place = f" ({event['program']} step {event['step']})" if event.get("program") else ""
    mode = f" {event['mode']}" if "mode" in event else ""
    return f"{event['what']}{mode} {event['value']}{place}"
