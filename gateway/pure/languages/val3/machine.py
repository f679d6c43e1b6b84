"""Runs an application: tasks in turns, synchronous tasks on the 4 ms grid, life cycle.  Source: VAL 3 reference 2.1, 5.

Time is virtual: each line costs `line_ns`.  Tasks that only wait cost nothing; then time advances to the next cycle.
"""

import functools
from dataclasses import dataclass

from gateway.pure.controllers.val3.sio.errors import Val3Error
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
from gateway.pure.languages.val3.controller import Controller
from gateway.pure.languages.val3.disk import PathFault
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.initial_values import literal
from gateway.pure.languages.val3.instance import Instance, Program
from gateway.pure.languages.val3.loader import UNIT
from gateway.pure.languages.val3.model import Application, Declaration, Use
from gateway.pure.languages.val3.program_code import CALL, END
from gateway.pure.languages.val3.robot_state import LOCAL, MANUAL, REMOTE, TEST
from gateway.pure.languages.val3.sealed import SealFault, library_of
from gateway.pure.languages.val3.sockets import sockets_in
from gateway.pure.languages.val3.tasks import LINES_A_CYCLE, RUNNING, SYSTEM_CYCLE, Owner, Task
from gateway.pure.languages.val3.values import copied, equal, passed, places
from motion.errors import MotionError
from motion.val3.errors import RuntimeFault
from motion.val3.stack import Mode

PLAIN = (numbers, strings, arrays)
BOUND = (builtin_geometry, builtin_io, builtin_libraries, builtin_moves, builtin_pages, builtin_robot, builtin_tasks)
OPERATORS = frozenset(
    "io_get io_put sio_write_string sio_write_num sio_read_string sio_read_num joint_sum joint_difference joint_above joint_below "
    "trsf_product trsf_inverse".split()
)
START_PRIORITY = 10
WORKING = {MANUAL: Mode.MANUAL, TEST: Mode.TEST, LOCAL: Mode.LOCAL, REMOTE: Mode.REMOTE}


