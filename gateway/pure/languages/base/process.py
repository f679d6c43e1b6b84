"""A process: a program that runs, as the scheduler sees it.  An answer that is a RuntimeFault is raised where the program asked."""

from collections.abc import Generator
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from gateway.pure.languages.base.requests import Ns, Request, RuntimeFault

Body = Generator[Request, object, None]


class Place(NamedTuple):
    """Where a process is: a line; the file of this line, "": the source of the program; `within`: source and line of the instruction
    that includes this file, None: it is not included."""

    line: int = 0
    file: str = ""
    within: tuple[str, int] | None = None


class ProcessState(Enum):
    """Life of a process."""

    READY = "ready"
    WAITING = "waiting"  # for a moment, a condition or an answer of the host
    HELD = "held"  # by the debugger
    ENDED = "ended"
    STOPPED = "stopped"  # by an order
    FAILED = "failed"


@dataclass(slots=True, eq=False)
class Process:
    """Runs `body`, a generator that yields requests and is resumed with their answers.

    The body keeps `line` (line before or in which it is; `file` and `within` as in Place) and `left` (statements it may still run in this
    turn) up to date.
    """

    number: int
    program: str
    priority: int = 0  # the lower number runs first
    parent: "Process | None" = None  # of a branch or of an internal subprocess
    permanent: bool = False
    line: int = 0
    file: str = ""
    within: tuple[str, int] | None = None
    left: int = 0
    state: ProcessState = ProcessState.READY
    fault: RuntimeFault | None = None
    waits_for: Request | None = None
    answer: object = None  # the value with which the body is resumed
    children: list["Process"] = field(default_factory=list)
    body: Body | None = None

    @property
    def place(self) -> Place:
        """Where it is."""
        return Place(self.line, self.file, self.within)

    @place.setter
    def place(self, place: Place) -> None:
        self.line, self.file, self.within = place

    @property
    def over(self) -> bool:
        """Whether the process has ended, however it did."""
        return self.state in (ProcessState.ENDED, ProcessState.STOPPED, ProcessState.FAILED)

    def resume(self, now: Ns) -> Request | None:
        """Runs up to the next request; None: the process is over."""
        if self.body is None:
            return None
        answer, self.answer = self.answer, None
        try:
            return self.body.throw(answer) if isinstance(answer, RuntimeFault) else self.body.send(answer)
        except StopIteration:
            self.finish(ProcessState.ENDED)
        except RuntimeFault as fault:
            self.fault = fault
            self.finish(ProcessState.FAILED)
        return None

    def finish(self, state: ProcessState) -> None:
        """Ends the process; its body is closed and runs no more statement."""
        body, self.body = self.body, None
        self.state, self.waits_for = state, None
        if body is not None and state in (ProcessState.STOPPED, ProcessState.FAILED):
            body.close()
