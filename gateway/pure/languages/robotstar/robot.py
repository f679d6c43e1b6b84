"""The interpreter as its operator sees it: modes, START, STOP, F1, F2, messages.  Source: robotstar 1.4, 1.5 (L1190-1298)."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.machine import AtBreakpoint, BitWait, Frame, Go, Halted, KeyTest, Machine, Wait
from gateway.pure.languages.robotstar.path import Target
from gateway.pure.languages.robotstar.program import Program

CYCLE: Ns = 10_000_000  # interpolation cycle (L2893)
BUDGET = 1_000  # steps in a cycle


class Stride(Enum):
    """How far a START goes.  The value is the order of page and tools."""

    MODE = "run"  # as the mode has it
    INTO = "into"  # one step, of a sub-program or macro too
    OVER = "over"  # one step, a call or macro to its end
    OUT = "out"  # to the step after the call in force


class State(Enum):
    """Of the program."""

    RUNNING = "running"
    WAITING = "waiting"
    STOPPED = "stopped"
    ERROR = "error"


@dataclass(frozen=True, slots=True)
class Mode:
    """One line of the table of modes.  `code`: M1022; 0 for none."""

    name: str
    single: bool
    simulated: bool
    code: int
    into_macros: bool = False
    executer: bool = False
    repeats: bool = False


MODES = {
    mode.name: mode
    for mode in (
        Mode("test1", True, True, 0x0201),
        Mode("test2", False, False, 0x0202),
        Mode("test3", True, False, 0x0203),
        Mode("test4", False, True, 0x0204),
        Mode("test5", True, False, 0, executer=True),
        Mode("test6", True, True, 0, into_macros=True),
        Mode("auto", False, False, 0x0300, repeats=True),
    )
}


@dataclass(frozen=True, slots=True)
class Message:
    """A message of the control.  `number` None: the manual prints none.  `step` 1 is the head."""

    text: str
    number: int | None
    program: str
    step: int
    kind: str


class Drive(Protocol):
    """The robot that goes."""

    def begin(self, target: Target, now: Ns) -> str:
        """A way begins; why it cannot, or ""."""

    def way(self, part: float) -> None:
        """How much of the way is done."""

    def arrived(self, target: Target, mode: str, now: Ns) -> None:
        """The position is reached."""

    def factor(self) -> float:
        """Override 0 .. 1; 0 holds the motion."""


@dataclass(slots=True)
class Robot:
    """Runs one program in one mode."""

    machine: Machine
    mode: Mode
    drive: Drive
    say: Callable[[Message], None]
    state: State = State.STOPPED
    failure: Message | None = None  # the error that is not acknowledged
    stride: Stride = Stride.MODE  # of the START in force, or of the next one
    _left: Ns | None = None  # of the request in force
    _asked_at: Ns = 0
    _macro_depth: int = 0  # of a macro or call that counts as one step; 0: none
    _rounds: dict[str, Ns] = field(default_factory=dict)  # key of a main program -> when its last round began
    _key: bool | None = None
    _request: object = field(default=None)
    _display: tuple[Program | None, int] = (None, 0)  # where the cursor goes once the error is acknowledged (L3828)

    def __post_init__(self) -> None:
        self.machine.repeats, self.machine.returns = self.mode.repeats, not self.mode.executer
        self.machine.simulated, self.machine.executer = self.mode.simulated, self.mode.executer

    @property
    def acknowledged(self) -> bool:
        """Whether a START is accepted."""
        return self.failure is None

    @property
    def quits(self) -> str:
        """How an error is acknowledged."""
        return "ACK acknowledges it"

    # ---- orders ----------------------------------------------------------------------------------------------------------
    def select(self, program: Program) -> None:
        """Choose a program; an interrupted one is not resumed (L1262)."""
        self.machine.select(program)
        self._forget()
        if self.state is not State.ERROR:
            self.state = State.STOPPED

    def _forget(self) -> None:
        self._request = None
        self._left, self._macro_depth, self._key = None, 0, None
        self._display = None, 0

    @property
    def single(self) -> bool:
        """Each step needs a START of its own."""
        return self.mode.single or self.stride is not Stride.MODE

    def start(self, now: Ns) -> str:
        """START; "" or why it is refused."""
        if not self.acknowledged:
            return f"the error is not acknowledged; {self.quits}"
        if self.machine.frame is None:
            return "no program is selected"
        if self.state in (State.RUNNING, State.WAITING):
            return ""
        frame = self.machine.frame
        if self.stride is Stride.OUT and len(self.machine.stack) == 1:
            return f"{frame.program.name} was not called by a program"
        self.state, self._asked_at, self.machine.idle = State.RUNNING, now, False
        if self.stride is not Stride.MODE:
            self._macro_depth = len(self.machine.stack) - 1 if self.stride is Stride.OUT else 0
        self.machine.passes = self.machine.request is None and frame.at in self.machine.breaks.get(frame.program.key, ())
        return ""

    def stop(self, now: Ns) -> None:
        """STOP on the path; START continues from there."""
        if self.state in (State.RUNNING, State.WAITING):
            self._elapse(now)
            self.state = State.STOPPED

    def key(self, level: bool) -> None:
        """F1 (False) or F2 (True)."""
        if isinstance(self.machine.request, KeyTest) or (isinstance(self.machine.request, BitWait) and self.machine.request.keys):
            self._key = level

    def acknowledge(self) -> None:
        """Quit."""
        self.failure = None
        if self.state is State.ERROR:
            self.state = State.STOPPED
        program, step = self._display
        self._display = None, 0
        if program is not None and step:
            self.machine.select(program)
            self.machine.to_step(step)

    def fail(self, message: Message) -> None:
        """An error of the cell: the program stops."""
        self.say(message)
        self.state, self.failure = State.ERROR, message

    # ---- time ------------------------------------------------------------------------------------------------------------
    def advance(self, now: Ns) -> Ns | None:
        """Runs up to now; when it is to be called again, None: only when something changes."""
        budget = BUDGET
        self.machine.idle = False
        while self.state in (State.RUNNING, State.WAITING):
            if self._asked():
                due = self._serve(now)
                if self._asked():
                    return due
                self._step_done(now)
                continue
            self.state = State.RUNNING
            if budget <= 0 or self.machine.idle:
                return now + CYCLE
            budget = self._steps(budget, now)
        return None

    def _asked(self) -> bool:
        """Whether a step waits for something."""
        return self.machine.request is not None

    def _steps(self, budget: int, now: Ns) -> int:
        machine = self.machine
        single = self.single
        frame = machine.frame
        assert frame is not None
        if single and not self._macro_depth and self._as_one(frame):
            self._macro_depth = len(machine.stack)
        try:
            first = frame.at == 0 and len(machine.stack) == 1
            if first and self.mode.repeats and not self._may_begin(frame, now):
                return 0
            left = machine.run(1 if single else budget)
            budget = budget - 1 + left if single else left
        except Halted as halt:
            self._halted(at_breakpoint=isinstance(halt, AtBreakpoint))
            return budget
        except StepFault as fault:
            self._failed(fault)
            return budget
        if machine.request is None:
            self._step_done(now)
        return budget

    def _halted(self, *, at_breakpoint: bool) -> None:
        """The program has stopped itself."""
        del at_breakpoint
        self._macro_depth = 0
        self.state = State.STOPPED

    def _as_one(self, frame: Frame) -> bool:
        """Whether the step under the cursor is executed with all that it calls."""
        step = frame.program.steps[frame.at] if frame.at < len(frame.program.steps) else None
        if step is None or not step.valid:
            return False
        match self.stride:
            case Stride.MODE:
                return step.macro and not self.mode.into_macros
            case Stride.OVER:
                return step.macro or step.word == "CALL"
        return False

    def _may_begin(self, frame: Frame, now: Ns) -> bool:
        """Return whether a round may begin: a round of AUTO lasts at least a cycle, even in programs that jump to one another."""
        key = frame.program.key
        if now < self._rounds.get(key, now - CYCLE) + CYCLE:
            return False
        self._rounds[key] = now
        return True

    def _step_done(self, now: Ns) -> None:
        """In single-step modes START is needed for each step."""
        del now
        if not self.single or self.state is State.STOPPED:
            return
        if self._macro_depth and len(self.machine.stack) > self._macro_depth:
            return
        self._macro_depth = 0
        self.state = State.STOPPED

    def _failed(self, fault: StepFault) -> None:
        frame = self.machine.frame
        assert frame is not None
        self._forget()
        self.machine.request = None
        message = Message(fault.text, fault.code or None, frame.program.name, frame.at + 1, fault.kind)
        self.say(message)
        refused = self.mode.executer and "not executable in Test 5" in fault.text
        self.state = State.STOPPED if refused else State.ERROR
        self.failure = None if refused else message
        self._display = fault.display

    # ---- requests --------------------------------------------------------------------------------------------------------
    def _serve(self, now: Ns) -> Ns | None:
        """Serves the request in force; the next moment of interest."""
        request = self.machine.request
        if request is not self._request:
            self._begin(request, now)
            if not self._asked():
                return None
        self._elapse(now)
        if isinstance(request, Go):
            return self._go(request, now)
        self.state = State.WAITING
        if isinstance(request, Wait):
            return self._due(now, None)
        if isinstance(request, KeyTest):
            if self._key is not None:
                branches, self._key = self._key == request.level, None
                self.machine.answered(request.branch if branches else None)
            return None
        assert isinstance(request, BitWait)
        met = self._key == request.level if request.keys and self._key is not None else not request.keys and self._tested(request)
        self._key = None
        if met:
            self.machine.answered()
            return None
        return self._due(now, request.late)

    def _begin(self, request: object, now: Ns) -> None:
        self._request, self._asked_at, self._key = request, now, None
        if isinstance(request, Go):
            self._left = request.whole
            wrong = self.drive.begin(request.target, now)
            if wrong:
                self._failed(StepFault(wrong, 0, "path"))
        else:
            self._left = request.left if isinstance(request, Wait | BitWait) else None

    def _tested(self, request: BitWait) -> bool:
        try:
            return request.test()
        except StepFault as fault:
            self._failed(fault)
            return False

    def _elapse(self, now: Ns) -> None:
        """Subtract the time since the last look from the remaining time."""
        passed, self._asked_at = max(now - self._asked_at, 0), now
        if self._left is None or self.state is State.STOPPED:
            return
        request = self.machine.request
        if isinstance(request, Go):
            self._left = max(self._left - round(passed * self.drive.factor()), 0)
            self.drive.way(1 - self._left / request.whole if request.whole else 1.0)
        else:
            self._left = max(self._left - passed, 0)

    def _due(self, now: Ns, late: int | None) -> Ns | None:
        """When the time is over; at that moment the request is answered."""
        if self._left is None:
            return None
        if self._left > 0:
            return now + self._left
        self.machine.answered(late)
        return None

    def _go(self, request: Go, now: Ns) -> Ns | None:
        self.state = State.RUNNING
        assert self._left is not None
        if self._left > 0:
            factor = self.drive.factor()
            return now + max(round(self._left / factor), 1) if factor > 0 else None
        self.drive.arrived(request.target, request.mode, now)
        if not request.whole:
            self.machine.effects -= 1  # no way means no change: a loop of it yields its time
        self.machine.answered()
        return None

    # ---- what shows ------------------------------------------------------------------------------------------------------
    @property
    def moving(self) -> bool:
        """Return whether a movement is running."""
        return self.state is State.RUNNING and isinstance(self.machine.request, Go)

    @property
    def inquiry(self) -> int:
        """The input that the program waits for (M996)."""
        request = self.machine.request
        return request.inquiry if self.state is State.WAITING and isinstance(request, BitWait) else 0

    def place(self) -> tuple[str, int]:
        """Program and step under the cursor; 1 is the head."""
        frame = self.machine.frame
        return ("", 0) if frame is None else (frame.program.name, frame.at + 1)