@dataclass(eq=False)
class Machine(Controller):
    """One controller in virtual time."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.shared: dict[str, Instance] = {}
        self.application: Instance | None = None
        self.stop_task: Task | None = None
        self.call: tuple[Program, list[object], int] | None = None
        self.stopping = False
        self.loads = self._loads

    # ---- applications ----------------------------------------------------------------------------------------------------
    def instance(self, folder: str, name: str, prefix: str) -> Instance | None:
        """An application in memory, once for all who load it; None where it has faults."""
        key = f"{folder}/{name}".lower()
        if key in self.shared:
            return self.shared[key]
        loaded = self.loader.load(folder, name)
        if loaded is None or loaded.faults.errors:
            for line in map(loaded.logged, loaded.faults) if loaded is not None else ():
                self.note(line, "VAL3")
            return None
        try:
            made = Instance(self, loaded, prefix)
        except Rte as fault:
            self.note(f"{name}: {fault}", "VAL3")
            return None
        made.path = f"Disk://{folder}" if folder else f"Disk://{name}"
        made.names = self._names(made)
        self.shared[key] = made
        for variable in sockets_in(list(made.data.values())):
            self.sio.register(variable)
        for alias, use in loaded.app.libraries.items():
            if use.autoload:
                self._autoload(made, alias, use)
        return made

    def _autoload(self, made: Instance, alias: str, use: Use) -> None:
        try:
            code = self.load_library(made, alias, *library_of(self.disk, use.path, made.loaded.app.path, use.password), use.path)
        except (PathFault, SealFault) as fault:
            code = fault.code
        if code > 1:
            self.note(f"library {alias} ({use.path}) is not loaded: {code}", "VAL3")

    def _names(self, own: Instance) -> dict[str, object]:
        """What the text of a program may use."""
        found: dict[str, object] = {"M": self, "Rte": Rte, "copied": copied, "passed": passed, "equal": equal, "programs": own.programs}
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

    def _loads(self, own: Owner, identifier: str, folder: str, name: str, path: str) -> int:
        assert isinstance(own, Instance)
        return self.load_library(own, identifier, folder, name, path)

    def load_library(self, own: Instance, identifier: str, folder: str, name: str, path: str) -> int:
        """libLoad: codes of L3970-4006."""
        old = own.libraries.get(identifier)
        gone = old if old is not None and self._only(own, identifier, old) else None
        if gone is not None and (code := self._in_use(gone)):
            return code
        loaded = self.loader.load(folder, name)
        if loaded is None or (
            not loaded.app.programs and not loaded.app.data and loaded.faults.errors and self.disk.read(loaded.app.project) is None
        ):
            return 39
        key = f"{folder}/{name}".lower()
        if gone is not None and self.shared.get(key) is gone:  # its data are initialised anew (L3935)
            del self.shared[key]
        found = self.instance(folder, name, own.prefix + identifier)
        if found is None:
            if gone is not None:
                self.shared.setdefault(f"{gone.loaded.app.path}/{gone.loaded.app.name}".lower(), gone)
            return 24 if any(fault.id == "val3-type" for fault in loaded.faults) else 12
        own.libraries[identifier] = found
        if gone is not None:
            old_types, types = gone.loaded.app.data, found.loaded.app.data
            alike = [name for name, each in types.items() if name in old_types and _alike(each, old_types[name])]
            self.pages.replaced(gone.data, {name: found.data[name] for name in alike})
            self._unload(gone)
        own.join(identifier)
        interface = own.loaded.app.interfaces.get(identifier)
        if interface is not None and not _provides(found, interface):
            return 11
        units = [loaded.logged(fault) for fault in loaded.faults if fault.id == UNIT]
        if loaded.app.millimetres != own.loaded.app.millimetres:
            units.append(f"{path}: the length unit is another one")
        for line in units:
            self.note(line, "VAL3")
        return 1 if units else 0

    def _in_use(self, library: Instance) -> int:
        """Why it cannot be unloaded: 14 a task of its own, 13 a program of it in another task; 0: it can."""
        if any(task.owner is library for task in self.tasks):
            return 14
        return 13 if any(getattr(frame.program, "owner", None) is library for task in self.tasks for frame in task.frames) else 0

    def _unload(self, library: Instance) -> None:
        """Unload a replaced library (L3945), including the libraries that only it uses."""
        self.shared = {key: each for key, each in self.shared.items() if each is not library}
        for variable in sockets_in(list(library.data.values())):
            self.sio.forget(variable)
        for inner in library.libraries.values():
            if inner is not None and inner is not self.application and inner in self.shared.values() and not self._in_use(inner):
                if not any(inner in each.libraries.values() for each in self.shared.values()):
                    self._unload(inner)

    def _only(self, own: Instance, identifier: str, library: Instance) -> bool:
        """Whether no other identifier has this library: replacing it there unloads it."""
        others = [(each, name) for each in self.shared.values() for name, found in each.libraries.items() if found is library]
        return library is not self.application and others == [(own, identifier)]

    def start(self, own: Instance) -> bool:
        """start() in a task of its own; False: an application runs already (L509)."""
        if self.application is not None and not self.ended:
            self.note(f"{own.loaded.app.name} is not started: {self.application.loaded.app.name} is running", "VAL3")
            return False
        self.application, self.ended, self.stopping = own, False, False
        for fault in own.loaded.faults:
            if fault.id == UNIT:  # L534
                self.popup(fault.text)
                self.note(own.loaded.logged(fault), "VAL3")
        task = Task(f"{own.loaded.app.name}~", own, START_PRIORITY)
        self._begin(task, own.programs["start"])
        return True

    def _begin(self, task: Task, program: Program) -> None:
        fault = task.begin(program)
        self.add(task)
        if fault is not None:
            self._failed(task, fault)

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
        task = Task(f"~{self.application.loaded.app.name}", self.application, START_PRIORITY)
        self.stop_task = task
        self._begin(task, self.application.programs["stop"])

    def _life(self) -> None:
        """After a task has ended."""
        if self.application is None or self.ended:
            return
        if self.stopping:
            if self.stop_task not in self.tasks:
                for task in reversed(list(self.tasks)):
                    self.kill(task)
                self.sio.end_application()
                self.ended = True
        elif not any(task.owner is self.application for task in self.tasks):
            self._run_stop()

    # ---- time ------------------------------------------------------------------------------------------------------------
    def run(self, until: Ns, leap: Ns = 0) -> None:
        """Run up to a moment, or the end of the application.  leap: how far time advances where all tasks wait, even beyond `until`."""
        while not self.ended and not self.halted and self.clock < until:
            if self.clock >= self.next_tick:
                self._tick()
                continue
            self._slice(min(until, self.next_tick), min(max(until, leap), self.next_tick))

    @property
    def stuck(self) -> bool:
        """All tasks are stopped: without the operator nothing happens any more."""
        return all(task.status != RUNNING for task in self.tasks) and (self.moves_or_none is None or self.moves_or_none.idle)

    def _tick(self) -> None:
        """One system cycle: arm, inputs, then synchronous tasks."""
        late = (self.clock - self.next_tick) // SYSTEM_CYCLE
        self.next_tick = (self.clock // SYSTEM_CYCLE + 1) * SYSTEM_CYCLE
        self._logged = 0
        self.sio.now = self.clock
        self.robot.tick(self.clock)
        if not self.io.refresh() and not self.robot.reboot:
            self.robot.overrun()
            self.note("overrun of the synchro task: user boards take longer than the system cycle; start the controller again", "SYS")
        self._move(late)
        self._cycles()

    def _move(self, late: int) -> None:
        """The arm, in the cycle that begins.  late: cycles before it that lines of synchronous tasks have covered."""
        moves = self.moves_or_none
        if moves is None:
            return
        moves.blocked = not self.robot.moving_allowed
        moves.stack.mode = WORKING[self.robot.mode]
        for missed in range(late if moves.timed else 0, -1, -1):
            failed = moves.step((self.clock - missed * SYSTEM_CYCLE) / 1e9, self.robot.speed / 100)
            if failed:
                self.note(f"motion: {failed}", "MOTION")
        self.latch.tick(moves.joints)

    def catch_up(self) -> None:
        """A system cycle that is late: its synchronous tasks alone.  The arm is looked at once a turn, else it seems to rest."""
        self.clock = max(self.clock, self.next_tick)
        self.next_tick = (self.clock // SYSTEM_CYCLE + 1) * SYSTEM_CYCLE
        self.sio.now = self.clock
        self._cycles()

    def _cycles(self) -> None:
        for task in [each for each in self.tasks if each.period]:
            if task in self.tasks and task.due <= self.clock and not self.halted:
                self._cycle(task)
        self._quiet = 0

    def _cycle(self, task: Task) -> None:
        """One period of a synchronous task."""
        began = self.clock
        if task.status == RUNNING:
            self._turn(task, LINES_A_CYCLE)
            if task.rest < 0 and not self.halted:  # still busy after the last line
                self._failed(task, Rte(33))
        task.due += task.period
        if self.clock - began > task.period:  # the next one is left out (L3397), and each that would begin before this one is over
            task.due += max(task.period, -(-(self.clock - task.due) // task.period) * task.period)
            if task.overrun is not None:
                container, place = task.overrun
                places(container)[place] = True
        while task.due <= began:
            task.due += task.period

    def _slice(self, until: Ns, leap: Ns) -> None:
        """Run lines of the asynchronous task whose turn it is; where all of them wait, time advances up to `leap`."""
        asynchronous = [task for task in self.tasks if not task.period]
        if not asynchronous or self._quiet > len(self.tasks):
            wakes = [task.wake for task in asynchronous if task.wake is not None and task.status == RUNNING]
            wakes += [task.deadline for task in asynchronous if task.deadline is not None and task.status == RUNNING]
            self.clock = min([leap, *(moment for moment in wakes if moment > self.clock)])
            self._quiet = 0
            return
        if self._at >= len(self.tasks):
            self._at = 0
        task = self.tasks[self._at]
        if task.period or task.status != RUNNING or (task.wake is not None and task.wake > self.clock):
            self._at += 1
            self._quiet += 1
            return
        others = [other for other in asynchronous if other is not task and other.status == RUNNING]
        alone = all(other.wake is not None and other.wake > self.clock for other in others)
        if alone:  # no task waits for the end of this turn: it lasts until one does
            until = min([until, *(other.wake for other in others if other.wake is not None)])
        room = max(-(-(until - self.clock) // self.line_ns), 1)
        self.long_turn = alone
        used, done = self._turn(task, room if alone else min(task.rest, room))
        self.long_turn = False
        if task in self.tasks:
            task.rest -= used
            if done or task.rest <= 0:
                task.rest = task.priority
                self._at = (self.tasks.index(task) + 1) if task in self.tasks else self._at
        self._quiet = 0 if used else self._quiet + 1

    # ---- lines -----------------------------------------------------------------------------------------------------------
    def _turn(self, task: Task, lines: int) -> tuple[int, bool]:
        """Run up to `lines` lines; return their number, and whether the task has nothing more to do now."""
        self.current, self.turn, self.left = task, lines, lines
        task.deadline = None
        done = True
        try:
            done = self._lines(task)
        except Rte as fault:
            self._failed(task, fault)
        except (
            MotionError,
            Val3Error,
            ArithmeticError,
            LookupError,
            ValueError,
            RecursionError,
            TypeError,
            AttributeError,
            AssertionError,
        ) as error:
            self._failed(task, as_rte(error))
        used = self.turn - self.left
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
                self.forget_sockets(frame)
                task.leave()
                if not task.frames:
                    return True
            elif pc == CALL:
                assert self.call is not None
                program, arguments, after = self.call
                task.enter(program, arguments)
                frame.pc = after
            else:
                task.waiting = self.gen
            if task.dead or task.status != RUNNING:
                return True

    def _fast(self, task: Task) -> int | None:
        """Run plain lines in sequence; return the result of the last one, None: no line is left."""
        frame = task.frames[-1]
        code, v, pc = frame.code, frame.v, frame.pc
        try:
            while self.left:
                self.left -= 1
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
        words = self.help(fault.code)
        task.status, task.wake = fault.code, None
        task.detail = f"{words} ({fault.detail})" if words and fault.detail else words or str(fault)
        self.note(f"{task.name} {task.program} line {task.line}: error {fault.code} {task.detail}", "VAL3")


def as_rte(error: Exception) -> Rte:
    """Any error of a line as the code it stops its task with."""
    match error:
        case RuntimeFault():
            return Rte(error.code, error.detail)
        case Val3Error():
            return Rte(int(error.code), error.text)
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


def _alike(first: Declaration, second: Declaration) -> bool:
    """Whether data of two libraries have the same type and container."""
    return (first.type, first.dims) == (second.type, second.dims)


def _provides(found: Instance, interface: Application) -> bool:
    """Whether all public symbols of the interface are there."""
    app = found.loaded.app
    data = all(name in app.data and app.data[name].public for name, each in interface.data.items() if each.public)
    return data and all(name in app.programs and app.programs[name].public for name, each in interface.programs.items() if each.public)
