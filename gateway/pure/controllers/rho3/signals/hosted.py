"""Processes of the interpreter in the process table of the control, and what they move, switch and report (AX-860).  Pure.

The table contains each program of the interpreter's memory like one of [[controller.process]]: selection and abort by the PLC, Control
reset, modes 10.1 and 10.2 of the panel act on it without knowing where it runs.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.jobs import Job
from gateway.pure.controllers.rho3.functions.processes import Body, Kind, Process, ProcessFault, ProcessTable, Program, State, Turn
from gateway.pure.controllers.rho3.pendant.panel import Panel
from gateway.pure.controllers.rho3.pendant.screen2000 import Screen2000
from gateway.pure.controllers.rho3.pendant.user_memory import UserMemory
from gateway.pure.controllers.rho3.signals.fast_io import Channels, InputFault
from gateway.pure.controllers.rho3.signals.pic import PicLink
from gateway.pure.controllers.rho3.signals.steps import NOT_MOVED
from gateway.pure.controllers.run_results import RunResults
from gateway.pure.image.reasons import CommandState, text
from gateway.pure.image.records.interpreter import Fact
from protocols.base.machine import Ns

INTERPRETER_GONE = 1276  # ours: the interpreter died, and its processes with it
STATES = {"ready": State.READY, "waiting": State.WAITING, "held": State.WAITING}
PRIORITY = 140
RESULTS = 64
SHOWN = ("test", "variables", "looked")  # what the interpreter reports of its test system


class Mover(Protocol):
    """What the control does for programs of the interpreter."""

    processes: ProcessTable
    channels: Channels

    @property
    def panel(self) -> Panel:
        """Of its pendant."""

    @property
    def screen(self) -> Screen2000:
        """Of the PHG 2000."""

    @property
    def memory(self) -> UserMemory:
        """The user memory as the pendant sees it."""

    @property
    def pic(self) -> PicLink | None:
        """The PIC program of the interpreter."""

    def open_path(self, program: str, robot: int, now: Ns) -> Job:
        """An order to move a robot; ProcessFault: the mode does not allow it."""

    def open_reference(self, program: str, robot: int, now: Ns) -> Job:
        """An order to reference a robot; ProcessFault: the mode does not allow it."""

    def slow(self, move: Job, share: float) -> None:
        """A share, 0 .. 1, of the speed of this move."""

    def run_on(self, robot: int, distance: float) -> None:
        """Set the m or rad that a robot continues after an edge."""

    def path_closed(self, program: str, robot: int) -> None:
        """It is over."""

    def panel_text(self, written: str) -> None:
        """WRITE PHG."""


@dataclass(slots=True, eq=False)
class HostedBody:
    """What the process table steps for a process of the interpreter."""

    run: int
    over: tuple[str, int, str, str] | None = None  # how, code, text, place
    process: Process | None = None
    source: int = 0  # command source it moves as; 0: the one of the selection strobe
    test: bool = False  # it was started in test

    def __call__(self, now: Ns) -> Turn:
        """The process as the interpreter reports it; raises ProcessFault."""
        if self.over is None:
            return Turn.WAIT
        _, code, words, place = self.over
        if code:
            if self.process is not None:
                self.process.place = place
            raise ProcessFault(code, words)
        return Turn.DONE


@dataclass(slots=True)
class _Order:
    """A stretch a process moves on."""

    ticket: int
    program: str
    robot: int
    job: Job


@dataclass(slots=True)
class HostedPrograms:
    """Call `report` with the state published by the interpreter, `hear` with each of its records, `step` once per cycle of the control."""

    control: Mover
    language: str = "en"
    language_id: int = 0  # of the interpreter that runs
    orders: list[dict[str, Fact]] = field(default_factory=list)  # to the interpreter
    programs: list[dict[str, object]] = field(default_factory=list)  # as it reports them
    rows: list[dict[str, object]] = field(default_factory=list)  # its processes
    ending: list[int] = field(default_factory=list)  # jobs whose interpreter is gone: the planner is informed that nothing follows
    starter: int = 0  # command source that starts a program just now; 0: the PLC's
    sentences: list[str] = field(default_factory=list)
    testing: bool | None = None  # a program is being started in test; True: held before its first line
    shown: dict[str, object] = field(default_factory=dict)  # of the test system, as the interpreter reports it
    answers: dict[int, str] = field(default_factory=dict)  # ticket of an order -> why it was refused; "": done
    gone: bool = False  # the interpreter ended under its processes: to be reported
    results: RunResults = field(default_factory=RunResults)
    _bodies: dict[int, HostedBody] = field(default_factory=dict)
    _paths: list[_Order] = field(default_factory=list)
    _runs: int = 0
    _tickets: int = 0

    # ---- what the interpreter publishes

    def report(self, report: Mapping[str, object], *, alive: bool) -> None:
        """Its region: identity, programs, processes."""
        found = report.get("id", 0)
        identity = found if isinstance(found, int) and alive else 0
        if identity != self.language_id:
            self._lost()
            self.language_id = identity
            self.control.panel.reader.reads("")
            if identity and self.control.pic is not None:
                self.control.pic.welcome()
        self.rows = _rows(report.get("processes")) if identity else []
        self.shown = {name: report[name] for name in SHOWN if name in report} if identity else {}
        programs = _rows(report.get("programs")) if identity else []
        if programs != self.programs:
            for row in self.programs:
                self.control.processes.programs.pop(str(row["name"]), None)
            self.programs = programs
            self.control.processes.programs |= {str(row["name"]): self._program(row) for row in programs if row["kind"] != "subroutine"}
        for row in sorted(self.rows, key=lambda row: bool(row["branch"])):  # the process itself first
            body = self._bodies.get(_int(row["run"]))
            if body is not None and body.process is not None:
                _seen(body.process, row)

    def _program(self, row: Mapping[str, object]) -> Program:
        name = str(row["name"])
        numbers = row["kinematics"]
        mask = sum(1 << _int(number) - 1 for number in numbers) if isinstance(numbers, list) else 1
        return Program(self._maker(name), Kind.PERMANENT if row["kind"] == "permanent" else Kind.NORMAL, PRIORITY, mask)

    def _maker(self, name: str) -> Callable[[], Body]:
        def make() -> Body:
            self._runs += 1
            body = self._bodies[self._runs] = HostedBody(self._runs, source=self.starter, test=self.testing is not None)
            if self.testing is not None:
                self.orders.append({"do": "test", "run": body.run, "hold": self.testing})
            self.orders.append({"do": "start", "run": body.run, "program": name})
            return body

        return make

    def _lost(self) -> None:
        """Drop the lost interpreter's processes; motion already handed on runs to its end."""
        table = self.control.processes
        for body in self._bodies.values():
            self._end(body, "lost", INTERPRETER_GONE, "the interpreter ended")
            if body.process is not None and table.numbered(body.process.number) is body.process:
                self.sentences.append(f"{body.process.name}: the interpreter ended, and this process with it")
                table.stop(body.process.number)
        if self._bodies:
            self.gone = True
        self._bodies.clear()
        for order in self._paths:
            if order.job.open:
                self.ending.append(order.job.id)
            self.control.path_closed(order.program, order.robot)
        self._paths.clear()

    # ---- its records

    def hear(self, said: Mapping[str, Fact], now: Ns) -> None:
        """One record of its ring."""
        if said["id"] != self.language_id:
            return
        match said["say"]:
            case "output":
                self._output(int(said["channel"]), float(said["value"]))
            case "path":
                self._wants(self.control.open_path, int(said["ticket"]), str(said["program"]), int(said["robot"]), now)
            case "reference":
                self._wants(self.control.open_reference, int(said["ticket"]), str(said["program"]), int(said["robot"]), now)
            case "started":
                self._started(int(said["run"]), str(said["program"]), int(said["parent"]))
            case "over":
                body = self._bodies.get(int(said["run"]))
                if body is not None and body.over is None:
                    if said["code"] and body.process is not None:
                        self.sentences.append(f"{body.process.name}: {said['code']} {said['text']} ({said['place']})")
                    self._end(body, str(said["how"]), int(said["code"]), str(said["text"]), str(said["place"]))
            case "memory" | "answered" | "phg2000" | "slow" | "run-on" | "kept":
                self._informed(said)
            case "phg-read":
                self.control.panel.reader.reads(str(said["base"]))
            case "panel":
                self.control.panel_text(str(said["text"]))
            case "pic" if self.control.pic is not None:
                self.control.pic.hear(said, now)
            case "pic-stopped" if self.control.pic is not None:
                self.control.pic.stopped = True

    def _asynchronous(self, said: Mapping[str, Fact]) -> None:
        """Process special functions 41 and 42, which are not part of the path."""
        if said["say"] == "run-on":
            self.control.run_on(int(said["robot"]), float(said["distance"]))
        for order in self._paths:
            if said["say"] == "slow" and order.job.id == said["job"] and order.job.open:
                self.control.slow(order.job, float(said["share"]))

    def _informed(self, said: Mapping[str, Fact]) -> None:
        """Process reports of the user memory, special functions outside the path, or the outcome of an order to the test system."""
        if said["say"] in ("slow", "run-on"):
            self._asynchronous(said)
            return
        if said["say"] == "kept":
            self.results.kept(said)
            return
        if said["say"] == "phg2000":
            self.control.screen.take(bytes.fromhex(str(said["hex"])), more=bool(said["more"]))
            return
        if said["say"] == "memory":
            self.control.memory.hear(said)
            return
        self.answers[int(said["ticket"])] = str(said["error"])
        for old in list(self.answers)[:-RESULTS]:
            del self.answers[old]

    def order(self, what: str, **facts: Fact) -> int:
        """To the test system of the interpreter; a ticket, under which `answers` has what became of it."""
        self._tickets += 1
        self.orders.append({"do": what, "ticket": self._tickets, **facts})
        return self._tickets

    def tests(self, program: str) -> bool:
        """Whether the process of this program was started in test."""
        process = self.control.processes.named(program)
        return process is not None and isinstance(process.body, HostedBody) and process.body.test

    def _end(self, body: HostedBody, how: str, code: int = 0, words: str = "", place: str = "") -> None:
        body.over = how, code, words, place
        self.results.end(body.run, body.over)

    def _output(self, channel: int, value: float) -> None:
        try:
            self.control.channels.put(channel, value)
        except (InputFault, ValueError) as fault:
            self.sentences.append(f"output {channel}: {fault}")

    def _started(self, run: int, program: str, parent: int) -> None:
        above = self._bodies.get(parent)
        body = HostedBody(run, source=above.source if above is not None else 0, test=above.test if above is not None else False)
        number = above.process.number if above is not None and above.process is not None else 0
        try:
            body.process = self.control.processes.start(program, number, body if number else None)
        except ProcessFault as fault:
            self.orders.append({"do": "fail", "run": run, "code": fault.code, "text": fault.text})
            return
        self._bodies[run] = body

    def _wants(self, opened: Callable[[str, int, Ns], Job], ticket: int, program: str, robot: int, now: Ns) -> None:
        try:
            job = opened(program, robot, now)
        except ProcessFault as fault:
            self._answer("over", ticket, code=fault.code, text=fault.text)
            return
        self._paths.append(_Order(ticket, program, robot, job))
        if job.open and job.code is Code.PROGRAM:
            self._answer("given", ticket, job=job.id)

    def _answer(self, what: str, ticket: int, **facts: Fact) -> None:
        self.orders.append({"do": what, "id": self.language_id, "ticket": ticket, **facts})

    # ---- one cycle

    def step(self, now: Ns) -> None:
        """Before the table is stepped: what became of processes and orders."""
        table = self.control.processes
        by_body = {id(process.body): process for process in table.processes}
        for run, body in list(self._bodies.items()):
            body.process = by_body.get(id(body))
            if body.process is None:  # taken off the table, or over
                if body.over is None:
                    self.orders.append({"do": "stop", "run": run})
                    self._end(body, "stopped")
                del self._bodies[run]
            elif body.process.state is State.FAULTY and body.over is None:  # the control ended it: its mode was switched
                self.orders.append({"do": "fail", "run": run, "code": body.process.error, "text": body.process.error_text})
                self._end(body, "aborted", body.process.error, body.process.error_text)
        reader = self.control.panel.reader
        self.orders += [{"do": "phg-line", "text": line} for line in reader.lines]
        reader.lines.clear()
        if self.control.pic is not None:
            self.orders += self.control.pic.orders
            self.control.pic.orders.clear()
        for order in [each for each in self._paths if not each.job.open]:
            self._paths.remove(order)
            self.control.path_closed(order.program, order.robot)
            done = order.job.state is CommandState.DONE
            words = "" if done else text(order.job.reason, self.language, order.job.detail)
            self._answer("over", order.ticket, code=0 if done else NOT_MOVED, text=words)

    def run_of(self, process: Process) -> int:
        """Number of its run; 0: not of the interpreter."""
        return process.body.run if isinstance(process.body, HostedBody) else 0

    def source_of(self, program: str) -> int:
        """The command source a program moves as; 0: the one of the selection strobe."""
        process = self.control.processes.named(program)
        body = process.body if process is not None else None
        return body.source if isinstance(body, HostedBody) else 0


def _seen(process: Process, row: Mapping[str, object]) -> None:
    """Where a process is, and what it waits for; what a branch of it waits for as well."""
    if not row["branch"]:
        line, included = _int(row["line"]), _int(row["included"])
        process.line, process.include_line = (included, line) if included else (line, 0)
        process.external, process.level = str(row["including" if included else "external"]), _int(row["level"])
        process.wants, process.holder, process.stuck = str(row["held"]), str(row["holder"]), bool(row["stuck"])
    elif row["holder"] and not process.holder:
        process.wants, process.holder = str(row["held"]), str(row["holder"])


def _rows(found: object) -> list[dict[str, object]]:
    return [row for row in found if isinstance(row, dict)] if isinstance(found, list) else []


def _int(value: object) -> int:
    return value if isinstance(value, int) else 0
