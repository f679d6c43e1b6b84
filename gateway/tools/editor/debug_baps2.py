"""BAPS2 programs for the debug adapter."""

import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path

from gateway.files.program_memory import baps2_words, folder_memory, read_feed
from gateway.pure.languages.baps2.debugging import DebugRun
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.values import Array
from gateway.pure.languages.base.debug import Step
from gateway.tools.editor.debugged import AdapterFault, Call, Row, next_lines

MOST_ELEMENTS = 200  # of one array


class Baps2Debugged:
    """A dry run of a .QLL file; its folder is the memory."""

    def __init__(self, path: Path, arguments: Row) -> None:
        """`arguments` of launch: `feed`, a feed file.  AdapterFault, FeedFault, OSError."""
        feed = read_feed(Path(str(arguments["feed"]))) if arguments.get("feed") else Feed()
        self._folder, self._program = path.parent, path.stem.upper()
        self._run = DebugRun(baps2_words(), folder_memory(self._folder, feed), feed)
        self._shown = 0  # events of the trace
        unit, faults = self._run.library.unit(self._program)
        if unit is None:
            raise AdapterFault("; ".join(str(each) for each in faults) or f"{path.name} is not a program of its folder")

    def begin(self, *, entry: bool) -> None:
        self._run.run.begin(self._program)
        if entry:
            self._run.pause()

    def go_on(self) -> bool:
        return self._run.run.go_on()

    def held(self) -> int | None:
        return next((task.process.number for task in self._run.held()), None)

    def resume(self, thread: int, how: Step) -> None:
        self._run.resume(thread, how)

    def pause(self) -> None:
        self._run.pause()

    def breakpoints(self, path: Path, lines: Sequence[int]) -> tuple[list[int | None], str]:
        name = path.stem.upper()
        there = self._run.lines(name)
        found = next_lines(there, lines)
        self._run.debugger.set_breakpoints(name, [each for each in found if each is not None])
        return found, "no statement here or below" if there else f"{name} is not a program of this memory, or has errors"

    def threads(self) -> list[tuple[int, str]]:
        return [(task.process.number, f"{task.unit.name} ({task.kind})") for task in self._run.tasks()]

    def calls(self) -> Iterator[Call]:
        for task in self._run.tasks():
            thread = task.process.number
            for depth, frame in enumerate(self._run.frames(thread)):
                own, wide = _elements(frame.own), _elements(frame.program_wide)
                scopes = {"Routine": own, "Program": wide, "Channels": self._run.channels(frame.program)}
                yield Call(thread * 1000 + depth, thread, frame.routine, frame.line, self._source(frame.program), scopes)

    def _source(self, program: str) -> Path:
        return next((each for each in self._folder.iterdir() if each.name.upper() == f"{program}.QLL"), self._folder / f"{program}.QLL")

    def output(self) -> list[str]:
        found: list[str] = []
        for event in itertools.islice(self._run.run.trace, self._shown, None):
            if event["event"] == "files":
                continue
            facts = " ".join(f"{name}={value}" for name, value in event.items() if name not in ("t", "process", "line", "event"))
            found.append(f"{event['t']:>8} s {event['process']}:{event['line']} {event['event']} {facts}".rstrip())
        self._shown = len(self._run.run.trace)
        return found


def _elements(values: dict[str, object]) -> dict[str, object]:
    """The same with the first elements of arrays one by one."""
    found: dict[str, object] = {}
    for name, value in values.items():
        if isinstance(value, Array):
            found |= {f"{name}[{at}]": each for at, each in enumerate(value.items[:MOST_ELEMENTS], value.low)}
        else:
            found[name] = value
    return found
