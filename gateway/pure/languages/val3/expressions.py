"""Checks expressions and writes them as Python.  Compile errors: VAL 3 reference L1073-1494, L5745, logs of controllers."""

from collections.abc import Callable, Iterator, Sequence

from gateway.pure.languages.val3.model import Parameter, Type, UserType
from gateway.pure.languages.val3.scope import Scope, Value
from gateway.pure.languages.val3.signatures import LIBRARY, PAGES, SIGNATURES, SPECIAL, Signature
from gateway.pure.languages.val3.syntax import (
    Assign,
    Binary,
    CompileFault,
    Field,
    Index,
    Invoke,
    Literal,
    Name,
    Node,
    Number,
    Text,
    Unary,
)
from gateway.pure.languages.val3.typing_rules import ARITHMETIC, ORDER, compare, fits

STRUCTURED = frozenset("trsf frame tool point joint config mdesc".split())
LITERAL = "{}"  # type of a literal before it is known what it is for


class Translator:
    """Expressions of one line."""

    def __init__(self, scope: Scope, line: str) -> None:
        self.scope, self.line = scope, line

    def text(self, node: Node) -> str:
        """As it is written."""
        return self.line[node.start : node.end]

    def fault(self, node: Node, what: str) -> CompileFault:
        """A fault of an expression, in the form of the controller's log."""
        return CompileFault(f"'{self.text(node)}' : {what}", node.start + 1)

    # ---- values ----------------------------------------------------------------------------------------------------------
    def value(self, node: Node) -> Value:
        """An expression of any type; a literal stays one."""
        match node:
            case Number():
                return Value(repr(node.value), "num", node)
            case Text():
                return Value(repr(cut_text(node.value)), "string", node)
            case Name():
                return self._readable(self.scope.variable(node.library, node.name, node))
            case Index():
                return self._indexed(node)
            case Field():
                return self._readable(self.scope.field(self.value(node.base), node.name, node))
            case Literal():
                parts = [None if part is None else self.value(part) for part in node.parts]
                return Value("", LITERAL, node, parts=parts, waits=any(part.waits for part in parts if part))
            case Unary():
                return self._unary(node)
            case Binary():
                return self._binary(node)
            case Assign():
                return self.assign(node)
            case Invoke():
                return self.invoke(node)
        raise self.fault(node, "data expected")

    def of(self, node: Node, kind: Type) -> Value:
        """An expression of this type."""
        return self.need(self.value(node), kind)

    def need(self, value: Value, kind: Type) -> Value:
        """The value as this type; CompileFault where it is none."""
        if value.type == LITERAL and value.parts is not None:
            return self._literal(value, kind)
        self._element(value)
        if value.type == "dio" and kind == "bool":
            return Value(f"io_get({value.code})", "bool", value.node, waits=value.waits)
        if not fits(value.type, kind):
            raise self.fault(value.node, "invalid type")
        return value

    def _readable(self, value: Value) -> Value:
        return value

    def _element(self, value: Value) -> None:
        """2-D, 3-D arrays and collections have no value without an index."""
        if value.whole and not value.indexed and value.dims != 1:
            raise self.fault(value.node, "indices expected" if value.dims else "key expected")

    def _indexed(self, node: Index) -> Value:
        base = self.value(node.base)
        if not base.whole or base.indexed:
            raise self.fault(node, "unexpected indices")
        made = Value("", base.type, node, whole=base.whole, dims=base.dims, indexed=True, local=base.local, waits=base.waits)
        if base.dims == 0:
            if len(node.indices) != 1:
                raise self.fault(node, "key expected")
            key = self.of(node.indices[0], "string")
            made.c, made.k, made.waits = base.whole, f"key({base.whole}, {key.code})", base.waits or key.waits
            made.offset = key.code
        else:
            if len(node.indices) != base.dims:
                raise self.fault(node, "invalid number of indices")
            indices = [self.of(each, "num") for each in node.indices]
            made.waits = base.waits or any(each.waits for each in indices)
            if base.dims == 1:
                made.c, made.k = base.whole, self._place(node.indices[0], indices[0], base.offset)
                made.offset = made.k
            else:
                made.c = f"{base.whole}.flat"
                made.k = f"{base.whole}.at({', '.join(each.code for each in indices)})"
        made.code = f"{made.c}[{made.k}]"
        return made

    def _place(self, node: Node, index: Value, offset: str) -> str:
        if isinstance(node, Number):
            place = str(int(node.value + 0.5))
        else:
            place = f"ix({index.code})"
        return place if offset == "0" else f"{offset} + {place}"

    def _literal(self, value: Value, kind: Type) -> Value:
        fields = self.scope.fields(kind)
        parts = value.parts or []
        if not fields:
            raise self.fault(value.node, "invalid type")
        if len(parts) > len(fields) or (len(parts) < len(fields) and kind != "tool"):
            raise self.fault(value.node, f"invalid number of fields, {kind} has {len(fields)}")
        codes = []
        for part, inner in zip(parts, fields.values(), strict=False):
            codes.append("None" if part is None else self.need(part, inner).code)
        return Value(f"literal({str(kind)!r}, ({', '.join(codes)},))", kind, value.node, waits=value.waits)

    # ---- operators -------------------------------------------------------------------------------------------------------
    def _unary(self, node: Unary) -> Value:
        operand = self.value(node.operand)
        self._element(operand)
        if node.operator == "-" and operand.type == "num":
            return Value(f"(-{operand.code})", "num", node, waits=operand.waits)
        if node.operator == "!" and operand.type in ("bool", "dio"):
            return Value(f"(not {self.need(operand, 'bool').code})", "bool", node, waits=operand.waits)
        if node.operator == "!" and operand.type == "trsf":
            return Value(f"trsf_inverse({operand.code})", "trsf", node, waits=operand.waits)
        raise self.fault(node, "Invalid unary operator for this type")

    def _binary(self, node: Binary) -> Value:
        left, right = self.value(node.left), self.value(node.right)
        operator = node.operator
        if operator in ("or", "and", "xor"):
            left, right = self._logical(node, left), self._logical(node, right)
            code = f"({left.code} != {right.code})" if operator == "xor" else f"({left.code} {operator} {right.code})"
            return Value(code, "bool", node, waits=left.waits or right.waits)
        left, right, kind = self._alike(node, left, right)
        waits = left.waits or right.waits
        if operator in ORDER or operator in ("==", "!="):
            compared = compare(operator, kind, left.code, right.code)
            if compared is None:
                raise self.fault(node, "Invalid binary operator for these types")
            return Value(compared, "bool", node, waits=waits)
        shape = ARITHMETIC[operator].get(kind) if isinstance(kind, str) else None
        if shape is None:
            raise self.fault(node, "Invalid binary operator for these types")
        return Value(shape.format(left.code, right.code), kind, node, waits=waits)

    def _logical(self, node: Binary, value: Value) -> Value:
        self._element(value)
        if value.type not in ("bool", "dio"):
            raise self.fault(node, "Invalid binary operator for these types")
        return self.need(value, "bool")

    def _alike(self, node: Binary, left: Value, right: Value) -> tuple[Value, Value, Type]:
        """Both sides as one type; a dio counts as bool, a literal as what stands on the other side."""
        for one in (left, right):
            self._element(one)
        if left.type == LITERAL and right.type != LITERAL:
            left = self.need(left, right.type)
        if right.type == LITERAL and left.type != LITERAL:
            right = self.need(right, left.type)
        if "dio" in (left.type, right.type) and {left.type, right.type} <= {"bool", "dio"}:
            left, right = self.need(left, "bool"), self.need(right, "bool")
        if left.type != right.type or left.type == LITERAL:
            raise self.fault(node, "Invalid binary operator for these types")
        return left, right, left.type

    # ---- assignment ------------------------------------------------------------------------------------------------------
    def variable(self, node: Node, what: str = "variable expected") -> Value:
        """A variable, not a constant or a result."""
        value = self.value(node)
        if not value.c:
            raise self.fault(node, what)
        return value

    def assign(self, node: Assign) -> Value:
        """target = value, as an expression."""
        target = self.variable(node.target)
        self._element(target)
        value = self.value(node.value)
        waits = target.waits or value.waits
        kind = target.type
        if kind == "dio":
            if value.type == "dio":
                raise self.fault(node, "Invalid binary operator for these types")
            return Value(f"io_put({target.code}, {self.need(value, 'bool').code})", "bool", node, waits=waits)
        if kind == "sio" and value.type in ("string", "num"):
            self._element(value)
            return Value(f"(yield from sio_write_{value.type}({target.code}, {value.code}))", value.type, node, waits=True)
        if kind in ("sio", "aio", "screen"):
            raise self.fault(node, "Invalid binary operator for these types")
        if value.type == "sio" and kind in ("num", "string"):
            self._element(value)
            return Value(f"store({target.c}, {target.k}, (yield from sio_read_{kind}({value.code})))", kind, node, waits=True)
        if value.type != LITERAL and not fits(value.type, kind):
            raise self.fault(node, "Invalid binary operator for these types")
        value = self.need(value, kind)
        if isinstance(kind, UserType) or kind in STRUCTURED:
            return Value(f"take({target.code}, {value.code})", kind, node, waits=waits)
        return Value(f"store({target.c}, {target.k}, {value.code})", kind, node, waits=waits)

    def assignment(self, node: Assign) -> tuple[str, bool]:
        """target = value, as a statement; whether it waits."""
        made = self.assign(node)
        if made.code.startswith("store("):
            target, value = self.value(node.target), self.value(node.value)
            if value.type != "sio":
                return f"{target.code} = {self.need(value, target.type).code}", made.waits
        return made.code, made.waits

    # ---- instructions ----------------------------------------------------------------------------------------------------
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
            return max(counted, key=lambda form: sum(self._matches(v, p) for v, p in zip(values, form.parameters, strict=True)))
        if len(good) > 1:
            open_literals = [v for at, v in enumerate(values) if v.type == LITERAL and len({form.parameters[at] for form in good}) > 1]
            if open_literals:
                raise self.fault(open_literals[0].node, "Ambiguous expression")
        return good[0]

    def _matches(self, value: Value, parameter: str) -> bool:
        kind = parameter.rstrip("&").split("[")[0]
        if value.type == LITERAL:
            return "[" not in parameter and "&" not in parameter and bool(self.scope.fields(kind))
        return fits(value.type, kind)

    def _made(self, node: Invoke, form: Signature, values: list[Value], first: str = "") -> Value:
        codes = [first] if first else []
        codes += [self._argument(value, parameter) for value, parameter in zip(values, form.parameters, strict=True)]
        waits = form.waits or any(value.waits for value in values)
        code = f"f_{form.function}({', '.join(codes)})"
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
        if not value.whole:
            raise self.fault(value.node, "array variable expected as parameter")
        if value.type != kind:
            raise self.fault(value.node, "invalid type")
        if any_dims:
            return value.whole
        if value.dims != 1:
            raise self.fault(value.node, "1d array variable expected")
        return f"({value.whole}, {value.offset})" if not value.local else f"Local({value.whole}, {value.offset})"

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
            codes += self._bound(rest, event)
        function = "page_set" if set_once else f"page_{'unbind' if 'unbind' in name else 'bind'}{'_event' if event else ''}"
        if event:
            codes.insert(2, repr(event))
        return Value(f"f_{function}({', '.join(codes)})", "bool" if "unbind" in name else "void", node, waits=any(v.waits for v in texts))

    def _bound(self, rest: Sequence[Node], event: str) -> list[str]:
        """The variable and what follows it."""
        variable = self.variable(rest[0], "variable expected as parameter")
        self._element(variable)
        if variable.type not in ("bool", "num", "string", "dio", "aio"):
            raise self.fault(rest[0], "invalid type")
        if variable.local:
            raise self.fault(rest[0], "a local variable cannot be bound to a page")
        kinds: list[Type] = ["num", "string", "num"]
        if event:
            kinds = [{"dio": "bool", "aio": "num"}.get(str(variable.type), variable.type)]
            if len(rest) == 1 and variable.type not in ("bool", "dio"):
                raise self.fault(rest[0], "value expected")
        codes = [f"({variable.c}, {variable.k})"]
        return codes + [self.of(each, kind).code for each, kind in zip(rest[1:], kinds, strict=False)]

    # ---- instructions on variables ---------------------------------------------------------------------------------------
    def _special(self, node: Invoke, name: str) -> Value | None:
        arguments = node.arguments
        if name in ("wait", "watch"):
            return self._waiting(node, name)
        if name in ("insert", "delete") and len(arguments) != 1:
            return None
        wanted = {"resize": 3, "getdata": 2}.get(name, 1)
        if len(arguments) != wanted and not (name == "size" and len(arguments) == 2):
            raise self.fault(node, "invalid number of parameters")
        if name == "getdata":
            return self._get_data(node)
        value = self.value(arguments[0])
        if not value.whole:
            raise self.fault(arguments[0], "variable expected as parameter")
        handlers: dict[str, Callable[[Invoke, Value], Value]] = {
            "size": self._on_size,
            "isdefined": self._on_isdefined,
            "insert": self._on_insert,
            "delete": self._on_delete,
            "append": self._on_append,
            "resize": self._on_resize,
            "first": self._on_first,
            "last": self._on_last,
            "next": self._on_next,
            "prev": self._on_prev,
        }
        return handlers[name](node, value)

    def _waiting(self, node: Invoke, name: str) -> Value:
        if len(node.arguments) != (1 if name == "wait" else 2):
            raise self.fault(node, "invalid number of parameters")
        condition = self.of(node.arguments[0], "bool")
        if condition.waits:
            raise self.fault(node.arguments[0], "instruction that waits not allowed in a condition")
        if name == "wait":
            return Value(f"(yield from f_wait(lambda: {condition.code}))", "void", node, waits=True)
        seconds = self.of(node.arguments[1], "num")
        return Value(f"(yield from f_watch(lambda: {condition.code}, {seconds.code}))", "bool", node, waits=True)

    def _get_data(self, node: Invoke) -> Value:
        name, target = self.of(node.arguments[0], "string"), self.variable(node.arguments[1], "variable expected as parameter")
        if not target.whole or (target.dims != 1 and not target.indexed):
            raise self.fault(node.arguments[1], "variable expected as parameter")
        single = target.indexed and target.dims != 1
        place = f"{target.c}, {target.k}, {single}" if single else f"{target.whole}, {target.offset}, False"
        kind = target.type if isinstance(target.type, str) else target.type.path
        return Value(f"f_get_data({name.code}, {place}, {kind!r})", "num", node, waits=name.waits or target.waits)

    def _on_size(self, node: Invoke, value: Value) -> Value:
        if len(node.arguments) == 2:
            if value.indexed and value.dims != 1:
                raise self.fault(node.arguments[0], "unexpected indices")
            which = self.of(node.arguments[1], "num")
            return Value(f"f_size_of({value.whole}, {value.offset}, {which.code})", "num", node, waits=value.waits or which.waits)
        if value.dims == 0 and value.indexed:
            raise self.fault(node.arguments[0], "unexpected key")
        if value.dims > 1 and value.indexed:
            raise self.fault(node.arguments[0], "unexpected indices")
        if value.dims > 1:
            raise self.fault(node, "dimension expected")
        if value.indexed and isinstance(node.arguments[0], Name):  # one value by reference
            return Value("1.0", "num", node)
        return Value(f"f_size({value.whole}, {value.offset})", "num", node, waits=value.waits)

    def _on_isdefined(self, node: Invoke, value: Value) -> Value:
        inner: Node = node.arguments[0]
        if isinstance(inner, Index):
            base = self.value(inner.base)
            codes = [self.of(each, "string" if value.dims == 0 else "num").code for each in inner.indices]
            offset = base.offset if value.dims == 1 else "0"
            return Value(f"f_is_defined(lambda: {value.whole}, {offset}, ({', '.join(codes)},))", "bool", node, waits=value.waits)
        return Value(f"f_is_defined(lambda: {value.whole}, 0, None)", "bool", node, waits=value.waits)

    def _on_insert(self, node: Invoke, value: Value) -> Value:
        return self._changed(node, value, "insert", "bool")

    def _on_delete(self, node: Invoke, value: Value) -> Value:
        return self._changed(node, value, "delete", "bool")

    def _changed(self, node: Invoke, value: Value, what: str, result: str) -> Value:
        if value.dims > 1:
            raise self.fault(node.arguments[0], "1d array or collection expected")
        if value.dims == 0 and not value.indexed:
            raise self.fault(node.arguments[0], "key expected")
        return Value(
            f"f_{what}({value.whole}, {value.offset}, {self._maker(value)}, {value.local and value.dims > 0})",
            result,
            node,
            waits=value.waits,
        )

    def _on_append(self, node: Invoke, value: Value) -> Value:
        if value.dims != 1:
            raise self.fault(node.arguments[0], "1d array variable expected")
        return Value(f"f_append({value.whole}, {self._maker(value)}, {value.local})", "void", node, waits=value.waits)

    def _on_resize(self, node: Invoke, value: Value) -> Value:
        if value.dims == 0 or (value.indexed and not isinstance(node.arguments[0], Name)):
            raise self.fault(node.arguments[0], "unexpected indices" if value.indexed else "array variable expected as parameter")
        which, size = self.of(node.arguments[1], "num"), self.of(node.arguments[2], "num")
        code = f"f_resize({value.whole}, {which.code}, {size.code}, {self._maker(value)}, {value.local})"
        return Value(code, "void", node, waits=value.waits or which.waits or size.waits)

    def _maker(self, value: Value) -> str:
        kind = value.type if isinstance(value.type, str) else f"type:{value.type.path}"
        return f"maker({kind!r})"

    def _on_first(self, node: Invoke, value: Value) -> Value:
        return self._key(node, value, "first", False)

    def _on_last(self, node: Invoke, value: Value) -> Value:
        return self._key(node, value, "last", False)

    def _on_next(self, node: Invoke, value: Value) -> Value:
        return self._key(node, value, "next", True)

    def _on_prev(self, node: Invoke, value: Value) -> Value:
        return self._key(node, value, "prev", True)

    def _key(self, node: Invoke, value: Value, what: str, indexed: bool) -> Value:
        if value.dims != 0:
            raise self.fault(node.arguments[0], "collection variable expected")
        if value.indexed is not indexed:
            raise self.fault(node.arguments[0], "key expected" if indexed else "unexpected key")
        key = f", {value.offset}" if indexed else ""
        return Value(f"f_{what}({value.whole}{key})", "string", node, waits=value.waits)

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
        if not parameter.reference:
            made = self.need(value, parameter.type)
            structured = isinstance(made.type, UserType) or made.type in STRUCTURED or made.type in ("dio", "aio", "sio", "screen")
            return [f"[copied({made.code})]" if structured else f"[{made.code}]"]
        if parameter.whole:
            return self._container(value, parameter)
        if not value.c:
            raise self.fault(value.node, "variable expected as parameter")
        self._element(value)
        if value.type is not parameter.type and value.type != parameter.type:
            raise self.fault(value.node, "invalid type")
        return [value.c, value.k]

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
            return [value.whole, value.offset]
        if value.indexed:
            raise self.fault(value.node, f"unexpected indices for the {'array' if parameter.dims else 'collection'}")
        return [value.whole]


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


def cut_text(text: str) -> str:
    """A string constant holds 128 bytes at most."""
    data = text.encode("utf-8", "replace")
    return data[:128].decode("utf-8", "ignore") if len(data) > 128 else text
