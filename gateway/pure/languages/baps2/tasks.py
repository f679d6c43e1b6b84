"""Processes of the control and the blocks each has prepared; the kinematics they move (rho 3 releases L7949-7994, spec 4.17, 5.5)."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from gateway.pure.languages.baps2.demands import Until
from gateway.pure.languages.baps2.lines import Wanted
from gateway.pure.languages.baps2.translation import Unit
from gateway.pure.languages.base.path import Stretch
from gateway.pure.languages.base.process import Place, Process
from gateway.pure.languages.base.requests import RuntimeFault

Peek = Callable[[], dict[str, object]]
Poke = Callable[[str, object], None]
MOST_PREPARED = 11  # blocks prepared while one runs


@dataclass(slots=True, eq=False)
class Block:
    """A movement that is prepared.  `start` is filled in when it begins."""

    number: int
    kinematic: str
    target: tuple[float, ...]
    place: Place
    until: Until | None = None
    start: tuple[float, ...] = ()
    began: int | None = None
    was: bool = False  # the condition a moment ago
    met: bool | None = None
    wanted: Wanted | None = None  # in a cell
    farther: Wanted | None = None  # the remainder of a target too far for one block of the planner
    index: int = 0  # among the blocks of its stretch
    stretch: Stretch | None = None  # it was handed on with
    stops: bool = True  # at its end
    before: tuple[str, ...] = ()  # statements that begin with it

    @property
    def line(self) -> int:
        """Of the program."""
        return self.place.line


@dataclass(slots=True, eq=False)
class Output:
    """An output that acts where the block before ends."""

    channel: int
    value: int | float
    line: int


@dataclass(slots=True, eq=False)
class Release:
    """The end of an EXCLUSIVE part: the semaphore is given away where the block before ends."""

    semaphore: tuple[str, str]


@dataclass(slots=True, eq=False)
class FastWait:
    """A wait for a high-speed input among the blocks; `delay` after it in ns; `kinematic`: of the traverse block before it, whose next
    block it holds (L1621-1631), None: there was none."""

    until: Until
    delay: int
    kinematic: str | None = None
    due: int | None = None


@dataclass(slots=True, eq=False)
class Statement:
    """Statements for the planner between two blocks (in a cell).  `alone`: the axes rest before and after it, and the program waits;
    `dummy`: a block without a way that carries it."""

    robot: int
    texts: tuple[str, ...]
    place: Place
    alone: bool = False
    dummy: bool = False
    block: bool = False  # one of the texts is a block
    reference: bool = False  # REF_PNT: an order of its own, without texts
    index: int = 0  # of its dummy among the blocks of its stretch
    stretch: Stretch | None = None  # it was handed on with


Item = Block | Output | Release | FastWait | Statement


@dataclass(slots=True)
class Lane:
    """A kinematic: where it is, where its last prepared block ends."""

    position: tuple[float, ...] = ()
    planned: tuple[float, ...] = ()
    owner: "Task | None" = None
    moving: Block | None = None
    measured: tuple[float, ...] | None = None
    frame: tuple[float, ...] = (0.0,) * 6
    belt: int = 0  # channel while it is synchronous
    rider: "Task | None" = None  # the process that has it in its synchronous part: those of other programs wait (L6111)
    belt_way: float = 0.0  # of the last block there, whose sign the next one must have
    belt_values: dict[int, float] = field(default_factory=dict)  # belt -> its value in the last point that was programmed
    before: tuple[str, ...] = ()  # statements that begin with its next block (in a cell)
    factors: dict[str, float] = field(default_factory=dict)
    limits: dict[str, tuple[float, ...]] = field(default_factory=dict)
    most: int = MOST_PREPARED
    distance: float = 0.0  # special function 42
    referenced: bool = False

    def ridden_for(self, task: "Task") -> bool:
        """Whether another program has it in a synchronous part."""
        return self.rider is not None and self.rider.main is not task.main

    def off_belt(self) -> None:
        """Its synchronous part is over."""
        self.belt, self.belt_way, self.rider = 0, 0.0, None


class Lanes(dict[str, Lane]):
    """Kinematics by the names that programs have for them.  numbers: name -> number of the kinematic."""

    def __init__(self) -> None:
        super().__init__()
        self.numbers: dict[str, int] = {}
        self.blocks = 0  # prepared so far, on any of them

    def on_belts(self, task: "Task", channel: int) -> list[tuple[str, Lane]]:
        """Return the kinematics that SYNCHRON_END of this process releases from their belt: its own on this belt (0: on any), else those
        of its program.
        """
        found = [(name, lane) for name, lane in self.items() if lane.rider is not None and channel in (0, lane.belt)]
        own = [(name, lane) for name, lane in found if lane.rider is task]
        return own or [(name, lane) for name, lane in found if not lane.ridden_for(task)]

    def renamed(self, kinematic: str) -> Lane | None:
        """The kinematic of this number where another program names it otherwise: its workpiece system and position are the same."""
        number = self.numbers.get(kinematic)
        return next((lane for name, lane in self.items() if number is not None and self.numbers.get(name) == number), None)


@dataclass(slots=True, eq=False)
class Task:
    """What the machine knows of a process.  `root`: the main process of branches."""

    process: Process
    unit: Unit
    kind: str
    root: "Task | None" = None
    starter: "Task | None" = None
    queue: deque[Item] = field(default_factory=deque)
    since: int = 0  # the moment of the request it waits for
    began: int | None = None  # the moment from which a wait counts
    block: Block | None = None  # of the move it waits for
    said: Statement | None = None  # that it waits for
    not_before: int = 0  # the moment at which its next block begins at the earliest
    last: str | None = None  # kinematic of its last traverse block
    circle: str | None = None  # kinematic of a circle of which the first point is given
    children: list["Task"] = field(default_factory=list)
    semaphores: list[tuple[str, str]] = field(default_factory=list)
    # semaphore -> of each of its parts: what was prepared before it
    entered: dict[tuple[str, str], list[Item | None]] = field(default_factory=dict)
    conditions: dict[str, int] = field(default_factory=dict)
    held: dict[str, bytes] = field(default_factory=dict)  # output that is kept open
    names: dict[str, str] = field(default_factory=dict)  # file variable -> name of the file, by ASSIGN
    moment: int = -1  # of the last reading
    readings: int = 0  # in that moment
    depth: int = 0
    round: int = 0
    how: str = ""  # it ends
    halted: bool = False
    run: int = 0  # number of the process to those outside
    tested: bool = False  # in the test system: breakpoints and single step act
    watches: dict[str, tuple[Peek, Poke]] = field(default_factory=dict)  # program -> its variables, of a tested process
    branch_fault: tuple[RuntimeFault, str] | None = None  # of a branch that took it along, and its place

    @property
    def main(self) -> "Task":
        """The main process."""
        return self.root or self

    def blocks(self, kinematic: str | None = None) -> list[Block]:
        """Prepared movements, the running one first."""
        return [item for item in self.queue if isinstance(item, Block) and kinematic in (None, item.kinematic)]

    def prepared(self, now: int, block_ns: int, p5: int) -> bool:
        """Whether the last movement is in its last two P5 or over: then inputs and positions are read."""
        if any(isinstance(item, FastWait) for item in self.queue):
            return False
        blocks = self.blocks()
        if not blocks:
            return True
        last = blocks[-1]
        return len(blocks) == 1 and last.began is not None and now >= last.began + block_ns - 2 * p5


def between(block: Block, now: int, block_ns: int) -> tuple[float, ...]:
    """Where a running block is: on a straight line."""
    if block.began is None:
        return block.start
    part = min(1.0, (now - block.began) / block_ns)
    return tuple(a + (b - a) * part for a, b in zip(block.start, block.target, strict=True))


def size_of(unit: Unit, kinematic: str) -> int:
    """Components of a kinematic's points as the program names them; 0: it names none."""
    head = unit.program.head
    tables = (head.joint_names, head.world_names)
    return max((len(table.get(key, ())) for table in tables for key in (kinematic, "")), default=0)
