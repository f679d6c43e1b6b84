"""BAPS2 under a debugger, in virtual time: position, variables and stepping of each process."""

from gateway.pure.languages.baps2.dry_run import DryRun
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.inspection import Frame, frames_of, lines_of
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.tasks import Task
from gateway.pure.languages.baps2.tree import Declared
from gateway.pure.languages.baps2.words import Words
from gateway.pure.languages.base.debug import Debugger, Step
from gateway.pure.languages.base.process import ProcessState


class DebugRun:
    """A dry run whose processes can be held before any line."""

    def __init__(self, words: Words, memory: Memory, feed: Feed) -> None:
        self.library = Library(words, memory, watched=True)
        self.run = DryRun(self.library, memory, feed)
        self.debugger = self.run.scheduler.debugger = Debugger()

    def held(self) -> list[Task]:
        """Processes the debugger holds."""
        return [task for task in self.tasks() if task.process.state is ProcessState.HELD]

    def tasks(self) -> list[Task]:
        """All that run."""
        return list(self.run.tasks.values())

    def resume(self, number: int, how: Step) -> None:
        """Continue one held process in this way, and all others."""
        for task in self.tasks():
            if task.process.number == number:
                self.debugger.go_on(task.process, how, task.depth)
            elif task.process.state is ProcessState.HELD:
                self.debugger.go_on(task.process, Step.RUN)

    def pause(self) -> None:
        """Holds each process before its next line."""
        for task in self.tasks():
            self.debugger.hold(task.process)

    def frames(self, number: int) -> list[Frame]:
        """The calls of a process, the innermost first; none where it is gone."""
        return frames_of(self.run.tasks.get(number), lambda name: self.library.unit(name)[0])

    def lines(self, program: str) -> list[int]:
        """Lines with a statement; none where the program is not there or has errors."""
        return lines_of(self.library.unit(program)[0])

    def channels(self, program: str) -> dict[str, object]:
        """Inputs and outputs a program declares, with their values now."""
        tree = self.library.tree(program)
        found: dict[str, object] = {}
        for each in tree.main.declarations if tree is not None else ():
            number = getattr(each.channel, "value", None) if isinstance(each, Declared) else None
            if isinstance(each, Declared) and isinstance(number, int):
                found[each.name] = self.run.outputs.get(number, 0) if each.type.base == "OUTPUT" else self.run.input(number)
        return found
