"""Checks values, operators and assignments and writes them as Python.  Compile errors: VAL 3 reference L1073-1494, logs of controllers."""

from gateway.pure.languages.val3.model import Type, UserType
from gateway.pure.languages.val3.scope import Scope, Value
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
LITERAL = "{}"  # type of a literal before its use is known


class ValueTranslator:
    """Values of one line.  What instructions are, its subclasses know."""

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
        made.start = base.start
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
        """Return both sides as one type; a dio counts as bool, a literal as the type of the other side."""
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
            how = "take_linked" if kind in ("frame", "tool", "point") else "take"
            return Value(f"{how}({target.code}, {value.code})", kind, node, waits=waits)
        return Value(f"store({target.c}, {target.k}, {value.code})", kind, node, waits=waits)

    def assignment(self, node: Assign) -> tuple[str, bool]:
        """target = value, as a statement; whether it waits."""
        made = self.assign(node)
        if made.code.startswith("store("):
            target, value = self.value(node.target), self.value(node.value)
            if value.type != "sio":
                return f"{target.code} = {self.need(value, target.type).code}", made.waits
        return made.code, made.waits

    def invoke(self, node: Invoke) -> Value:
        """A built-in instruction."""
        raise self.fault(node, "undefined instruction")


def cut_text(text: str) -> str:
    """A string constant holds 128 bytes at most."""
    data = text.encode("utf-8", "replace")
    return data[:128].decode("utf-8", "ignore") if len(data) > 128 else text
