"""A VAL 3 application in a cell (AX-930): its tasks in real time, the arm and the signals those of the cell.  Pure.

The machine is the one of a virtual run.  It has a line cost, so that a turn is bounded; time that a turn cannot run is omitted from the
application's clock and not made up for.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from gateway.pure.controllers.val3.io.system import Point as CellPoint
from gateway.pure.image.records.interpreter import Fact
from gateway.pure.languages.base.hosting import Port, ProcessRow, ProgramRow
from gateway.pure.languages.base.requests import Ns, RuntimeFault
from gateway.pure.languages.val3.boards import UserBoards
from gateway.pure.languages.val3.cell_alter import AlterPlace
from gateway.pure.languages.val3.cell_io import CellIo
from gateway.pure.languages.val3.cell_moves import CellMoves
from gateway.pure.languages.val3.cell_robot import CellRobot
from gateway.pure.languages.val3.cell_view import POPUPS, act, seen
from gateway.pure.languages.val3.disk import Disk
from gateway.pure.languages.val3.errors import TEXTS
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.loader import Loader, family_of_arm
from gateway.pure.languages.val3.machine import Machine
from gateway.pure.languages.val3.robot_state import REMOTE, Service
from gateway.pure.languages.val3.tasks import RUNNING, SUSPENDED, Task
from gateway.pure.languages.val3.virtual_events import MODES
from gateway.pure.languages.val3.virtual_sio import VirtualSio
from motion.planner.robot import Machine as RobotMachine
from motion.robot import Robot

LINE_NS = 1_000  # of a line
SLICE_NS = 500_000  # of a call of turn
BEHIND_NS = 4_000_000  # lines of more time are left out when the machine is late
LATE_NS = 40_000_000  # cycles of synchronous tasks that are made up for
LOOK_NS = 200_000_000
LINES = 10  # of the log, to the journal, in one turn


@dataclass(frozen=True, slots=True)
class Setup:
    """The application as its cell has it.  largest: following errors of the robot's axes in their units."""

    folder: str
    name: str
    robot: Robot
    machine: RobotMachine
    axes: int = 0
    largest: tuple[float, ...] = ()
    points: tuple[CellPoint, ...] = ()
    mode: int = REMOTE
    version: str = ""
    strict: bool = False
    auto_connect: bool = False
    epoch: Ns = 0  # clock of the host at which the date of a virtual run begins
    watchdog_ns: Ns = 0  # 0: there is none
    operator: bool = False  # prompts wait for an answer of the dashboard
    alter: AlterPlace | None = None
    boards: UserBoards | None = None
    service: Service = field(default_factory=Service)
    profile: str = "default"
    profiles: Mapping[str, str] = field(default_factory=dict)  # in addition to "default": name -> password
    references: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    licences: Mapping[str, str] = field(default_factory=dict)
    options: tuple[str, ...] = ()
    rated: tuple[float, ...] = ()  # force of each joint at the rated torque of its motor, Nm or N; 0: not known
    language: str = "english"
    texts: Mapping[str, Mapping[int, str]] = field(default_factory=dict)  # of run-time errors: language -> code -> text


