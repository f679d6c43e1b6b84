"""Small mutants: one place of a function changed so that it still runs and answers wrongly.

Made of the source's syntax tree, in an order that a hash of the place decides: the same tree gives the same mutants on every
machine, and an edit elsewhere in the file changes none.  A function inside belongs to the one that makes it.  Kinds: AX-670.
"""

import ast
import functools
import hashlib
import inspect
import itertools
import pathlib
import types
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from hil_tests.matrix.catalogue import resolve

MOST = 6  # of one function
KINDS = ("boundary", "operator", "constant", "branch", "off-by-one", "statement")
BOUNDARIES: dict[type[ast.cmpop], type[ast.cmpop]] = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult, ast.Mod: ast.FloorDiv,
    ast.LShift: ast.RShift, ast.RShift: ast.LShift, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.BitXor: ast.BitAnd,
}  # fmt: skip
Function = ast.FunctionDef | ast.AsyncFunctionDef
N = TypeVar("N", bound=ast.AST)


class Place(NamedTuple):
    """Where a function can be changed."""

    kind: str
    line: int
    words: Callable[[], str]  # the place as it reads now
    change: Callable[[], None]


@dataclass(frozen=True, slots=True)
class Small:
    """One change; `name` is also the argument of a child process."""

    name: str  # kind-hash
    line: int
    words: str  # "a < b -> a <= b"
    code: types.CodeType


def small_mutants(by: str, most: int = MOST, lines: Collection[int] = ()) -> tuple[Small, ...]:
    """The chosen ones of "module:function"; none where it has no source.

    `lines`: those a test runs of it; a change elsewhere it could not notice.  Empty: not known, all are taken.
    """
    code = resolve(by).__code__
    found = _queue(by, code)
    if lines:
        found = [one for one in found if not one.span.isdisjoint(lines)]
    made = (_mutant(code, one) for one in found)
    return tuple(itertools.islice((one for one in made if one is not None), most))


def code_of(by: str, name: str) -> types.CodeType:
    code = resolve(by).__code__
    found = next(_mutant(code, one) for one in _queue(by, code) if one.name == name)
    assert found is not None
    return found.code


class _Candidate(NamedTuple):
    name: str
    number: int  # of the place in its function
    span: frozenset[int]  # lines of its statement


@functools.lru_cache(maxsize=64)
def _queue(by: str, code: types.CodeType) -> list[_Candidate]:
    """All changes of a function, the kinds in turn."""
    path = pathlib.Path(code.co_filename)
    if not path.is_file():
        return []
    tree = ast.parse(path.read_text(encoding="utf-8"))
    spans = _spans(tree)
    queues: dict[str, list[_Candidate]] = {kind: [] for kind in KINDS}
    for number, place in enumerate(places(tree, code)):
        mark = hashlib.sha256(f"{by}|{place.kind}|{place.words()}|{number}".encode()).hexdigest()[:8]
        span = min((one for one in spans if place.line in one), key=len, default=frozenset([place.line]))
        queues[place.kind].append(_Candidate(f"{place.kind}_{mark}", number, span))
    turns = itertools.zip_longest(*(sorted(queue) for queue in queues.values()))
    return [one for turn in turns for one in turn if one is not None]


