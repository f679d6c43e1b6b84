"""Types expressions and translates them to Python in one pass.  A faulty part is reported and has the type NONE, which fits everything."""

from collections.abc import Callable

from gateway.pure.languages.baps2 import standard, values
from gateway.pure.languages.baps2.operators import CHECKED, Operators
from gateway.pure.languages.baps2.scope import Names, Symbol
from gateway.pure.languages.baps2.standard import DEVICES
from gateway.pure.languages.baps2.tree import Binary, Call, Expression, Faulty, Index, Member, Name, Number, PointValue, Text, Unary
from gateway.pure.languages.baps2.typed import NOTHING, Typed, numbers_text
from gateway.pure.languages.baps2.types import BINARY, CHAR, FRAME, INTEGER, NONE, NUMBERS, POINTS, REAL, TEXT, Type
from gateway.pure.languages.base.requests import RuntimeFault
from gateway.pure.languages.base.source import Position


class Typing:
    """Translates the expressions of a program.  `ask`: the Python name of a request that is made once."""

    def __init__(self, names: Names, ask: Callable[[str], str]) -> None:
        self.names, self._ask = names, ask
        self._operators = Operators(self.fault)
        self.direct = False  # inside of a condition that is waited for: nothing is asked of the host, values are looked up
        self.kinematic = names.kinematic  # the default here
        self.referenced: set[str] = set()  # variables that are passed by reference somewhere
        self.written: set[str] = set()  # variables that the function under translation sets

    def fault(self, id: str, at: Position, text: str, hint: str = "") -> Typed:
        """Reports a fault."""
        self.names.faults.error(id, at, text, hint)
        return NOTHING

    def of(self, tree: Expression) -> Typed:
        """The typed expression."""
        match tree:
            case Name():
                return self._name(tree)
            case Binary():
                return self._binary(tree)
            case Number():
                return self._number(tree.at, tree.value)
            case Text(value=value):
                return Typed(CHAR if len(value) == 1 else TEXT, repr(value[:80]), value[:80])
            case Member():
                return self._member(tree)
            case Index():
                return self._index(tree)
            case PointValue():
                return self._point(tree)
            case Call():
                return self._call(tree)
            case Unary():
                return self._unary(tree)
            case Faulty():
                return NOTHING

    def _number(self, at: Position, value: int | float) -> Typed:
        if isinstance(value, int):
            if value > values.HIGHEST:
                return self.fault("number-range", at, f"{value} is not a 32-bit integer")
            return Typed(INTEGER, str(value), value)
        if not abs(value) <= values.MOST_REAL:
            return self.fault("number-range", at, "this number is greater than any REAL")
        return Typed(REAL, repr(value), value)

    # ---- names

    def _name(self, tree: Name) -> Typed:
        symbol = self.names.find(tree.name)
        if symbol is None:
            return self._standard(tree, self.kinematic)
        if symbol.kind == "variable":
            return Typed(symbol.type, f"{symbol.python}.get()" if symbol.reference and not symbol.type.is_array else symbol.python)
        if symbol.kind == "constant":
            return Typed(symbol.type, repr(symbol.constant), symbol.constant)
        if symbol.kind == "input":
            return Typed(symbol.type, self._input(symbol))
        if symbol.kind == "output":
            return Typed(symbol.type, f"h.output({_channel(symbol)})")
        if symbol.kind == "belt":
            return Typed(REAL, f"h.belt({symbol.channel})")
        return self.fault("no-value", tree.at, f"{tree.name} is {with_article(symbol.kind)} and has no value")

    def _input(self, symbol: Symbol) -> str:
        if symbol.reference:
            return f"h.input({symbol.python})" if self.direct else f"(yield ReadInput({symbol.python}))"
        return f"h.input({symbol.channel})" if self.direct else f"(yield {self._ask(f'ReadInput({symbol.channel})')})"

    def _standard(self, tree: Name, kinematic: str) -> Typed:
        name = tree.name
        if name in standard.POSITIONS:
            code = f"ReadPosition({kinematic!r}, {name!r})"
            direct = f"h.position({kinematic!r}, {name!r})"
            return Typed(Type(standard.POSITIONS[name], kinematic), direct if self.direct else f"(yield {self._ask(code)})")
        if name in standard.CONSTANTS:
            kind, value = standard.CONSTANTS[name]
            return Typed(kind, repr(value), value)
        if name in standard.FACTORS:
            return Typed(REAL, f"h.factor({kinematic!r}, {name!r})")
        if name in standard.LIMITS:
            return Typed(Type("POINT", kinematic), f"h.limit({kinematic!r}, {name!r})")
        if name == "WC_UR":
            return Typed(FRAME, "(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)")
        if name == "WC_SYSTEM":
            return Typed(FRAME, f"h.frame({kinematic!r})")
        if name in self.names.head.kinematics:
            return self.fault("no-value", tree.at, f"{name} is a kinematic and has no value")
        if name in DEVICES:
            return self.fault("no-value", tree.at, f"{name} is a device and has no value")
        self.names.unknown(name, tree.at, f"{name} is not declared")
        return NOTHING

    def is_kinematic(self, tree: Expression) -> bool:
        """Whether the expression names a kinematic."""
        return isinstance(tree, Name) and tree.name in self.names.head.kinematics and self.names.find(tree.name) is None

    def _member(self, tree: Member) -> Typed:
        if isinstance(tree.base, Name) and self.is_kinematic(tree.base):
            if tree.name not in standard.STANDARD_NAMES:
                return self.fault("name-unknown", tree.at, f"{tree.name} is not a standard variable of a kinematic")
            return self._standard(Name(tree.at, tree.name), tree.base.name)
        base = self.of(tree.base)
        index = self.component(tree, base.type)
        return Typed(REAL, f"component({base.code}, {index})") if index is not None else NOTHING

    def component(self, tree: Member, kind: Type) -> int | None:
        """Index of the component that is named; faults are reported."""
        if kind is NONE:
            return None
        if kind.base not in POINTS or kind.is_array:
            self.fault("type", tree.at, f"{tree.name} is not a component: {kind} has none")
            return None
        index = self.names.component(kind, tree.name)
        if index is None:
            self.fault("component-unknown", tree.at, f"{tree.name} is not a component of {kind}")
        return index

    def _index(self, tree: Index) -> Typed:
        base, index = self.of(tree.base), self.whole(tree.index, "an index")
        if base.type is NONE or index.type is NONE:
            return NOTHING
        self.bounds(tree, base.type, index)
        if base.type.is_array:
            return Typed(base.type.item, f"{base.code}.get({index.code})")
        if base.type == TEXT:
            return Typed(CHAR, f"letter({base.code}, {index.code})")
        return self.fault("type", tree.at, f"{base.type} has no elements")

    def bounds(self, tree: Index, kind: Type, index: Typed) -> None:
        """Reports a constant index outside the bounds."""
        low, high = (kind.low, kind.high) if kind.low is not None and kind.high is not None else (1, 80)
        if isinstance(index.constant, int) and not low <= index.constant <= high:
            self.fault("index-range", tree.at, f"index {index.constant} is not in {low}..{high}")

    def whole(self, tree: Expression, what: str) -> Typed:
        """An INTEGER."""
        found = self.of(tree)
        if found.type not in (INTEGER, NONE):
            return self.fault("type", tree.at, f"{what} is INTEGER, not {found.type}")
        return found

    def number(self, tree: Expression, what: str) -> Typed:
        """INTEGER or REAL."""
        found = self.of(tree)
        if found.type not in (INTEGER, REAL, NONE):
            return self.fault("type", tree.at, f"{what} is a number, not {found.type}")
        return found

    def truth(self, tree: Expression, what: str) -> Typed:
        """A condition."""
        found = self.of(tree)
        if found.type not in (BINARY, NONE) and not (found.type == INTEGER and found.constant in (0, 1)):
            return self.fault("type", tree.at, f"{what} is BINARY, not {found.type}")
        return found

    # ---- points

    def _point(self, tree: PointValue) -> Typed:
        parts = [self.number(value, "a component") for value in tree.values]
        if any(part.type is NONE for part in parts):
            return NOTHING
        return Typed(Type("JC_POINT" if tree.joint else "POINT"), numbers_text(parts))

    def point(self, tree: Expression, kinematic: str, *, target: bool = False) -> Typed:
        """A point of a kinematic; a number in brackets is a point with one component (L1667)."""
        found = self.of(tree)
        if found.type in (INTEGER, REAL):
            found = Typed(Type("POINT"), numbers_text([found]))
            tree = PointValue(tree.at, (tree,), joint=False)
        if found.type is NONE:
            return found
        if found.type.base not in POINTS or found.type.is_array:
            return self.fault("type", tree.at, f"a point is expected, not {found.type}")
        self.size(tree, kinematic)
        if target and found.type.kinematic and found.type.kinematic != kinematic:
            return self.fault("kinematic-other", tree.at, f"this point belongs to {found.type.kinematic}, {kinematic} moves")
        return found

    def size(self, tree: Expression, kinematic: str) -> None:
        """Reports a point in brackets that has not the components of the kinematic."""
        if not isinstance(tree, PointValue):
            return
        expected = len(self.names.components(Type("JC_POINT" if tree.joint else "POINT", kinematic)))
        if expected and len(tree.values) != expected:
            self.fault("point-size", tree.at, f"{len(tree.values)} components; {kinematic or 'the kinematic'} has {expected}")

    # ---- functions

    def _call(self, tree: Call) -> Typed:
        if tree.name in standard.FUNCTIONS and self.names.find(tree.name) is None:
            return self._function(tree)
        if tree.name in standard.CONDITIONS:
            return self._condition(tree)
        if tree.name in standard.ENDS:
            return self._at_end(tree)
        if tree.name in standard.CONVERSIONS:
            return self._conversion(tree)
        if tree.name == "WC_FRAME":
            if len(tree.arguments) != 6:
                return self.fault("argument-count", tree.at, f"WC_FRAME takes 6 values, not {len(tree.arguments)}")
            parts = [self.number(value, "a component") for value in tree.arguments]
            return NOTHING if any(part.type is NONE for part in parts) else Typed(FRAME, numbers_text(parts))
        known = self.names.find(tree.name)
        if known is not None:
            text = f"{tree.name} is {with_article(known.kind)}, not a function"
            return NOTHING if known.misread else self.fault("no-value", tree.at, text)
        self.names.unknown(tree.name, tree.at, f"{tree.name} is not a function")
        return NOTHING

    def _function(self, tree: Call) -> Typed:
        takes, result, python = standard.FUNCTIONS[tree.name]
        if len(tree.arguments) != 1:
            return self.fault("argument-count", tree.at, f"{tree.name} takes one value, not {len(tree.arguments)}")
        value = self.of(tree.arguments[0])
        good = value.type.base in NUMBERS if takes == "NUMBER" else value.type.base == takes
        if value.type is NONE:
            return NOTHING
        if not good or value.type.is_array:
            wanted = "a number" if takes == "NUMBER" else takes
            return self.fault("type", tree.at, f"{tree.name} takes {wanted}, not {value.type}")
        if tree.name == "ABS":
            return Typed(value.type, CHECKED.format(f"abs({value.code})") if value.type == INTEGER else f"abs({value.code})")
        if tree.name == "CHR":
            constant = values.character(value.constant) if isinstance(value.constant, int) else None
            return Typed(result, repr(constant) if constant is not None else f"{python}({value.code})", constant)
        if tree.name == "ORD" and isinstance(value.constant, str):
            return Typed(result, f"{python}({value.code})", values.code(value.constant))
        if tree.name in standard.ROUNDED and isinstance(value.constant, int | float):
            return self._rounded(tree, value.constant)
        return Typed(result, f"{python}({value.code})")

    def _at_end(self, tree: Call) -> Typed:
        unit = self.unit(tree.arguments[0]) if len(tree.arguments) == 1 else ""
        if unit:
            return Typed(BINARY, f"h.at_end(p, {unit})", truth=True)
        named = tree.arguments[0] if tree.arguments else None
        self.names.once("type", named.name if isinstance(named, Name) else str(tree.at), tree.at, f"{tree.name} takes a file")
        return NOTHING

    def _rounded(self, tree: Call, number: float) -> Typed:
        """ROUND or TRUNC of a constant is one."""
        try:
            found = standard.ROUNDED[tree.name](number)
        except RuntimeFault as error:
            return self.fault("constant", tree.at, error.text)
        return Typed(INTEGER, f"({found})", found)

    def _conversion(self, tree: Call) -> Typed:
        takes, gives = standard.CONVERSIONS[tree.name]
        if len(tree.arguments) != 1:
            return self.fault("argument-count", tree.at, f"{tree.name} takes one point")
        value = self.of(tree.arguments[0])
        if value.type is NONE:
            return NOTHING
        if value.type.base != takes:
            return self.fault("type", tree.at, f"{tree.name} takes {takes}, not {value.type}")
        kinematic = value.type.kinematic or self.kinematic
        return Typed(Type(gives, value.type.kinematic), f"h.{tree.name.lower()}({kinematic!r}, point({value.code}))")

    def _condition(self, tree: Call) -> Typed:
        if len(tree.arguments) != 1:
            return self.fault("argument-count", tree.at, f"{tree.name} takes one device, file or signal")
        argument = tree.arguments[0]
        if isinstance(argument, Text):
            if not signal_place(argument.value):
                return self.fault("signal", argument.at, f"{argument.value!r} is not a signal", "the form is I88.0")
            code = f"Condition({argument.value.upper()!r}, True)"
        elif (unit := self.unit(argument)) == "":
            named = argument.name if isinstance(argument, Name) else str(tree.at)
            self.names.once("type", named, tree.at, f"{tree.name} takes a device, a file or a signal")
            return NOTHING
        else:
            code = f"Condition({unit})"
        return Typed(INTEGER, f"h.condition(p, {code})" if self.direct else f"(yield {code})")

    def unit(self, tree: Expression) -> str:
        """Python text of the name of a device or file; "": it is none."""
        if not isinstance(tree, Name):
            return ""
        symbol = self.names.find(tree.name)
        if symbol is not None:
            if symbol.kind != "file" and not symbol.misread:
                return ""
            return symbol.python if symbol.reference else repr(tree.name)
        return repr(tree.name) if tree.name in DEVICES else ""

    # ---- operators

    def _unary(self, tree: Unary) -> Typed:
        if tree.sign == "NOT":
            value = self.truth(tree.value, "the operand of NOT")
            if value.type is NONE:
                return NOTHING
            return Typed(BINARY, f"(not {value.code})", truth=True)
        if tree.sign == "-" and isinstance(tree.value, Number) and tree.value.value == 2**31:
            return Typed(INTEGER, "(-2147483648)", -(2**31))
        return self._operators.sign(tree, self.of(tree.value))

    def _binary(self, tree: Binary) -> Typed:
        if tree.sign in ("AND", "OR"):
            left, right = (self.truth(each, f"an operand of {tree.sign}") for each in (tree.left, tree.right))
            if NONE in (left.type, right.type):
                return NOTHING
            return Typed(BINARY, f"({left.code} {tree.sign.lower()} {right.code})", truth=True)
        return self._operators.between(tree, self.of(tree.left), self.of(tree.right))

    # ---- assignment

    def assigned(self, tree: Expression, value: str) -> str:
        """Python statement that sets a variable; "" where it cannot be set (reported)."""
        match tree:
            case Name():
                return self._set_name(tree, value)
            case Member() if isinstance(tree.base, Name) and self.is_kinematic(tree.base):
                return self._set_standard(tree, tree.base.name, tree.name, value)
            case Member():
                base = self.of(tree.base)
                index = self.component(tree, base.type)
                if index is None:
                    return ""
                size = len(self.names.components(base.type))
                return self.assigned(tree.base, f"with_component({base.code}, {index}, {size}, {value})")
            case Index():
                base, place = self.of(tree.base), self.whole(tree.index, "an index")
                if base.type is NONE or place.type is NONE:
                    return ""
                self.bounds(tree, base.type, place)
                if base.type.is_array:
                    return f"{base.code}.set({place.code}, {value})"
                return self.assigned(tree.base, f"lettered({base.code}, {place.code}, {value})") if base.type == TEXT else ""
        self.fault("not-assignable", tree.at, "this cannot be assigned to")
        return ""

    def _set_name(self, tree: Name, value: str) -> str:
        symbol = self.names.find(tree.name)
        if symbol is None:
            return self._set_standard(tree, self.kinematic, tree.name, value)
        if symbol.kind == "output":
            return f"yield WriteOutput({_channel(symbol)}, {value})"
        if symbol.kind != "variable":
            self.fault("not-assignable", tree.at, f"{tree.name} is {with_article(symbol.kind)} and cannot be assigned to")
            return ""
        if symbol.type.is_array:
            return f"{symbol.python}.fill({value})"
        if symbol.reference:
            return f"{symbol.python}.set({value})"
        if not symbol.shared:
            self.written.add(symbol.python)
        return f"{symbol.python} = {kept(symbol, value)}"

    def _set_standard(self, tree: Expression, kinematic: str, name: str, value: str) -> str:
        if name in standard.FACTORS:
            return f"h.set_factor({kinematic!r}, {name!r}, {value})"
        if name in standard.LIMITS:
            return f"h.set_limit({kinematic!r}, {name!r}, {value})"
        if name == "WC_SYSTEM":
            return f"h.set_frame({kinematic!r}, {value})"
        if name in standard.STANDARD_NAMES:
            self.fault("not-assignable", tree.at, f"{name} cannot be assigned to")
        else:
            self.names.unknown(name, tree.at, f"{name} is not declared")
        return ""

    def reference(self, tree: Expression) -> tuple[Type, str]:
        """Type and Python text of a variable that is passed by reference; NONE and "" where it is none (reported)."""
        found = self.of(tree)
        if found.type is NONE:
            return NONE, ""
        symbol = self.names.find(tree.name) if isinstance(tree, Name) else None
        if found.type.is_array:
            return found.type, found.code
        if symbol is not None and symbol.reference and symbol.kind == "variable":
            return found.type, symbol.python
        if not isinstance(tree, Name | Member | Index):
            return self._no_reference(tree, "not-assignable")
        written, before = set(self.written), self.names.faults.errors
        value = self.assigned(tree, "x")
        self.written = written
        if self.names.faults.errors > before:
            return NONE, ""
        if symbol is not None and symbol.kind == "variable" and not symbol.shared:
            self.referenced.add(symbol.python)
            return found.type, f"r_{symbol.python}"
        if symbol is not None and symbol.shared:
            owner, _, attribute = symbol.python.partition(".")
            return found.type, f"Ref(lambda: {symbol.python}, lambda x: setattr({owner}, {attribute!r}, x))"
        if isinstance(tree, Member | Index) and not (self.is_kinematic(tree.base) or self.of(tree.base).type.is_array):
            return found.type, self._part(tree)
        if isinstance(tree, Index) and value and ".set(" in value and " = " not in value and "yield" not in value:
            return found.type, f"element({self.of(tree.base).code}, {self.of(tree.index).code})"
        return self._no_reference(tree)

    def _part(self, tree: Member | Index) -> str:
        """Python text of a component of a point or a character of a TEXT, by way of the entire value."""
        kind, whole = self.reference(tree.base)
        if not whole:
            return ""
        if isinstance(tree, Index):
            return f"sign({whole}, {self.of(tree.index).code})"
        return f"part({whole}, {self.component(tree, kind)}, {len(self.names.components(kind))})"

    def _no_reference(self, tree: Expression, id: str = "reference") -> tuple[Type, str]:
        self.fault(id, tree.at, "a variable or an element is expected, which the subroutine can set", "use VALUE for expressions")
        return NONE, ""


def _channel(symbol: Symbol) -> str:
    """Python text of the channel of an output; that of a parameter is known only in the run."""
    return symbol.python if symbol.reference else str(symbol.channel)


def signal_place(text: str) -> tuple[str, int, int] | None:
    """Letter, byte and bit of a signal; English and German letters (L11298-11322)."""
    letter, (byte, _, bit) = text[:1].upper(), text[1:].partition(".")
    if letter not in ("I", "O", "E", "A", "M") or not (byte.isdecimal() and byte.isascii()) or bit not in tuple("01234567"):
        return None
    return ({"E": "I", "A": "O"}.get(letter, letter), int(byte), int(bit)) if len(byte) <= 3 and int(byte) < 128 else None


def with_article(kind: str) -> str:
    """A noun with its article."""
    kind = "special function" if kind == "special" else kind
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


def kept(symbol: Symbol, value: str) -> str:
    """Python text of a value that is assigned to a variable: a teach point goes into its point file, too."""
    return f"h.keep({symbol.kept!r}, {symbol.name!r}, {value})" if symbol.kept else value
