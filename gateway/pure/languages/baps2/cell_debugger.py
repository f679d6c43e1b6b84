"""The test system of a cell (modes 4 and 5 of the pendant): breakpoints, single step, variables and points of programs (AX-1040).

Breakpoints hold processes that were started in test, and no others: one that is left over does not stop the production.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from gateway.pure.image.records.interpreter import Fact
from gateway.pure.languages.baps2.forms import real_text
from gateway.pure.languages.baps2.inspection import frames_of, lines_of, plain_name
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.scope import python_name
from gateway.pure.languages.baps2.tasks import Poke, Task
from gateway.pure.languages.baps2.translation import Unit
from gateway.pure.languages.baps2.tree import Declared
from gateway.pure.languages.baps2.types import TEXT_SIZE
from gateway.pure.languages.baps2.values import HIGHEST, LOWEST, MOST_REAL, Array
from gateway.pure.languages.base.debug import Debugger, Step
from gateway.pure.languages.base.process import ProcessState

MOST_SHOWN = 200  # variables, elements of arrays among them
LOOKED_NS = 3_000_000_000  # how long variables are shown after a request
TAUGHT = re.compile(r"h\.taught\('[^']+', '([^']+)'\)")  # as a translation reads its points
POINT_NAME = re.compile(r"@?[^\W\d]\w{0,31}")
ELEMENT = re.compile(r"(@?\w+)\[(-?\d{1,9})\]")


class DebugFault(Exception):
    """Why an order of the test system is not carried out; one sentence."""


class DebuggedCell(Protocol):
    """The cell as its test system sees it."""

    def task_of(self, run: int) -> Task | None:
        """A process by its run."""

    def tasks_of(self, run: int) -> Sequence[Task]:
        """A process with its branches."""

    def here(self, program: str, point: str, kinematic: int) -> tuple[float, ...]:
        """Where a kinematic is now, as a point of this name; DebugFault."""

    def components(self, program: str) -> int:
        """Of the points of a program."""

    def points_of(self, program: str) -> Mapping[str, tuple[float, ...]]:
        """Of its point file."""

    def define(self, program: str, point: str, value: tuple[float, ...]) -> None:
        """Stores a point."""


@dataclass(slots=True)
class CellDebugger:
    """`hear` accepts an order and returns its answer, `shown` returns the published state."""

    cell: DebuggedCell
    library: Library  # programs that ask the debugger
    debugger: Debugger = field(default_factory=Debugger)
    movement: bool = True  # WITH or WITHOUT movement (L737-747)
    _runs: dict[int, bool] = field(default_factory=dict)  # runs to be started in test; True: held before the first line
    answers: list[tuple[int, int, str]] = field(default_factory=list)  # moment, ticket, why an order was refused
    _looked: int = 0
    _until: int = 0

    def take_answers(self, now: int) -> list[tuple[int, str]]:
        """Return the answers of previous turns, whose effects are on the disk."""
        found = [(ticket, answer) for since, ticket, answer in self.answers if since < now]
        self.answers = [each for each in self.answers if each[0] >= now]
        return found

    def tests(self, run: int) -> bool:
        """Whether a run that begins is one of the test."""
        return run in self._runs

    def begun(self, task: Task) -> None:
        """A process of the test."""
        task.tested = True
        if self._runs.pop(task.run, False):
            self.debugger.hold(task.process)

    def hear(self, order: Mapping[str, Fact], now: int) -> str | None:
        """An order; None: none of the test system, "" or why it is refused."""
        try:
            return self._obey(order, now)
        except DebugFault as fault:
            return str(fault)

    def _obey(self, order: Mapping[str, Fact], now: int) -> str | None:
        match order["do"]:
            case "test":
                self._runs[int(order["run"])] = bool(order["hold"])
            case "breakpoints":
                self._breakpoints(str(order["program"]), str(order["lines"]))
            case "step":
                self._step(int(order["run"]), str(order["how"]))
            case "movement":
                self.movement = bool(order["on"])
            case "look":
                self._looked, self._until = int(order["run"]), now + LOOKED_NS
            case "variable":
                self._set(int(order["run"]), str(order["program"]), str(order["name"]), str(order["value"]))
            case "teach":
                program, point = self._point(order)
                self._define(program, point, self.cell.here(program, point, int(order["kinematic"])))
            case "define":
                program, point = self._point(order)
                self._define(program, point, point_of(str(order["value"]), self.cell.components(program)))
            case _:
                return None
        return ""

    # ---- breakpoints and steps

    def _breakpoints(self, program: str, lines: str) -> None:
        """Move each to the next line with a statement; one after the last is dropped."""
        unit, _ = self.library.unit(program)
        if unit is None:
            raise DebugFault(f"{program}: no such program, or it has errors")
        there = lines_of(unit)
        wanted = [int(each) for each in lines.split(",") if each]
        found = {next((at for at in there if at >= line), 0) for line in wanted} - {0}
        if wanted and not found:
            raise DebugFault(f"{program}: there is no statement in line {wanted[0]} or below")
        self.debugger.set_breakpoints(unit.name, found)

    def _step(self, run: int, how: str) -> None:
        tasks = [task for task in self.cell.tasks_of(run) if task.main.tested]
        if not tasks:
            raise DebugFault("the process is not in test; start it in test to step it")
        for task in tasks:
            if how == "hold":
                self.debugger.hold(task.process)
            elif task.process.state is ProcessState.HELD:
                self.debugger.go_on(task.process, Step(how), task.depth)

    # ---- variables

    def _set(self, run: int, program: str, name: str, text: str) -> None:
        task = self.cell.task_of(run)
        if task is None or not task.tested:
            raise DebugFault("variables are set in a process that was started in test")
        if task.process.state is not ProcessState.HELD:
            raise DebugFault(f"{program} runs; variables are set while it is held")
        found = ELEMENT.fullmatch(name)
        base, index = (found[1].upper(), int(found[2])) if found is not None else (name.upper(), None)
        values, poke = self._access(task, program)
        python = python_name(base, 0)
        if python not in values:
            raise DebugFault(f"{base}: {program} has no variable of this name that can be set")
        held, kind = values[python], self._kind(program, base)
        if isinstance(held, Array):
            if index is None or not held.low <= index <= held.high:
                raise DebugFault(f"{base} is an array: {base}[{held.low}] to {base}[{held.high}]")
            held.set(index, value_of(kind, text, self.cell.components(program)))
        elif index is not None:
            raise DebugFault(f"{base} is not an array")
        else:
            poke(python, value_of(kind, text, self.cell.components(program)))

    @staticmethod
    def _access(task: Task, program: str) -> tuple[dict[str, object], Poke]:
        peek, poke = task.watches.get(program.upper(), (dict, _nowhere))
        return peek(), poke

    def _kind(self, program: str, name: str) -> str:
        """Base type of a variable; points need no declaration."""
        tree = self.library.tree(program)
        for each in tree.main.declarations if tree is not None else ():
            if isinstance(each, Declared) and each.name == name:
                return each.type.base
        return "JC_POINT" if name.startswith("@") else "POINT"

    # ---- points

    def _point(self, order: Mapping[str, Fact]) -> tuple[str, str]:
        """Program and name of a point that it has, or that its point file has."""
        program, point = str(order["program"]).upper(), str(order["point"]).strip().upper()
        unit, _ = self.library.unit(program)
        known = {*taught_in(unit), *self.cell.points_of(program)}
        if not known:
            raise DebugFault(f"{program}: no program with points, and no point file")
        if POINT_NAME.fullmatch(point) is None or point not in known:
            raise DebugFault(f"{point or 'no name'}: {program} has no such point; it has {', '.join(sorted(known)[:12])}")
        return program, point

    def _define(self, program: str, point: str, value: tuple[float, ...]) -> None:
        """Into the point file; processes of the test have it at once, others at their next start."""
        self.cell.define(program, point, value)
        for run in self._tested():
            task = self.cell.task_of(run)
            values, poke = self._access(task, program) if task is not None else ({}, _nowhere)
            if python_name(point, 0) in values:
                poke(python_name(point, 0), value)

    def _tested(self) -> Iterable[int]:
        return [task.run for task in self.cell.tasks_of(0) if task.tested]

    # ---- what others see

    def shown(self, now: int) -> dict[str, object]:
        """Breakpoints, and the variables of the process that is looked at."""
        points = {name: sorted(lines) for name, lines in self.debugger.breakpoints.items() if lines}
        tested = [{"run": task.run, "program": task.unit.name} for task in self.cell.tasks_of(0) if task.tested]
        found: dict[str, object] = {"test": {"movement": self.movement, "breakpoints": points, "tested": tested}}
        task = self.cell.task_of(self._looked) if now < self._until else None
        if task is not None:
            found["variables"] = self._variables(task)
            found["looked"] = task.run
        return found

    def _variables(self, task: Task) -> list[list[object]]:
        """Rows: routine, name, type, value, whether it can be set."""
        held = task.tested and task.process.state is ProcessState.HELD
        rows: list[list[object]] = []
        wide: dict[str, dict[str, object]] = {
            program: {plain_name(name): value for name, value in peek().items()} for program, (peek, _) in task.watches.items()
        }
        for frame in frames_of(task, lambda name: self.library.unit(name)[0]):
            for name, value in frame.own.items():
                rows += _rows(frame.routine, name, value, "", settable=False)
            wide.setdefault(frame.program, frame.program_wide)
        for program, values in wide.items():
            for name, value in values.items():
                rows += _rows(program, name, value, self._kind(program, name), settable=held and program in task.watches)
        return rows[:MOST_SHOWN]


def _nowhere(name: str, value: object) -> None:
    """Of a program without variables."""


def taught_in(unit: Unit | None) -> list[str]:
    """Return the points that a program reads from its point file."""
    return list(dict.fromkeys(TAUGHT.findall(unit.text))) if unit is not None else []


def _rows(where: str, name: str, value: object, kind: str, *, settable: bool) -> list[list[object]]:
    if isinstance(value, Array):
        return [[where, f"{name}[{at}]", kind, shown_value(each), settable] for at, each in enumerate(value.items, value.low)]
    return [[where, name, kind, shown_value(value), settable]]


def shown_value(value: object) -> str:
    """As it is typed; empty: not defined."""
    if value is None:
        return ""
    if isinstance(value, tuple):
        return ", ".join("-" if each is None else f"{each:.10g}" for each in value)
    return real_text(value).strip() if isinstance(value, float) else str(value)


def value_of(kind: str, text: str, components: int) -> object:
    """A value of this type as it is typed.  DebugFault."""
    typed = text.strip()
    if kind in ("POINT", "JC_POINT", "WC_FRAME"):
        return point_of(typed, 6 if kind == "WC_FRAME" else components)
    if kind in ("TEXT", "CHAR"):
        quoted = len(typed) >= 2 and typed[0] == typed[-1] == "'"
        found = typed[1:-1] if quoted else text
        most = TEXT_SIZE if kind == "TEXT" else 1
        if len(found) > most or (kind == "CHAR" and not found):
            raise DebugFault(f"{kind}: {'one character' if most == 1 else f'up to {most} characters'}")
        return found
    if kind == "BINARY" and typed in ("0", "1"):
        return int(typed)
    if kind == "INTEGER" and re.fullmatch(r"[+-]?\d{1,10}", typed) and LOWEST <= int(typed) <= HIGHEST:
        return int(typed)
    if kind == "REAL" and (number := _number(typed)) is not None:
        return number
    ranges = {"BINARY": "0 or 1", "INTEGER": f"a whole number {LOWEST} to {HIGHEST}", "REAL": "a number of up to 3.4E38"}
    raise DebugFault(f"{text!r} is not a value: {ranges.get(kind, f'a {kind} is not set here')}")


def point_of(text: str, components: int) -> tuple[float, ...]:
    """`1, 2, 3` or `(1, 2, 3)`.  DebugFault."""
    parts = [each for each in re.split(r"[\s,]+", text.strip().removeprefix("@").strip("() ")) if each]
    found = [_number(each) for each in parts]
    if len(found) != components or None in found:
        raise DebugFault(f"{text!r} is not a point: {components} numbers with a comma between")
    return tuple(each for each in found if each is not None)


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if abs(number) <= MOST_REAL else None
