"""Enters the declarations of a program in its names: types, constants, channels, imports, special functions."""

from collections.abc import Callable, Iterable, Mapping

from gateway.pure.languages.baps2 import standard
from gateway.pure.languages.baps2.scope import Names, Symbol, python_name
from gateway.pure.languages.baps2.tree import Constant, Declaration, Declared, External, Parameter, Program, SpecialFunction, TypeName
from gateway.pure.languages.baps2.types import BINARY, FRAME, INTEGER, NONE, REAL, Type
from gateway.pure.languages.baps2.typing import Typing
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.near import hint_of
from gateway.pure.languages.base.source import Position

Programs = Callable[[str], Program | None]
MOST_ELEMENTS = 100_000
CHANNELS = {  # ranges of channels and their types (spec 0.3)
    "input": ((1, 199, BINARY), (201, 224, REAL), (401, 408, INTEGER), (600, 799, BINARY), (801, 804, BINARY)),
    "output": ((1, 199, BINARY), (201, 224, REAL), (401, 408, INTEGER), (801, 804, BINARY)),
}
ASYNCHRONOUS = 1_000


class Naming:
    """Enters names.  `programs`: the tree of another program, or None."""

    def __init__(self, names: Names, typing: Typing, program: str, programs: Programs) -> None:
        self._names, self._typing, self._program, self._programs = names, typing, program, programs
        self.publics: list[Symbol] = []
        self.variables: list[tuple[Symbol, Declared | None]] = []
        self._imported = ""
        self._gone: set[str] = set()  # programs reported as missing

    def fault(self, id: str, at: Position, text: str, hint: str = "") -> None:
        """Reports a fault."""
        self._names.faults.error(id, at, text, hint)

    def declare(self, declarations: Iterable[Declaration], level: int) -> None:
        """Declare all names of a routine; constants first, because they may follow their uses (L7163-7169)."""
        found = tuple(declarations)
        for each in found:
            if isinstance(each, Constant):
                self._constant(each)
        for each in found:
            match each:
                case Declared():
                    self._declared(each, level)
                case External():
                    self._external(each, level)
                case SpecialFunction():
                    self._special(each)

    def _constant(self, each: Constant) -> None:
        value = self._typing.of(each.value)
        if value.type is not NONE and value.constant is None:
            self.fault("no-constant", each.at, f"{each.name} is not a constant: its value is known only when the program runs")
        self._names.declare(Symbol(each.name, "constant", value.type, constant=value.constant), each.at)

    def type_of(self, written: TypeName, *, joint: bool = False) -> Type:
        """The type that is written; NONE where its bounds are faulty (reported).  `joint`: WC_POINT of an @ name (D-34)."""
        if not written.base:  # it was misspelt
            return NONE
        kind = Type("JC_POINT" if joint and written.base == "POINT" else written.base, written.kinematic, element=written.element)
        if written.base == "WC_FRAME":
            return FRAME
        if written.low is None or written.high is None:
            return kind
        bounds = [self._typing.of(bound) for bound in (written.low, written.high)]
        low, high = (bound.constant for bound in bounds)
        if not isinstance(low, int) or not isinstance(high, int):
            if NONE not in (bounds[0].type, bounds[1].type):
                self.fault("bounds", written.at, "the bounds of an array are INTEGER constants")
            return NONE
        if not 0 <= high - low < MOST_ELEMENTS:
            self.fault("bounds", written.at, f"{low}..{high}: the bounds of an array must rise, with at most {MOST_ELEMENTS} elements")
            return NONE
        return Type(kind.base, written.kinematic, low, high)

    def _declared(self, each: Declared, level: int) -> None:
        base = each.type.base
        if (each.public or each.teach) and level:
            self.fault("public-place", each.at, "PUBLIC and DEF belong in the declarations of the main program only")
        if each.teach and base and base not in ("POINT", "JC_POINT"):
            self.fault("teach-type", each.at, f"DEF is for points, {each.name} is {base}")
        if base == "JC_POINT" and not each.name.startswith("@"):
            self.fault("at-sign", each.at, f"the name of a JC_POINT begins with @: {each.name}")
        if base in ("INPUT", "OUTPUT", "BELT"):
            self._names.declare(self._channel(each), each.at)
            return
        if base in ("FILE", "BNR_FILE", "SEMAPHORE"):
            symbol = Symbol(each.name, "semaphore" if base == "SEMAPHORE" else "file", self.type_of(each.type), owner=self._program)
        else:
            name = python_name(each.name, level)
            kind = self.type_of(each.type, joint=each.name.startswith("@"))
            symbol = Symbol(each.name, "variable", kind, f"g.{name}" if each.public else name, each.public, level=level)
            symbol.kept = self._program if each.teach else ""
            self.variables.append((symbol, each))
        self._names.declare(symbol, each.at)
        if each.public:
            self.publics.append(symbol)
            if self._imported:
                self._mixed(each.at)

    def _channel(self, each: Declared) -> Symbol:
        kind, number = each.type.base.lower(), 0
        if each.channel is not None:
            channel = self._typing.of(each.channel)
            if isinstance(channel.constant, int):
                number = channel.constant
            elif channel.type is not NONE:
                self.fault("channel", each.at, f"the channel of {each.name} is not an INTEGER constant")
        if kind == "belt":
            if not 501 <= number <= 508:
                self.fault("channel", each.at, f"belt channel {number} of {each.name} is not in 501..508")
            return Symbol(each.name, "belt", REAL, channel=number)
        place = number - ASYNCHRONOUS if kind == "input" and number > ASYNCHRONOUS else number
        found = next((type for low, high, type in CHANNELS[kind] if low <= place <= high), None)
        if found is None or (place != number and place >= 600):
            self.fault("channel", each.at, f"there is no {kind} channel {number}", "1..199 BINARY, 201..224 REAL, 401..408 INTEGER")
        elif each.type.element and each.type.element != found.base:
            self.fault("channel", each.at, f"channel {number} is {found}, not {each.type.element}")
        return Symbol(each.name, kind, found or NONE, channel=number)

    # ---- other programs

    def _external(self, each: External, level: int) -> None:
        if not each.program:
            for name, at in each.names:
                self._names.declare(self._other(name, at), at)
            return
        if level:
            self.fault("public-place", each.at, "EXTERNAL data belong in the declarations of the main program only")
        exporter = self._programs(each.program)
        if exporter is not None and self._imported not in ("", each.program):
            self.fault("import-two", each.at, f"data of {self._imported} are imported already; data may be imported from one program only")
        if exporter is not None:
            self._imported = each.program
        if self.publics:
            self._mixed(each.at)
        if exporter is None and each.program not in self._gone:
            self._gone.add(each.program)
            self.fault(
                "import-missing", each.at, f"program {each.program} does not exist", f"{each.program}.QLL belongs in the same folder"
            )
        exports = {} if exporter is None else exports_of(exporter, self._programs)
        for name, at in each.names:
            found = exports.get(name)
            if found is None:
                if exporter is not None:
                    hint = hint_of(name, exports)
                    self.fault("import-unknown", at, f"{name} is not PUBLIC in {each.program}", hint)
                    self._meant(name, exports, at)
                found = Symbol(name, "variable", NONE, python_name(name, 0))
            self._names.declare(self._imported_symbol(found, each.program), at)

    def _meant(self, name: str, exports: Mapping[str, Symbol], at: Position) -> None:
        """Declare the name that a misspelt import is like, if the program does not: its uses are consequences."""
        for like in exports:
            if hint_of(name, (like,)) and self._names.find(like) is None:
                self._names.declare(Symbol(like, "variable", NONE, python_name(like, 0)), at)

    def _mixed(self, at: Position) -> None:
        self.fault("import-mixed", at, "a program imports data or exports them, not both")

    @staticmethod
    def _imported_symbol(found: Symbol, program: str) -> Symbol:
        python = f"{python_name(program, 9)}.{found.python.rpartition('.')[2]}"
        return Symbol(found.name, found.kind, found.type, python, True, owner=program, kept=found.kept)

    @property
    def imported(self) -> str:
        """The program that data are imported from."""
        return self._imported

    def _other(self, name: str, at: Position) -> Symbol:
        """An external program; one with parameters is an external subroutine."""
        program = self._programs(name) if name != self._program else None
        if program is None and name != self._program:
            self._missing(name, at)
            return Symbol(name, "program", constant="any")  # its parameters are unknown
        if program is None or not program.external_subroutine:
            return Symbol(name, "program")
        parameters = tuple((self.type_of(each.type), each.by_value) for each in program.main.parameters)
        return Symbol(name, "program", parameters=parameters)

    def _missing(self, name: str, at: Position) -> None:
        """Only a run finds it (1092): it may be loaded later."""
        if name in self._gone:
            return
        hint = f"put {name}.QLL into the same folder; starting or calling it while it is missing ends the program with error 1092"
        self._names.faults.warning("program-missing", at, f"program {name} does not exist", hint)

    def started(self, name: str, at: Position) -> None:
        """Check START of a program; a declared one was checked at its declaration."""
        program = self._programs(name) if name != self._program else None
        if program is None and name != self._program and self._names.find(name) is None:
            self._missing(name, at)
        elif program is not None and program.external_subroutine:
            hint = "call it by its name; START ends the program with error 1073"
            self._names.faults.warning("subroutine-started", at, f"{name} is an external subroutine", hint)

    # ---- special functions

    def _special(self, each: SpecialFunction) -> None:
        number = self._typing.of(each.number).constant
        parameters = tuple((self.type_of(parameter.type), parameter.by_value) for parameter in each.parameters)
        symbol = Symbol(
            each.name, "special", channel=number if isinstance(number, int) else 0, parameters=parameters, written=each.parameters
        )
        self._names.declare(symbol, each.at)
        if number in standard.NAMED_ONLY or any(kind is NONE for kind, _ in parameters):
            return
        forms = standard.SPECIAL.get(number) if isinstance(number, int) else None
        if forms is None:
            self.fault("special-function-unknown", each.at, f"there is no special function {number}")
        elif tuple(f"{kind.base}{'[]' if kind.is_array else ''}" for kind, _ in parameters) not in [
            tuple(base for base, _ in form) for form in forms
        ]:
            listed = ", ".join(base for base, _ in forms[0])
            self.fault("special-function-parameters", each.at, f"special function {number} has the parameters {listed}")

    def parameter(self, each: Parameter, level: int) -> Symbol:
        """Enters a parameter of a subroutine."""
        kind, name = self.type_of(each.type), python_name(each.name, level)
        if kind.base in ("FILE", "BNR_FILE"):
            symbol = Symbol(each.name, "file", kind, name, reference=True)
        elif kind.base in ("INPUT", "OUTPUT"):
            symbol = Symbol(each.name, kind.base.lower(), BINARY, name, reference=True)
        else:
            symbol = Symbol(each.name, "variable", kind, name, reference=not each.by_value, level=level)
        self._names.declare(symbol, each.at)
        return symbol


def exports_of(program: Program, programs: Programs) -> dict[str, Symbol]:
    """The PUBLIC names of a program; its own faults are reported where it is checked itself."""
    names = Names(program.head, Faults())
    naming = Naming(names, Typing(names, str), program.main.name, lambda name: None)
    naming.declare(program.main.declarations, 0)
    return {symbol.name: symbol for symbol in naming.publics}