@dataclass(eq=False)
class CellRun:
    """disk: the files as they are at a start; sio: channels for each start."""

    setup: Setup
    port: Port
    disk: Callable[[], Disk]
    sio: Callable[[], VirtualSio] = VirtualSio
    machine: Machine | None = None
    own: Instance | None = None
    run: int = 0
    _row: ProgramRow | None = None
    _began: Ns = 0
    _stopped: bool = False  # by the operator
    _faults: str = ""
    _moves: CellMoves | None = None
    _robot: CellRobot = field(default_factory=CellRobot)
    _io: CellIo = field(default_factory=CellIo)
    _popups: list[str] = field(default_factory=list)
    _seen: Mapping[str, object] = field(default_factory=dict)
    _look: Ns = 0  # at which it is made again

    def __post_init__(self) -> None:
        setup = self.setup
        self._robot = CellRobot(port=self.port, axes=setup.axes, mode=setup.mode, arm_type=setup.robot.name, profile=setup.profile)
        self._robot.language, self._robot.said = setup.language, self._said
        self._robot.service, self._robot.components = setup.service, dict.fromkeys((name.lower() for name in setup.options), "enabled")
        boards = replace(setup.boards) if setup.boards is not None else None
        self._io = CellIo(owned=setup.points, put=lambda name, value: self.port.send("put", name=name, value=value), boards=boards)

    # ---- from outside
    def read(self) -> list[str]:
        """The application is read and checked; its faults."""
        setup = self.setup
        axes = len(setup.robot.axes)
        loaded = Loader(self.disk(), axes, family=family_of_arm(axes), strict=setup.strict).load(setup.folder, setup.name)
        if loaded is None:
            self._row = ProgramRow(setup.name, "normal", (1,), 1, 0, f"there is no {setup.name}.pjx")
            return [self._row.fault]
        lines = [loaded.logged(fault) for fault in loaded.faults]
        found = [line for line, fault in zip(lines, loaded.faults, strict=True) if fault.severity.value == "error"]
        found += [f"{setup.name} has no {each}()" for each in ("start", "stop") if each not in loaded.app.programs]
        self._row = ProgramRow(setup.name, "normal", (1,), len(found), len(lines) - loaded.faults.errors, *found[:1])
        return found

    def catalogue(self) -> Sequence[ProgramRow]:
        """The application."""
        return [] if self._row is None else [self._row]

    def start_run(self, name: str, run: int, now: Ns) -> None:
        """start() begins in a task of its own; an application that cannot is over at once."""
        if self.machine is not None:
            self.port.over(run, "aborted", RuntimeFault(0, f"{self.setup.name} runs already"), self.setup.name)
            return
        setup = self.setup
        robot = self._robot
        robot.watchdog_ns, robot.watchdog_until = setup.watchdog_ns, None
        robot.watchdog_broken = robot.dead_watch = False
        if setup.version:
            self._robot.version = setup.version
        moves = CellMoves(setup.robot, setup.machine, self.port, setup.largest, self._said, setup.alter, setup.rated)
        moves.stack.auto_connect = setup.auto_connect
        machine = Machine(self.disk(), moves, LINE_NS, self._robot, setup.strict)
        machine.io, machine.sio = self._io, self.sio()
        machine.pages.io, machine.operator = self._io, setup.operator
        machine.references, machine.licences, machine.profiles = setup.references, setup.licences, {"default": "", **setup.profiles}
        machine.texts = setup.texts
        self._popups.clear()
        machine.epoch = now - setup.epoch
        own = machine.instance(setup.folder, setup.name, "")
        if own is None or not machine.start(own):
            fault = self._row.fault if self._row is not None else ""
            self.port.over(run, "aborted", RuntimeFault(0, fault or "it has faults"), setup.name)
            return
        self.machine, self.own, self.run, self._moves = machine, own, run, moves
        self._began, self._stopped, self._faults = now, False, ""

    def stop_run(self, run: int, now: Ns, error: RuntimeFault | None = None) -> None:
        """stop() runs, then all tasks end; a second stop ends them at once, as an error does."""
        machine = self.machine
        if machine is None or run != self.run:
            return
        if error is not None or self._stopped:
            self._over("aborted" if error is not None else "stopped", error)
            return
        self._stopped = True
        machine.stop()

    def stop_all(self, now: Ns) -> None:
        """Handle a restart of the services: for the control this is a start, and nothing runs."""
        if self._moves is not None:
            self._moves.mover.forget()
        if self.machine is not None:
            self._over("stopped", None)

    def file_changed(self, name: str) -> None:
        """All files are read before each start."""

    def path_given(self, ticket: int, job: int) -> None:
        """The arm moves for the application from now on."""
        if self._moves is not None:
            self._moves.mover.given(ticket, job)

    def path_over(self, ticket: int, error: RuntimeFault | None, now: Ns) -> None:
        """It does not any more."""
        if self._moves is not None:
            self._moves.over(ticket, error)

    def hear(self, order: Mapping[str, Fact], now: Ns) -> None:
        """Control, hold, points, the connection move."""
        match order["do"]:
            case "control":
                self._robot.held = bool(order["held"])
            case "hold":
                self._robot.button = bool(order["on"])
            case "connect" if self._moves is not None:
                self._moves.confirm()
            case "act" if self.machine is not None and self.own is not None:
                if words := act(self.machine, self.own, order):
                    self._said(words)
            case "mode":
                self._robot.mode = MODES[str(order["mode"])]
            case "speed":  # the operator's: no rule of setMonitorSpeed
                self.port.send("speed", value=float(order["value"]) / 100.0)
            case "ratio" if self._io.boards is not None:
                self._io.boards.ratio = int(order["value"])
            case "io":
                self._io.state(str(order["name"]), int(order["status"]))

    # ---- turns
    def turn(self, now: Ns) -> bool:
        """Continue all tasks; True: there is time to make up."""
        machine, moves = self.machine, self._moves
        if machine is None or moves is None:
            self._robot.look()
            return False
        target = now - self._began
        self._robot.look()
        moves.powered = self._robot.powered
        self._io.look(self.port.view.channels)
        machine.sio.now = machine.clock
        machine.sio.settle()
        self._late(machine, target)
        machine.run(min(target, machine.clock + SLICE_NS), target)  # inputs stay as they are in this turn: who waits is not asked again
        moves.hand_on()
        moves.correct(now)
        self._show(machine)
        if machine.ended:
            self._over("stopped" if self._stopped else "ended", None)
            return False
        return machine.clock < target

    @staticmethod
    def _late(machine: Machine, target: Ns) -> None:
        """Lines of more than a cycle are left out; synchronous tasks lose a cycle only where the process was later than LATE_NS."""
        machine.clock = max(machine.clock, target - LATE_NS)
        while target - machine.clock > BEHIND_NS and not machine.ended:
            machine.catch_up()

    def _show(self, machine: Machine) -> None:
        lines, machine.log = machine.log, []
        for line in lines[:LINES]:
            self._said(line)
        if len(lines) > LINES:
            self._said(f"{len(lines) - LINES} more lines of the log")
        popups, machine.popups = machine.popups, []
        for text in popups[:LINES]:
            self._said(f"popup: {text}")
        self._popups = [*self._popups, *popups][-POPUPS:]
        faults = "; ".join(_fault_of(task) for task in machine.tasks if task.status > RUNNING)
        if faults != self._faults:
            self._faults = faults
            self.port.send("faults", text=faults)

    def _said(self, text: str) -> None:
        self.port.report(self.setup.name, 0, text)

    def _over(self, how: str, error: RuntimeFault | None) -> None:
        assert self.machine is not None and self._moves is not None
        first = next((task for task in self.machine.tasks if task.status > RUNNING), None)
        if first is not None and error is None:
            how, error = "aborted", RuntimeFault(first.status, _words(first))
        place = self.setup.name if first is None else f"{first.program} line {first.line}"
        for task in reversed(list(self.machine.tasks)):
            self.machine.kill(task)
        self.machine.sio.end_application()
        self._moves.mover.end()
        if self._faults:
            self._faults = ""
            self.port.send("faults", text="")
        self.port.over(self.run, how, error, place)
        self.machine, self.own, self.run = None, None, 0
        self._robot.watchdog_ns = 0  # without an application power is a matter of the other command sources

    def seen(self, now: Ns) -> Mapping[str, object]:
        """For the dashboard, five times a second."""
        if self.machine is None or self.own is None:
            self._seen, self._look = {}, 0
        elif now >= self._look:
            self._seen, self._look = seen(self.machine, self.own, self._popups), now + LOOK_NS
        return self._seen

    def rows(self) -> Sequence[ProcessRow]:
        """The tasks, those with errors first."""
        if self.machine is None:
            return []
        tasks = sorted(self.machine.tasks, key=lambda task: task.status <= RUNNING)
        return [self._row_of(task) for task in tasks]

    def _row_of(self, task: Task) -> ProcessRow:
        state = "running" if task.status == RUNNING else "suspended" if task.status == SUSPENDED else "error"
        error = f"{task.status} {_words(task)}" if task.status > RUNNING else ""
        prefix = task.owner.prefix
        name = f"{prefix}:{task.name}" if prefix else task.name
        return ProcessRow(self.run, task.program, "task", state, task.line, task=name, error=error)


def _words(task: Task) -> str:
    """Return the text of its error, with its subject."""
    return task.detail or TEXTS.get(task.status, "error")


def _fault_of(task: Task) -> str:
    return f"task {task.name}, {task.program} line {task.line}: error {task.status} {_words(task)}"
