"""Runs processes in turns: the lowest priority number first, round robin among equals, a budget of statements for each turn."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Protocol

from gateway.pure.languages.base.debug import Debugger
from gateway.pure.languages.base.process import Process, ProcessState
from gateway.pure.languages.base.requests import PENDING, Await, Ns, Pending, Request, RuntimeFault, Sleep, Stopped, Turn


class Host(Protocol):
    """The surroundings of the processes: signals, motion, devices, files."""

    def ask(self, process: Process, request: Request, now: Ns) -> object:
        """Begins a request.  The answer, or PENDING: `answer_of` is asked in each round until there is one."""

    def answer_of(self, process: Process, request: Request, now: Ns) -> object:
        """The answer to a request that was PENDING, or PENDING."""

    def ended(self, process: Process, now: Ns) -> None:
        """Release the resources of an ended process."""


@dataclass(slots=True)
class Scheduler:
    """The processes of one control.  Pure: `now` is handed in, the next deadline is returned."""

    host: Host
    budget: int = 2_000  # statements of a process in a turn
    rounds: int = 64  # turns of a process in one call of `run`; the remainder runs in the next call
    processes: list[Process] = field(default_factory=list)
    debugger: Debugger | None = None  # programs that are watched ask it before each line
    _numbers: int = 0

    def start(self, program: str, begin: "Callable[[Process], None]", priority: int = 0, parent: Process | None = None) -> Process:
        """Add a process and return it; `begin` sets its body."""
        self._numbers += 1
        process = Process(self._numbers, program, priority, parent)
        begin(process)
        self.processes.append(process)
        if parent is not None:
            parent.children.append(process)
        return process

    def stop(self, process: Process, now: Ns) -> None:
        """Stops a process and all that it started as its own, innermost first."""
        for child in list(process.children):
            self.stop(child, now)
        if not process.over:
            process.finish(ProcessState.STOPPED)
            self._remove(process, now)

    def fail(self, process: Process, fault: RuntimeFault, now: Ns) -> None:
        """Ends a process because of an error outside of its statements, and all that it started as its own."""
        for child in list(process.children):
            self.stop(child, now)
        if not process.over:
            process.fault = fault
            process.finish(ProcessState.FAILED)
            self._remove(process, now)

    def run(self, now: Ns) -> Ns | None:
        """Run all processes until each waits or has used its turns; return the next moment at which one is due.

        Return `now` itself where a process could continue at once; None where all wait for the host alone.
        """
        busy = False
        for _ in range(self.rounds):
            ready = sorted((p for p in self.processes if self._wake(p, now)), key=lambda process: process.priority)
            if not ready:
                busy = False
                break
            busy = True
            first = ready[0].priority
            for process in ready:
                if process.priority != first and any(p.state is ProcessState.READY and p.priority == first for p in self.processes):
                    break
                if not process.over:
                    self._turn(process, now)
        return now if busy else self.deadline()

    def deadline(self) -> Ns | None:
        """The earliest moment any process waits for."""
        return min(self._moments(), default=None)

    def _moments(self) -> Iterator[Ns]:
        for process in self.processes:
            match process.waits_for:
                case Sleep(until=moment):
                    yield moment
                case Await(deadline=int() as moment):
                    yield moment

    def _wake(self, process: Process, now: Ns) -> bool:
        """Whether the process can run now."""
        if process.state is not ProcessState.WAITING:
            return process.state is ProcessState.READY
        request = process.waits_for
        answer: object = PENDING
        match request:
            case Sleep(until=until):
                answer = None if now >= until else PENDING
            case Await(test=test, deadline=deadline):
                if test():
                    answer = True
                elif deadline is not None and now >= deadline:
                    answer = False
            case Request():
                answer = self.host.answer_of(process, request, now)
        if isinstance(answer, Pending):
            return False
        process.state, process.waits_for, process.answer = ProcessState.READY, None, answer
        return True

    def _turn(self, process: Process, now: Ns) -> None:
        process.left = self.budget
        while process.state is ProcessState.READY:
            request = process.resume(now)
            if request is None:
                self._remove(process, now)
                return
            if isinstance(request, Turn):
                return
            if isinstance(request, Stopped):
                process.state = ProcessState.HELD
                return
            if isinstance(request, Sleep | Await):
                process.state, process.waits_for = ProcessState.WAITING, request
                if not self._wake(process, now):
                    return
                continue
            answer = self.host.ask(process, request, now)
            if isinstance(answer, Pending):
                process.state, process.waits_for = ProcessState.WAITING, request
                return
            process.answer = answer

    def _remove(self, process: Process, now: Ns) -> None:
        self.processes.remove(process)
        if process.parent is not None and process in process.parent.children:
            process.parent.children.remove(process)
        if self.debugger is not None:
            self.debugger.forget(process)
        self.host.ended(process, now)
