"""Movement of BAPS2 programs in a cell: prepared blocks and statements are handed on to the planner.  Pure."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace

from gateway.pure.image.records.interpreter import FAST, FIRST_FAST
from gateway.pure.languages.baps2 import demands, lines
from gateway.pure.languages.baps2.cell_acts import CellActs
from gateway.pure.languages.baps2.cell_asynchronous import CellAsynchronous
from gateway.pure.languages.baps2.cell_belts import CAM, CellSetup
from gateway.pure.languages.baps2.cell_view import EARLY, FIRST_INPUT, RUN_ON, USER, CellView
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.feed import SECOND
from gateway.pure.languages.baps2.frames import to_workpiece
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.lines import Wanted
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.robots import CellRobot
from gateway.pure.languages.baps2.tasks import Block, FastWait, Lane, Output, Release, Statement, Task
from gateway.pure.languages.baps2.waiting import KINEMATIC, Wait
from gateway.pure.languages.baps2.working_range import check_range, range_keys
from gateway.pure.languages.base.hosting import Port
from gateway.pure.languages.base.path import Paths, Stretch
from gateway.pure.languages.base.process import ProcessState
from gateway.pure.languages.base.requests import PENDING, Ns, RuntimeFault

DRY_NS = 100_000_000  # idle time after which the order is given back


class CellMotion(CellView):
    """What programs move.  one: robots move one at a time."""

    def __init__(
        self, library: Library, memory: Memory, port: Port, robots: Sequence[CellRobot], p5: Ns, setup: CellSetup, *, one: bool
    ) -> None:
        super().__init__(library, memory, port, robots, p5, setup)
        self.paths = Paths(port, len(robots), one=one)
        self.acts = CellActs(self, self.belts, CellAsynchronous(self))
        self._systems: dict[int, tuple[float, ...]] = {}  # ticket of a stretch -> workpiece system the planner has

    def path_given(self, ticket: int, job: int) -> None:
        """The robot moves for a program from now on."""
        stretch = self.paths.given(ticket, job)
        if stretch is not None:
            if stretch.whole:
                self.port.whole(job)
            for text in lines.head(self.robots[stretch.robot - 1]):
                self.port.line(job, text)

    def _settle(self) -> None:
        """Run the blocks handed on if nothing follows soon; withdraw an order that is no longer needed."""
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

    def _ready(self, task: Task, lane: Lane, block: Block, request: demands.MoveTo) -> None:
        until = "" if request.until is None else self._until(request.until, request)
        factors = {**lane.factors, **dict(request.factors)}
        robot = self.robot_of(request.kinematic)
        how = request.way, request.via, request.joint, request.relative
        lines.check(request.way, request.via, factors, self._presets(robot.number))
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
            if block.farther is not None and not block.met:
                block.wanted, block.farther, block.stretch = block.farther, None, None
                return False
            self.lane(block.kinematic).measured = None  # the cycle's measurement is newer
        return True

    def _hand_on(self, task: Task) -> None:
        """What is prepared goes to the planner, as far as it follows without a question."""
        under_way, last, through = 0, None, None
        for item in list(task.queue):
            if isinstance(item, FastWait):
                return
            if isinstance(item, Output | Release):
                continue
            if isinstance(item, Statement):
                if item.stretch is None and not self._hand_on_statement(task, item, first=last is None):
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

    def _hand_on_statement(self, task: Task, item: Statement, *, first: bool) -> bool:
        """Hand on the statement.  Return False when it must be alone and is not the first, or its kinematic accepts none now."""
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
            path.hand_on(stretch, text, item.place, block=False)
        if item.dummy:
            zeros = " ".join(["0"] * self.robot(item.robot).size)
            item.index = path.hand_on(stretch, f"ptp rel joints {zeros}", item.place)
        elif item.block:
            stretch.count += 1
            stretch.places.append(item.place)
        item.stretch = stretch
        if item.alone:
            path.release(task)
        return True

    def queue(self, task: Task, statement: Statement) -> object:
        """Queue the statement after the prepared ones; PENDING until one that is waited for is done."""
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
            self.paths.of(stretch.robot).hand_on(stretch, text, item.place, block=False)
        frame = item.wanted.frame
        if self._systems.get(stretch.ticket) != frame:
            self._systems[stretch.ticket] = frame
            for text in lines.system(frame):
                self.paths.of(stretch.robot).hand_on(stretch, text, item.place, block=False)
        near, shares = self.lane(item.kinematic).position, self.port.view.channels.factors
        text = lines.line(self._leg(item, item.wanted), near, shares, None if through is None else through.wanted)
        item.index = self.paths.of(stretch.robot).hand_on(stretch, text, item.place)
        item.stretch = stretch
        if through is not None:
            through.index, through.stretch = item.index, stretch

    def _leg(self, item: Block, wanted: Wanted) -> Wanted:
        """As far as one block of the planner goes; the rest follows where UNTIL is not met before."""
        most = None if item.until is None else item.until.limit
        if item.until is None or (most is not None and most > lines.LEG_S):
            return wanted
        leg = lines.leg(wanted, self.where(item.kinematic), self.port.view.channels.factors)
        if leg is not None and most is None:
            keys = " ".join(each for each in wanted.until.split() if not each.startswith(("wait=", "delay=")))
            item.farther = replace(wanted, until=keys, target=lines.left(wanted, leg))
        return leg or wanted

    def _act(self, task: Task) -> bool:
        try:
            item = task.queue[0]
            if isinstance(item, Statement) and not self._done(task, item):
                return False
            return super()._act(task)
        except RuntimeFault as error:
            first = task.queue[0] if task.queue else None
            if isinstance(first, Block):
                task.process.place = first.place
            self.scheduler.fail(task.process, error, self.now)
            return False

    def _halted(self, task: Task, lane: Lane) -> None:
        self.paths.forget(task)

    def kinematic_wait(self, task: Task) -> Wait | None:
        """Another process moves it, or has it in a synchronous part."""
        asked = task.process.waits_for
        if isinstance(asked, demands.Synchronise | demands.MoveTo):
            lane = self.lanes.get(asked.kinematic)
            if lane is not None and lane.rider is not None and lane.ridden_for(task):
                return Wait(KINEMATIC, asked.kinematic, lane.rider)
        first = task.queue[0] if task.queue else None
        if not isinstance(first, Block) or first.stretch is not None:
            return None
        robot = self.robot_of(first.kinematic).number
        now = self.paths.of(robot).now
        if now is None or now.owner is task or not isinstance(now.owner, Task):
            return None
        name = next((name for name, number in self.lanes.numbers.items() if number == now.robot), first.kinematic)
        return Wait(KINEMATIC, first.kinematic if now.robot == robot else name, now.owner, blocks=not self._rides(now.robot))

    @abstractmethod
    def _still(self, task: Task) -> bool:
        """Tested WITHOUT movement."""

    def prepared(self, task: Task) -> bool:
        """Where everything that was prepared is run."""
        return not any(isinstance(item, Block | FastWait) for item in task.queue)