def _spans(tree: ast.Module) -> list[frozenset[int]]:
    """Lines of each statement; of one with a block in it those before the block."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.stmt):
            block = getattr(node, "body", None) or getattr(node, "cases", None)
            first = block[0].pattern if block and isinstance(block[0], ast.match_case) else block[0] if block else None
            last = first.lineno - 1 if first is not None else node.end_lineno or node.lineno
            found.append(frozenset(range(node.lineno, max(last, node.lineno) + 1)))
        elif isinstance(node, ast.match_case):
            found.append(frozenset([node.pattern.lineno]))
    return found


@functools.lru_cache(maxsize=512)
def _mutant(code: types.CodeType, candidate: _Candidate) -> Small | None:
    """None: what comes out does not fit the function, or is the same."""
    tree = ast.parse(pathlib.Path(code.co_filename).read_text(encoding="utf-8"))
    place = next(itertools.islice(places(tree, code), candidate.number, None))
    before = place.words()
    place.change()
    after = place.words()
    compiled = compile(ast.fix_missing_locations(tree), code.co_filename, "exec")
    made = next((one for one in codes(compiled) if _same_place(one, code)), None)
    if made is None or made == code or (made.co_freevars, made.co_flags) != (code.co_freevars, code.co_flags):
        return None
    return Small(candidate.name, place.line, f"{_short(before)} -> {_short(after)}", made)


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= 60 else line[:57] + "..."


def _same_place(made: types.CodeType, code: types.CodeType) -> bool:
    return (made.co_qualname, made.co_firstlineno) == (code.co_qualname, code.co_firstlineno)


def codes(code: types.CodeType) -> Iterator[types.CodeType]:
    yield code
    for constant in code.co_consts:
        if inspect.iscode(constant):
            yield from codes(constant)


# ------------------------------------------------------------------------------------------------------- places to change


def places(tree: ast.Module, code: types.CodeType) -> Iterator[Place]:
    """All of the function whose code this is."""
    for node in ast.walk(tree):
        if isinstance(node, Function) and node.name == code.co_name:
            if min([node.lineno, *(one.lineno for one in node.decorator_list)]) == code.co_firstlineno:
                yield from _of_function(node)


def _of_function(function: Function) -> Iterator[Place]:
    returns = ast.unparse(function.returns) if function.returns else ""
    yield from _of_block(function)
    inner = []
    for statement in function.body:
        for node in _inside(statement):
            if isinstance(node, Function):
                inner.append(node)
            else:
                yield from _of_node(node, returns)
    for one in inner:
        yield from _of_function(one)


def _inside(node: ast.AST) -> Iterator[ast.AST]:
    """What decides what happens: no annotations, no words of an exception or of a text, a function inside as one."""
    yield node
    if isinstance(node, (ast.Raise, ast.JoinedStr, ast.Assert, Function)):
        return
    for name, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and name != "annotation":
                yield from _inside(child)


def _of_node(node: ast.AST, returns: str) -> Iterator[Place]:
    match node:
        case ast.Compare():
            yield from _of_compare(node)
        case ast.BinOp() | ast.AugAssign() if type(node.op) in OPERATORS and not _is_text(node):
            yield _set("operator", node, "op", OPERATORS[type(node.op)]())
        case ast.BoolOp():
            yield _set("operator", node, "op", ast.Or() if isinstance(node.op, ast.And) else ast.And())
        case ast.Constant(value=bool()):
            yield _set("constant", node, "value", not node.value)
        case ast.Constant(value=int() | float() as number):
            yield _set("constant", node, "value", number + 1)
        case ast.If() | ast.IfExp():
            never = ast.BoolOp(ast.And(), [node.test, ast.Constant(False)])  # what the test itself does still happens
            yield _set("branch", node, "test", never, lambda: ast.unparse(node.test))
        case ast.match_case():
            yield Place("branch", node.pattern.lineno, lambda: _case(node), functools.partial(setattr, node, "guard", ast.Constant(False)))
        case ast.Slice():
            yield from _of_slice(node)
        case ast.Call(func=ast.Name(id="range"), args=[*args]) if not any(isinstance(one, ast.Starred) for one in args):
            end = min(1, len(args) - 1)
            yield _at("off-by-one", node, node.args, end, _plus_one(args[end]))
        case ast.Return(value=ast.expr() as value) if returns in ("int", "float", "Ns") and not isinstance(value, ast.Constant):
            yield _set("off-by-one", node, "value", _plus_one(value))
        case ast.Return(value=ast.expr() as value) if returns == "bool" and not isinstance(value, (ast.Constant, ast.Compare)):
            yield _set("operator", node, "value", ast.UnaryOp(ast.Not(), value))
    yield from _of_block(node)


def _set(kind: str, node: ast.expr | ast.stmt, name: str, value: object, words: Callable[[], str] | None = None) -> Place:
    return Place(kind, node.lineno, words or (lambda: ast.unparse(node)), functools.partial(setattr, node, name, value))


def _at(kind: str, node: ast.expr | ast.stmt, items: list[N], number: int, value: N) -> Place:
    return Place(kind, node.lineno, lambda: ast.unparse(node), functools.partial(items.__setitem__, number, value))


def _case(node: ast.match_case) -> str:
    return f"case {ast.unparse(node.pattern)}" + (f" if {ast.unparse(node.guard)}" if node.guard else "")


def _of_compare(node: ast.Compare) -> Iterator[Place]:
    for number, operator in enumerate(node.ops):
        for kind, table in (("boundary", BOUNDARIES), ("operator", COMPARISONS)):
            if type(operator) in table:
                yield _at(kind, node, node.ops, number, table[type(operator)]())


def _of_slice(node: ast.Slice) -> Iterator[Place]:
    for name in ("lower", "upper"):
        bound = getattr(node, name)
        if bound is not None and not isinstance(bound, ast.Constant):
            yield _set("off-by-one", node, name, _plus_one(bound))


def _of_block(node: ast.AST) -> Iterator[Place]:
    """Calls made for their effect, what is stored outside the function and refusals go."""
    for name in ("body", "orelse", "finalbody"):
        block = getattr(node, name, None)
        if isinstance(block, list):
            yield from (_dropped(block, number) for number, statement in enumerate(block) if _acts(statement))


def _dropped(block: list[ast.stmt], number: int) -> Place:
    statement = block[number]
    gone = ast.copy_location(ast.Pass(), statement)
    return Place("statement", statement.lineno, lambda: ast.unparse(block[number]), functools.partial(block.__setitem__, number, gone))


def _acts(statement: ast.stmt) -> bool:
    match statement:
        case ast.Expr(value=ast.Call() | ast.Await()) | ast.Raise() | ast.AugAssign():
            return True
        case ast.Assign():
            targets = [part for one in statement.targets for part in (one.elts if isinstance(one, ast.Tuple) else [one])]
            return all(isinstance(target, (ast.Attribute, ast.Subscript)) for target in targets)
    return False


def _plus_one(value: ast.expr) -> ast.expr:
    return ast.BinOp(value, ast.Add(), ast.Constant(1))


def _is_text(node: ast.BinOp | ast.AugAssign) -> bool:
    """Texts and lists have no other operator."""
    sides = [node.left, node.right] if isinstance(node, ast.BinOp) else [node.value]
    return any(
        isinstance(side, (ast.JoinedStr, ast.List, ast.Tuple, ast.ListComp))
        or (isinstance(side, ast.Constant) and isinstance(side.value, (str, bytes)))
        for side in sides
    )
