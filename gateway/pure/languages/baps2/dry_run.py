"""Dry run of programs: in virtual time, every block lasts the same, world equals joints.  Pure; yields the trace (AX-696)."""

from collections.abc import Iterator

from gateway.pure.languages.baps2 import demands, lines
from gateway.pure.languages.baps2.control import PROBES, READINGS, Control
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.feed import SECOND, Feed
from gateway.pure.languages.baps2.frames import to_workpiece
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.tasks import Block, FastWait, Lane, Task, between
from gateway.pure.languages.baps2.translation import Unit
from gateway.pure.languages.baps2.tree import Declared
from gateway.pure.languages.baps2.waiting import KINEMATIC, Wait
from gateway.pure.languages.base.process import ProcessState
from gateway.pure.languages.base.requests import PENDING, Request, RuntimeFault
from gateway.pure.languages.base.trace import Trace

SIX = 6  # axes of a kinematic of which nothing is known
MOST_SYSTEMS = 24
SPARE = 2_000  # turns that cost no time


class DryRun(Control):
    """A control in virtual time."""

    def __init__(self, library: Library, memory: Memory, feed: Feed) -> None:
        super().__init__(library, memory, feed)
        self.trace = Trace()
        self._belts_at = 0
        self._program, self._spare, self._over = "", SPARE, False
        self.belts = dict.fromkeys(feed.belts, 0.0)  # counters at the moment `_belts_at`

    def run(self, program: str) -> RuntimeFault | None:
        """Starts a program and runs up to the end of the feed or of all processes; the fault that kept it from starting."""
        try:
            self.begin(program)
        except RuntimeFault as error:
            return error
        while self.go_on():
            pass
        return None

    def begin(self, program: str) -> None:
        """Starts the program; RuntimeFault: it cannot run."""
        self._program = self.start(program, None).unit.name

    def go_on(self) -> bool:
        """Run one round of all processes; False: the run is over, the trace is complete.  Time stops while the debugger holds one."""
        if self._over:
            return False
        self._advance()
        self._look_for_circles()
        self._round += 1
        busy = self.scheduler.run(self.now) == self.now
        moved = self._advance()
        if any(process.state is ProcessState.HELD for process in self.scheduler.processes):
            return True
        if not (self._round > 1 and moved):
            if busy and self._spare:
                self._spare -= 1
            elif (moment := self._next(busy)) is None or moment > self.feed.until:
                return self._end()
            else:
                self.now = moment
        return bool(self.scheduler.processes) or self._end()

    def _end(self) -> bool:
        self._over = True
        self.filing_close()
        written = {*self.feed.files, *self.filing.written}
        rows = {name: data.hex() for name, data in sorted(self.filing.files.items()) if name in written or name.endswith((".DAT", ".BNR"))}
        self.trace.add(self.now, self._program, 0, "files", files=rows)
        return False

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
        moving = any(lane.moving for lane in self.lanes.values())
        if (waiting and (any(self.feed.belts.values()) or moving)) or (self.specials.records and (any(self.feed.belts.values()) or moving)):
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
            yield task.not_before
            for item in task.queue:
                if isinstance(item, FastWait) and item.due is not None:
                    yield item.due
            if task.began is not None:
                match task.process.waits_for:
                    case demands.Dwell(seconds=seconds):
                        yield task.began + round(seconds * SECOND)
                    case demands.Special(number=4):
                        yield task.began + feed.p5
                    case demands.WaitFor(limit=float() | int() as limit):
                        yield task.began + round(limit * SECOND)

    def event(self, task: Task, event: str, line: int, **facts: object) -> None:
        """One event of the trace."""
        self.trace.add(self.now, task.unit.name, line, event, **facts)

    def _moves_on(self, task: Task, block: Block) -> bool:
        """Begin or continue a block; True: it is over."""
        lane = self.lane(block.kinematic)
        if block.began is None:
            if lane.owner not in (None, task) or self.now < task.not_before:
                return False
            lane.owner, lane.moving = task, block
            block.began, block.start = self.now, lane.position
            try:
                self.specials.functions.begun(block)
            except RuntimeFault as error:
                task.process.line = block.line
                self.scheduler.fail(task.process, error, self.now)
                return False
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

    def _ready(self, task: Task, lane: Lane, block: Block, request: demands.MoveTo) -> None:
        lines.check(request.way, request.via, {**lane.factors, **dict(request.factors)})
        self.specials.functions.prepared(block)

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

    def _on_belt(self, task: Task, request: Request) -> object:
        if isinstance(request, demands.SyncBelt):
            return self._sync(request)
        if isinstance(request, demands.Synchronise) and request.channel:
            lane = self.lane(request.kinematic)
            if lane.owner not in (None, task) or lane.ridden_for(task):
                return PENDING
            lane.off_belt()
            lane.belt, lane.rider = request.channel, task
        elif isinstance(request, demands.Synchronise):
            for _, lane in self.lanes.on_belts(task, request.belt):
                lane.off_belt()
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

    def kinematic_wait(self, task: Task) -> Wait | None:
        """Another process has it, or has it in a synchronous part."""
        first, asked = task.queue[0] if task.queue else None, task.process.waits_for
        name = first.kinematic if isinstance(first, Block) and first.began is None else None
        if name is None and isinstance(asked, demands.Synchronise | demands.MoveTo):
            name = asked.kinematic
        lane = self.lanes.get(name) if name is not None else None
        if lane is None or name is None:
            return None
        if lane.rider is not None and lane.ridden_for(task):
            return Wait(KINEMATIC, name, lane.rider)
        return None if lane.owner is None or lane.owner is task else Wait(KINEMATIC, name, lane.owner, blocks=True)

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
            near = mine and mine[-1] is lane.moving and self.prepared(task)
            where = lane.moving.target if near else between(lane.moving, self.now, self.feed.block)
        if not where:
            where = (0.0,) * self._components(task)
        return to_workpiece(lane.frame, where) if name == "POS" else where

    def _components(self, task: Task) -> int:
        """Of the points of a program that names no kinematic: as many as the points have that are known, else those of six axes."""
        points = {**self.lasting.points.of_file(task.unit.name), **self.feed.points.get(task.unit.name, {})}
        return next((len(point) for point in points.values()), SIX)

    def where(self, kinematic: str) -> tuple[float, ...]:
        """Joints of a kinematic now."""
        lane = self.lane(kinematic)
        return lane.position if lane.moving is None else between(lane.moving, self.now, self.feed.block)

    def measuring_system(self, unit: Unit, number: int) -> float:
        """In the order of the kinematics: their axes, then the belts that the program declares for them (L5276-5290).  One that the
        program does not know may exist: it does not count."""
        order = sorted(unit.program.head.kinematics.items(), key=lambda each: each[1]) or [("", 1)]
        axes, belts = list[float](), list[float]()
        for name, _ in order:
            place = self.where(name)
            count = len(place) - belts_of(unit, name)
            axes += place[:count]
            belts += place[count:]
        found = (*axes, *belts, *(self.belt(each) for each in self.feed.belts))
        if not 1 <= number <= MOST_SYSTEMS:
            raise fault(91, str(number))
        return found[number - 1] if number <= len(found) else 0.0

    def prepared(self, task: Task) -> bool:
        """Return whether the task is in the last two P5 of the last movement, or after it."""
        return task.prepared(self.now, self.feed.block, self.feed.p5)

    def _halted(self, task: Task, lane: Lane) -> None:
        if lane.moving is not None:
            lane.position = between(lane.moving, self.now, self.feed.block)

    def world(self, kinematic: str, joints: tuple[float, ...]) -> tuple[float, ...]:
        """The same numbers."""
        return joints

    def joints(self, kinematic: str, world: tuple[float, ...]) -> tuple[float, ...]:
        """The same numbers."""
        return world

    def image(self, letter: str, bit: int) -> int:
        """Outputs as assigned, inputs as the feed has them."""
        return int(self.outputs.get(bit, 0) if letter == "O" else self.input(bit))


def belts_of(unit: Unit, kinematic: str) -> int:
    """Components of a kinematic's points that are belts: those the program declares for it."""
    declared = [each for each in unit.program.main.declarations if isinstance(each, Declared) and each.type.base == "BELT"]
    return sum(each.type.kinematic == kinematic for each in declared)
