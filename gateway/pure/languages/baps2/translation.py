"""Check of a complete program, and its translation to a Python module that makes one running copy of it at a time."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import cast

from gateway.pure.languages.baps2 import demands, errors, values
from gateway.pure.languages.baps2.bodies import Bodies
from gateway.pure.languages.baps2.flow import inside
from gateway.pure.languages.baps2.naming import Naming, Programs
from gateway.pure.languages.baps2.scope import Names, Symbol, python_name
from gateway.pure.languages.baps2.standard import DEVICES, STANDARD_NAMES
from gateway.pure.languages.baps2.travel import targets
from gateway.pure.languages.baps2.tree import Declared, Instruction, Move, Parallel, Program, Routine, StartStop, Statement
from gateway.pure.languages.baps2.types import NONE, POINTS, Type, default_of
from gateway.pure.languages.baps2.typing import Typing, kept
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.process import Body, Process
from gateway.pure.languages.base.requests import Stopped, Turn

Main = Callable[[Process], Body]  # an external subroutine has its parameters after the process
GLOBALS: dict[str, object] = {
    **{name: value for name, value in vars(values).items() if not name.startswith("_")},
    **{name: value for name, value in vars(demands).items() if isinstance(value, type)},
    "fault": errors.fault,
    "TURN": Turn(),
    "Stopped": Stopped,
}
LINE = re.compile(r"^( *)p\.line = (\d+)$", re.MULTILINE)  # as bodies.py writes it
WIDE = re.compile(r"^    (v0_\w+) = ", re.MULTILINE)  # variables of the entire program


@dataclass(slots=True)
class Unit:
    """A program that can run."""

    name: str
    program: Program
    text: str = ""
    file: str = ""  # its source without the ending, by which others start and stop it
    parameters: int = 0
    imports: str = ""
    files: dict[str, Type] = field(default_factory=dict)
    make: Callable[[object], Main] | None = None
    share: Callable[[object, object], None] | None = None

    def load(self, faults: Faults, *, watched: bool = False) -> bool:
        """Make the functions of the text; False: Python cannot compile it (reported).  `watched`: ask the debugger before each line."""
        if watched:
            self.text = _watched(self.text, self.name)
        try:
            space = dict(GLOBALS)
            exec(compile(self.text, f"<{self.name}>", "exec"), space)
            self.make = cast(Callable[[object], Main], space["make"])  # what exec() made of axisgate's own text
            self.share = cast(Callable[[object, object], None], space["share"])
        except (RecursionError, SyntaxError, MemoryError):
            _too_complex(self.program, faults)
            return False
        return True

    @property
    def permanent(self) -> bool:
        """Whether it is a permanent process."""
        return self.program.head.permanent


def _watched(text: str, name: str) -> str:
    """The debugger is asked before each line whose flag is set; a process that is held shows the variables of the entire program."""
    flags = [f"b{number} = True" for number in dict.fromkeys(number for _, number in LINE.findall(text))]
    text = LINE.sub(rf"\g<0>\n\1if b\2 and h.stops(p, {name!r}, \2, globals()): yield Stopped(\2)", "\n".join([*flags, text]))
    body, found, rest = text.partition("    return main\n")
    names = list(dict.fromkeys(WIDE.findall(body.partition("    def ")[0])))
    if not found or not names:
        return text
    peek = ["    def peek():", f"        return {{{', '.join(f'{each!r}: {each}' for each in names)}}}"]
    poke = ["    def poke(name, value):", f"        nonlocal {', '.join(names)}"]
    poke += [f"        if name == {each!r}: {each} = value" for each in names]
    return "\n".join([body.rstrip("\n"), *peek, *poke, f"    h.watched({name!r}, peek, poke)", found + rest])


def check(program: Program, faults: Faults, programs: Programs) -> Unit:
    """Check a program; the unit can run if there are no errors."""
    unit = Unit(program.main.name, program)
    try:
        unit.text = _Translation(unit, faults, programs).text()
    except RecursionError:
        _too_complex(program, faults)
    return unit


def _too_complex(program: Program, faults: Faults) -> None:
    faults.error(
        "too-complex", program.main.at, f"{program.main.name} is nested too deeply", "divide its expressions or loops into smaller ones"
    )


class _Translation:
    def __init__(self, unit: Unit, faults: Faults, programs: Programs) -> None:
        self._unit, self._faults = unit, faults
        self._head = unit.program.head
        self._names = Names(self._head, faults)
        self._asked: dict[str, str] = {}
        self._typing = Typing(self._names, self._ask)
        self._naming = Naming(self._names, self._typing, unit.name, programs)
        self._bodies = Bodies(self._names, self._typing, self._head.default_way)

    def _ask(self, code: str) -> str:
        """Return the Python name of a request that is made once for the entire program."""
        return self._asked.setdefault(code, f"q{len(self._asked)}")

    def text(self) -> str:
        """The Python module."""
        program = self._unit.program
        self._declare_subroutines(program)
        parameters = [self._naming.parameter(each, 0) for each in program.main.parameters]
        self._naming.declare(program.main.declarations, 0)
        for routine in program.subroutines:
            self._check_subroutine_names(routine)
        self._teach_points(program)
        for routine in (program.main, *program.subroutines):
            self._started(routine.body)
        self._unit.files = {name: symbol.type for name, symbol in self._names.scopes[0].items() if symbol.kind == "file"}
        self._unit.parameters, self._unit.imports = len(parameters), self._naming.imported
        variables = list(self._naming.variables)
        out = self._bodies.out
        out.indent = 1
        for level, routine in enumerate(program.subroutines, 1):
            self._subroutine(routine, level)
        self._main(program.main, parameters)
        self._names.report_values()
        head = [f"{name} = {code}" for code, name in self._asked.items()]
        return "\n".join([*head, "def make(h):", *self._prologue(variables), *out.rows, "    return main", *self._share(variables), ""])

    def _declare_subroutines(self, program: Program) -> None:
        for routine in program.subroutines:
            if routine.name in DEVICES:
                self._faults.error("declared-twice", routine.at, f"{routine.name} is a device")
            parameters: tuple[tuple[Type, bool], ...] = ()
            known = "any" if routine.garbled else None
            self._names.declare(Symbol(routine.name, "subroutine", constant=known, parameters=parameters), routine.at)

    def _check_subroutine_names(self, routine: Routine) -> None:
        """Types of the parameters, which may need constants of the main program."""
        symbol = self._names.find(routine.name)
        if symbol is not None and symbol.kind == "subroutine":
            symbol.parameters = tuple((self._naming.type_of(each.type), each.by_value) for each in routine.parameters)
            symbol.written = routine.parameters

    def _started(self, body: tuple[Statement, ...]) -> None:
        """START of other programs, and whether statements are in included files."""
        for outer in body:
            for each in inside(outer):
                self._bodies.included |= each.at.included_from is not None
                if isinstance(each, StartStop) and each.word == "START":
                    self._naming.started(each.program, each.at)
                elif isinstance(each, Parallel):
                    for branch in each.branches:
                        self._started(branch)

    # ---- teach points

    def _teach_points(self, program: Program) -> None:
        for routine in (program.main, *program.subroutines):
            own = {each.name for each in routine.parameters} | {getattr(each, "name", "") for each in routine.declarations}
            self._taught(routine.body, own, [self._names.kinematic])

    def _taught(self, body: tuple[Statement, ...], own: set[str], kinematic: list[str]) -> None:
        for outer in body:
            for each in inside(outer):
                if isinstance(each, Instruction) and each.word == "KINEMATICS":
                    kinematic[0] = each.value
                elif isinstance(each, Parallel):
                    for branch in each.branches:
                        self._taught(branch, own, kinematic)
                elif isinstance(each, Move):
                    known = not each.kinematic or each.kinematic in self._head.kinematics
                    self._targets(each, own, (each.kinematic or kinematic[0]) if known else "")

    def _targets(self, move: Move, own: set[str], kinematic: str) -> None:
        for name in targets(move):
            known = self._is_known(name.name)
            if name.name in own or known or self._names.find(name.name) is not None:
                continue
            kind = Type("JC_POINT" if name.name.startswith("@") else "POINT", kinematic)
            symbol = Symbol(name.name, "variable", kind, python_name(name.name, 0), kept=self._unit.name)
            self._names.declare(symbol, name.at)
            self._naming.variables.append((symbol, None))

    def _is_known(self, name: str) -> bool:
        return name in STANDARD_NAMES or name in self._head.kinematics or name in DEVICES

    # ---- parts of the module

    def _value_at_start(self, symbol: Symbol) -> str:
        if symbol.kept and symbol.type.is_array:
            return f"h.taught_array({symbol.kept!r}, {symbol.name!r}, {symbol.type.low}, {symbol.type.high})"
        if symbol.type.base in POINTS and not symbol.type.is_array:
            return f"h.taught({self._unit.name!r}, {symbol.name!r})"
        return default_of(symbol.type) if symbol.type is not NONE else "None"

    def _declared(self, symbol: Symbol, indent: str) -> list[str]:
        """A variable and, where it is passed by reference, its Ref."""
        name = symbol.python
        rows = [f"{indent}{name} = {self._value_at_start(symbol)}"]
        if name in self._typing.referenced:
            rows += [
                f"{indent}def w_{name}(x):",
                f"{indent}    nonlocal {name}",
                f"{indent}    {name} = {kept(symbol, 'x')}",
                f"{indent}r_{name} = Ref(lambda: {name}, w_{name})",
            ]
        return rows

    def _prologue(self, variables: list[tuple[Symbol, Declared | None]]) -> list[str]:
        rows = ["    pass"]
        if self._naming.publics:
            rows.append(f"    g = h.shared({self._unit.name!r})")
        if self._naming.imported:
            rows.append(f"    {python_name(self._naming.imported, 9)} = h.shared({self._naming.imported!r})")
        for symbol, _ in variables:
            if not symbol.shared:
                rows += self._declared(symbol, "    ")
        return rows

    def _share(self, variables: list[tuple[Symbol, Declared | None]]) -> list[str]:
        rows = [f"    {symbol.python} = {self._value_at_start(symbol)}" for symbol, _ in variables if symbol.shared]
        return ["def share(h, g):", "    pass", *rows]

    def _main(self, routine: Routine, parameters: list[Symbol]) -> None:
        out = self._bodies.out
        names = ", ".join(["p", *(each.python for each in parameters)])
        out.add(f"def main({names}):")
        out.indent += 1
        self._bodies.body(
            routine.body,
            ("yield Drain()",) if not self._unit.program.external_subroutine else ("if 0: yield",),
            [each.python for each in parameters],
        )
        out.indent -= 1

    def _subroutine(self, routine: Routine, level: int) -> None:
        self._names.scopes.append({})
        kinematic, way = self._typing.kinematic, self._bodies.way
        before = len(self._naming.variables)
        parameters = [self._naming.parameter(each, level) for each in routine.parameters]
        self._naming.declare(routine.declarations, level)
        mine = [symbol for symbol, _ in self._naming.variables[before:] if symbol.level == level]
        out = self._bodies.out
        out.add(f"def s_{python_name(routine.name, 0)}({', '.join(['p', *(each.python for each in parameters)])}):")
        out.indent += 1
        out.add("h.deeper(p)")
        place = len(out.rows)
        own = [symbol.python for symbol in (*parameters, *mine)]
        self._bodies.body(routine.body, ("h.back(p)", "if 0: yield"), own)
        rows = [row for symbol in mine if not symbol.shared for row in self._declared(symbol, "    " * out.indent)]
        rows += [row for symbol in parameters for row in self._passed_on(symbol, "    " * out.indent)]
        out.rows[place + 1 : place + 1] = rows
        out.indent -= 1
        del self._naming.variables[before:]
        self._names.scopes.pop()
        self._typing.kinematic, self._bodies.way = kinematic, way

    def _passed_on(self, symbol: Symbol, indent: str) -> list[str]:
        """The Ref of a parameter by value that is passed by reference further on."""
        if symbol.reference or symbol.kind != "variable" or symbol.python not in self._typing.referenced:
            return []
        return self._declared(symbol, indent)[1:]
