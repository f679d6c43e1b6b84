"""Runs an application: tasks in turns, synchronous tasks on the 4 ms grid, life cycle.  Source: VAL 3 reference 2.1, 5, L499-598, L3338-3397.

Time is virtual: each line costs `line_ns`.  Tasks that only wait cost nothing; then time goes on to the next cycle.
"""

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3 import (
    arrays,
    builtin_geometry,
    builtin_io,
    builtin_libraries,
    builtin_moves,
    builtin_pages,
    builtin_robot,
    builtin_tasks,
    numbers,
    strings,
)
from gateway.pure.languages.val3.builtin_pages import date_at
from gateway.pure.languages.val3.disk import Disk, application_of
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.instance import Instance, Program
from gateway.pure.languages.val3.loader import Loader, family_of_arm
from gateway.pure.languages.val3.model import Application
from gateway.pure.languages.val3.moves import Moves
from gateway.pure.languages.val3.robot_state import RobotState
from gateway.pure.languages.val3.screen import Screen
from gateway.pure.languages.val3.tasks import LINES_A_CYCLE, RUNNING, SYSTEM_CYCLE, Task
from gateway.pure.languages.val3.translate import CALL, END
from gateway.pure.languages.val3.values import FrameV, ToolV, copied, equal, literal
from gateway.pure.languages.val3.virtual_io import Point, VirtualIo
from gateway.pure.languages.val3.virtual_sio import VirtualSio
from gateway.pure.val3_sio.errors import Val3Error
from motion.errors import MotionError
from motion.val3.cartesian import Arm
from motion.val3.errors import RuntimeFault

PLAIN = (numbers, strings, arrays)
BOUND = (builtin_geometry, builtin_io, builtin_libraries, builtin_moves, builtin_pages, builtin_robot, builtin_tasks)
OPERATORS = frozenset(
    "io_get io_put sio_write_string sio_write_num sio_read_string sio_read_num joint_sum joint_difference joint_above joint_below "
    "trsf_product trsf_inverse".split()
)
MOST_LOG = 10_000
LOG_A_CYCLE = 50  # lines of the log in one system cycle; the next is lost (L3140)
START_PRIORITY = 10


@dataclass(frozen=True, slots=True)
class Event:
    """Of the event ring: type 0 popup, 1 history, 2 log."""

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


