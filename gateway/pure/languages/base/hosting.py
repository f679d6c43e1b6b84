"""Interface between a language and the process that hosts its programs in a cell.  Independent of any language."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from gateway.pure.image.records.cell import CellState, Motion
from gateway.pure.image.records.interpreter import Channels, Fact
from gateway.pure.image.records.planner import PlannerState
from gateway.pure.languages.base.requests import Ns, RuntimeFault


@dataclass(frozen=True, slots=True)
class PathState:
    """Report of the planner on the job under way: blocks that are over, and the last fault with its block; of the cycle: whether the last
    movement that an input ends was ended by it."""

    job: int = 0
    passed: int = 0
    failed_job: int = 0
    fault_block: int = 0
    met: bool = False
    block: int = 0  # under way
    share: float = 0.0  # of its way
    fault_code: int = 0  # number of the manual, 0: it has none


@dataclass(frozen=True, slots=True)
class View:
    """What programs see of the cell in one turn.  set, actual, measured: of the axes in their units (mm, deg); enabled: axes (bit n-1 =
    axis n) that have power; measured: by measuring inputs."""

    channels: Channels = Channels()
    set: tuple[float, ...] = ()
    measured: tuple[float | None, ...] = ()
    paths: tuple[PathState, ...] = (PathState(),)  # of each robot; in a cell that moves one at a time one for all
    actual: tuple[float, ...] = ()
    enabled: int = 0
    motion: Motion = Motion.IDLE
    override: float = 0.0
    chain: bool = True  # the emergency-stop chain is closed, no emergency stop is latched
    belts: tuple[float, ...] = ()  # counters, in the unit of each
    belt_types: tuple[int, ...] = ()  # 1 parallel, 2 without parallel axis, 3 cam
    torque: tuple[float, ...] = ()  # of the motors, as shares of their rated torque

    def path_of(self, robot: int) -> PathState:
        """By its number, from 1."""
        return self.paths[robot - 1] if 1 < robot <= len(self.paths) else self.paths[0]


def paths_of(planner: PlannerState, state: CellState) -> tuple[PathState, ...]:
    """Of the lanes of a cell, as planner and cycle report them."""
    states = (planner, *planner.others)
    met = [lane.met for lane in state.apart] or [state.met]
    return tuple(
        PathState(each.job, each.passed, each.failed_job, each.fault_block, one, each.block, each.share, each.fault_code)
        for each, one in zip(states, met, strict=False)
    )


@dataclass(frozen=True, slots=True)
class ProgramRow:
    """A program of the memory, for lists; kinematics: numbers from 1; fault: the first one, empty: it can run."""

    name: str
    kind: str  # normal | permanent | subroutine
    kinematics: tuple[int, ...] = ()
    errors: int = 0
    warnings: int = 0
    fault: str = ""


@dataclass(frozen=True, slots=True)
class ProcessRow:
    """A process as others see it."""

    run: int
    program: str
    kind: str
    state: str
    line: int
    waits: str = ""  # for what
    parent: int = 0  # run of the process that started it
    branch: bool = False
    task: str = ""  # name of a task that runs the program; "": programs of the language are their own processes
    error: str = ""  # with which it has stopped, in words
    done: int = 0  # line executed last, of the same program; 0: not known
    held: str = ""  # what it waits for and another process has: `semaphore NAME`, `kinematic NAME`
    holder: str = ""  # that process, in words
    stuck: bool = False  # it waits for one that waits for it
    external: str = ""  # the external program, or the included file, that it executes just now
    level: int = 0  # subroutines one in the other
    including: str = ""  # the external program that includes this file; "": the program itself does, or it is not included
    inquiry: int = 0  # an input it waits for, as M996 has it
    included: int = 0  # line of the instruction there that includes it; 0: it is not included


def as_reported(row: ProgramRow | ProcessRow) -> dict[str, object]:
    """Field by name.  dataclasses.asdict copies what lies in them, which costs more than the report itself."""
    return {name: getattr(row, name) for name in row.__slots__}


class Port(Protocol):
    """What the hosting process does for a language."""

    @property
    def view(self) -> View:
        """The cell in this turn."""

    def output(self, channel: int, value: float) -> None:
        """Sets an output."""

    def ask_path(self, ticket: int, program: str, robot: int) -> None:
        """A robot is to move for a program; the answer comes as path_given or path_over of this ticket."""

    def line(self, job: int, text: str) -> None:
        """A statement of the text form for the planner."""

    def whole(self, job: int) -> None:
        """The lines that follow are read when `end` has come."""

    def finish(self, job: int) -> None:
        """Nothing follows for the time being: the path is run to its end."""

    def end(self, job: int) -> None:
        """Nothing follows any more."""

    def started(self, run: int, program: str, kind: str, parent: int) -> None:
        """A program has started another one."""

    def over(self, run: int, how: str, fault: RuntimeFault | None, place: str) -> None:
        """A process is over; `place`: file and line."""

    def report(self, program: str, line: int, text: str) -> None:
        """What a person should read."""

    def correct(self, record: bytes) -> None:
        """Correction of the path (gateway.pure.image.records.correction), from the next cycle on."""

    def panel(self, text: str) -> None:
        """Characters for the hand-held panel."""

    def send(self, what: str, **facts: Fact) -> None:
        """A message of the language's own to its part in the services."""


class Language(Protocol):
    """Programs of one language in a cell; never an exception for what a program does."""

    def catalogue(self) -> Sequence[ProgramRow]:
        """All programs."""

    def start_run(self, name: str, run: int, now: Ns) -> None:
        """A program begins; one that cannot is over at once."""

    def stop_run(self, run: int, now: Ns, error: RuntimeFault | None = None) -> None:
        """It ends, with all it started; `error`: because of one."""

    def stop_all(self, now: Ns) -> None:
        """Nothing runs any more."""

    def file_changed(self, name: str) -> None:
        """A file of the memory was replaced from outside."""

    def path_given(self, ticket: int, job: int) -> None:
        """The robot moves for the program from now on."""

    def path_over(self, ticket: int, error: RuntimeFault | None, now: Ns) -> None:
        """It does not any more; an error ends the program."""

    def turn(self, now: Ns) -> bool:
        """Continue all processes; True: they could continue at once."""

    def rows(self) -> Sequence[ProcessRow]:
        """The processes."""

    def hear(self, order: Mapping[str, Fact], now: Ns) -> None:
        """A message of the language's own from its part in the services."""


class Programs(Protocol):
    """Programs of a cell and their files; the process that hosts them reads and writes no file.  Faults are lines for the journal."""

    @property
    def language(self) -> Language:
        """What runs them."""

    def read(self, alive: Callable[[], None]) -> list[str]:
        """Read and check all programs before any is started; `alive` is called in between, as this may take seconds."""

    def refresh(self, alive: Callable[[], None]) -> list[str] | None:
        """Before a program starts: files that were put there since; None: none was."""

    def seen(self, now: Ns) -> Mapping[str, object]:
        """Return language-specific lists by name, for the dashboard."""

    def write_back(self) -> list[str]:
        """What programs have written is on the disk."""
