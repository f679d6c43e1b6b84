"""Runs the steps of programs: stack of calls, names in force, the request a step waits for.  Source: robotstar 1.1, 2.3, 2.7.

Each step of a program is one function without parameters that returns the index of the next step, or -1 where the machine has to look:
a request was made, or the stack changed.  The index of the step in force is all that a resumption needs.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol, TypeAlias

from gateway.pure.languages.base.collecting import uncollected
from gateway.pure.languages.base.requests import Ns, Request
from gateway.pure.languages.robotstar.faults import IN_THE_STACK, StepFault, operating
from gateway.pure.languages.robotstar.memory import Memory
from gateway.pure.languages.robotstar.mouse import Mouse
from gateway.pure.languages.robotstar.path import PathState, Target
from gateway.pure.languages.robotstar.program import Program
from gateway.pure.languages.robotstar.values import Names, Structure

Op: TypeAlias = Callable[[], int]
DEEPEST = 12  # calls of SPR and MAC in one another (L213)
LOOK = -1
OUTPUT_MARKERS = 2008  # M2008 to M2047 are the outputs (L2986)
OWN_RETURN = 4017  # END of a sub-program that was not called (L211)


class Surroundings(Protocol):
    """What a program sees of the cell.  Areas: INPUT, OUTPUT, MARKER."""

    def byte(self, area: str, number: int) -> int:
        """A byte of an area."""

    def set_bit(self, area: str, number: int, bit: int, level: bool) -> None:
        """Sets a bit of an output or marker byte."""

    def element(self, area: str, number: int) -> int:
        """Four bytes from `number` on, the lowest first, signed."""

    def set_element(self, area: str, number: int, value: int) -> None:
        """Writes four bytes."""

    def analog_input(self, channel: int) -> float:
        """Volts."""

    def set_analog_output(self, channel: int, volts: float) -> None:
        """Volts."""

    def actual(self) -> Target:
        """Where the robot is."""

    def planned(self) -> Target:
        """Where it is once all positions that were asked for are reached."""

    def based(self, target: Target) -> Target:
        """Return a position in the basic system.  Raise StepFault without a station with its frame."""

    def seen_from(self, frame: int, target: Target) -> Target:
        """A position of the basic system in a station's frame."""


class NotYet(Exception):
    """A step reads the cell, and positions before it are not reached: it is executed again when they are."""


@dataclass(frozen=True, slots=True)
class Wait(Request):
    """WAIT: `left` ns."""

    left: Ns


@dataclass(frozen=True, slots=True)
class BitWait(Request):
    """WAIT_BIT: until `test` holds; after `left` ns (None: for ever) on at `late`.  `keys`: F1 and F2 set the level.  `input`: its
    number, None for other bits."""

    test: Callable[[], bool]
    level: bool
    left: Ns | None
    late: int
    keys: bool = False
    input: int | None = None

    @property
    def inquiry(self) -> int:
        """Input, level and status as M996 to M999 show them (L2937); 0: no input."""
        return 0 if self.input is None else 1 << 31 | self.level << 16 | self.input


@dataclass(frozen=True, slots=True)
class KeyTest(Request):
    """TEST_BIT on a simulated input: F1 and F2 set the level; on at `branch` where it is `level`."""

    level: bool
    branch: int


@dataclass(frozen=True, slots=True)
class Go(Request):
    """A position: it lasts `whole` ns in virtual time.  settings: parameters of the path as they are at this step; auxiliary: first point
    of a circle; approximates: its end may be rounded."""

    target: Target
    mode: str
    whole: Ns
    settings: Mapping[str, float] = field(default_factory=dict)
    tool: Structure | None = None
    auxiliary: bool = False
    approximates: bool = False


@dataclass(slots=True, eq=False)
class Frame:
    """A program in work.  `kind`: main, call or macro."""

    program: Program
    kind: str
    names: Names
    ops: list[Op] = field(default_factory=list)
    at: int = 0
    done: int = -1  # the step that was executed last, -1: none (L1484)


class Halted(Exception):
    """The program stops itself: STOP, or END of a main program in a test mode."""


class AtBreakpoint(Halted):
    """The program stops before a step with a breakpoint."""


