"""Special functions and belts of BAPS2 programs in a cell: statements of the text form for the planner, between two blocks
(AX-982, AX-1030).  Pure.
"""

from typing import Protocol

from gateway.pure.languages.baps2 import demands
from gateway.pure.languages.baps2.cell_asynchronous import CellAsynchronous
from gateway.pure.languages.baps2.cell_belts import PARALLEL, CellBelts
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.machine import Machine
from gateway.pure.languages.baps2.robots import CellRobot
from gateway.pure.languages.baps2.tasks import Lane, Statement, Task
from gateway.pure.languages.baps2.values import Ref, point
from gateway.pure.languages.base.requests import PENDING

LOGIC = {1: "iol", 2: "ppo"}  # special functions, and the words of the text form
BELTS = {15: "belt_param", 21: "belt_type", 28: "set_beltcnt"}
QUEUED = (*LOGIC, 3, *BELTS, 45)
ANYWHERE = 1e9  # mm or deg: a belt value that is always passed
FIRST_INPUT, USER = 464, 120  # RC input of user input 1
EARLY = 1_000  # channels read while the block is prepared


class Cell(Machine, Protocol):
    """The machine of a cell."""

    def robot(self, number: int) -> CellRobot:
        """By its number; a runtime error where the cell has none."""

    def robot_of(self, kinematic: str) -> CellRobot:
        """As programs name it."""

    def lane_of(self, task: Task, number: object) -> tuple[str, Lane]:
        """A kinematic of the program by its number."""

    def queue(self, task: Task, statement: Statement) -> object:
        """Queue the statement after the prepared ones; one that must be alone returns PENDING until it is done."""


