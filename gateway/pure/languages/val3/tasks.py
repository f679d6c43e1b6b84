"""Tasks at run time: frames, states, memory.  Source: VAL 3 reference 5, L3334-3397; memory AX-721."""

from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import Protocol, TypeAlias

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.initial_values import Surroundings
from gateway.pure.languages.val3.model import Declaration, ProgramText
from gateway.pure.languages.val3.program_code import Code
from gateway.pure.languages.val3.scope import width

RUNNING, SUSPENDED = 1, 0
FRAME_BYTES, SLOT_BYTES, VALUE_BYTES = 32, 8, 8  # AX-721
LINES_A_CYCLE = 3000
SYSTEM_CYCLE: Ns = 4_000_000

Step: TypeAlias = Callable[[list[object]], int]
Line: TypeAlias = Generator[Ns | None, None, int]


class Owner(Protocol):
    """The application or library that creates a task."""

    prefix: str

    @property
    def stack(self) -> int:
        """Bytes of a task."""
        ...


class Callee(Protocol):
    """A program that is called."""

    text: ProgramText
    code: Code
    bytes: int
    sockets: tuple[int, ...]

    @property
    def name(self) -> str:
        """As declared."""
        ...

    @property
    def home(self) -> Surroundings:
        """What defaults depend on."""
        ...

    def steps(self) -> list[Step]:
        """One function a step."""
        ...

    def fresh(self) -> list[object]:
        """Its local variables as a call begins."""
        ...

    def line_of(self, pc: int) -> int:
        """Line of a step."""
        ...

    def step_at(self, line: int) -> int:
        """Return the first step at or after a line."""
        ...


@dataclass(slots=True, eq=False)
class Frame:
    """One call of a program."""

    program: Callee
    v: list[object]
    code: list[Step]
    pc: int
    bytes: int


@dataclass(slots=True, eq=False)
class Task:
    """One task.  status: 1 running, 0 suspended, else the code of its error."""

    name: str
    owner: Owner
    priority: int
    frames: list[Frame] = field(default_factory=list)
    status: int = RUNNING
    waiting: Line | None = None
    wake: Ns | None = None  # earliest moment at which to ask again; None: at each turn
    deadline: Ns | None = None  # moment at which a wait ends in any case
    rest: int = 0  # lines left in this turn
    bytes: int = 0
    period: Ns = 0  # 0: asynchronous
    due: Ns = 0
    overrun: "tuple[object, object] | None" = None
    dead: bool = False
    detail: str = ""

    @property
    def line(self) -> int:
        """Line of its program."""
        return self.frames[-1].program.line_of(self.frames[-1].pc) if self.frames else 0

    @property
    def program(self) -> str:
        """Program it is in."""
        return self.frames[-1].program.name if self.frames else ""

    def enter(self, program: Callee, arguments: list[object]) -> None:
        """Calls a program; 41 where the memory of the task is too small."""
        if self.bytes + program.bytes > self.owner.stack:
            raise Rte(41, f"{self.bytes + program.bytes} bytes of {self.owner.stack}")
        self._push(program, arguments)

    def begin(self, program: Callee) -> Rte | None:
        """start() or stop(), whatever it needs: an error leaves the task on its first line."""
        self._push(program, [])
        return Rte(41, f"{self.bytes} bytes of {self.owner.stack}") if self.bytes > self.owner.stack else None

    def _push(self, program: Callee, arguments: list[object]) -> None:
        v: list[object] = [*arguments]
        v += program.fresh()
        v += [None] * program.code.temps
        self.frames.append(Frame(program, v, program.steps(), program.code.entry, program.bytes))
        self.bytes += program.bytes

    def leave(self) -> None:
        """The program has ended."""
        self.bytes -= self.frames.pop().bytes

    def resume_at(self, skip: int) -> None:
        """Set the line at which to continue; 90 where there is none."""
        frame = self.frames[-1]
        wanted = self.line + skip
        if not 1 <= wanted <= frame.program.code.last_line:
            raise Rte(90, f"line {wanted} of {frame.program.name}")
        if skip or self.status > RUNNING:
            if self.waiting is not None:
                self.waiting.close()
                self.waiting = None
            if skip:
                frame.pc = frame.program.step_at(wanted)
        self.status, self.wake, self.detail = RUNNING, None, ""


def bytes_of(text: ProgramText) -> int:
    """Memory of one call: a frame, its parameters, its locals."""
    total = FRAME_BYTES + SLOT_BYTES * sum(width(each) for each in text.parameters)
    return total + sum(SLOT_BYTES + VALUE_BYTES * count(each) for each in text.locals)


def count(declared: Declaration) -> int:
    """Values of a local variable."""
    total = 1
    for size in declared.sizes:
        total *= size
    return total
