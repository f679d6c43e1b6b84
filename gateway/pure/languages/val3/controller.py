"""State of a controller that instructions act on: tasks, inputs and outputs, arm, log, events.  `Machine` runs it."""

import datetime
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.dates import date_at
from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.errors import Rte, help_text
from gateway.pure.languages.val3.loader import Loader, family_of_arm
from gateway.pure.languages.val3.moves import Moves
from gateway.pure.languages.val3.pages import PageBoard, Prompt
from gateway.pure.languages.val3.robot_state import RobotState
from gateway.pure.languages.val3.screen import Screen
from gateway.pure.languages.val3.sockets import sockets_in
from gateway.pure.languages.val3.tasks import SYSTEM_CYCLE, Frame, Line, Owner, Step, Task
from gateway.pure.languages.val3.values import FrameV, ToolV
from gateway.pure.languages.val3.virtual_io import Point, VirtualIo
from gateway.pure.languages.val3.virtual_sio import VirtualSio
from motion.val3.cartesian import Arm

MOST_LOG = 10_000
LOG_A_CYCLE = 50  # lines of the log in one system cycle; the next is lost (L3140)
Loads = Callable[[Owner, str, str, str, str], int]


@dataclass(frozen=True, slots=True)
class Event:
    """An entry of the event ring: type 0 popup, 1 history, 2 log."""

    id: int
    type: int
    info: str


@dataclass(slots=True)
class Latch:
    """The position latch: armed, then caught at the next rising edge."""

    source: Point | None = None
    seen_low: bool = False
    position: tuple[float, ...] | None = None

    def arm(self, source: Point) -> None:
        """setLatch."""
        self.source, self.seen_low, self.position = source, source.value == 0, None

    def tick(self, joints: Callable[[], tuple[float, ...]]) -> None:
        """Once a cycle."""
        if self.source is None:
            return
        if self.source.value == 0:
            self.seen_low = True
        elif self.seen_low:
            self.position, self.source = joints(), None


def _no_library(own: Owner, identifier: str, folder: str, name: str, path: str) -> int:
    return 39


