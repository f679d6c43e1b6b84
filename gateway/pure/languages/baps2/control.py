"""Runs programs: processes, prepared blocks, outputs, devices and files; the plant is that of a dry run or a cell.  Pure."""

from collections.abc import Mapping

from gateway.pure.languages.baps2 import circles, demands, forms
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.feed import SECOND, Feed
from gateway.pure.languages.baps2.filing import Filing
from gateway.pure.languages.baps2.frames import to_workpiece, to_world
from gateway.pure.languages.baps2.handle import Handle
from gateway.pure.languages.baps2.lasting import LastingValues
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.outside import Outside
from gateway.pure.languages.baps2.plant import Plant
from gateway.pure.languages.baps2.semaphores import Semaphores
from gateway.pure.languages.baps2.special import Specials
from gateway.pure.languages.baps2.tasks import Block, FastWait, Lane, Lanes, Output, Release, Task, size_of
from gateway.pure.languages.baps2.translation import Unit
from gateway.pure.languages.baps2.units import Device
from gateway.pure.languages.baps2.values import Shared
from gateway.pure.languages.baps2.waiting import words
from gateway.pure.languages.baps2.working_range import check_range
from gateway.pure.languages.base.process import Process, ProcessState
from gateway.pure.languages.base.requests import PENDING, Request, RuntimeFault
from gateway.pure.languages.base.scheduler import Scheduler

BUDGET = 5_000  # statements of a process in a turn; in a P5, once the spare turns are used
READINGS = 32  # readings of a process in one moment; the next one is a P5 later
PROBES = range(600, 800)
UNNAMED = "1"  # the kinematic of a program that names none


