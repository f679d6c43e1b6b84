"""Checks the instructions on variables of any type: size, insert, resize, wait and their like.  Source: VAL 3 reference 2.5.4-2.5.6."""

from collections.abc import Callable

from gateway.pure.languages.val3.scope import Value
from gateway.pure.languages.val3.sockets import has_sockets
from gateway.pure.languages.val3.syntax import Field, Index, Invoke, Name, Node
from gateway.pure.languages.val3.value_expressions import ValueTranslator


def keeps(value: Value) -> str:
    """Python for whether an array is a local one, which keeps its size; a local collection grows."""
    if value.start:
        return f"is_kept({value.start})"
    return str(value.local and value.dims > 0)


def _of_sockets(value: Value) -> str:
    """Which instruction drops values: connections of sio variables close with them (L2646)."""
    return "_of_sockets" if has_sockets(value.type) else ""


class VariableTranslator(ValueTranslator):
    """Their parameters are variables, not values."""

    def _special(self, node: Invoke, name: str) -> Value | None:
        arguments = node.arguments
        if name in ("wait", "watch"):
            return self._waiting(node, name)
        if name in ("insert", "delete") and len(arguments) != 1:
            return None
        wanted = {"resize": 3, "getdata": 2, "opcuaexport": 2}.get(name, 1)
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
            "opcuaexport": self._on_opcuaexport,
        }
        return handlers[name](node, value)

    def _waiting(self, node: Invoke, name: str) -> Value:
        if len(node.arguments) != (1 if name == "wait" else 2):
            raise self.fault(node, "invalid number of parameters")
        condition = self.of(node.arguments[0], "bool")
        function = f"f_{name}_for" if condition.waits else f"f_{name}"  # sioGet in it: the lambda is a generator
        if name == "wait":
            return Value(f"(yield from {function}(lambda: {condition.code}))", "void", node, waits=True)
        seconds = self.of(node.arguments[1], "num")
        return Value(f"(yield from {function}(lambda: {condition.code}, {seconds.code}))", "bool", node, waits=True)

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
        return self._changed(node, value, f"delete{_of_sockets(value)}", "bool")

    def _changed(self, node: Invoke, value: Value, what: str, result: str) -> Value:
        if value.dims > 1:
            raise self.fault(node.arguments[0], "1d array or collection expected")
        if value.dims == 0 and not value.indexed:
            raise self.fault(node.arguments[0], "key expected")
        return Value(
            f"f_{what}({value.whole}, {value.offset}, {self._maker(value)}, {keeps(value)})",
            result,
            node,
            waits=value.waits,
        )

    def _on_append(self, node: Invoke, value: Value) -> Value:
        if value.dims != 1:
            raise self.fault(node.arguments[0], "1d array variable expected")
        return Value(f"f_append({value.whole}, {self._maker(value)}, {keeps(value)})", "void", node, waits=value.waits)

    def _on_resize(self, node: Invoke, value: Value) -> Value:
        if value.dims == 0 or (value.indexed and not isinstance(node.arguments[0], Name)):
            raise self.fault(node.arguments[0], "unexpected indices" if value.indexed else "array variable expected as parameter")
        which, size = self.of(node.arguments[1], "num"), self.of(node.arguments[2], "num")
        code = f"f_resize{_of_sockets(value)}({value.whole}, {which.code}, {size.code}, {self._maker(value)}, {keeps(value)})"
        return Value(code, "void", node, waits=value.waits or which.waits or size.waits)

    def _maker(self, value: Value) -> str:
        kind = value.type if isinstance(value.type, str) else f"type:{value.type.path}"
        component = isinstance(value.node.base if isinstance(value.node, Index) else value.node, Field)
        return f"maker({kind!r}{', linked=False' if component else ''})"  # L4151: components hang on nothing

    def _on_first(self, node: Invoke, value: Value) -> Value:
        return self._key(node, value, "first", False)

    def _on_last(self, node: Invoke, value: Value) -> Value:
        return self._key(node, value, "last", False)

    def _on_next(self, node: Invoke, value: Value) -> Value:
        return self._key(node, value, "next", True)

    def _on_prev(self, node: Invoke, value: Value) -> Value:
        return self._key(node, value, "prev", True)

    def _on_opcuaexport(self, node: Invoke, value: Value) -> Value:
        self.of(node.arguments[1], "bool")  # whether clients may write it
        return Value("0.0", "num", node)

    def _key(self, node: Invoke, value: Value, what: str, indexed: bool) -> Value:
        if value.dims != 0:
            raise self.fault(node.arguments[0], "collection variable expected")
        if value.indexed is not indexed:
            raise self.fault(node.arguments[0], "key expected" if indexed else "unexpected key")
        key = f", {value.offset}" if indexed else ""
        return Value(f"f_{what}({value.whole}{key})", "string", node, waits=value.waits)