class CellActs:
    """Requests of a program other than blocks."""

    def __init__(self, cell: Cell, belts: CellBelts, asynchronous: CellAsynchronous) -> None:
        self._cell, self.belts, self.asynchronous = cell, belts, asynchronous

    def ended(self, task: Task) -> None:
        """Forget an ended process: none of its statements may begin with the block of another one."""
        for name in task.unit.program.head.kinematics or ("",):
            if name in self._cell.lanes and (task.root is None or self._cell.lanes[name].rider is task):
                self._cell.lanes[name].before = ()
        for lane in self._cell.lanes.values():
            if lane.rider is task:
                lane.off_belt()

    # ---- special functions

    def special(self, task: Task, number: int, values: tuple[object, ...]) -> object:
        """1, 2, 3, 15, 21, 28, 45."""
        if task.said is not None:
            return self._over(task)
        if number in LOGIC:
            return self._logic(task, number, values)
        if number in BELTS:
            return self._belt_function(task, number, values)
        return self._machine_position(task, values) if number == 3 else self._move_file(task, values)

    def _over(self, task: Task) -> object:
        """The statement it waits for is done."""
        return PENDING if task.said in task.queue else None

    def _logic(self, task: Task, number: int, values: tuple[object, ...]) -> object:
        """IOL and PPO begin with the next block of the kinematic; a negative number frees the function and sets its value (L4210-4245)."""
        function, kinematic, coordinate, offset = (_whole(values[n]) for n in (0, 1, 2, 5))
        _, lane = self._cell.lane_of(task, kinematic)
        text = f"{LOGIC[number]} {function} {kinematic} {coordinate} {_number(values[3]):.10g} {_number(values[4]):.10g} {offset}"
        if function < 0:
            return self._alone(task, kinematic, text, dummy=True)
        lane.before += (text,)
        return None

    def _belt_function(self, task: Task, function: int, values: tuple[object, ...]) -> object:
        """BELT_PARAM, BELT_TYPE, SET_BELTCNT: for all processes, where the axes rest."""
        number = self.belts.number(_whole(values[0]))
        if function == 21:
            kind = _whole(values[1])
            if kind != 1 and not (kind % 10 in (2, 3) and 0 <= kind // 10 <= 12):
                raise fault(92, str(kind))
        rest = " ".join(f"{_number(value):.10g}" for value in values[1:])
        return self._alone(task, min(self.belts.named(number).robots), f"{BELTS[function]} {number} {rest}")

    def _machine_position(self, task: Task, values: tuple[object, ...]) -> object:
        """MACH_POS: belts in the point are not set (L4119-4208)."""
        name, lane = self._cell.lane_of(task, values[0])
        robot = self._cell.robot_of(name)
        given = point(values[1].get() if isinstance(values[1], Ref) else values[1])
        if len(given) < robot.size:
            raise fault(221, f"{len(given)}, the kinematic has {robot.size}")
        places = tuple(float(each) for each in given[: robot.size])
        if lane.measured is not None:
            lane.measured = places
        return self._alone(task, robot.number, f"mach_pos {robot.text('joints', places)}")

    def _move_file(self, task: Task, values: tuple[object, ...]) -> object:
        """MOVE_FILE of a file that is open for reading (L6956-7212); its content is checked before any motion."""
        name, _ = self._cell.lane_of(task, values[0])
        file, _ = self._cell.units.place(task, str(values[1]))
        opened = self._cell.filing.opened(file, [task.process.number, task.main.process.number], writing=False)
        if opened is None:
            raise fault(63)
        if task.since == self._cell.now:
            return PENDING  # data written in this turn is on the disk with the next one
        robot, flags = self._cell.robot_of(name), values[3].get() if isinstance(values[3], Ref) else values[3]
        row = flags if isinstance(flags, tuple) else ()
        modulo = ",".join("-" if each is None else f"{each:g}" for each in (*row, *[None] * robot.size)[: robot.size])
        run = f"move_file {file} base={_whole(values[2])} modulo={modulo}"
        return self._alone(task, robot.number, f"read_begin {file} {opened.place}", run, f"close {file}", block=True)

    def reference(self, task: Task, kinematic: str) -> object:
        """REF_PNT: all axes of the kinematic; the program waits for the end of the reference run."""
        if task.said is not None:
            return self._over(task)
        return self._cell.queue(task, Statement(self._cell.robot_of(kinematic).number, (), task.process.place, alone=True, reference=True))

    def _alone(self, task: Task, robot: int, *texts: str, dummy: bool = False, block: bool = False) -> object:
        self._cell.robot(robot)
        return self._cell.queue(task, Statement(robot, texts, task.process.place, alone=True, dummy=dummy, block=block))

    # ---- belts

    def sync(self, task: Task, request: demands.SyncBelt) -> object:
        """SYNC: the program waits, and the counter is set; in a synchronous part it is lessened, and the robot stays on its belt."""
        if task.said is not None:
            return self._over(task)
        number = self.belts.number(request.channel)
        belt = self.belts.named(number)
        text = f"sync {belt.name} "
        if request.test is None:
            text += f"{request.sign[0]}= {self.belts.length(number, request.at)}"
        elif 1 <= request.input % EARLY <= USER:
            text += f"input={'' if request.level else '!'}{FIRST_INPUT + request.input % EARLY - 1}"
        elif request.test():
            text += f">= {self.belts.length(number, -ANYWHERE)}"
        else:
            return PENDING
        name = next((name for name, lane in self._cell.lanes.items() if lane.belt), None)
        if name is None:
            return self._alone(task, min(belt.robots), text)
        robot = self._cell.robot_of(name)
        statement = Statement(robot.number, (text,), task.process.place, dummy=True)
        return self._cell.queue(task, statement)

    def synchronise(self, task: Task, request: demands.Synchronise) -> object:
        """SYNCHRON and SYNCHRON_END; the blocks after them are prepared.  PENDING: another program has the kinematic on its belt."""
        kinematic, channel = request.kinematic, request.channel
        if not channel:
            for name, lane in self._cell.lanes.on_belts(task, request.belt):
                lane.off_belt()
                self._cell.queue(task, Statement(self._cell.robot_of(name).number, ("synchron_end",), task.process.place))
            return None
        lane, robot = self._cell.lane(kinematic), self._cell.robot_of(kinematic)
        if lane.ridden_for(task):
            return PENDING
        number = self.belts.number(channel)
        belt = self.belts.named(number)
        if lane.belt:
            raise fault(20)
        if robot.number not in belt.robots:
            raise fault(93, str(number))
        text = f"synchron {belt.name}"
        if self.belts.kind(number) != PARALLEL:
            at = lane.belt_values.get(number, self.belts.counter(number))
            text += f" at={self.belts.length(number, at)}"
        lane.belt, lane.rider = channel, task
        self._cell.queue(task, Statement(robot.number, (text,), task.process.place))
        return None

    def target(self, robot: CellRobot, lane: Lane, request: demands.MoveTo, values: tuple[float, ...]) -> str:
        """Keys of a block in a synchronous part; remembers the belt values of a point (those after the axes)."""
        followed = self.belts.followed(robot.number)
        extra = values[robot.size :]
        if len(extra) > len(followed):
            raise fault(221, f"{len(values)}, the kinematic has {robot.size} and follows {len(followed)} belts")
        found = dict(zip(followed, extra, strict=False))
        for number, value in found.items():
            before = lane.belt_values.get(number, self.belts.counter(number)) if request.relative else 0.0
            lane.belt_values[number] = before + value
        number = lane.belt % 500
        if number not in found:
            return ""
        parallel = self.belts.kind(number) == PARALLEL
        if parallel and request.relative:
            return ""
        return f"belt={self.belts.length(number, found[number])}"

    def cam(self, lane: Lane, shares: tuple[float, float, float], factors: dict[str, float]) -> str:
        """Sections of a cam: A and D are ways of the belt; D is A where the program sets none (L6357-6370, L6410-6450)."""
        first = factors.get("A", 0.0) * factors.get("AFACTOR", 1.0) * shares[1]
        third = factors.get("D", factors.get("A", 0.0)) * factors.get("DFACTOR", 1.0) * shares[2]
        number = lane.belt % 500
        return f"camin={self.belts.length(number, first)} camout={self.belts.length(number, third)}"


def _whole(value: object) -> int:
    return int(value) if isinstance(value, int | float) else 0


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else 0.0
