"""BAPS2 programs in a cell: the axes are the planner's, inputs and outputs those of the control (AX-861).  Pure."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from gateway.pure.image.records.interpreter import FAST, FIRST_FAST, FIRST_MULTI, FIRST_REAL, MULTI, REALS, Fact
from gateway.pure.languages.baps2 import demands, lines
from gateway.pure.languages.baps2.cell_access import CellAccess
from gateway.pure.languages.baps2.cell_acts import TOLD, CellActs
from gateway.pure.languages.baps2.cell_asynchronous import DISTANCE, SPEED, CellAsynchronous
from gateway.pure.languages.baps2.cell_belts import CAM, CellBelts, CellSetup
from gateway.pure.languages.baps2.cell_debugger import CellDebugger
from gateway.pure.languages.baps2.cell_devices import CellDevices, SerialUnits, fault_of
from gateway.pure.languages.baps2.cell_eeprom import EepromOrders
from gateway.pure.languages.baps2.cell_files import CellFiles
from gateway.pure.languages.baps2.control import Control, size_of
from gateway.pure.languages.baps2.errors import TEXTS, fault
from gateway.pure.languages.baps2.feed import SECOND, Feed, UnitFeed
from gateway.pure.languages.baps2.frames import to_workpiece
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.lines import Wanted
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.outside import PANEL
from gateway.pure.languages.baps2.robots import CellRobot
from gateway.pure.languages.baps2.tasks import Block, FastWait, Lane, Output, Statement, Task
from gateway.pure.languages.baps2.translation import Unit
from gateway.pure.languages.baps2.units import Device
from gateway.pure.languages.baps2.working_range import check_range, range_keys
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.hosting import Port, ProcessRow, ProgramRow
from gateway.pure.languages.base.path import Paths, Stretch
from gateway.pure.languages.base.process import Process, ProcessState
from gateway.pure.languages.base.requests import PENDING, Ns, Request, RuntimeFault
from gateway.pure.languages.pic.cell_pic import CellPic
from motion.program.passing import Presets

FIRST_INPUT, USER = 464, 120  # RC input of user input 1
FIRST_INTEGER, INTEGERS = 401, 8
RUN_ON = range(710, 800, 10)  # probes of the modified MOVE UNTIL, of boards 1 to 9
EARLY = 1_000  # the same inputs, read while the block is prepared
SAID_ANEW = "-"  # no type: what is read next is said, also when it is nothing
PIECE = 1_000  # characters of an output to the screen of a PHG 2000
OUTPUTS = (
    *range(1, USER + 1),
    *range(FIRST_MULTI, FIRST_MULTI + MULTI),
    *range(FIRST_REAL, FIRST_REAL + REALS),
    *range(FIRST_INTEGER, FIRST_INTEGER + INTEGERS),
)
DRY_NS = 100_000_000  # with nothing to do for so long the order is given back
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
    reading: str = ""  # type of what a READ of the panel waits for, as it was said


class CellRun(Control):
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
        super().__init__(library, memory, Feed(p5=p5, belts={}))
        self.port, self.robots, self.setup = port, tuple(robots), setup or CellSetup()
        self.paths = Paths(port, len(robots), one=one)
        self.acts = CellActs(self, CellBelts(self.setup.belts, port), CellAsynchronous(self))
        self.devices[PANEL] = Device(UnitFeed())
        self._numbers: dict[str, int] = {}  # kinematic as programs name it -> its robot
        self._runs: dict[int, Task] = {}
        self._begun = _Begun()
        self._read: dict[int, set[tuple[int, int]]] = {}  # process -> places that have read in this turn
        self.pic: CellPic | None = None  # scanned beside the programs
        self.pendant = Pendant(CellDebugger(CellAccess(self), library.watched()), CellFiles(port))
        self.scheduler.debugger = self.test.debugger
        self._systems: dict[int, tuple[float, ...]] = {}  # ticket of a stretch -> workpiece system as told

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
            if self._numbers.setdefault(name, number) != number:
                raise fault(220, f"{name} is {number} here and {self._numbers[name]} in another program")
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
        """Nothing runs any more, and no order is under way: the services have begun anew."""
        self.pendant.files.again()
        for run in list(self._runs):
            self.stop_run(run, now)
        self.paths.drop()

    def path_given(self, ticket: int, job: int) -> None:
        """The robot moves for a program from now on."""
        stretch = self.paths.given(ticket, job)
        if stretch is not None:
            if stretch.whole:
                self.port.whole(job)
            for text in lines.head(self.robots[stretch.robot - 1]):
                self.port.line(job, text)

    def path_over(self, ticket: int, error: RuntimeFault | None, now: Ns) -> None:
        """It does not any more; an error ends the program."""
        self.now = now
        self._systems.pop(ticket, None)
        stretch = self.paths.ended(ticket, error)
        if stretch is None or error is None or not isinstance(stretch.owner, Task):
            return
        task = stretch.owner
        if line := self.paths.of(stretch.robot).place_of(stretch):
            task.process.line = line
        self.scheduler.fail(task.process, numbered(error), now)

    def file_changed(self, name: str) -> None:
        """A file of the memory was replaced from outside."""
        program, _, kind = name.rpartition(".")
        if self.pic is not None:
            self.pic.file_changed(name)
        if kind == "PKT":
            self._points.pop(program, None)
            self._kept.pop(program, None)
        else:
            self.library.forget(program)

    def hear(self, order: Mapping[str, Fact], now: Ns) -> None:
        """What the control has for the test system, and for the PIC."""
        self.now = now
        if order["do"] == "phg-line":
            self.devices[PANEL].pieces.append(bytearray(str(order["text"]).encode("latin-1", "replace")))
            self.pendant.reading = SAID_ANEW
            return
        if order["do"] == "points":
            file = str(order["file"])
            self.pendant.files.points(file, self.memory.points(file.removesuffix(".PKT"), Faults()), select=False)
            return
        answer = self.test.hear(order, now)
        if answer is not None:
            if "ticket" in order:
                self.test.answers.append((now, int(order["ticket"]), answer))
        elif not self.pendant.eeprom.hear(order) and self.pic is not None:
            self.pic.hear(order)

    def point_selected(self, program: str, point: str, points: Mapping[str, tuple[float, ...]]) -> None:
        """Special function 16: the pendant offers this file, and this point first."""
        self.pendant.files.points(f"{program}.PKT", points, point, select=True)

    @property
    def test(self) -> CellDebugger:
        """Its test system."""
        return self.pendant.debugger

    def task_of(self, run: int) -> Task | None:
        """A process by its run."""
        return self._runs.get(run)

    def robot_lane(self, number: int) -> Lane:
        """A robot by its number; a new one where no program has named it."""
        return next((self.lanes[name] for name, each in self._numbers.items() if each == number and name in self.lanes), Lane())

    # ---- turns

    def turn(self, now: Ns) -> bool:
        """All processes go on; True: one could go on at once."""
        if self.pic is not None:
            self.pic.turn(now)
        self.now = now
        self.pendant.files.turn(self.memory.files, now)
        for ticket, answer in self.test.told(now):
            self.port.tell("answered", ticket=ticket, error=answer)
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
        self._say_read()
        return busy

    def _say_read(self) -> None:
        """The control takes keys of the panel for a program as long as one reads them."""
        wanted = ""
        for task in self.tasks.values():
            asked = task.process.waits_for
            waits = task.process.state is ProcessState.WAITING and isinstance(asked, demands.ReadDevice)
            if waits and isinstance(asked, demands.ReadDevice) and self.units.place(task, asked.unit)[0] == PANEL:
                wanted = "TEXT" if asked.count else asked.base
        if wanted != self.pendant.reading:
            self.pendant.reading = wanted
            self.port.tell("phg-read", base=wanted)

    def _lines_turn(self) -> None:
        """What has come on the lines; a fault of an interface ends its program."""
        for failed in self.units.serial.turn(self.port.view.channels.inputs) if isinstance(self.units, CellDevices) else ():
            task = self.tasks.get(failed.number)
            if task is not None:
                self.scheduler.fail(task.process, fault_of(failed.unit, failed.condition, failed.words), self.now)

    def _woken(self) -> bool:
        return any(task.process.state is ProcessState.WAITING for task in self.tasks.values())

    def _settle(self) -> None:
        """What has been handed on is run where nothing follows soon; an order nobody needs goes back."""
        for stretch in self.paths.stretches:
            if isinstance(stretch.owner, Task) and stretch.job:
                self._settle_one(stretch, stretch.owner)

    def _settle_one(self, stretch: Stretch, task: Task) -> None:
        path = self.paths.of(stretch.robot)
        waits = task.process.waits_for
        idle = task.process.state in (ProcessState.WAITING, ProcessState.HELD)
        if idle and not (isinstance(waits, demands.MoveTo) and task.block is None):
            path.finish(stretch)
        if any(block.stretch is stretch for block in task.blocks()) or self._rides(stretch.robot):
            stretch.dry = None
        elif stretch.dry is None:
            stretch.dry = self.now
        elif self.now - stretch.dry >= DRY_NS or path.contended:
            path.release(task)

    def _rides(self, robot: int) -> bool:
        """The program has it in a synchronous part."""
        return any(lane.belt and self.robot_of(name).number == robot for name, lane in self.lanes.items())

    def robot(self, number: int) -> CellRobot:
        """By its number; a runtime error where the cell has none."""
        if not 1 <= number <= len(self.robots):
            raise fault(220, f"{number}; this cell has {len(self.robots)} with a model")
        return self.robots[number - 1]

    def robot_of(self, kinematic: str) -> CellRobot:
        """As programs name it."""
        return self.robots[self._numbers.get(kinematic, 1) - 1]

    def lane_of(self, task: Task, number: object) -> tuple[str, Lane]:
        """A kinematic of the program by its number."""
        return self.specials.lane_of(task, number)

    def lane(self, kinematic: str, size: int = 0) -> Lane:
        """A kinematic, at the position of its axes."""
        lane = self.lanes.get(kinematic)
        if lane is None:
            lane = self.lanes[kinematic] = Lane(self.robot_of(kinematic).own(self.port.view.set))
        return lane

    # ---- movement

    def _ready(self, task: Task, lane: Lane, block: Block, request: demands.MoveTo) -> None:
        until = "" if request.until is None else self._until(request.until, request)
        factors = {**lane.factors, **dict(request.factors)}
        robot = self.robot_of(request.kinematic)
        how = request.way, request.via, request.joint, request.relative
        on_belt = self.acts.target(robot, lane, request, tuple(float(value) for value in request.target if value is not None))
        if on_belt and self.acts.belts.kind(self.acts.belts.number(lane.belt)) == CAM:
            on_belt += " " + self.acts.cam(lane, self.port.view.channels.factors, factors)
        block.before, lane.before = lane.before, ()
        held = "" if request.way == "circular" else self._held(task, request.kinematic)
        until = " ".join(each for each in (until, held, range_keys(lane.limits)) if each)
        block.wanted = Wanted(robot, *how, block.target, factors, self._presets(robot.number), lane.frame, until, on_belt)
        if not request.relative and not request.joint and request.way != "circular":
            robot.target(block.target, lane.position)  # its faults belong to the statement

    def _held(self, task: Task, kinematic: str) -> str:
        """WAIT UNTIL of a high-speed input directly before a block: the cycle starts it (L1574-1655)."""
        for item in reversed(task.queue):
            if isinstance(item, Block) and item.kinematic != kinematic:
                continue
            own = isinstance(item, FastWait) and item.kinematic in (None, kinematic) and item.due is None
            if not own or not isinstance(item, FastWait) or item.until.channel not in self.setup.wires:
                return ""
            task.queue.remove(item)
            return f"wait={'' if item.until.level else '!'}ch{item.until.channel} delay={item.delay / SECOND:.10g}"
        return ""

    def _presets(self, robot: int) -> Presets:
        """P212 to P214 of a kinematic."""
        return self.setup.presets[robot - 1] if robot <= len(self.setup.presets) else Presets()

    def _until(self, until: demands.Until, request: demands.MoveTo) -> str:
        """The input that ends a movement, as the planner knows it."""
        number, sign = until.channel % EARLY, "" if until.level else "!"
        most = lines.within(until.limit)
        self.signal(number, self.now)  # one that is not there is a runtime error of this statement
        if 1 <= number <= USER:
            return f"until={sign}{FIRST_INPUT + number - 1}{most}"
        if number in RUN_ON and request.way != "ptp" and not self.robot_of(request.kinematic).straight:
            raise fault(222, f"input {until.channel} ends a {request.way} movement of an arm; use PTP")
        if FIRST_FAST <= number < FIRST_FAST + FAST or number in RUN_ON:
            return f"until={sign}ch{number}{most}"
        raise fault(222, f"MOVE UNTIL with input {until.channel}")

    def _check_range(self, lane: Lane, request: demands.MoveTo, target: tuple[float, ...]) -> None:
        """Of absolute points, before anything moves; the planner looks at the way, and at relative blocks."""
        if not request.relative:
            place = target if not request.joint else to_workpiece(lane.frame, self.robot_of(request.kinematic).world(target))
            check_range(lane.limits, place)

    def _target(self, task: Task, lane: Lane, request: demands.MoveTo) -> tuple[float, ...]:
        values = tuple(float(value) for value in request.target if value is not None)
        size = self.robot_of(request.kinematic).size
        if not values or len(values) != len(request.target):
            raise fault(200)
        if len(values) < size or len(values) > size + len(self.acts.belts.followed(self.robot_of(request.kinematic).number)):
            raise fault(221, f"{len(values)}, the kinematic has {size}")
        return values[:size]

    def _moves_on(self, task: Task, block: Block) -> bool:
        if self._still(task) and block.stretch is None:
            return True
        if block.stretch is None:
            self._hand_on(task)
            return False
        self._hand_on(task)
        if block.stretch.passed < block.index:
            return False
        if block.until is not None:
            if not block.stretch.over:
                return False
            block.met = self.port.view.path_of(block.stretch.robot).met
            self.lane(block.kinematic).measured = None  # what the cycle has measured is newer
        return True

    def _hand_on(self, task: Task) -> None:
        """What is prepared goes to the planner, as far as it follows without a question."""
        under_way, last, through = 0, None, None
        for item in list(task.queue):
            if isinstance(item, FastWait):
                return
            if isinstance(item, Output):
                continue
            if isinstance(item, Statement):
                if item.stretch is None and not self._told(task, item, first=last is None):
                    return
                continue
            if item.stretch is not None:
                under_way += item.stretch.passed < item.index
                last = item
                continue
            assert item.wanted is not None
            if item.until is not None and last is not None:
                return  # it begins from rest
            if last is not None and (last.wanted is None or last.wanted.robot is not item.wanted.robot):
                return  # the one before ends first
            path = self.paths.of(item.wanted.robot.number)
            if last is not None and last.stops and path.contended:
                return
            if item.wanted.way == "circular" and item.wanted.via and through is None:
                through = item
                continue
            if under_way > self.lane(item.kinematic).most:
                return
            stretch = path.wanted(task, task.unit.name, item.wanted.robot.number, whole=item.until is not None)
            if stretch is None:
                return
            self._say(stretch, item, through)
            if item.until is not None:
                path.release(task)
                return
            last, through = item, None
            under_way += 1

    def _told(self, task: Task, item: Statement, *, first: bool) -> bool:
        """The statement is handed on; one that is alone when nothing stands before it, and its stretch ends with it."""
        if item.alone and not first:
            return False
        path = self.paths.of(item.robot)
        if item.reference:
            item.stretch = path.reference(task, task.unit.name, item.robot)
            return item.stretch is not None
        stretch = path.wanted(task, task.unit.name, item.robot)
        if stretch is None:
            return False
        for text in item.texts:
            path.hand_on(stretch, text, item.line, block=False)
        if item.dummy:
            zeros = " ".join(["0"] * self.robot(item.robot).size)
            item.index = path.hand_on(stretch, f"ptp rel joints {zeros}", item.line)
        elif item.block:
            stretch.count += 1
            stretch.places.append(item.line)
        item.stretch = stretch
        if item.alone:
            path.release(task)
        return True

    def tell(self, task: Task, statement: Statement) -> object:
        """Puts it behind what is prepared; PENDING until one that is waited for is done."""
        waits = statement.alone or statement.dummy
        if statement.alone and task.queue:
            return PENDING
        task.queue.append(statement)
        task.said = statement if waits else None
        self._passed(task)
        return PENDING if waits and statement in task.queue else None

    def _done(self, task: Task, item: Statement) -> bool:
        self._hand_on(task)
        if item.stretch is None:
            return False
        return item.stretch.over if item.alone else item.stretch.passed >= item.index

    def _say(self, stretch: Stretch, item: Block, through: Block | None) -> None:
        assert item.wanted is not None
        for text in item.before:
            self.paths.of(stretch.robot).hand_on(stretch, text, item.line, block=False)
        frame = item.wanted.frame
        if self._systems.get(stretch.ticket) != frame:
            self._systems[stretch.ticket] = frame
            for text in lines.system(frame):
                self.paths.of(stretch.robot).hand_on(stretch, text, item.line, block=False)
        near, shares = self.lane(item.kinematic).position, self.port.view.channels.factors
        text = lines.line(item.wanted, near, shares, None if through is None else through.wanted)
        item.index = self.paths.of(stretch.robot).hand_on(stretch, text, item.line)
        item.stretch = stretch
        if through is not None:
            through.index, through.stretch = item.index, stretch

    def _act(self, task: Task) -> bool:
        try:
            item = task.queue[0]
            if isinstance(item, Statement) and not self._done(task, item):
                return False
            return super()._act(task)
        except RuntimeFault as error:
            first = task.queue[0] if task.queue else None
            if isinstance(first, Block):
                task.process.line = first.line
            self.scheduler.fail(task.process, error, self.now)
            return False

    def _halted(self, task: Task, lane: Lane) -> None:
        self.paths.forget(task)

    def _rest(self, task: Task) -> None:
        super()._rest(task)
        self.acts.ended(task)
        self.paths.forget(task)

    def _process_answer(self, task: Task, request: Request) -> object:
        if isinstance(request, demands.Drain):
            return None if not task.queue and self.paths.release(task) else PENDING
        return super()._process_answer(task, request)

    def _answer(self, task: Task, request: Request) -> object:
        match request:
            case demands.Synchronise() | demands.Reference() if self._still(task):
                return None
            case demands.Special(number=number) if number in TOLD and self._still(task):
                return None
            case demands.SyncBelt():
                return self.acts.sync(task, request) if not self._before(task) else PENDING
            case demands.Synchronise(kinematic=kinematic, channel=channel):
                self.acts.synchronise(task, kinematic, channel)
                return None
            case demands.Reference(kinematic=kinematic):
                return self.acts.reference(task, kinematic)
            case demands.Special(number=number, values=values) if number in (SPEED, DISTANCE):
                self.acts.asynchronous.call(task, number, values)
                return None
            case demands.Special(number=number, values=values) if number in TOLD:
                return self.acts.special(task, number, values)
            case demands.WriteOutput(channel=channel) if channel not in OUTPUTS:
                raise fault(224, str(channel))
        return super()._answer(task, request)

    def _still(self, task: Task) -> bool:
        """Tested WITHOUT movement."""
        return task.main.tested and not self.test.movement

    def _before(self, task: Task) -> bool:
        """Something is prepared that has to be over before the request counts."""
        return bool(task.queue) and task.said is None

    # ---- what is looked up

    def prepared(self, task: Task) -> bool:
        """Where everything that was prepared is run."""
        return not any(isinstance(item, Block | FastWait) for item in task.queue)

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
        """BREAK: on behind the others of its priority, once in an interpolation cycle."""
        if task.round == self._round:
            self.scheduler.processes.remove(task.process)
            self.scheduler.processes.append(task.process)
            return PENDING
        return None

    def signal(self, channel: int, now: int) -> int | float:
        """Value of an input as the control has it; a runtime error where there is none."""
        number, seen = channel % EARLY, self.port.view.channels
        if number in RUN_ON:
            number -= 100  # the probe of the same board
        if 1 <= number <= USER:
            bit = FIRST_INPUT + number - 1
            return seen.inputs[bit >> 3] >> (bit & 7) & 1
        if FIRST_INTEGER <= number < FIRST_INTEGER + INTEGERS:
            return seen.integers[number - FIRST_INTEGER]
        if 0 <= number - FIRST_REAL < REALS and seen.reals_given >> number - FIRST_REAL & 1:
            return seen.reals[number - FIRST_REAL]
        place = number - FIRST_FAST
        if 0 <= place < FAST and seen.fast_given >> place & 1:
            return seen.fast >> place & 1
        if (wire := self.setup.wires.get(number, -1)) >= 0:
            return seen.inputs[wire >> 3] >> (wire & 7) & 1
        if FIRST_MULTI <= number < FIRST_MULTI + MULTI and seen.multi is not None:
            return seen.multi >> (number - FIRST_MULTI) & 1
        raise RuntimeFault(206, f"{TEXTS[206]}: {channel}")

    def image(self, letter: str, bit: int) -> int:
        """A signal of the interface, as the PIC names it: O its outputs (RC inputs), I its inputs (RC outputs)."""
        if letter == "M":
            raise fault(206)
        seen = self.port.view.channels
        octets = seen.inputs if letter == "O" else seen.outputs
        return octets[bit >> 3] >> (bit & 7) & 1 if bit >> 3 < len(octets) else 0

    def belt(self, channel: int) -> float:
        """Counter of a belt."""
        return self.acts.belts.counter(self.acts.belts.number(channel))

    def set_belt(self, channel: int, value: float) -> None:
        """The cycle sets counters."""

    def where(self, kinematic: str) -> tuple[float, ...]:
        """Set joints of a kinematic now."""
        return self.robot_of(kinematic).own(self.port.view.set)

    def with_belts(self, unit: Unit, kinematic: str) -> tuple[float, ...]:
        """Set joints, and behind them the counters of belts that the program names as components."""
        robot = self.robot_of(kinematic)
        return (*self.where(kinematic), *self.acts.belts.values(robot.number, max(0, size_of(unit, kinematic) - robot.size)))

    def measuring_system(self, unit: Unit, number: int) -> float:
        """The axes of the cell in its order, then its belts."""
        found = (*self.port.view.set, *self.port.view.belts)
        if not 1 <= number <= len(found):
            raise fault(91, str(number))
        return found[number - 1]

    def actual(self, kinematic: str) -> tuple[float, ...]:
        """As its drives report."""
        return self.robot_of(kinematic).own(self.port.view.actual)

    def position(self, task: Task, kinematic: str, name: str) -> tuple[float, ...]:
        """POS, @POS, @MPOS now."""
        robot = self.robot_of(kinematic)
        if name == "@MPOS":
            flying = self.lane(kinematic).measured
            if flying is not None:
                return flying
            found = self.port.view.measured[robot.first : robot.first + robot.size]
            if any(each is None for each in found):
                raise fault(200)
            return tuple(each for each in found if each is not None)
        joints = self.where(kinematic)
        belts = self.acts.belts.values(robot.number, max(0, size_of(task.unit, kinematic) - robot.size))
        place = to_workpiece(self.lane(kinematic).frame, robot.world(joints)) if name == "POS" else joints
        return (*place, *belts)

    def world(self, kinematic: str, joints: tuple[float, ...]) -> tuple[float, ...]:
        """World coordinates of joints; values of belts behind them stay."""
        robot = self.robot_of(kinematic)
        return (*robot.world(joints[: robot.size]), *joints[robot.size :])

    def joints(self, kinematic: str, world: tuple[float, ...]) -> tuple[float, ...]:
        """Joints of world coordinates, near where the axes are; values of belts behind them stay."""
        robot = self.robot_of(kinematic)
        return (*robot.joints(world[: robot.size], self.where(kinematic)), *world[robot.size :])

    # ---- what is told

    def _output(self, task: Task, item: Output) -> None:
        super()._output(task, item)
        self.port.output(item.channel, float(item.value))

    def event(self, task: Task, event: str, line: int, **facts: object) -> None:
        """Warnings and output to devices; `ended` reports ends."""
        if event == "warning":
            self.port.told(task.unit.name, line, str(facts["text"]))
        elif event == "write" and facts["device"] != "PHG":
            text = str(facts["hex"])
            for at in range(0, max(len(text), 1), PIECE):
                self.port.tell("phg2000", hex=text[at : at + PIECE], more=at + PIECE < len(text))
        elif event == "write":
            self.port.panel(bytes.fromhex(str(facts["hex"])).decode("cp437"))

    def ended(self, process: Process, now: int) -> None:
        """The process is over; its starter gets the result."""
        task = self.tasks[process.number]
        failed = process.fault if process.state is ProcessState.FAILED else None
        if failed is not None and task.root is not None:
            task.root.branch_fault = failed, process.line
        super().ended(process, now)
        self._read.pop(process.number, None)
        if isinstance(self.units, CellDevices):
            self.units.ended(task, aborted=failed is not None or bool(task.how))
        if task.root is not None:
            return
        line = process.line
        if failed is None and task.branch_fault is not None:
            failed, line = task.branch_fault
        self._runs.pop(task.run, None)
        self.port.over(task.run, task.how or "ended", failed, f"{task.unit.name}.QLL line {line}")

    def rows(self) -> list[ProcessRow]:
        """The processes, branches too."""
        found = []
        for task in self.tasks.values():
            asked = task.process.waits_for
            waits = WAITS.get(type(asked).__name__, "") if asked is not None else ""
            main = task.main
            parent = task.starter.main.run if task.root is None and task.starter is not None else 0
            row = ProcessRow(
                main.run, task.unit.name, task.kind, task.process.state.value, task.process.line, waits, parent, task.root is not None
            )
            found.append(row)
        return found


def numbered(error: RuntimeFault) -> RuntimeFault:
    """The manual's own number where planner or cycle name one: `.. beltdistance is zero (rho 3 89)`; not those of others."""
    text = FOREIGN.sub("", error.text)
    found = NUMBERED.search(text)
    return RuntimeFault(error.code if found is None else int(found[1]), text)


def changed(before: Mapping[str, bytes], after: Mapping[str, bytes]) -> dict[str, bytes | None]:
    """Files that programs have written, and deleted (None)."""
    found: dict[str, bytes | None] = {name: data for name, data in after.items() if before.get(name) is not data}
    return found | {name: None for name in before if name not in after}
