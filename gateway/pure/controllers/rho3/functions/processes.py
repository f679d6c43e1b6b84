"""The table of user processes: names, kinds, priorities, states, parents.  Source: rho 3 Releases; rho3 5.5, AX-539, AX-540.

What a process does is a callable, called once per turn; a test or an interpreter supplies it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto

from protocols.base.machine import Ns

ALREADY_EXISTS, OWN_MAIN, NOT_AVAILABLE = 1051, 1079, 1092  # codes of the manual (rho3 9.1)
MOST = 100  # processes; the list of the PHG 2000 has as many places (L9434)
BODY_FAULT = 1255  # ours, AX-534: a body that broke down


class Kind(Enum):
    """Columns of the panel's process counts (L9430-9433)."""

    NORMAL, PERMANENT, SUB, TEST = auto(), auto(), auto(), auto()


class State(Enum):
    """FAULTY: ended by an error and kept until it is stopped or acknowledged."""

    READY, RUNNING, WAITING, FAULTY = auto(), auto(), auto(), auto()


class Turn(Enum):
    """Result of a body after its turn."""

    GO_ON, WAIT, DONE = auto(), auto(), auto()


class ProcessFault(Exception):
    """An error with the manual's code; raised by a body it ends the process, raised by the table nothing was done."""

    def __init__(self, code: int, text: str = "") -> None:
        super().__init__(code, text)
        self.code, self.text = code, text


Body = Callable[[Ns], Turn]


@dataclass(frozen=True, slots=True)
class Program:
    """A program that can be started: `make` returns a body for each start."""

    make: Callable[[], Body]
    kind: Kind = Kind.NORMAL
    priority: int = 140
    kinematics: int = 0  # mask of the kinematics it moves


@dataclass(slots=True)
class Process:
    """One line of the table; `line`, `include_line`, `level` and `external` are kept by its body."""

    number: int
    name: str
    kind: Kind
    priority: int
    parent: int  # number of the process that started it, 0: none
    body: Body
    kinematics: int = 0
    state: State = State.READY
    error: int = 0
    error_text: str = ""
    line: int = 0
    include_line: int = 0
    level: int = 0
    external: str = ""
    place: str = ""  # of its error: file and line
    wants: str = ""  # what it waits for and another process has
    holder: str = ""  # that process and its line
    stuck: bool = False  # it waits for one that waits for it
    turns: int = 0


@dataclass(frozen=True, slots=True)
class Stopped:
    """A process was stopped from outside: motion of these kinematics ends at once and is not finished (L2610)."""

    name: str
    kinematics: int


class ProcessTable:
    """Starts, steps and stops processes; the lower priority number runs first, equal ones take turns (L3427, L11347)."""

    def __init__(self, programs: Mapping[str, Program] | None = None) -> None:
        self.programs = dict(programs or {})
        self._all: dict[int, Process] = {}
        self._next = 1
        self._turn = 0
        self._stopped: list[Stopped] = []

    @property
    def processes(self) -> tuple[Process, ...]:
        """In the order they were started."""
        return tuple(self._all.values())

    def named(self, name: str) -> Process | None:
        """The process of that name, in any case of letters."""
        return next((process for process in self._all.values() if process.name == name.upper()), None)

    def numbered(self, number: int) -> Process | None:
        """The process with that number."""
        return self._all.get(number)

    def start(self, name: str, parent: int = 0, body: Body | None = None) -> Process:
        """Starts a program, or with `body` a branch of PARALLEL; with a parent it is a sub-process.  Raises ProcessFault."""
        name = name.upper()
        above = self._all.get(parent)
        program = self.programs.get(name)
        if body is not None and above is not None:
            program = Program(lambda: body, Kind.SUB, above.priority, above.kinematics)
        if program is None or (parent and above is None):
            raise ProcessFault(NOT_AVAILABLE, name)
        if self.named(name) is not None or len(self._all) >= MOST:
            raise ProcessFault(ALREADY_EXISTS, name)
        kind = Kind.SUB if parent else program.kind
        process = Process(self._next, name, kind, program.priority, parent, program.make(), program.kinematics)
        self._all[process.number] = process
        self._next += 1
        return process

    def stop(self, number: int, by: int = 0) -> tuple[str, ...]:
        """Stop a process and all that it started at once; return their names, () where there is no such process.

        by: the requesting process, 0: from outside.  A sub-process must not stop its parent: ProcessFault 1079 (L5872).
        """
        process = self._all.get(number)
        if process is None:
            return ()
        if by and by != number and by in self.family(number):
            raise ProcessFault(OWN_MAIN, process.name)
        gone = [self._all.pop(member) for member in self.family(number)]
        self._stopped += [Stopped(each.name, each.kinematics) for each in gone]
        return tuple(each.name for each in gone)

    def control_reset(self, keep_permanent: bool) -> tuple[str, ...]:
        """Ends all processes; keep_permanent (RC input 61): permanent ones and what they started stay (L2620)."""
        mains = [each for each in self._all.values() if not each.parent]  # sub-processes share what befalls theirs
        ended = [each.number for each in mains if not (keep_permanent and each.kind is Kind.PERMANENT)]
        return tuple(name for number in ended for name in self.stop(number))

    def family(self, number: int) -> list[int]:
        """A process and everything it started, and what that started, parents first."""
        found = [number]
        for member in found:  # grows while it is walked
            found += [process.number for process in self._all.values() if process.parent == member]
        return found

    def take_stopped(self) -> list[Stopped]:
        """What was stopped from outside since the last call."""
        stopped, self._stopped = self._stopped, []
        return stopped

    def step(self, now: Ns) -> list[Process]:
        """One turn for all; returns those whose error came in this turn."""
        self._turn += 1
        faulty: list[Process] = []
        for number in self._order():
            process = self._all.get(number)
            if process is not None and process.state is not State.FAULTY and self._fails(process, now):
                faulty.append(process)
        return faulty

    def _order(self) -> list[int]:
        """Lower priority numbers first; among equals another one begins each turn."""
        by_priority: dict[int, list[int]] = {}
        for process in self._all.values():
            by_priority.setdefault(process.priority, []).append(process.number)
        order: list[int] = []
        for priority in sorted(by_priority):
            equals = by_priority[priority]
            first = self._turn % len(equals)
            order += equals[first:] + equals[:first]
        return order

    def _fails(self, process: Process, now: Ns) -> bool:
        """One turn of one process; True when an error ended it."""
        process.state = State.RUNNING
        process.turns += 1
        try:
            said = process.body(now)
        except ProcessFault as fault:
            process.state, process.error, process.error_text = State.FAULTY, fault.code, fault.text
            return True
        except Exception as error:  # a broken body must not stop the others
            process.state, process.error, process.error_text = State.FAULTY, BODY_FAULT, repr(error)
            return True
        process.state = State.WAITING if said is Turn.WAIT else State.READY
        if said is Turn.DONE:
            self._done(process)
        return False

    def _done(self, process: Process) -> None:
        """End a process that finished: the processes it started continue (AX-540)."""
        self._all.pop(process.number, None)
        for child in self._all.values():
            if child.parent == process.number:
                child.parent = process.parent
