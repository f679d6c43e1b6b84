"""Which functions of the product a root reaches, read from the sources: nothing is imported, nothing runs.

A name leads to what the module binds it to, through imports.  An attribute leads to the methods of that name of every class that
reached code makes or hands on (a class that is only named in an annotation, a pattern, isinstance or except is not made).  Names that are
put together at run time are not seen but for those that are declared: `assembled`.
"""

import ast
import pathlib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from hil_tests.house.statements import statements_in
from hil_tests.matrix.catalogue import OURS, ROOT

Function = ast.FunctionDef | ast.AsyncFunctionDef
PLAIN = (  # decorators that call nothing of their own
    "property", "cached_property", "staticmethod", "classmethod", "override", "overload", "cache", "lru_cache", "contextmanager", "wraps",
)  # fmt: skip


@dataclass(slots=True)
class Node:
    """A function, a class or a variable of a module."""

    name: str  # module:qualname
    names: set[str] = field(default_factory=set)  # full names it refers to: a.b.c
    attributes: set[str] = field(default_factory=set)
    methods: dict[str, str] = field(default_factory=dict)  # of a class: name -> node
    always: set[str] = field(default_factory=set)  # of a class: nodes of what runs without being named


@dataclass(slots=True)
class Module:
    """A module's bindings and what runs when it is loaded."""

    name: str
    bound: dict[str, str] = field(default_factory=dict)  # name -> full name a.b.c
    nodes: dict[str, Node] = field(default_factory=dict)
    imports: set[str] = field(default_factory=set)
    top: Node = field(default_factory=lambda: Node(""))


class CallGraph:
    """All sources of the product.  assembled: function -> (module, prefix) of functions, or of methods of a class (module, Class.prefix),
    that it calls by names it puts together."""

    def __init__(
        self,
        root: pathlib.Path = ROOT,
        packages: Collection[str] = OURS,
        assembled: Mapping[str, Sequence[tuple[str, str]]] = MappingProxyType({}),
    ) -> None:
        self.assembled = assembled
        self.modules: dict[str, Module] = {}
        for path in sorted(path for package in packages for path in (root / package).rglob("*.py")):
            parts = path.relative_to(root).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            self.modules[name] = _read(name, ast.parse(path.read_text(encoding="utf-8")), package=parts[-1] == "__init__")

    def reached(self, roots: Collection[str], barred: Callable[[str], bool] = lambda _module: False) -> set[str]:
        """Names "module:qualname" of functions that run when a root does; modules that are barred are not entered."""
        return _Walk(self, barred).run(roots)

    def find(self, full: str) -> tuple[Module, str] | None:
        """The module that defines a.b.c, and what is left of the name in it ("" for the module itself)."""
        for _ in range(8):  # through modules that hand a name on
            module, rest = self._split(full)
            if module is None or not rest:
                return (module, "") if module else None
            head, _, tail = rest.partition(".")
            if head in module.nodes:
                return module, rest
            if head not in module.bound:
                return None
            full = ".".join(filter(None, [module.bound[head], tail]))
        return None

    def _split(self, full: str) -> tuple[Module | None, str]:
        parts = full.split(".")
        for end in range(len(parts), 0, -1):
            if module := self.modules.get(".".join(parts[:end])):
                return module, ".".join(parts[end:])
        return None, full


class _Walk:
    """One search."""

    def __init__(self, graph: CallGraph, barred: Callable[[str], bool]) -> None:
        self.graph, self.barred = graph, barred
        self.seen: set[str] = set()
        self.open: list[Node] = []
        self.attributes: set[str] = set()
        self.live: dict[str, list[str]] = {}  # attribute -> nodes of methods of classes that are made
        self.loaded: set[str] = set()

    def run(self, roots: Collection[str]) -> set[str]:
        for root in roots:
            module, _, qualname = root.partition(":")
            self.take(module, qualname)
        while self.open:
            node = self.open.pop()
            for attribute in node.attributes - self.attributes:
                self.attributes.add(attribute)
                for name in self.live.get(attribute, ()):
                    self.take(*name.split(":"))
            for full in node.names:
                self.follow(full)
        return self.seen

    def follow(self, full: str) -> None:
        found = self.graph.find(full)
        if found is not None:
            module, rest = found
            self.load(module)
            if rest:
                self.take(module.name, rest.partition(".")[0])

    def load(self, module: Module) -> None:
        if module.name not in self.loaded and not self.barred(module.name):
            self.loaded.add(module.name)
            self.open.append(module.top)
            for name in module.imports:
                found = self.graph.find(name)
                if found is not None:
                    self.load(found[0])

    def take(self, module_name: str, qualname: str) -> None:
        name = f"{module_name}:{qualname}"
        module = self.graph.modules.get(module_name)
        node = module.nodes.get(qualname) if module else None
        if module is None or node is None or name in self.seen or self.barred(module_name):
            return
        self.seen.add(name)
        for other, prefix in self.graph.assembled.get(name, ()):
            for each in self.graph.modules[other].nodes:
                if each.startswith(prefix):
                    self.take(other, each)
        self.load(module)
        self.open.append(node)
        for method, full in node.methods.items():
            self.live.setdefault(method, []).append(full)
            if method in self.attributes or full in node.always:
                self.take(*full.split(":"))


# --------------------------------------------------------------------------------------------------------------- reading