@dataclass(slots=True)
class Machine:
    """State of the interpreter.  `build` makes the steps' functions of a program."""

    memory: Memory
    world: Surroundings
    system: Names
    build: "Callable[[Machine, Program], list[Op]]"
    stack: list[Frame] = field(default_factory=list)
    frame: Frame | None = None
    names: Names = field(default_factory=dict)
    request: Request | None = None
    path: PathState = field(default_factory=PathState)
    mouse: Mouse = field(default_factory=Mouse)
    tool: Structure | None = None
    repeats: bool = True  # END of a main program continues at step 1 (AUTO)
    returns: bool = True  # END of a main program goes to step 1 at all (not in Test 5)
    simulated: bool = False  # inputs come from F1 and F2, outputs are not switched
    executer: bool = False  # Test 5
    effects: int = 0
    polled: tuple[Frame | None, int, int] = (None, 0, -1)  # frame, step and effects at the last jump back
    idle: bool = False
    breaks: dict[str, frozenset[int]] = field(default_factory=dict)  # key of a program -> steps before which it stops, from 0
    stops: dict[str, frozenset[int]] = field(default_factory=dict)  # the same by numbers of the steps, head included
    passes: bool = False  # START: the breakpoint in force is passed once
    _built: dict[str, tuple[int, list[Op]]] = field(default_factory=dict)
    _names: dict[tuple[int, str], tuple[Names, Names]] = field(default_factory=dict)
    _version: int = -1

    def switches(self, area: str, byte: int) -> bool:
        """Whether a byte is written: outputs are not while inputs are simulated, as markers neither (L1227, L2986)."""
        output = area == "OUTPUT" or (area == "MARKER" and byte >= OUTPUT_MARKERS)
        return not (self.simulated and output)

    # ---- programs --------------------------------------------------------------------------------------------------------
    def select(self, program: Program) -> None:
        """Select a program, as chosen by the operator: only default values of parameters remain from previous ones."""
        self.stack, self.request = [], None
        self.path, self.tool = PathState(self.path.defaults), None
        self._push(program, "main")

    def to_step(self, step: int) -> None:
        """The operator's choice of a step; tool and modal values in force stay, so that a position can be approached directly (L1208)."""
        del self.stack[1:]
        self.request, frame = None, self.stack[0]
        self.names, frame.at, frame.done = frame.names, min(max(step, 1), len(frame.program.steps)) - 1, -1

    def switch(self, name: str) -> None:
        """PROGRAM: goes to step 1 of another main program."""
        assert self.frame is not None
        found = self.memory.find(name, self.frame.program.directory)
        if found is None:
            raise StepFault(f"program {name} not found")
        if found.kind != "MPR":
            raise StepFault(f"program {name} is not a main program")
        if self.frame.program.kind not in ("MPR", "PAL"):
            raise StepFault("PROGRAM is allowed in a main program only")
        self._refuse_faulty(found)
        self.stack = []
        self._push(found, "main")

    def call(self, name: str, kinds: tuple[str, ...], back: int) -> None:
        """CALL or a macro; continues at step index `back` afterwards."""
        assert self.frame is not None
        found = self.memory.find(name, self.frame.program.directory, kinds) or self.memory.find(name, self.frame.program.directory)
        if found is None:
            raise StepFault(f"program {name} not found")
        if found.kind not in kinds:
            raise StepFault(f"program {name} is not a {'sub-program' if 'SPR' in kinds else 'macro'}")
        if len(self.stack) > DEEPEST:
            raise StepFault(f"nesting depth too big: more than {DEEPEST} calls")
        self._refuse_faulty(found)
        self.frame.at, self.frame.done = back, back - 1
        self._push(found, "macro" if found.kind == "MAC" else "call")

    def _refuse_faulty(self, program: Program) -> None:
        if program.refused:
            raise StepFault(f"program {program.name} has faults: {program.refused[0][1]}")

    def _push(self, program: Program, kind: str) -> None:
        above = self.stack[-1].names if self.stack else None
        self.stack.append(Frame(program, kind, self._names_of(above, program), self._ops(program)))
        self.frame = self.stack[-1]
        self.names = self.frame.names

    def end(self) -> int:
        """END of the program in force."""
        frame = self.frame
        assert frame is not None
        if len(self.stack) > 1:
            self.stack.pop()
            self.frame = self.stack[-1]
            self.names = self.frame.names
            return LOOK
        if frame.program.kind not in ("MPR", "PAL"):
            raise operating(OWN_RETURN)
        frame.done = len(frame.program.steps) - 1
        if self.returns:
            frame.at = 0
        if not self.repeats:
            raise Halted
        return LOOK

    def _ops(self, program: Program) -> list[Op]:
        version, ops = self._built.get(program.key, (-1, []))
        if version != self.memory.version:
            with uncollected():
                ops = self.build(self, program)
            for at in self.breaks.get(program.key, ()):
                if at < len(ops):
                    ops[at] = self._held(ops[at])
            self._built[program.key] = (self.memory.version, ops)
        return ops

    def set_breaks(self, program: Program, steps: frozenset[int]) -> None:
        """Set breakpoints of a program, by the numbers of its steps: it stops before them as by STOP."""
        self.stops[program.key] = steps
        self.breaks[program.key] = frozenset(step.number - 1 for step in program.steps[1:] if step.number in steps)
        self._built.pop(program.key, None)
        for frame in self.stack:
            if frame.program is program:
                frame.ops = self._ops(program)

    def _held(self, op: Op) -> Op:
        def held() -> int:
            if not self.passes:
                raise AtBreakpoint
            self.passes = False
            try:
                return op()
            except (NotYet, StepFault):
                self.passes = True  # it is executed again
                raise

        return held

    def _names_of(self, above: Names | None, program: Program) -> Names:
        """System, global and local names as `program` sees them below its caller."""
        if self._version != self.memory.version:
            self._names.clear()
            self._version = self.memory.version
        key = (id(above), program.key)
        if key not in self._names:
            base: Names = above if above is not None else {**self.system, **self.memory.globals}
            self._names[key] = ({**base, **self.memory.locals.get(program.key, {})}, base)  # base is kept: its id is in the key
        return self._names[key][0]

    def refresh(self) -> None:
        """Programs have changed: the frames in work get the names in force now."""
        above: Names | None = None
        for frame in self.stack:
            frame.names = above = self._names_of(above, frame.program)
        if self.frame is not None:
            self.names = self.frame.names

    def forbid_in_stack(self, program: Program | None) -> None:
        """StepFault where the program is in work (L3814)."""
        if program is not None and any(frame.program.key == program.key for frame in self.stack):
            raise StepFault(IN_THE_STACK)

    # ---- steps -----------------------------------------------------------------------------------------------------------
    def run(self, budget: int) -> int:
        """Run up to `budget` steps, until a request or an end; return the remaining budget.  StepFault, Halted: `frame.at` is the step."""
        while budget > 0 and self.request is None and not self.idle:
            frame = self.frame
            assert frame is not None
            ops, at, done = frame.ops, frame.at, frame.done
            try:
                while budget > 0:
                    budget -= 1
                    frame.at, frame.done, done = at, done, at
                    at = ops[at]()
                    if at < 0:
                        break
                else:
                    frame.at, frame.done = at, done
            except IndexError:
                raise StepFault("Step not defined!") from None
            if at < 0 and len(self.stack) == 1 and self.stack[0].at == 0:
                break  # a round of a main program begins
        return budget

    def jump(self, here: int, target: int) -> int:
        """Take a branch.  A loop that changes nothing yields its time until the next cycle."""
        if target <= here:
            mark = (self.frame, here, self.effects)
            if mark == self.polled:
                assert self.frame is not None
                self.frame.at, self.frame.done, self.idle = target, here, True
                return LOOK
            self.polled = mark
        return target

    def ask(self, request: Request, following: int) -> int:
        """Wait for a request; continue at `following`."""
        assert self.frame is not None
        self.request = request
        self._following = following
        return LOOK

    _following: int = 0

    def answered(self, at: int | None = None) -> None:
        """The request is answered: on at its following step, or at `at`."""
        assert self.frame is not None
        self.request = None
        self.frame.done, self.frame.at = self.frame.at, self._following if at is None else at

    def last_done(self) -> tuple[str, int]:
        """Program and step that was executed last; ("", 0): none of those in work."""
        frame = next((each for each in reversed(self.stack) if each.done >= 0), None)
        return ("", 0) if frame is None else (frame.program.name, frame.done + 1)


SystemNames: TypeAlias = Mapping[str, object]