@dataclass(eq=False)
class Controller:
    """`moves_or_none` None: no arm."""

    disk: Disk
    moves_or_none: Moves | None = None
    line_ns: Ns = 1_000
    robot: RobotState = field(default_factory=RobotState)
    strict: bool = False
    references: Mapping[str, Sequence[float]] = field(default_factory=dict)
    licences: Mapping[str, str] = field(default_factory=dict)
    profiles: Mapping[str, str] = field(default_factory=lambda: {"default": ""})
    texts: Mapping[str, Mapping[int, str]] = field(default_factory=dict)  # of run-time errors, language -> code; empty: English

    def __post_init__(self) -> None:
        self.axes = len(self.moves_or_none.units) if self.moves_or_none is not None else 6
        self.family = family_of_arm(self.axes) if self.moves_or_none is not None else ""
        self.loader = Loader(self.disk, self.axes, family=self.family, strict=self.strict)
        self.arm: Arm | None = self.moves_or_none.geometry if self.moves_or_none is not None else None
        self.world, self.flange = FrameV(root=True), ToolV(root=True)
        self.flange.gripper.link = "valve1"  # as of every tool (L4923)
        self.io, self.sio, self.screen, self.latch = VirtualIo(), VirtualSio(), Screen(), Latch()
        self.pages = PageBoard(self.io)
        self.keyed = False  # get() waits for a key, which a virtual run has
        self.operator = False  # prompts wait for an answer; without an operator they are answered at once
        self.answers: list[str] = []
        self.prompts: list[Prompt] = []  # in the order in which they were asked; the operator sees and answers the first
        self.tasks: list[Task] = []
        self.current: Task | None = None
        self.log: list[str] = []
        self.popups: list[str] = []
        self.events: list[Event] = []
        self.event_count = 0
        self.payload: tuple[float, tuple[float, ...], tuple[float, ...]] = (0.0, (0.0,) * 6, (0.0,))
        self.clock: Ns = 0  # at the begin of the turn
        self.epoch: Ns = 0  # at which the clock begins, after the date of a virtual run
        self.next_tick: Ns = 0
        self.turn = self.left = 0
        self.long_turn = False
        self.gen: Line | None = None
        self.loads: Loads = _no_library
        self.ended = False
        self.halted = False  # by a debugger: no time passes
        self.watched: Callable[[object, int, Step], Step] | None = None  # what a debugger makes of each step of a program
        self._at = 0  # whose turn it is
        self._quiet = 0  # turns since the last line
        self._logged = 0

    # ---- what instructions ask -------------------------------------------------------------------------------------------
    @property
    def moves(self) -> Moves:
        """153 without an arm."""
        if self.moves_or_none is None:
            raise Rte(153, "there is no arm")
        return self.moves_or_none

    @property
    def now(self) -> Ns:
        """In the middle of a turn, too."""
        return self.clock + (self.turn - self.left) * self.line_ns

    @property
    def current_is_synchronous(self) -> bool:
        """Of the task that runs."""
        return self.current is not None and self.current.period > 0

    @property
    def date(self) -> datetime.datetime:
        """Date and time of now."""
        return date_at(self.now + self.epoch)

    def expect(self, moment: Ns) -> None:
        """The current task waits until then at the latest."""
        if self.current is not None:
            self.current.deadline = moment

    def task(self, owner: Owner, name: str) -> Task | None:
        """Only those created by the same application or library are seen."""
        return next((task for task in self.tasks if task.name == name and task.owner is owner), None)

    def add(self, task: Task) -> None:
        """Behind those that are there."""
        task.rest = task.priority
        self._end_long_turn()
        if task.period:
            task.due = (self.now // SYSTEM_CYCLE + 1) * SYSTEM_CYCLE
        self.tasks.append(task)
        self._quiet = 0

    def _end_long_turn(self) -> None:
        """Another task is there: a turn that had the processor alone ends with this line."""
        if self.long_turn:
            self.turn -= self.left
            self.left = 0

    def restarted(self, task: Task) -> None:
        """Continue a stopped task."""
        task.rest = task.priority
        self._end_long_turn()
        self._quiet = 0

    def kill(self, task: Task) -> None:
        """Gone for good."""
        task.dead = True
        if task in self.tasks:
            at = self.tasks.index(task)
            del self.tasks[at]
            if at < self._at:
                self._at -= 1
        if task.waiting is not None and task is not self.current:
            task.waiting.close()
        for frame in task.frames:  # its programs are left, too
            self.forget_sockets(frame)
        self._quiet = 0

    def forget_sockets(self, frame: Frame) -> None:
        """sio variables of a program end with it (L2646)."""
        for at in frame.program.sockets:
            for variable in sockets_in(frame.v[at]):
                self.sio.forget(variable)

    def help(self, code: int) -> str:
        """The description of a code in the language of the controller (L3635); "" where there is none."""
        return self.texts.get(self.robot.language, {}).get(code) or help_text(code)

    def note(self, text: str, source: str) -> bool:
        """A line of the log; false: too many at once."""
        if self._logged >= LOG_A_CYCLE and source == "USR":
            return False
        self._logged += 1
        stamp = self.date.strftime("%d/%m/%y %H:%M:%S")
        self.log.append(f"[{stamp}]: <0x{self.event_count + 1:04x}> {source}:{text}")
        del self.log[:-MOST_LOG]
        self._event(2, text)
        return True

    def popup(self, text: str) -> None:
        """A popup of the operator."""
        self.popups.append(text)
        del self.popups[:-MOST_LOG]
        self._event(0, text)

    def _event(self, kind: int, text: str) -> None:
        self.event_count += 1
        self.events.append(Event(self.event_count, kind, text))
        del self.events[:-20]