def _read(name: str, tree: ast.Module, package: bool) -> Module:
    module = Module(name)
    module.top = Node(f"{name}:")
    for node in _imports(tree):
        for bound, full in _imported(node, name, package):
            module.bound.setdefault(bound, full)
            module.imports.add(full)
    for statement in _statements(tree.body):
        _bind(module, statement)
    return module


def _imports(tree: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """At any depth; only statements are looked at, of which there are few beside expressions.  Outer ones first, as ast.walk has them."""
    level: list[ast.AST] = [tree]
    while level:
        deeper: list[ast.AST] = []
        for node in level:
            if isinstance(node, (ast.Import, ast.ImportFrom)):
                yield node
            deeper += statements_in(node)
        level = deeper


def _statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Of the module's own level, those under `if` and `try` as well."""
    for statement in body:
        if isinstance(statement, (ast.If, ast.Try, ast.With)):
            for name in ("body", "orelse", "finalbody"):
                yield from _statements(getattr(statement, name, []))
        else:
            yield statement


def _imported(node: ast.Import | ast.ImportFrom, module: str, package: bool) -> Iterator[tuple[str, str]]:
    if isinstance(node, ast.Import):
        for one in node.names:
            yield (one.asname, one.name) if one.asname else (one.name.partition(".")[0], one.name.partition(".")[0])
        return
    base = node.module or ""
    if node.level:
        parts = module.split(".")
        base = ".".join(filter(None, [*parts[: len(parts) - node.level + package], base]))
    for one in node.names:
        yield one.asname or one.name, f"{base}.{one.name}"


def _bind(module: Module, statement: ast.stmt) -> None:
    match statement:
        case ast.FunctionDef() | ast.AsyncFunctionDef():
            _add(module, statement.name, [*statement.body, *statement.args.defaults, *filter(None, statement.args.kw_defaults)])
            decorators = [one for one in statement.decorator_list if _last(one) not in PLAIN]
            _refer(module, module.top, decorators)
            if decorators:  # what a decorator was given may be called by whoever reads its table
                module.top.names.add(f"{module.name}.{statement.name}")
        case ast.ClassDef():
            _bind_class(module, statement)
        case ast.Assign() | ast.AnnAssign() if statement.value is not None:
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            for target in targets:
                for name in (part.id for part in ast.walk(target) if isinstance(part, ast.Name)):
                    _add(module, name, [statement.value])
        case ast.Import() | ast.ImportFrom():
            pass
        case _:
            _refer(module, module.top, [statement])


def _bind_class(module: Module, statement: ast.ClassDef) -> None:
    own = [one for one in statement.body if not isinstance(one, Function)]
    node = _add(module, statement.name, [*statement.bases, *[one.value for one in statement.keywords], *statement.decorator_list, *own])
    for method in statement.body:
        if isinstance(method, Function):
            qualname = f"{statement.name}.{method.name}"
            _add(module, qualname, [*method.body, *method.args.defaults, *filter(None, method.args.kw_defaults), *method.decorator_list])
            node.methods[method.name] = f"{module.name}:{qualname}"
            odd = [one for one in method.decorator_list if _last(one) not in PLAIN and "setter" not in _last(one)]
            if odd or (method.name.startswith("__") and method.name.endswith("__")):
                node.always.add(f"{module.name}:{qualname}")


def _last(decorator: ast.expr) -> str:
    inner = decorator.func if isinstance(decorator, ast.Call) else decorator
    return inner.attr if isinstance(inner, ast.Attribute) else ast.unparse(inner)


def _add(module: Module, qualname: str, body: Sequence[ast.AST]) -> Node:
    node = module.nodes.setdefault(qualname, Node(f"{module.name}:{qualname}"))  # a name bound twice is both
    module.nodes[qualname] = node
    _refer(module, node, body)
    return node


def _refer(module: Module, node: Node, parts: Sequence[ast.AST]) -> None:
    for part in parts:
        for used in _used(part):
            names = _words(used)
            if isinstance(used, ast.Attribute):
                node.attributes.add(used.attr)
            if names[0] in module.bound:
                node.names.add(".".join([module.bound[names[0]], *names[1:]]))
            else:
                node.names.add(".".join([module.name, *names]))


def _used(node: ast.AST) -> Iterator[ast.Name | ast.Attribute]:
    """Names and dotted names that are read to be called or handed on."""
    if isinstance(node, ast.Attribute):
        if _dotted(node):
            yield node
            inner: ast.expr = node.value
            while isinstance(inner, ast.Attribute):  # self.a.b reads a as well
                yield inner
                inner = inner.value
            return
        yield ast.Attribute(ast.Name("?"), node.attr)
    if isinstance(node, ast.Name):
        yield node
        return
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "cls") or (name == "type" and isinstance(node, ast.ExceptHandler)):
            continue
        children = value if isinstance(value, list) else [value]
        if isinstance(node, ast.Call) and name == "args" and _words(node.func) in (["isinstance"], ["issubclass"]):
            children = children[:1]
        for child in children:
            if isinstance(child, ast.AST):
                yield from _used(child)


def _words(node: ast.expr) -> list[str]:
    """a.b.c -> a, b, c; nothing of any other expression."""
    words: list[str] = []
    while isinstance(node, ast.Attribute):
        words.append(node.attr)
        node = node.value
    return [node.id, *reversed(words)] if isinstance(node, ast.Name) else []


def _dotted(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) or (isinstance(node, ast.Attribute) and _dotted(node.value))
