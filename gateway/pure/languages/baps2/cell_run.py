"""BAPS2 programs in a cell: the axes are the planner's, inputs and outputs those of the control (AX-861).  Pure."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from gateway.pure.image.records.interpreter import FIRST_MULTI, FIRST_REAL, MULTI, REALS, Fact
from gateway.pure.languages.baps2 import demands
from gateway.pure.languages.baps2.cell_access import CellAccess
from gateway.pure.languages.baps2.cell_acts import QUEUED
from gateway.pure.languages.baps2.cell_asynchronous import DISTANCE, SPEED
from gateway.pure.languages.baps2.cell_belts import CellSetup
from gateway.pure.languages.baps2.cell_debugger import CellDebugger, taught_in
from gateway.pure.languages.baps2.cell_devices import CellDevices, SerialUnits, fault_of
from gateway.pure.languages.baps2.cell_eeprom import EepromOrders
from gateway.pure.languages.baps2.cell_files import CellFiles
from gateway.pure.languages.baps2.cell_motion import CellMotion
from gateway.pure.languages.baps2.cell_view import FIRST_INTEGER, INTEGERS, USER
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.feed import UnitFeed
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.outside import PANEL, Outside
from gateway.pure.languages.baps2.robots import CellRobot
from gateway.pure.languages.baps2.tasks import Lane, Output, Task
from gateway.pure.languages.baps2.translation import Unit
from gateway.pure.languages.baps2.types import CODE_PAGE
from gateway.pure.languages.baps2.units import Device
from gateway.pure.languages.baps2.waiting import place_of, waits_of
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.hosting import Port, ProcessRow, ProgramRow
from gateway.pure.languages.base.process import Process, ProcessState
from gateway.pure.languages.base.requests import PENDING, Ns, Request, RuntimeFault
from gateway.pure.languages.pic.cell_pic import CellPic

SAID_ANEW = "-"  # not a type: forces the next report of the type that is read, even of none
PIECE = 1_000  # characters of an output to the screen of a PHG 2000
OUTPUTS = (
    *range(1, USER + 1),
    *range(FIRST_MULTI, FIRST_MULTI + MULTI),
    *range(FIRST_REAL, FIRST_REAL + REALS),
    *range(FIRST_INTEGER, FIRST_INTEGER + INTEGERS),
)
OWN_RUNS = 1 << 20  # runs that programs start themselves
NUMBERED = re.compile(r"\(rho 3 (\d+)\)$")
FOREIGN = re.compile(r" \(VAL 3 \d+\)")
WAITS = {
    "MoveTo": "the blocks before", "ReadInput": "the end of a movement", "Dwell": "a time", "WaitFor": "a condition",
    "ReadDevice": "a device", "Branches": "its branches", "Drain": "the end of a movement", "Enter": "a semaphore",
}  # fmt: skip


@dataclass(slots=True)
class _Begun:
    """What is started just now.  run: as it is known outside, 0: a program starts it; own: the last run of that kind."""

    run: int = 0
    own: int = OWN_RUNS
    test: bool = False


@dataclass(slots=True)
class Pendant:
    """What serves the pendant: the test system, and the files as it lists them."""

    debugger: CellDebugger
    files: CellFiles
    eeprom: EepromOrders = field(default_factory=EepromOrders)
    reading: str = ""  # type that a READ of the panel waits for, as reported


class CellRun(CellMotion):
    """All programs of a memory in one cell.  one: robots move one at a time."""

    def __init__(
        self,
        library: Library,
        memory: Memory,
        port: Port,
        robots: Sequence[CellRobot],
        p5: Ns,
        *,
        setup: CellSetup | None = None,
        one: bool = True,
    ) -> None:
        super().__init__(library, memory, port, robots, p5, setup or CellSetup(), one=one)
        self.devices[PANEL] = Device(UnitFeed())
        self.units = Outside(self, seen=True)
        self._runs: dict[int, Task] = {}
        self._begun = _Begun()
        self._read: dict[int, set[tuple[int, int]]] = {}  # process -> places that have read in this turn
        self._asked: Request | None = None  # the request that is being answered
        self.pic: CellPic | None = None  # scanned in parallel with the programs
        self.pendant = Pendant(CellDebugger(CellAccess(self), library.watched()), CellFiles(port))
        self.scheduler.debugger = self.test.debugger

    def connect(self, serial: SerialUnits) -> None:
        """The units V24_1 to V24_4 are on lines of the cell; before anything runs."""
        self.units = CellDevices(self, serial)

    # ---- from outside

    def catalogue(self) -> list[ProgramRow]:
        """All programs of the memory."""
        return [self._row(name) for name in self.library.names()]

    def _row(self, name: str) -> ProgramRow:
        _, faults = self.library.unit(name)
        tree = self.library.tree(name)
        first = next((str(each) for each in faults), "")
        if tree is None:
            return ProgramRow(name, "normal", (), max(1, faults.errors), 0, first)
        kind = "subroutine" if tree.external_subroutine else "permanent" if tree.head.permanent else "normal"
        numbers = tuple(sorted(set(tree.head.kinematics.values()))) or (1,)
        return ProgramRow(name, kind, numbers, faults.errors, len(faults) - faults.errors, first if faults.errors else "")

    def start_run(self, name: str, run: int, now: Ns) -> None:
        """A program begins; one that cannot is over at once."""
        self.now, self._begun.run = now, run
        try:
            self.start(name, None)
        except RuntimeFault as error:
            self.port.over(run, "aborted", error, name.upper())
        finally:
            self._begun.run = 0

    def start(self, program: str, starter: Task | None) -> Task:
        """Starts a program as a process; its kinematics have to be robots of the cell."""
        unit, _ = self.library.unit(program.upper())
        if unit is not None:
            self._meet(unit)
        if not self._begun.run:
            self._begun.own += 1
        run = self._begun.run or self._begun.own
        self._begun.test = self.test.tests(run) or (starter is not None and starter.main.tested)
        task = super().start(program, starter)
        task.run = run
        self._runs[run] = task
        if self._begun.test:
            self.test.begun(task)
        if starter is not None:
            self.port.started(run, task.unit.name, task.kind, starter.main.run)
        return task

    def library_of(self, task: Task | None) -> Library:
        """Processes of the test run programs that can be held."""
        return self.test.library if (self._begun.test if task is None else task.main.tested) else self.library

    def _meet(self, unit: Unit) -> None:
        for name, number in (unit.program.head.kinematics or {"": 1}).items():
            if not 1 <= number <= len(self.robots):
                raise fault(220, f"{name or 'kinematic'} = {number}; this cell has {len(self.robots)} with a model")
            if self.lanes.numbers.setdefault(name, number) != number:
                raise fault(220, f"{name} is {number} here and {self.lanes.numbers[name]} in another program")
            moved = any(number in self._numbers_of(task) for task in self.tasks.values())
            if not moved:  # process start: factors of the kinematic are 1.0 again (L2707-2719)
                preset = self._presets(number)
                self.lane(name).factors = {"R": preset.radius, "R_PTP": preset.factor}  # L1888
                self.lane(name).measured = None
                self.lane(name).limits = {}

    @staticmethod
    def _numbers_of(task: Task) -> tuple[int, ...]:
        return tuple(task.unit.program.head.kinematics.values()) or (1,)

    def stop_run(self, run: int, now: Ns, error: RuntimeFault | None = None) -> None:
        """Ends a process and all it started."""
        self.now = now
        task = self._runs.get(run)
        if task is None:
            return
        if error is not None:
            self.scheduler.fail(task.process, error, now)
        else:
            self.stop(task, "stopped")

    def stop_all(self, now: Ns) -> None:
        """Stop all processes and orders: the services have restarted."""
        self.pendant.files.again()
        for run in list(self._runs):
            self.stop_run(run, now)
        self.paths.drop()

    def path_over(self, ticket: int, error: RuntimeFault | None, now: Ns) -> None:
        """It does not any more; an error ends the program."""
        self.now = now
        self._systems.pop(ticket, None)
        stretch = self.paths.ended(ticket, error)
        if stretch is None or error is None or not isinstance(stretch.owner, Task):
            return
        task = stretch.owner
        if place := self.paths.of(stretch.robot).place_of(stretch):
            task.process.place = place
        self.scheduler.fail(task.process, numbered(error), now)

    def file_changed(self, name: str) -> None:
        """The PIC has its program there, too."""
        if self.pic is not None:
            self.pic.file_changed(name)
        super().file_changed(name)

    def hear(self, order: Mapping[str, Fact], now: Ns) -> None:
        """What the control has for the test system, and for the PIC."""
        self.now = now
        if order["do"] == "phg-line":
            self.devices[PANEL].pieces.append(bytearray(str(order["text"]).encode(CODE_PAGE, "replace")))
            self.pendant.reading = SAID_ANEW
            return
        if order["do"] == "points":
            file = str(order["file"])
            program = file.removesuffix(".PKT")
            self.pendant.files.points(file, self._offered(program), size=self.test.cell.components(program), select=False)
            return
        answer = self.test.hear(order, now)
        if answer is not None:
            if "ticket" in order:
                self.test.answers.append((now, int(order["ticket"]), answer))
        elif not self.pendant.eeprom.hear(order) and self.pic is not None:
            self.pic.hear(order)

    def _offered(self, program: str) -> Mapping[str, tuple[float, ...]]:
        """The points of its file, and those that it names and that are not taught yet: without components."""
        points = self.memory.points(program, Faults())
        unit, _ = self.library.unit(program) if self.library.has(program) else (None, None)
        return {**points, **{name: () for name in taught_in(unit) if name not in points}}

    def point_selected(self, program: str, point: str, points: Mapping[str, tuple[float, ...]]) -> None:
        """Special function 16: the pendant offers this file, and this point first."""
        self.pendant.files.points(f"{program}.PKT", points, point, size=self.test.cell.components(program), select=True)

    @property
    def test(self) -> CellDebugger:
        """Its test system."""
        return self.pendant.debugger

    def task_of(self, run: int) -> Task | None:
        """A process by its run."""
        return self._runs.get(run)

    def robot_lane(self, number: int) -> Lane:
        """A robot by its number; a new one where no program has named it."""
        return next((self.lanes[name] for name, each in self.lanes.numbers.items() if each == number and name in self.lanes), Lane())

    # ---- turns

    def turn(self, now: Ns) -> bool:
        """Continue all processes; True: one could continue at once."""
        if self.pic is not None:
            self.pic.turn(now)
        self.now = now
        self.pendant.files.turn(self.memory.files, now)
        for ticket, answer in self.test.take_answers(now):
            self.port.send("answered", ticket=ticket, error=answer)
        self._round += 1
        self._read.clear()
        self._lines_turn()
        self.paths.look()
        self.acts.asynchronous.turn()
        for lane, robot in ((self.lanes[name], self.robot_of(name)) for name in self.lanes):
            lane.position = robot.own(self.port.view.set)
        self._advance()
        busy = self.scheduler.run(now) == now
        while self._advance() and self._woken():
            busy = self.scheduler.run(now) == now
        self._settle()
        self._look_for_circles()
        self._say_read()
        return busy

    def _say_read(self) -> None:
        """Report what a program reads: the control passes keys of the panel to it only while it reads them."""
        wanted = ""
        for task in self.tasks.values():
            asked = task.process.waits_for
            waits = task.process.state is ProcessState.WAITING and isinstance(asked, demands.ReadDevice)
            if waits and isinstance(asked, demands.ReadDevice) and self.units.place(task, asked.unit)[0] == PANEL:
                wanted = "TEXT" if asked.count else asked.base
        if wanted != self.pendant.reading:
            self.pendant.reading = wanted
            self.port.send("phg-read", base=wanted)

    def _lines_turn(self) -> None:
        """What has come on the lines; a fault of an interface ends its program."""
        for failed in self.units.serial.turn(self.port.view.channels.inputs) if isinstance(self.units, CellDevices) else ():
            task = self.tasks.get(failed.number)
            if task is not None:
                self.scheduler.fail(task.process, fault_of(failed.unit, failed.condition, failed.words), self.now)

    def _woken(self) -> bool:
        return any(task.process.state is ProcessState.WAITING for task in self.tasks.values())

    def _rest(self, task: Task) -> None:
        super()._rest(task)
        self.acts.ended(task)
        self.paths.forget(task)

    def _process_answer(self, task: Task, request: Request) -> object:
        if isinstance(request, demands.Drain):
            return None if not task.queue and self.paths.release(task) else PENDING
        return super()._process_answer(task, request)

    def _answer(self, task: Task, request: Request) -> object:
        self._asked = request
        match request:
            case demands.Synchronise() | demands.Reference() if self._still(task):
                return None
            case demands.Special(number=number) if number in QUEUED and self._still(task):
                return None
            case demands.SyncBelt():
                return self.acts.sync(task, request) if not self._before(task) else PENDING
            case demands.Synchronise():
                return self.acts.synchronise(task, request)
            case demands.Reference(kinematic=kinematic):
                return self.acts.reference(task, kinematic)
            case demands.Special(number=number, values=values) if number in (SPEED, DISTANCE):
                self.acts.asynchronous.call(task, number, values)
                return None
            case demands.Special(number=number, values=values) if number in QUEUED:
                return self.acts.special(task, number, values)
            case demands.WriteOutput(channel=channel) if channel not in OUTPUTS:
                raise fault(224, str(channel))
        return super()._answer(task, request)

    def _still(self, task: Task) -> bool:
        return task.main.tested and not self.test.movement

    def _before(self, task: Task) -> bool:
        """Something is prepared that has to be over before the request counts."""
        return bool(task.queue) and task.said is None

    # ---- queries

    def _counted(self, task: Task) -> bool:
        """The same statement reads once in an interpolation cycle: the inputs do not change meanwhile."""
        waits = self._asked.channel if isinstance(self._asked, demands.ReadInput) else -1
        place = (task.process.line, waits)
        seen = self._read.setdefault(task.process.number, set())
        if place in seen:
            return False
        seen.add(place)
        return True

    def _give_up(self, task: Task) -> object:
        """BREAK: continue after the others of its priority, once in an interpolation cycle."""
        if task.round == self._round:
            self.scheduler.processes.remove(task.process)
            self.scheduler.processes.append(task.process)
            return PENDING
        return None

    # ---- reports

    def _output(self, task: Task, item: Output) -> None:
        super()._output(task, item)
        self.port.output(item.channel, float(item.value))

    def event(self, task: Task, event: str, line: int, **facts: object) -> None:
        """Warnings and output to devices; `ended` reports ends."""
        if event == "warning":
            self.port.report(task.unit.name, line, str(facts["text"]))
        elif event == "write" and facts["device"] != "PHG":
            text = str(facts["hex"])
            for at in range(0, max(len(text), 1), PIECE):
                self.port.send("phg2000", hex=text[at : at + PIECE], more=at + PIECE < len(text))
        elif event == "write":
            self.port.panel(bytes.fromhex(str(facts["hex"])).decode(CODE_PAGE))

    def ended(self, process: Process, now: int) -> None:
        """The process is over; its starter gets the result."""
        task = self.tasks[process.number]
        failed = process.fault if process.state is ProcessState.FAILED else None
        if failed is not None and task.root is not None:
            task.root.branch_fault = failed, _place(task)
        super().ended(process, now)
        self._read.pop(process.number, None)
        if isinstance(self.units, CellDevices):
            self.units.ended(task, aborted=failed is not None or bool(task.how))
        if task.root is not None:
            return
        place = _place(task)
        if failed is None and task.branch_fault is not None:
            failed, place = task.branch_fault
        self._runs.pop(task.run, None)
        self.port.over(task.run, task.how or "ended", failed, place)

    def rows(self) -> list[ProcessRow]:
        """The processes, branches too."""
        found = []
        for task in self.tasks.values():
            asked = task.process.waits_for
            waits = WAITS.get(type(asked).__name__, "") if asked is not None else ""
            wait = next(waits_of(task, self.tasks.values(), self), None)
            held = wait if wait is not None and wait.name else None
            main = task.main
            parent = task.starter.main.run if task.root is None and task.starter is not None else 0
            within = task.process.within or ("", 0)
            row = ProcessRow(
                main.run, task.unit.name, task.kind, task.process.state.value, task.process.line, waits, parent, task.root is not None,
                held=f"{held.what} {held.name}" if held is not None else "",
                holder=place_of(held.holder) if held is not None else "",
                stuck=self._semaphores.watch.has(task),
                external=_other(task, task.process.file),
                level=task.depth,
                including=_other(task, within[0]),
                included=within[1],
            )  # fmt: skip
            found.append(row)
        return found


def _other(task: Task, file: str) -> str:
    """A source that is not the one of the program; "": it is."""
    return "" if file in ("", f"{task.unit.file}.QLL", f"{task.unit.name}.QLL") else file.removesuffix(".QLL")


def _place(task: Task) -> str:
    """File and line where the process is."""
    return f"{task.process.file or f'{task.unit.name}.QLL'} line {task.process.line}"


def numbered(error: RuntimeFault) -> RuntimeFault:
    """The manual's own number where planner or cycle name one: `.. beltdistance is zero (rho 3 89)`; not those of others."""
    text = FOREIGN.sub("", error.text)
    found = NUMBERED.search(text)
    return RuntimeFault(error.code if found is None else int(found[1]), text)


def changed(before: Mapping[str, bytes], after: Mapping[str, bytes]) -> dict[str, bytes | None]:
    """Files that programs have written, and deleted (None)."""
    found: dict[str, bytes | None] = {name: data for name, data in after.items() if before.get(name) is not data}
    return found | {name: None for name in before if name not in after}
