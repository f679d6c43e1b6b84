"""What a verdict was made of: a test with what it uses of its own file, and the function it breaks.

A verdict holds as long as both read the same (AX-1510).  Comments, docstrings, line breaks and neighbours in the file
do not count.
"""

import ast
import copy
import functools
import hashlib
import pathlib
from collections.abc import Iterator, Mapping

from hil_tests.house.statements import statements_in
from hil_tests.matrix.catalogue import resolve

DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


def fingerprint(test_file: pathlib.Path, name: str, by: str) -> str:
    """Of the test function `name` ("test_a" or "TestA::test_a") of this file and "module:qualname".  Raises MarkError."""
    code = resolve(by).__code__
    source = pathlib.Path(code.co_filename)
    function = _named(_parsed(source, source.stat().st_mtime_ns), code.co_qualname.split(".")) if source.is_file() else ()
    used = _used(test_file, test_file.stat().st_mtime_ns, name.partition("::")[0])
    text = "\n".join([*used, *map(_code, function)])
    return hashlib.sha256(text.encode()).hexdigest()[:12]


@functools.lru_cache(maxsize=256)
def _parsed(path: pathlib.Path, _changed_ns: int) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def _code(node: ast.AST) -> str:
    """Source of this node without its docstrings."""
    bare = copy.deepcopy(node)
    for inner in ast.walk(bare):
        if isinstance(inner, DEFINITIONS) and ast.get_docstring(inner, clean=False) is not None:
            inner.body = inner.body[1:] or [ast.Pass()]
    return ast.unparse(bare)


def _named(tree: ast.AST, parts: list[str]) -> tuple[ast.AST, ...]:
    """All definitions of that name: a property has up to three."""
    found = tuple(node for node in _definitions(tree) if node.name == parts[0])
    return found if len(parts) == 1 else tuple(inner for node in found for inner in _named(node, parts[1:]))


def _definitions(tree: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef]:
    for node in statements_in(tree):
        if isinstance(node, DEFINITIONS):
            yield node
        else:  # under `if` and `try`
            yield from _definitions(node)


@functools.lru_cache(maxsize=4096)
def _used(path: pathlib.Path, changed_ns: int, name: str) -> tuple[str, ...]:
    """Return the sources of the test and of all it uses of its own file, including fixtures and constants."""
    bound = _bound(path, changed_ns)
    seen: dict[str, str] = {}
    waiting = [name]
    while waiting:
        one = waiting.pop()
        if one in bound and one not in seen:
            seen[one] = "\n".join(map(_code, bound[one]))
            waiting += [other for node in bound[one] for other in _names(node)]
    return tuple(seen[one] for one in sorted(seen))


@functools.lru_cache(maxsize=256)
def _bound(path: pathlib.Path, changed_ns: int) -> Mapping[str, list[ast.stmt]]:
    """Of each name the file defines: the statements that do."""
    found: dict[str, list[ast.stmt]] = {}
    for node in _parsed(path, changed_ns).body:
        for name in _targets(node):
            found.setdefault(name, []).append(node)
    return found


def _targets(node: ast.stmt) -> Iterator[str]:
    if isinstance(node, DEFINITIONS):
        yield node.name
    elif isinstance(node, (ast.Assign, ast.AnnAssign, ast.AugAssign)):
        for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
            yield from (part.id for part in ast.walk(target) if isinstance(part, ast.Name))


def _names(node: ast.AST) -> Iterator[str]:
    """A fixture is named by an argument, or by the text of usefixtures."""
    for part in ast.walk(node):
        match part:
            case ast.Name(id=name) | ast.arg(arg=name) | ast.Constant(value=str(name)):
                yield name
