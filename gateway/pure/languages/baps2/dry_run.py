"""Programs run dry: in virtual time, every block lasts the same, world equals joints.  Pure; gives the trace (AX-696)."""

from collections.abc import Iterator

from gateway.pure.languages.baps2 import demands, forms
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.feed import SECOND, Feed
from gateway.pure.languages.baps2.filing import Filing
from gateway.pure.languages.baps2.frames import to_workpiece, to_world
from gateway.pure.languages.baps2.handle import Handle
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.outside import Outside
from gateway.pure.languages.baps2.special import Specials
from gateway.pure.languages.baps2.tasks import Block, FastWait, Lane, Output, Task, between
from gateway.pure.languages.baps2.translation import Unit
from gateway.pure.languages.baps2.units import Device
from gateway.pure.languages.baps2.values import Shared
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.process import Process, ProcessState
from gateway.pure.languages.base.requests import PENDING, Request, RuntimeFault
from gateway.pure.languages.base.scheduler import Scheduler
from gateway.pure.languages.base.trace import Trace

BUDGET = 5_000  # statements of a process in a turn; in a P5, once the spare turns are used
SPARE = 2_000  # turns that cost no time
READINGS = 32  # readings of a process in one moment; the next one is a P5 later
PROBES = range(600, 800)


class DryRun:
    """Host of the processes."""

    def __init__(self, library: Library, memory: Memory, feed: Feed) -> None:
        self.library, self.memory, self.feed = library, memory, feed
        self.trace = Trace()
        self.now = 0
        self.scheduler = Scheduler(self, BUDGET, 1)
        self.tasks: dict[int, Task] = {}
        self.lanes: dict[str, Lane] = {}
        self.outputs: dict[int, int | float] = {}
        self.filing = Filing({**memory.files, **feed.files})
        memory.files = self.filing.files
        self.devices = {name: Device(each) for name, each in feed.units.items()}
        self.units = Outside(self)
        self.specials = Specials(self)
        self.belts = dict.fromkeys(feed.belts, 0.0)  # counters at the moment `_belts_at`
        self._belts_at = 0
        self._shared: dict[str, Shared] = {}
        self._semaphores: dict[tuple[str, str], Task] = {}
        self._points: dict[str, dict[str, tuple[float, ...]]] = {}
        self._moves = self._round = 0

    # ---- the run

    def run(self, program: str) -> RuntimeFault | None:
        """Starts a program and runs up to the end of the feed or of all processes; the fault that kept it from starting."""
        try:
            name = self.start(program, None).unit.name
        except RuntimeFault as error:
            return error
        spare = SPARE
        while self.scheduler.processes:
            self._advance()
            self._round += 1
            busy = self.scheduler.run(self.now) == self.now
            moved = self._advance()
            if self._round > 1 and moved:
                continue
            if busy and spare:
                spare -= 1
                continue
            moment = self._next(busy)
            if moment is None or moment > self.feed.until:
                break
            self.now = moment
        self.filing_close()
        rows = {name: data.hex() for name, data in sorted(self.filing.files.items()) if name.endswith((".DAT", ".BNR"))}
        self.trace.add(self.now, name, 0, "files", files=rows)
        return None

    def filing_close(self) -> None:
        """What is still open at the end of the run is written."""
        for number in list(self.tasks):
            self.filing.close_all(number)

    def _next(self, busy: bool) -> int | None:
        """The next moment at which anything can change."""
        tick = self.now + self.feed.p5 - self.now % self.feed.p5
        moments = [moment for moment in self._moments() if moment > self.now]
        if busy or any(task.moment == self.now and task.readings >= READINGS for task in self.tasks.values()):
            moments.append(tick)
        waiting = any(isinstance(task.process.waits_for, demands.WaitFor | demands.SyncBelt) for task in self.tasks.values())
        if waiting and (any(self.feed.belts.values()) or any(lane.moving for lane in self.lanes.values())):
            moments.append(tick)
        return min(moments, default=None)

    def _moments(self) -> Iterator[int]:
        feed = self.feed
        for lane in self.lanes.values():
            if lane.moving is not None and lane.moving.began is not None:
                end = lane.moving.began + feed.block
                yield from (end, end - 2 * feed.p5)
                if lane.moving.until is not None and lane.moving.until.limit is not None:
                    yield lane.moving.began + round(lane.moving.until.limit * SECOND)
        for moments in feed.inputs.values():
            yield from (moment for moment, _ in moments)
        for device in self.devices.values():
            if device.due is not None:
                yield device.due
        for task in self.tasks.values():
            for item in task.queue:
                if isinstance(item, FastWait) and item.due is not None:
                    yield item.due
            if task.began is not None:
                match task.process.waits_for:
                    case demands.Dwell(seconds=seconds):
                        yield task.began + round(seconds * SECOND)
                    case demands.WaitFor(limit=float() | int() as limit):
                        yield task.began + round(limit * SECOND)

    # ---- processes

    def start(self, program: str, starter: Task | None) -> Task:
        """Starts a program as a process.  RuntimeFault where it cannot run."""
        name = program.upper()
        unit, faults = self.library.unit(name)
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
        for kinematic in unit.program.head.kinematics:
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
        return next((task for task in self.tasks.values() if task.root is None and task.unit.name == program.upper()), None)

    def stop(self, task: Task, how: str) -> None:
        """Ends a process and its branches; what it started too, where it is stopped."""
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
        for semaphore in task.semaphores:
            self._semaphores.pop(semaphore, None)
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
            if lane.owner is task:
                if lane.moving is not None:
                    lane.position = between(lane.moving, self.now, self.feed.block)
                lane.moving, lane.owner, lane.planned = None, None, lane.position

    def event(self, task: Task, event: str, line: int, **facts: object) -> None:
        """One event of the trace."""
        self.trace.add(self.now, task.unit.name, line, event, **facts)

    # ---- blocks

    def lane(self, kinematic: str, size: int = 0) -> Lane:
        """A kinematic; its start position is known or zero."""
        lane = self.lanes.setdefault(kinematic, Lane())
        if not lane.position:
            lane.position = lane.planned = self.feed.start.get(kinematic.upper(), (0.0,) * size)
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
            case FastWait():
                if item.due is None and item.until.test():
                    item.due = self.now + item.delay
                if item.due is None or self.now < item.due:
                    return False
            case Block():
                if not self._moves_on(task, item):
                    return False
        task.queue.popleft()
        if isinstance(item, Block) and not task.blocks(item.kinematic):
            self.lane(item.kinematic).owner = None
        return True

    def _output(self, task: Task, item: Output) -> None:
        self.outputs[item.channel] = item.value
        self.event(task, "out", item.line, channel=item.channel, value=item.value)

    def _moves_on(self, task: Task, block: Block) -> bool:
        """Begins or goes on with a block; True: it is over."""
        lane = self.lane(block.kinematic)
        if block.began is None:
            if lane.owner not in (None, task):
                return False
            lane.owner, lane.moving = task, block
            block.began, block.start = self.now, lane.position
            if block.until is not None and block.until.channel % 10 == 0 and block.until.channel in PROBES:
                block.was = block.until.test()
            self.event(task, "moving", block.line, n=block.number)
        end = self.now >= block.began + self.feed.block
        if block.until is not None:
            block.met = self._met(block)
            if block.until.limit is not None and self.now >= block.began + round(block.until.limit * SECOND):
                end = True
        if not (end or block.met):
            return False
        lane.position = block.target if end and not block.met and not self._cut(block) else between(block, self.now, self.feed.block)
        if block.met:
            self._measure(lane, block)
        lane.moving = None
        if not [each for each in task.blocks(block.kinematic) if each is not block]:
            lane.planned = lane.position
        facts = {"met": bool(block.met)} if block.until is not None else {}
        self.event(task, "moved", block.line, n=block.number, **facts)
        return True

    def _cut(self, block: Block) -> bool:
        """Whether a time limit ended it before its end."""
        return block.began is not None and self.now < block.began + self.feed.block

    def _met(self, block: Block) -> bool:
        """The condition of MOVE UNTIL: a probe needs a change, all others the value (L1120-1130)."""
        if block.until is None:
            return False
        now = block.until.test()
        probe = block.until.channel in PROBES and block.until.channel % 10 == 0
        met = now and not (probe and block.was)
        block.was = now
        return met

    def _measure(self, lane: Lane, block: Block) -> None:
        if block.until is None or block.until.channel not in PROBES:
            return
        lane.measured = lane.position
        if block.until.channel >= 700:  # the distance of special function 42 is travelled at once (L6766-6795)
            size = sum((b - a) ** 2 for a, b in zip(block.start, block.target, strict=True)) ** 0.5 or 1.0
            lane.position = tuple(
                value + (b - a) / size * lane.distance for value, a, b in zip(lane.position, block.start, block.target, strict=True)
            )

    # ---- what is looked up

    def input(self, channel: int) -> int | float:
        """Value of an input now; of a probe that measures in flight: whether it has measured."""
        if (measured := self.specials.measured(channel)) is not None:
            return measured
        return self.signal(channel, self.now)

    def signal(self, channel: int, now: int) -> int | float:
        """Value of an input as the feed has it."""
        value: float = 0
        for moment, each in self.feed.inputs.get(channel % 1_000, ()):
            if moment <= now:
                value = each
        return value if 201 <= channel % 1_000 <= 299 else int(value)

    def belt(self, channel: int) -> float:
        """Counter of a belt in mm."""
        number = channel % 500
        if number not in self.feed.belts:
            raise fault(93, str(number))
        return self.belts[number] + self.feed.belts[number] * (self.now - self._belts_at) / SECOND

    def set_belt(self, channel: int, value: float) -> None:
        """Sets the counter of a belt."""
        self.belts[channel % 500] += value - self.belt(channel)

    def position(self, task: Task, kinematic: str, name: str) -> tuple[float, ...]:
        """POS, @POS, @MPOS now."""
        lane = self.lane(kinematic)
        if name == "@MPOS":
            if lane.measured is None:
                raise fault(200)
            return lane.measured
        where = lane.position
        if lane.moving is not None:
            mine = task.blocks(kinematic)
            near = mine and mine[-1] is lane.moving and task.prepared(self.now, self.feed.block, self.feed.p5)
            where = lane.moving.target if near else between(lane.moving, self.now, self.feed.block)
        if not where:
            raise fault(200)
        return to_workpiece(lane.frame, where) if name == "POS" else where

    def where(self, kinematic: str) -> tuple[float, ...]:
        """Joints of a kinematic now."""
        lane = self.lane(kinematic)
        return lane.position if lane.moving is None else between(lane.moving, self.now, self.feed.block)

    def taught(self, program: str, name: str) -> tuple[float, ...] | None:
        """A point of the feed or the point file; None: not defined."""
        found = self.feed.points.get(program, {}).get(name)
        if found is None:
            if program not in self._points:
                self._points[program] = self.memory.points(program, Faults())
            found = self._points[program].get(name)
        return found

    def shared(self, program: str) -> Shared:
        """The PUBLIC variables of a program, made when first asked for; they stay when it ends."""
        if program not in self._shared:
            space = self._shared[program] = Shared()
            unit, _ = self.library.unit(program)
            if unit is None or unit.share is None:
                raise fault(1092, program)
            unit.share(Handle(self, None), space)
        return self._shared[program]

    # ---- what programs ask

    def ask(self, process: Process, request: Request, now: int) -> object:
        """Begins a request."""
        task = self.tasks[process.number]
        task.since, task.began, task.block, task.round = now, None, None, self._round
        try:
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
            case demands.Special(number=number, values=values):
                return self.specials.call(task, number, values)
            case demands.Dwell() | demands.WaitFor() | demands.SyncBelt() | demands.Synchronise() | demands.Reference():
                return self._at_rest(task, request)
        return self._process_answer(task, request)

    def _at_rest(self, task: Task, request: Request) -> object:
        """Requests that begin when all that is prepared is done, but for high-speed inputs."""
        if isinstance(request, demands.WaitFor) and request.fast:
            task.queue.append(FastWait(demands.Until(0, request.test), round((request.limit or 0) * SECOND)))
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
            case demands.SyncBelt():
                return self._sync(request)
            case demands.Synchronise(kinematic=kinematic, channel=channel):
                self._synchronise(kinematic, channel)
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
                return self._enter(task, semaphore)
            case demands.Leave(semaphore=semaphore):
                self._semaphores.pop(semaphore, None)
                if semaphore in task.semaphores:
                    task.semaphores.remove(semaphore)
                return None
            case demands.StartProgram(program=program):
                self.start(program, task)
                return None
            case demands.StopProgram(program=program):
                return self.stop_named(task, program)
        return self.units.answer(task, request)

    def _passed(self, task: Task) -> None:
        """An item that nothing stands before acts at once."""
        while task.queue and self._act(task):
            pass

    def _may_read(self, task: Task) -> bool:
        """Whether motion is far enough, and the process has not read all the time in this moment."""
        if not task.prepared(self.now, self.feed.block, self.feed.p5):
            return False
        return self._counted(task)

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
        if len([each for each in task.blocks(request.kinematic) if each.began is None]) >= lane.most:
            return PENDING
        target = self._target(task, lane, request)
        self._moves += 1
        block = Block(self._moves, request.kinematic, target, task.process.line, request.until)
        self.event(
            task, "move", block.line, n=block.number, kinematic=request.kinematic or "1", way=request.way, target=list(target),
            space="jc" if request.joint else "wc", **{"pass": "via" if request.via else "to"},
        )  # fmt: skip
        lane.planned = target
        task.queue.append(block)
        self._passed(task)
        if request.until is None:
            return False
        task.block = block
        return PENDING if block in task.queue else bool(block.met)

    def _target(self, task: Task, lane: Lane, request: demands.MoveTo) -> tuple[float, ...]:
        values = tuple(float(value) for value in request.target if value is not None)
        if len(values) != len(lane.position):
            raise fault(221, f"{len(values)}, the kinematic has {len(lane.position)}")
        if lane.belt:
            self.specials.check_synchronous(lane, request)
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
                process.line = task.process.line
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

    def _enter(self, task: Task, semaphore: tuple[str, str]) -> object:
        holder = self._semaphores.get(semaphore)
        if holder is not None and holder is not task:
            return PENDING
        self._semaphores[semaphore] = task
        task.semaphores.append(semaphore)
        return None

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

    def _sync(self, request: demands.SyncBelt) -> object:
        value = self.belt(request.channel)
        compare = {">=": value >= request.at, ">": value > request.at, "<=": value <= request.at, "<": value < request.at}
        if not (request.test() if request.test is not None else compare[request.sign]):
            return PENDING
        inside = any(lane.belt == request.channel for lane in self.lanes.values())
        self.set_belt(
            request.channel, value - request.at if inside and request.test is None else self.specials.reset_value(request.channel)
        )
        return None

    def _synchronise(self, kinematic: str, channel: int) -> None:
        for lane in [self.lane(kinematic)] if channel else self.lanes.values():
            lane.belt = channel


def size_of(unit: Unit, kinematic: str) -> int:
    """Components of a kinematic's points as the program names them; 0: it names none."""
    head = unit.program.head
    tables = (head.joint_names, head.world_names)
    return max((len(table.get(key, ())) for table in tables for key in (kinematic, "")), default=0)
