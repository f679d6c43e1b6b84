"""The pending calls and their events; one interface for all lines of a control."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from gateway.pure.controllers.rho3.serial.baps import BapsType, Value
from gateway.pure.controllers.rho3.serial.events import Event, Finished, ProgramAborted
from gateway.pure.controllers.rho3.serial.setup import SYSTEM, WORDS, Condition, Function, Process
from protocols.base.machine import Ns


@dataclass(slots=True, eq=False)
class Job:
    """One READ, WRITE or print; or (ticket 0) the claim of a function that keeps its line."""

    ticket: int
    process: Process
    function: Function
    order: int  # of arrival; a READ of several variables queues anew for each (8.1)
    data: bytes = b""  # of an output, what was not yet given out
    wanted: tuple[BapsType, ...] = ()  # of a READ
    values: list[Value] = field(default_factory=list)
    due: Ns | None = None
    silent: bool = False  # WRITE_BEGIN was called: its end no longer matters

    @property
    def permanent(self) -> bool:
        return self.ticket == 0


class LineInterface:
    """Open jobs, the STATUS of each process and unit, events not yet reported."""

    def __init__(self) -> None:
        self.jobs: dict[int, Job] = {}
        self.status: dict[tuple[int, Function], Condition] = {}
        self.on_abort: Callable[[Process, Ns], None] | None = None
        self.events: list[Event] = []
        self.reported_at: Ns = 0
        self._tickets = self._orders = 0

    def open(self, process: Process, function: Function, data: bytes = b"", wanted: Iterable[BapsType] = ()) -> Job:
        self._tickets += 1
        job = Job(self._tickets, process, function, self.order(), data, tuple(wanted))
        self.jobs[job.ticket] = job
        return job

    def claim(self, function: Function) -> Job:
        """Of a function that keeps its line; before every program's (AX-165)."""
        return Job(0, SYSTEM, function, self.order())

    def order(self) -> int:
        self._orders += 1
        return self._orders

    def delete(self, job: Job, now: Ns) -> None:
        """WRITE_BEGIN, or the end of its program."""
        if self.jobs.pop(job.ticket, None) is not None:
            self.report(Finished(job.ticket, Condition.NO_ERROR, tuple(job.values), deleted=True), now)

    def finish(self, job: Job, condition: Condition, now: Ns) -> None:
        """The job is over and already off its line."""
        if job.silent or self.jobs.pop(job.ticket, None) is None:
            self.delete(job, now)
            return
        self.status[job.process.number, job.function] = condition
        self.report(Finished(job.ticket, condition, tuple(job.values)), now)
        if condition and job.process.stop_on_error:
            self.abort(job, condition, now)

    def abort(self, job: Job, condition: Condition, now: Ns) -> None:
        reading = bool(job.wanted) and condition is Condition.PROTOCOL
        self.stop(job.process, job.function, condition, "Protocol error READ" if reading else WORDS[condition], now)

    def stop(self, process: Process, function: Function, condition: Condition | None, text: str, now: Ns) -> None:
        """The program ends with a runtime error."""
        self.report(ProgramAborted(process.number, function, condition, text), now)
        if self.on_abort is not None:
            self.on_abort(process, now)

    def outputs(self, process: Process, function: Function) -> int:
        """Not yet finished ones, those that WRITE_BEGIN gave up not counted."""
        return sum(job.process == process and job.function is function and not job.wanted and not job.silent for job in self.jobs.values())

    def report(self, event: Event, now: Ns) -> None:
        self.events.append(event)
        self.reported_at = now

    def take_events(self) -> list[Event]:
        events, self.events = self.events, []
        return events


def first(jobs: Iterable[Job]) -> Job:
    """By the priority of the process, then by arrival (8.1)."""
    return min(jobs, key=lambda job: (job.process.priority, job.order))


def earliest(*moments: Ns | None) -> Ns | None:
    return min((moment for moment in moments if moment is not None), default=None)
