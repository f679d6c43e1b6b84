"""The names of a program: meaning of each, and how a translated program reads, sets and passes it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import chain

from gateway.pure.languages.baps2.standard import STANDARD_NAMES, TAKEN
from gateway.pure.languages.baps2.tree import Head, Parameter
from gateway.pure.languages.baps2.types import NONE, Type
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.near import hint_of
from gateway.pure.languages.base.source import Position


def python_name(name: str, level: int) -> str:
    """A Python name for a name of a program, whatever characters it has."""
    return f"v{level}_" + "".join(sign if sign.isascii() and (sign.isalnum() or sign == "_") else f"_{ord(sign):x}_" for sign in name)


@dataclass(slots=True)
class Symbol:
    """One name.  `kind`: variable, constant, input, output, belt, file, semaphore, program, special, subroutine."""

    name: str
    kind: str
    type: Type = NONE
    python: str = ""  # variable: how it is read
    shared: bool = False  # PUBLIC or imported: an attribute
    reference: bool = False  # passed by reference: a Ref
    constant: object = None
    channel: int = 0
    owner: str = ""  # program that a semaphore or an import belongs to
    parameters: tuple["tuple[Type, bool]", ...] = ()  # type, by value
    written: tuple[Parameter, ...] = ()  # the same as this program declares them
    level: int = 0
    kept: str = ""  # a teach point: the program in whose point file it stays

    @property
    def misread(self) -> bool:
        """Whether its declaration is faulty and reported: it may be anything."""
        return self.kind == "variable" and self.type is NONE


@dataclass(slots=True)
class Names:
    """Scopes, the innermost last; kinematics and their components."""

    head: Head
    faults: Faults
    scopes: list[dict[str, Symbol]] = field(default_factory=lambda: [{}])
    _twice: tuple[str, int] = ("", 0)  # file and line of the last name that was declared twice
    _unknown: set[str] = field(default_factory=set)  # names reported as not declared
    _values: dict[tuple[str, int], list[Position]] = field(default_factory=dict)  # routine, parameter that it may set -> values passed
    _variables: set[tuple[str, int]] = field(default_factory=set)  # parameters that a call has passed a variable to

    def declare(self, symbol: Symbol, at: Position) -> None:
        """Enters a name in the innermost scope."""
        if symbol.name in TAKEN:
            self.faults.error("name-taken", at, f"{symbol.name} is a standard subroutine", "give it another name")
        if symbol.name in self.scopes[-1]:
            if at[:2] != self._twice:  # a list that is copied is one mistake
                self.faults.error("declared-twice", at, f"{symbol.name} is declared twice")
            self._twice = at[:2]
            return
        self.scopes[-1][symbol.name] = symbol

    def find(self, name: str) -> Symbol | None:
        """What a name is; None: not declared."""
        for scope in reversed(self.scopes):
            if (symbol := scope.get(name)) is not None:
                return symbol
        return None

    def unknown(self, name: str, at: Position, text: str, hint: str = "") -> None:
        """Reports a name that is not declared, once, with the one it is like: its declaration may be missing, or misspelt."""
        if name in self._unknown:
            return
        line = self.head.commented.get(name)
        if line is not None:
            hint = f"line {line} has it in a comment after a semicolon"
        self.once("name-unknown", name, at, text, self.like(name) or hint)

    def like(self, name: str) -> str:
        """A hint with the declared name that this one is like."""
        return hint_of(name, {*STANDARD_NAMES, *chain(*self.scopes)})

    def once(self, id: str, name: str, at: Position, text: str, hint: str = "") -> None:
        """Reports a name that is nothing, at the first place only."""
        if name not in self._unknown:
            self._unknown.add(name)
            self.faults.error(id, at, text, hint)

    def passed(self, routine: str, number: int, at: Position, *, variable: bool) -> None:
        """A call passes a variable, or a value, where the routine may set a variable."""
        if variable:
            self._variables.add((routine, number))
        else:
            self._values.setdefault((routine, number), []).append(at)

    def report_values(self) -> None:
        """Values that were passed for variables; where all of several calls do so, or of a special function, the declaration lacks its
        VALUE.
        """
        several = [key for key, places in self._values.items() if self._wants_value(key[0], places) and key not in self._variables]
        lacking = {each.type.at for key in several for each in self._written(*key)}  # one VALUE serves its group
        for key, places in self._values.items():
            written = self._written(*key)
            if written and written[0].type.at in lacking:
                kind, hint = written[0].type, f"calls pass values to {written[0].name}, not variables"
                self.faults.error("value-missing", kind.at, f"VALUE is missing in front of {kind.base}", hint)
                continue
            for at in places:
                text = "a variable or an element is expected, which the subroutine can set"
                self.faults.error("not-assignable", at, text, "use VALUE for expressions")

    def _wants_value(self, routine: str, places: Sequence[Position]) -> bool:
        """Whether so many values show that VALUE is missing: several, or one for a special function, whose form is given."""
        symbol = self.find(routine)
        return len(places) > 1 or (symbol is not None and symbol.kind == "special")

    def _written(self, routine: str, number: int) -> tuple[Parameter, ...]:
        """The parameter as this program declares it; none: another one does."""
        symbol = self.find(routine)
        return symbol.written[number : number + 1] if symbol is not None else ()

    @property
    def kinematic(self) -> str:
        """The default kinematic at the beginning."""
        if self.head.default_kinematic or not self.head.kinematics:
            return self.head.default_kinematic
        return min(self.head.kinematics, key=lambda name: self.head.kinematics[name])

    def components(self, kind: Type) -> tuple[str, ...]:
        """Component names of points of a type; () where the program names none, or not all of them can be read."""
        if self._garbled(kind, (kind.kinematic or self.kinematic, "")):
            return ()
        table = self.head.joint_names if kind.base == "JC_POINT" else self.head.world_names
        other = self.head.world_names if kind.base == "JC_POINT" else self.head.joint_names
        kinematic = kind.kinematic or self.kinematic
        return table.get(kinematic) or table.get("") or other.get(kinematic) or other.get("") or ()

    def component(self, kind: Type, name: str) -> int | None:
        """Index of a component; world and joint names of a kinematic serve both kinds of points."""
        tables = (self.head.joint_names, self.head.world_names)
        first, second = tables if kind.base == "JC_POINT" else tables[::-1]
        keys: Iterable[str] = (kind.kinematic,) if kind.kinematic else (self.kinematic, *self.head.kinematics)
        for table in (first, second):
            for key in (*keys, ""):
                if name in table.get(key, ()):
                    return table[key].index(name)
        return 0 if self._garbled(kind, (*keys, "")) else None  # it may be any of them

    def _garbled(self, kind: Type, kinematics: Iterable[str]) -> bool:
        """Whether the names of the components are faulty and reported."""
        word = "JC_NAMES" if kind.base == "JC_POINT" else "WC_NAMES"
        return any(f"{each}.{word}" in self.head.faulty for each in kinematics)