class Control(Plant):
    """Host of the processes, whatever moves."""

    def __init__(self, library: Library, memory: Memory, feed: Feed) -> None:
        self.library, self.memory, self.feed = library, memory, feed
        self.now = 0
        self.scheduler = Scheduler(self, BUDGET, 1)
        self.tasks: dict[int, Task] = {}
        self.lanes = Lanes()
        self.outputs: dict[int, int | float] = {}
        self.filing = Filing({**memory.files, **feed.files})
        memory.files = self.filing.files
        self.devices = {name: Device(each) for name, each in feed.units.items()}
        self.units = Outside(self)
        self.specials = Specials(self)
        self._semaphores = Semaphores()
        self.lasting = LastingValues(library, memory, feed)
        self._round = 0

    # ---- processes

    def holder_of(self, semaphore: tuple[str, str]) -> Task | None:
        """The process in an EXCLUSIVE part of it."""
        return self._semaphores.holder_of(semaphore)

    def _look_for_circles(self) -> None:
        """Processes that wait for each other, once they do."""
        if self._semaphores.held or any(lane.rider is not None for lane in self.lanes.values()):
            if found := self._semaphores.watch.look(self.tasks.values(), self):
                self.event(found[0][0], "warning", found[0][0].process.line, text=words(found))

    def library_of(self, task: Task | None) -> Library:
        """The programs as this process runs them; None: one that is started just now."""
        return self.library

    def start(self, program: str, starter: Task | None) -> Task:
        """Starts a program as a process.  RuntimeFault where it cannot run."""
        name = program.upper()
        unit, faults = self.library_of(None).unit(name)
        if unit is None:
            more = next((str(each) for each in faults), "") if len(faults) else name
            raise fault(1092, more)
        if unit.program.external_subroutine:
            raise fault(1073, name)
        if any(task.root is None and task.unit.name == unit.name for task in self.tasks.values()):
            raise fault(1051, name)
        kind = "permanent" if unit.permanent else "main" if starter is None else "sub"
        process = self.scheduler.start(unit.name, lambda process: None)
        task = Task(process, unit, kind, starter=starter)
        process.permanent = unit.permanent
        self.tasks[process.number] = task
        if starter is not None:
            starter.main.children.append(task)
        for kinematic, number in (unit.program.head.kinematics or {"": 1}).items():
            self.lanes.numbers.setdefault(kinematic, number)
            if kinematic:
                self.lane(kinematic, size_of(unit, kinematic))
        self.event(task, "start", unit.program.main.at.line, kind=kind)
        self._warn(task, unit)
        if unit.make is not None:
            process.body = unit.make(Handle(self, task))(process)
        return task

    def _warn(self, task: Task, unit: Unit) -> None:
        """An importing program that is older than its exporter (L2476-2494)."""
        mine, other = self.memory.age(unit.name), self.memory.age(unit.imports) if unit.imports else None
        if mine is not None and other is not None and mine < other:
            self.event(task, "warning", unit.program.main.at.line, text=f"{unit.name} is older than {unit.imports}, whose data it imports")

    def named(self, program: str) -> Task | None:
        """The main process of a program that runs."""
        return next(
            (task for task in self.tasks.values() if task.root is None and program.upper() in (task.unit.file, task.unit.name)), None
        )

    def stop(self, task: Task, how: str) -> None:
        """End a process and its branches; if it is stopped, also the processes it started."""
        task = task.main
        task.how = how
        if how == "stopped":
            for child in list(task.children):
                if not child.process.over:
                    self.stop(child, how)
        self.scheduler.stop(task.process, self.now)

    def ended(self, process: Process, now: int) -> None:
        """The process is over."""
        task = self.tasks.pop(process.number)
        self._rest(task)
        self._semaphores.leave_all(task, self.tasks.values())
        self.filing.close_all(process.number)
        if process.state is ProcessState.FAILED and process.fault is not None:
            self.event(task, "error", process.line, code=process.fault.code, text=process.fault.text)
            task.how = "aborted"
            if task.root is not None and not task.root.process.over:
                self.stop(task.root, "aborted")
            for child in list(process.children):
                self.scheduler.stop(child, now)
        if task.root is None:
            self.event(task, "end", process.line, how=task.how or "ended")

    def _rest(self, task: Task) -> None:
        """Its kinematics rest where they are on their path."""
        task.queue.clear()
        for lane in self.lanes.values():
            if lane.rider is task:
                lane.off_belt()
            if lane.owner is task:
                self._halted(task, lane)
                lane.moving, lane.owner, lane.planned = None, None, lane.position

    # ---- blocks

    def lane(self, kinematic: str, size: int = 0) -> Lane:
        """A kinematic; its start position is known or zero."""
        lane = self.lanes.get(kinematic)
        if lane is None:
            lane = self.lanes[kinematic] = self.lanes.renamed(kinematic) or Lane()
        if not lane.position:
            lane.position = lane.planned = self.feed.start.get(kinematic.upper() or UNNAMED, (0.0,) * size)
        return lane

    def _advance(self) -> bool:
        """Lets all that is prepared act up to now; whether anything did."""
        changed = False
        self.specials.measure()
        for device in self.devices.values():
            device.take_in(self.now)
        for task in list(self.tasks.values()):
            while task.queue and self._act(task):
                changed = True
            if task.halted and not task.queue and not any(child.queue for child in self._branches(task)):
                self.stop(task, "ended")
                changed = True
        return changed

    def _branches(self, task: Task) -> list[Task]:
        return [each for each in self.tasks.values() if each.root is task]

    def _act(self, task: Task) -> bool:
        """The first item of a process; False: it is not over yet."""
        item = task.queue[0]
        match item:
            case Output():
                self._output(task, item)
            case Release(semaphore=semaphore):
                self._semaphores.leave(task, semaphore, self.tasks.values())
            case FastWait():
                if item.due is None and item.until.test():
                    item.due = self.now + item.delay
                if item.due is None or self.now < item.due:
                    return self._overtakes(task, item) and self._act(task)
            case Block():
                if not self._moves_on(task, item):
                    return False
        task.queue.popleft()
        if isinstance(item, Block) and not self._follows(task, item.kinematic):
            self.lane(item.kinematic).owner = None
        return True

    def _follows(self, task: Task, kinematic: str) -> bool:
        """Return whether its next block moves this kinematic too; one that moves another releases this one meanwhile."""
        follows = next((item for item in task.queue if isinstance(item, Block)), None)
        return follows is not None and follows.kinematic == kinematic

    def _overtakes(self, task: Task, wait: FastWait) -> bool:
        """Return whether a following block overtakes a wait: the wait holds its own kinematic only (L1621-1631)."""
        follows = task.queue[1] if len(task.queue) > 1 else None
        if not isinstance(follows, Block) or wait.kinematic in (None, follows.kinematic):
            return False
        task.queue[0], task.queue[1] = follows, wait
        return True

    def _output(self, task: Task, item: Output) -> None:
        self.outputs[item.channel] = item.value
        self.event(task, "out", item.line, channel=item.channel, value=item.value)

    # ---- queries

    def input(self, channel: int) -> int | float:
        """Value of an input now; of a probe that measures in flight: whether it has measured."""
        measured = self.specials.measured(channel)
        return self.signal(channel, self.now) if measured is None else measured

    def taught(self, program: str, name: str) -> tuple[float, ...] | None:
        """A point of the feed or the point file; None: not defined."""
        return self.lasting.points.get(program, name)

    def point_selected(self, program: str, point: str, points: Mapping[str, tuple[float, ...]]) -> None:
        """A dry run has no pendant."""
        return

    def keep(self, program: str, name: str, value: tuple[float, ...]) -> None:
        """A teach point was assigned to: it stays when the program ends, and is kept in the point file."""
        self.lasting.points.keep(program, name, value)

    def file_changed(self, name: str) -> None:
        """A file of the memory was replaced or deleted."""
        self.lasting.file_changed(name, self.library)

    def shared(self, program: str) -> Shared:
        """The PUBLIC variables of a program; they stay when it ends."""
        return self.lasting.public(program, self)

    # ---- what programs ask

    def ask(self, process: Process, request: Request, now: int) -> object:
        """Begins a request."""
        task = self.tasks[process.number]
        task.since, task.began, task.block, task.said, task.round = now, None, None, None, self._round
        try:
            circles.follow(task, request)
            return self._answer(task, request)
        except forms.BadForm:
            return fault(201)
        except RuntimeFault as error:
            return error

    def answer_of(self, process: Process, request: Request, now: int) -> object:
        """Asks again."""
        try:
            return self._answer(self.tasks[process.number], request)
        except RuntimeFault as error:
            return error

    def _answer(self, task: Task, request: Request) -> object:
        match request:
            case demands.ReadInput(channel=channel):
                return self._read_input(task, channel)
            case demands.WriteOutput(channel=channel, value=value):
                self.outputs[channel] = value
                task.queue.append(Output(channel, value, task.process.line))
                self._passed(task)
                return None
            case demands.MoveTo():
                return self.move(task, request)
            case demands.ReadPosition(kinematic=kinematic, name=name):
                return self.position(task, kinematic, name) if self._may_read(task) else PENDING
            case demands.Late():
                task.not_before = self.now + 2 * self.feed.p5
                return None
            case demands.Special(number=number, values=values):
                return self.specials.call(task, number, values)
            case demands.Dwell() | demands.WaitFor() | demands.SyncBelt() | demands.Synchronise() | demands.Reference():
                return self._at_rest(task, request)
        return self._process_answer(task, request)

    def _at_rest(self, task: Task, request: Request) -> object:
        """Requests that begin when all that is prepared is done, but for high-speed inputs."""
        if isinstance(request, demands.WaitFor) and request.fast:
            until = demands.Until(request.channel, request.test, level=request.level)
            task.queue.append(FastWait(until, round((request.limit or 0) * SECOND), task.last))
            self._passed(task)
            return True
        if task.queue:
            return PENDING
        if task.began is None:
            task.began = self.now
        match request:
            case demands.Dwell(seconds=seconds):
                return None if self.now >= task.began + round(seconds * SECOND) else PENDING
            case demands.WaitFor():
                return self._wait(task, request)
            case demands.SyncBelt() | demands.Synchronise():
                return self._on_belt(task, request)
            case demands.Reference(kinematic=kinematic):
                self.lane(kinematic).referenced = True
        return None

    def _process_answer(self, task: Task, request: Request) -> object:
        """Requests about processes."""
        match request:
            case demands.Branches(bodies=bodies):
                return self._parallel(task, bodies)
            case demands.Drain():
                return PENDING if task.queue else None
            case demands.Halt():
                task.main.halted = True
                return PENDING
            case demands.GiveUp():
                return self._give_up(task)
            case demands.Enter(semaphore=semaphore):
                return self._semaphores.enter(task, semaphore)
            case demands.Leave(semaphore=semaphore):
                self._semaphores.end(task, semaphore, self.tasks.values())
                return None
            case demands.StartProgram(program=program):
                self.start(program, task)
                return None
            case demands.StopProgram(program=program):
                return self.stop_named(task, program)
        return self.units.answer(task, request)

    def _passed(self, task: Task) -> None:
        """An item with nothing before it acts at once."""
        while task.queue and self._act(task):
            pass

    def _may_read(self, task: Task) -> bool:
        """Whether motion is far enough, and the process has not read all the time in this moment."""
        return self.prepared(task) and self._counted(task)

    def _counted(self, task: Task) -> bool:
        if task.moment != self.now:
            task.moment, task.readings = self.now, 0
        if task.readings >= READINGS:
            return False
        task.readings += 1
        return True

    def _read_input(self, task: Task, channel: int) -> object:
        if not (self._may_read(task) if channel < 1_000 else self._counted(task)):
            return PENDING
        value = self.input(channel)
        self.event(task, "in", task.process.line, channel=channel, value=value)
        return value

    def _wait(self, task: Task, request: demands.WaitFor) -> object:
        if request.test():
            return True
        return False if request.limit is not None and self.now >= (task.began or 0) + round(request.limit * SECOND) else PENDING

    def move(self, task: Task, request: demands.MoveTo) -> object:
        """Prepares a block."""
        if task.block is not None:  # its UNTIL decides
            return PENDING if task.block in task.queue else bool(task.block.met)
        size = len(request.target)
        lane = self.lane(request.kinematic, size)
        if lane.ridden_for(task) or len([each for each in task.blocks(request.kinematic) if each.began is None]) >= lane.most:
            return PENDING
        target = self._target(task, lane, request)
        if lane.limits:
            self._check_range(lane, request, target)
        self.lanes.blocks += 1
        block = Block(self.lanes.blocks, request.kinematic, target, task.process.place, request.until, stops=not request.via)
        self._ready(task, lane, block, request)
        self.event(
            task, "move", block.line, n=block.number, kinematic=request.kinematic or UNNAMED, way=request.way, target=list(target),
            space="jc" if request.joint else "wc", **{"pass": "via" if request.via else "to"},
        )  # fmt: skip
        lane.planned, task.last = target, request.kinematic
        task.queue.append(block)
        self._passed(task)
        if request.until is None:
            return False
        task.block = block
        return PENDING if block in task.queue else bool(block.met)

    def _ready(self, task: Task, lane: Lane, block: Block, request: demands.MoveTo) -> None:
        """A block is prepared; what a cell needs to know of it."""
        return

    def _check_range(self, lane: Lane, request: demands.MoveTo, target: tuple[float, ...]) -> None:
        """LIMIT_MIN, LIMIT_MAX; a runtime error."""
        check_range(lane.limits, to_workpiece(lane.frame, self.world(request.kinematic, target)))

    def _target(self, task: Task, lane: Lane, request: demands.MoveTo) -> tuple[float, ...]:
        values = tuple(float(value) for value in request.target if value is not None)
        if len(values) != len(lane.position):
            raise fault(221, f"{len(values)}, the kinematic has {len(lane.position)}")
        if lane.belt:
            self.specials.check_synchronous(task, lane, request)
        if not request.relative:
            return values if request.joint else to_world(lane.frame, values)
        if request.joint:
            return tuple(a + b for a, b in zip(lane.planned, values, strict=True))
        here = to_workpiece(lane.frame, lane.planned)
        return to_world(lane.frame, tuple(a + b for a, b in zip(here, values, strict=True)))

    def _parallel(self, task: Task, bodies: tuple[object, ...]) -> object:
        if task.began is None:
            if task.queue:
                return PENDING
            task.began = self.now
            for body in bodies:
                process = self.scheduler.start(task.unit.name, lambda process: None, task.process.priority, task.process)
                process.place = task.process.place
                self.tasks[process.number] = Task(process, task.unit, "branch", root=task.main, names=task.names)
                if callable(body):
                    process.body = body(process)
        return PENDING if task.process.children else None

    def _give_up(self, task: Task) -> object:
        if task.round == self._round:
            self._counted(task)
            self.scheduler.processes.remove(task.process)  # to the end of the queue
            self.scheduler.processes.append(task.process)
            return PENDING
        return None if task.moment != self.now or task.readings < READINGS else PENDING

    def stop_named(self, task: Task, program: str) -> object:
        """STOP: not a program that this process is part of (1079)."""
        found = self.named(program)
        if found is None:
            return None
        above: Task | None = task.main if task.root is not None else task.starter and task.starter.main
        while above is not None:
            if above is found:
                raise fault(1079)
            above = above.starter and above.starter.main
        self.stop(found, "stopped")
        return None
