"""Checks instructions and parameters of programs and writes them as Python.  Compile errors: VAL 3 reference L1073-1494, L5745."""

from collections.abc import Iterator, Sequence

from gateway.pure.languages.val3.model import Parameter, Type, UserType
from gateway.pure.languages.val3.scope import Value
from gateway.pure.languages.val3.signatures import LIBRARY, PAGES, SIGNATURES, SPECIAL, Signature
from gateway.pure.languages.val3.syntax import (
    Assign,
    Binary,
    CompileFault,
    Consequence,
    Field,
    Index,
    Invoke,
    Literal,
    Name,
    Node,
    Unary,
)
from gateway.pure.languages.val3.typing_rules import fits
from gateway.pure.languages.val3.value_expressions import LITERAL, STRUCTURED
from gateway.pure.languages.val3.variable_expressions import VariableTranslator, keeps


class Translator(VariableTranslator):
    """Expressions of one line."""

    def invoke(self, node: Invoke) -> Value:
        """A built-in instruction."""
        name = node.name.lower()
        for argument in node.arguments:
            for inner in nodes(argument):
                if isinstance(inner, Assign):
                    raise self.fault(inner, "assignment not allowed in a parameter")
        if node.library:
            return self._of_library(node, name)
        if name in PAGES:
            return self._page(node, name)
        if name in SPECIAL and (made := self._special(node, name)) is not None:
            return made
        if name not in SIGNATURES:
            raise CompileFault(f"'{node.name}' : undefined instruction", node.start + 1)
        values = [self.value(each) for each in node.arguments]
        return self._made(node, self._choose(node, SIGNATURES[name], values), values)

    def _choose(self, node: Invoke, forms: Sequence[Signature], values: list[Value]) -> Signature:
        counted = [form for form in forms if len(form.parameters) == len(values)]
        if not counted:
            raise self.fault(node, "invalid number of parameters")
        good = [form for form in counted if all(self._matches(v, p) for v, p in zip(values, form.parameters, strict=True))]
        if not good:
            return max(counted, key=lambda form: self._likeness(values, form))
        if len(good) > 1:
            open_literals = [v for at, v in enumerate(values) if v.type == LITERAL and len({form.parameters[at] for form in good}) > 1]
            if open_literals:
                raise self.fault(open_literals[0].node, "Ambiguous expression")
        return good[0]

    def _likeness(self, values: list[Value], form: Signature) -> tuple[int, int]:
        """How many parameters fit before the first that does not, and in all: the form that was meant."""
        fit = [self._matches(value, parameter) for value, parameter in zip(values, form.parameters, strict=True)]
        return [*fit, False].index(False), sum(fit)

    def _matches(self, value: Value, parameter: str) -> bool:
        kind = parameter.rstrip("&").split("[")[0]
        if value.type == LITERAL:
            return "[" not in parameter and "&" not in parameter and bool(self.scope.fields(kind))
        return fits(value.type, kind)

    def _made(self, node: Invoke, form: Signature, values: list[Value], first: str = "") -> Value:
        codes = [first] if first else []
        codes += [self._argument(value, parameter) for value, parameter in zip(values, form.parameters, strict=True)]
        waits = form.waits or any(value.waits for value in values)
        function = form.function
        if function == "to_binary" and self.scope.app.since_s8:
            function = "to_binary_of_what_is_there"  # s8 applications state the number of bytes
        code = f"f_{function}({', '.join(codes)})"
        return Value(f"(yield from {code})" if form.waits else code, form.result, node, waits=waits)

    def _argument(self, value: Value, parameter: str) -> str:
        kind = parameter.rstrip("&").split("[")[0]
        if "[" in parameter:
            return self._array(value, kind, parameter.endswith("[*]"))
        if parameter.endswith("&"):
            if not value.c:
                raise self.fault(value.node, "variable expected as parameter")
            self._element(value)
            if value.type != kind:
                raise self.fault(value.node, "invalid type")
            return value.code if kind in STRUCTURED or kind in ("dio", "aio", "sio") else f"({value.c}, {value.k})"
        return self.need(value, kind).code

    def _array(self, value: Value, kind: str, any_dims: bool) -> str:
        single = bool(value.c) and (not value.whole or (value.indexed and (value.dims != 1 or isinstance(value.node, Name))))
        if not value.whole and not single:
            raise self.fault(value.node, "array variable expected as parameter")
        if value.type != kind:
            raise self.fault(value.node, "invalid type")
        if single and not any_dims:
            return f"one({value.c}, {value.k})"
        if not value.whole:
            raise self.fault(value.node, "array variable expected as parameter")
        if any_dims:
            return f"({value.whole}, {keeps(value)})"
        if value.dims != 1:
            raise self.fault(value.node, "1d array variable expected")
        passed = f"({value.whole}, {_inside(value)})"
        if value.start:
            return f"kept({value.whole}, {_inside(value)}, {value.start})"
        return f"Local{passed}" if value.local else passed

    def _of_library(self, node: Invoke, name: str) -> Value:
        if node.library not in self.scope.app.libraries:
            raise CompileFault(f"'{node.library}' : undefined library", node.start + 1)
        if name not in LIBRARY:
            raise CompileFault(f"'{node.name}' : undefined instruction", node.start + 1)
        values = [self.value(each) for each in node.arguments]
        return self._made(node, self._choose(node, LIBRARY[name], values), values, first=repr(node.library))

    def _page(self, node: Invoke, name: str) -> Value:
        """Bindings of user pages: page, object, then attribute or variable."""
        set_once, event = name == "userpageset", name.partition("bind")[2]
        names = 3 if not event else 2
        texts = [self.of(each, "string") for each in node.arguments[:names]]
        rest = node.arguments[names:]
        least, most = _page_rest(name, event)
        if len(texts) < names or not least <= len(rest) <= most:
            raise self.fault(node, "invalid number of parameters")
        codes = [each.code for each in texts]
        if set_once:
            value = self.value(rest[0])
            if value.type not in ("bool", "num", "string"):
                raise self.fault(rest[0], "invalid type")
            codes.append(self.need(value, value.type).code)
        elif rest:
            codes += self._bound(rest, event, valued="unbind" not in name)
        function = "page_set" if set_once else f"page_{'unbind' if 'unbind' in name else 'bind'}{'_event' if event else ''}"
        if event:
            codes.insert(2, repr(event))
        return Value(f"f_{function}({', '.join(codes)})", "bool" if "unbind" in name else "void", node, waits=any(v.waits for v in texts))

    def _bound(self, rest: Sequence[Node], event: str, valued: bool) -> list[str]:
        """The variable and what follows it; `valued`: an event that does not toggle needs a value."""
        variable = self.variable(rest[0], "variable expected as parameter")
        self._element(variable)
        if variable.type not in ("bool", "num", "string", "dio", "aio"):
            raise self.fault(rest[0], "invalid type")
        if variable.local:
            raise self.fault(rest[0], "a local variable cannot be bound to a page")
        kinds: list[Type] = ["num", "string", "num"]
        if event:
            kinds = [{"dio": "bool", "aio": "num"}.get(str(variable.type), variable.type)]
            if valued and len(rest) == 1 and variable.type not in ("bool", "dio"):
                raise self.fault(rest[0], "value expected")
        codes = [f"({variable.c}, {variable.k})"]
        return codes + [self.of(each, kind).code for each, kind in zip(rest[1:], kinds, strict=False)]

    # ---- parameters of programs ------------------------------------------------------------------------------------------
    def parameters(self, node: Invoke, wanted: Sequence[Parameter], task: bool = False) -> tuple[str, bool]:
        """The start of the list of a frame; whether an expression waits.  `task`: no local by reference (L3713)."""
        if len(node.arguments) != len(wanted):
            raise self.fault(node, f"invalid number of parameters, {len(wanted)} expected")
        codes: list[str] = []
        waits = False
        for argument, parameter in zip(node.arguments, wanted, strict=True):
            for inner in nodes(argument):
                if isinstance(inner, Assign):
                    raise self.fault(inner, "assignment not allowed in a parameter")
            value = self.value(argument)
            waits = waits or value.waits
            if task and parameter.reference and value.local:
                raise self.fault(argument, "local variable not allowed as a reference parameter of a task")
            codes += self._passed(value, parameter)
        return f"[{', '.join(codes)}]", waits

    def _passed(self, value: Value, parameter: Parameter) -> list[str]:
        if parameter.broken:
            raise Consequence
        if not parameter.reference:
            made = self.need(value, parameter.type)
            structured = isinstance(made.type, UserType) or made.type in STRUCTURED or made.type in ("dio", "aio", "sio", "screen")
            return [f"[passed({made.code})]" if structured else f"[{made.code}]"]
        if parameter.whole:
            return self._container(value, parameter)
        if not value.c:
            raise self.fault(value.node, "variable expected as parameter")
        self._element(value)
        if value.type is not parameter.type and value.type != parameter.type:
            raise self.fault(value.node, "invalid type")
        place = _inside(value) if isinstance(value.node, Index) and value.dims == 1 and value.c == value.whole else value.k
        return [value.c, place]

    def _container(self, value: Value, parameter: Parameter) -> list[str]:
        kind = {0: "collection", 1: "1d array", 2: "2d array", 3: "3d array"}[parameter.dims]
        if not value.whole:
            what = "collection" if parameter.dims == 0 else "array"
            raise self.fault(value.node, f"{what} variable expected as parameter" if not value.c else f"{kind} variable expected")
        if value.dims != parameter.dims:
            raise self.fault(value.node, f"{kind} variable expected")
        if value.type is not parameter.type and value.type != parameter.type:
            raise self.fault(value.node, "invalid type")
        if parameter.dims == 1:
            return [value.whole, _begin(value)]
        if value.indexed:
            raise self.fault(value.node, f"unexpected indices for the {'array' if parameter.dims else 'collection'}")
        return [value.whole]