@dataclass(eq=False)
class Machine:
    """One controller in virtual time.  `moves` None: no arm."""

    disk: Disk
    moves_or_none: Moves | None = None
    line_ns: Ns = 1_000
    robot: RobotState = field(default_factory=RobotState)
    pages: Callable[[str], bool] = lambda path: False
    strict: bool = False
    references: Mapping[str, Sequence[float]] = field(default_factory=dict)
    licences: Mapping[str, str] = field(default_factory=dict)
    profiles: Mapping[str, str] = field(default_factory=lambda: {"default": ""})

    def __post_init__(self) -> None:
        self.axes = len(self.moves_or_none.units) if self.moves_or_none is not None else 6
        self.family = family_of_arm(self.axes) if self.moves_or_none is not None else ""
        self.loader = Loader(self.disk, self.axes, family=self.family, strict=self.strict)
        self.arm: Arm | None = self.moves_or_none.geometry if self.moves_or_none is not None else None
        self.world, self.flange = FrameV(root=True), ToolV(root=True)
        self.io, self.sio, self.screen, self.latch = VirtualIo(), VirtualSio(), Screen(), Latch()
        self.tasks: list[Task] = []
        self.shared: dict[str, Instance] = {}
        self.application: Instance | None = None
        self.current: Task | None = None
        self.log: list[str] = []
        self.popups: list[str] = []
        self.events: list[Event] = []
        self.event_count = 0
        self.payload: tuple[float, tuple[float, ...], tuple[float, ...]] = (0.0, (0.0,) * 6, (0.0,))
        self.clock: Ns = 0  # at the begin of the turn
        self.next_tick: Ns = 0
        self.turn = self.left = 0
        self.gen: object = None
        self.call: tuple[Program, list[object], int] | None = None
        self.ended = False
        self.stopping = False
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

    def expect(self, moment: Ns) -> None:
        """The current task waits until then at the latest."""
        if self.current is not None:
            self.current.deadline = moment

    def task(self, owner: Instance, name: str) -> Task | None:
        """Only those created by the same application or library are seen."""
        return next((task for task in self.tasks if task.name == name and task.owner is owner), None)

    def add(self, task: Task) -> None:
        """Behind those that are there."""
        task.rest = task.priority
        if task.period:
            task.due = (self.now // SYSTEM_CYCLE + 1) * SYSTEM_CYCLE
        self.tasks.append(task)
        self._quiet = 0

    def restarted(self, task: Task) -> None:
        """A stopped task goes on."""
        task.rest = task.priority
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
        self._quiet = 0

    def note(self, text: str, source: str) -> bool:
        """A line of the log; false: too many at once."""
        if self._logged >= LOG_A_CYCLE and source == "USR":
            return False
        self._logged += 1
        stamp = date_at(self.now).strftime("%d/%m/%y %H:%M:%S")
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

    def has_page(self, own: Instance, name: str) -> bool:
        """Whether the application has a page of that name."""
        start = f"{own.loaded.app.path}/" if own.loaded.app.path else ""
        return self.disk.read(f"{start}interface/{name}.html") is not None or self.pages(name)

    # ---- applications ----------------------------------------------------------------------------------------------------
    def instance(self, folder: str, name: str, prefix: str) -> Instance | None:
        """An application in memory, once for all who load it; None where it has faults."""
        key = f"{folder}/{name}".lower()
        if key in self.shared:
            return self.shared[key]
        loaded = self.loader.load(folder, name)
        if loaded is None or loaded.faults.errors:
            for fault in loaded.faults if loaded is not None else ():
                self.note(f"(File {fault.position.file}-line {fault.position.line}) {fault.text}", "VAL3")
            return None
        try:
            made = Instance(self, loaded, prefix)
        except Rte as fault:
            self.note(f"{name}: {fault}", "VAL3")
            return None
        made.path = f"Disk://{folder}" if folder else f"Disk://{name}"
        made.names = self._names(made)
        self.shared[key] = made
        for alias, use in loaded.app.libraries.items():
            if use.autoload:
                self.load_library(made, alias, *application_of(use.path, loaded.app.path), use.path)
        return made

    def _names(self, own: Instance) -> dict[str, object]:
        """What the text of a program may use."""
        found: dict[str, object] = {"M": self, "Rte": Rte, "copied": copied, "equal": equal, "programs": own.programs}
        for module in PLAIN:
            found.update({name: each for name, each in vars(module).items() if not name.startswith("_") and callable(each)})
        for module in BOUND:
            for name, each in vars(module).items():
                if (name.startswith("f_") or name in OPERATORS) and getattr(each, "__module__", "") == module.__name__:
                    found[name] = functools.partial(each, own)
        found["literal"] = lambda kind, parts: literal(kind, parts, self)
        found["maker"], found["lib_data"], found["lib_program"] = own.maker, own.public_data, own.public_program
        found["world"], found["flange"] = [self.world], [self.flange]
        found.update({f"g_{name}": container for name, container in own.data.items()})
        return found

    def load_library(self, own: Instance, identifier: str, folder: str, name: str, path: str) -> int:
        """libLoad: codes of L3970-4006."""
        old = own.libraries.get(identifier)
        if old is not None and any(task.owner is old for task in self.tasks):
            return 14
        loaded = self.loader.load(folder, name)
        if loaded is None or not loaded.app.programs and not loaded.app.data and loaded.faults.errors and self.disk.read(loaded.app.project) is None:
            return 39
        found = self.instance(folder, name, own.prefix + identifier)
        if found is None:
            return 24 if any(fault.id == "val3-type" for fault in loaded.faults) else 12
        own.libraries[identifier] = found
        interface = own.loaded.app.interfaces.get(identifier)
        if interface is not None and not _provides(found, interface):
            return 11
        if loaded.app.millimetres != own.loaded.app.millimetres:
            self.note(f"{path}: the length unit is another one", "VAL3")
            return 1
        return 0

    def start(self, own: Instance) -> None:
        """start() in a task of its own."""
        self.application = own
        task = Task(f"{own.loaded.app.name}~", own, START_PRIORITY)
        task.enter(own.programs["start"], [])
        self.add(task)

    def stop(self) -> None:
        """The operator stops: the start task goes at once, then stop() runs."""
        if self.application is None or self.stopping:
            return
        first = self.task(self.application, f"{self.application.loaded.app.name}~")
        if first is not None:
            self.kill(first)
        self._run_stop()

    def _run_stop(self) -> None:
        assert self.application is not None
        self.stopping = True
        name = f"~{self.application.loaded.app.name}"
        self._stop_task = Task(name, self.application, START_PRIORITY)
        self._stop_task.enter(self.application.programs["stop"], [])
        self.add(self._stop_task)

    def _life(self) -> None:
        """After a task has ended."""
        if self.application is None or self.ended:
            return
        if self.stopping:
            if self._stop_task not in self.tasks:
                for task in reversed(list(self.tasks)):
                    self.kill(task)
                self.ended = True
        elif not any(task.owner is self.application for task in self.tasks):
            self._run_stop()

    # ---- time ------------------------------------------------------------------------------------------------------------
    def run(self, until: Ns) -> None:
        """Up to a moment, or the end of the application."""
        while not self.ended and self.clock < until:
            if self.clock >= self.next_tick:
                self._tick()
                continue
            self._slice(min(until, self.next_tick))

    @property
    def stuck(self) -> bool:
        """All tasks are stopped: without the operator nothing happens any more."""
        return all(task.status != RUNNING for task in self.tasks) and (self.moves_or_none is None or self.moves_or_none.idle)

    def _tick(self) -> None:
        """One system cycle: arm, inputs, then synchronous tasks."""
        self.next_tick = (self.clock // SYSTEM_CYCLE + 1) * SYSTEM_CYCLE
        self._logged = 0
        self.sio.now = self.clock
        self.robot.tick(self.clock)
        if self.moves_or_none is not None:
            moves = self.moves_or_none
            moves.blocked = not self.robot.moving_allowed
            failed = moves.step(self.clock / 1e9, self.robot.speed / 100)
            if failed:
                self.note(f"motion: {failed}", "MOTION")
            self.latch.tick(moves.joints)
        for task in [each for each in self.tasks if each.period]:
            if task in self.tasks and task.due <= self.clock:
                self._cycle(task)
        self._quiet = 0

    def _cycle(self, task: Task) -> None:
        """One period of a synchronous task."""
        began = self.clock
        if task.status == RUNNING:
            self._turn(task, LINES_A_CYCLE)
            if task.rest < 0:  # still busy behind the last line
                self._failed(task, Rte(33))
        task.due += task.period
        if self.clock - began > task.period:
            task.due += task.period
            if task.overrun is not None:
                container, place = task.overrun
                container[place] = True  # type: ignore[index]  # the variable given at its creation
        while task.due <= began:
            task.due += task.period

    def _slice(self, until: Ns) -> None:
        """Lines of the asynchronous task whose turn it is; time goes on where all of them wait."""
        asynchronous = [task for task in self.tasks if not task.period]
        if not asynchronous or self._quiet > len(self.tasks):
            wakes = [task.wake for task in asynchronous if task.wake is not None and task.status == RUNNING]
            wakes += [task.deadline for task in asynchronous if task.deadline is not None and task.status == RUNNING]
            self.clock = min([until, *(moment for moment in wakes if moment > self.clock)])
            self._quiet = 0
            return
        if self._at >= len(self.tasks):
            self._at = 0
        task = self.tasks[self._at]
        if task.period or task.status != RUNNING or (task.wake is not None and task.wake > self.clock):
            self._at += 1
            self._quiet += 1
            return
        room = max(-(-(until - self.clock) // self.line_ns), 1)
        used, done = self._turn(task, min(task.rest, room))
        if task in self.tasks:
            task.rest -= used
            if done or task.rest <= 0:
                task.rest = task.priority
                self._at = (self.tasks.index(task) + 1) if task in self.tasks else self._at
        self._quiet = 0 if used else self._quiet + 1

    # ---- lines -----------------------------------------------------------------------------------------------------------
    def _turn(self, task: Task, lines: int) -> tuple[int, bool]:
        """Up to so many lines; how many, and whether the task has nothing more to do now."""
        self.current, self.turn, self.left = task, lines, lines
        task.deadline = None
        done = True
        try:
            done = self._lines(task)
        except Rte as fault:
            self._failed(task, fault)
        except (MotionError, Val3Error, ArithmeticError, LookupError, ValueError, RecursionError, TypeError, AttributeError, AssertionError) as error:
            self._failed(task, as_rte(error))
        used = lines - self.left
        self.clock += used * self.line_ns
        self.turn = self.left = 0
        self.current = None
        if task.period:
            task.rest = 0 if done else -1
        if not task.frames and task in self.tasks:
            self.kill(task)
        if task not in self.tasks:
            self._life()
        return used, done

    def _lines(self, task: Task) -> bool:
        """Whether the task waits, has ended or was stopped; False: its lines are used up."""
        while True:
            frame = task.frames[-1]
            if task.waiting is not None:
                try:
                    task.wake = next(task.waiting)
                    return True
                except StopIteration as stop:
                    task.waiting, task.wake, pc = None, None, stop.value
                if task.dead:
                    return True
            elif self.left == 0:
                return False
            else:
                pc = self._fast(task)
                if pc is None:
                    return False
            if pc >= 0:
                frame.pc = pc
            elif pc == END:
                task.leave()
                if not task.frames:
                    return True
            elif pc == CALL:
                assert self.call is not None
                program, arguments, after = self.call
                task.enter(program, arguments)
                frame.pc = after
            else:
                task.waiting = self.gen  # type: ignore[assignment]  # set by the line that has just run
            if task.dead or task.status != RUNNING:
                return True

    def _fast(self, task: Task) -> int | None:
        """Plain lines one after the other; what the last one returned, None: no line is left."""
        frame = task.frames[-1]
        code, v, pc, left = frame.code, frame.v, frame.pc, self.left
        try:
            while left:
                left -= 1
                self.left = left
                after = code[pc](v)
                if after < 0:
                    return after
                pc = after
            return None
        finally:
            frame.pc = pc

    def _failed(self, task: Task, fault: Rte) -> None:
        """The task stops on its line."""
        if task.waiting is not None:
            task.waiting.close()
            task.waiting = None
        task.status, task.detail, task.wake = fault.code, str(fault), None
        self.note(f"{task.name} {task.program} line {task.line}: error {fault.code} {fault}", "VAL3")


def as_rte(error: Exception) -> Rte:
    """Any error of a line as the code it stops its task with."""
    match error:
        case RuntimeFault():
            return Rte(error.code, error.detail)
        case Val3Error():
            return Rte(int(error.code), str(error))
        case ZeroDivisionError():
            return Rte(10)
        case RecursionError():
            return Rte(41)
        case MotionError():
            return Rte(154, str(error))
        case KeyError():
            return Rte(25)
        case IndexError():
            return Rte(20)
        case ArithmeticError() | ValueError():
            return Rte(11, str(error))
    return Rte(61, f"{type(error).__name__}: {error}")


def _provides(found: Instance, interface: Application) -> bool:
    """Whether all public symbols of the interface are there."""
    app = found.loaded.app
    data = all(name in app.data and app.data[name].public for name, each in interface.data.items() if each.public)
    return data and all(name in app.programs and app.programs[name].public for name, each in interface.programs.items() if each.public)