def _inside(value: Value) -> str:
    """Return the place from which an array is passed; 20 where it lies past the end."""
    indexed = value.indexed and isinstance(value.node, Index)
    return f"there({value.whole}, {value.offset})" if indexed else value.offset


def _begin(value: Value) -> str:
    """Like _inside; marks a local array for the called program."""
    place = _inside(value)
    if value.local:
        return f"LocalPlace({place})"
    return f"part_of({value.start}, {place})" if value.start and place != value.start else place


def _page_rest(name: str, event: str) -> tuple[int, int]:
    """How many parameters follow page, object and attribute."""
    if not event and "unbind" in name:
        return 0, 0
    if "unbind" in name or name == "userpageset":
        return 1, 1
    return (1, 2) if event else (3, 4)


def nodes(node: Node) -> Iterator[Node]:
    """A node and all inside it."""
    yield node
    inner: list[Node | None] = []
    match node:
        case Index():
            inner = [node.base, *node.indices]
        case Field():
            inner = [node.base]
        case Invoke():
            inner = [*node.arguments]
        case Literal():
            inner = [*node.parts]
        case Binary():
            inner = [node.left, node.right]
        case Unary():
            inner = [node.operand]
        case Assign():
            inner = [node.target, node.value]
    for each in inner:
        if each is not None:
            yield from nodes(each)
