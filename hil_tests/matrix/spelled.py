"""`python -m hil_tests.matrix.spelled`: requirement marks of rows or functions that are not there; no test is imported (make lint)."""

import ast
import pathlib
import sys
from collections.abc import Iterator
from typing import NamedTuple

from hil_tests.matrix.catalogue import ROOT, Claim, MarkError, claim


def main() -> int:
    faults = [fault for path in sorted((ROOT / "hil_tests").rglob("*.py")) for fault in faults_of(path)]
    print("\n".join(faults), end="\n" if faults else "")
    return 1 if faults else 0


def faults_of(path: pathlib.Path) -> Iterator[str]:
    """Of one file.  Marks made of more than text and the file's own constants are judged when their tests run."""
    for mark in marks_of(path):
        try:
            claim(mark.ids, mark.words)
        except MarkError as error:
            yield f"{path.relative_to(ROOT) if path.is_relative_to(ROOT) else path}:{mark.line}: {error}"


class Mark(NamedTuple):
    """One requirement mark as it is written."""

    test: str
    line: int
    ids: tuple[object, ...]
    words: dict[str, object]


def marks_of(path: pathlib.Path) -> Iterator[Mark]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    known: dict[str, object] = {}
    for line in tree.body:
        if isinstance(line, ast.Assign) and isinstance(line.targets[0], ast.Name):
            known[line.targets[0].id] = _value(line.value, known)
    tests = (node for node in ast.walk(tree) if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)))
    for test in tests:
        for node in test.decorator_list:
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "requirement":
                ids = tuple(_value(one, known) for one in node.args)
                words = {one.arg: _value(one.value, known) for one in node.keywords if one.arg}
                if None not in ids and None not in words.values():
                    yield Mark(test.name, node.lineno, ids, words)


def claims() -> dict[str, list[Claim]]:
    """Of all tests of the tree, by their id.  Raises MarkError."""
    found: dict[str, list[Claim]] = {}
    for path in sorted((ROOT / "hil_tests").rglob("test_*.py")):
        for mark in marks_of(path):
            found.setdefault(f"{path.relative_to(ROOT)}::{mark.test}", []).append(claim(mark.ids, mark.words))
    return found


def _value(node: ast.expr, known: dict[str, object]) -> object:
    """Text or a tuple of texts, or None."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.Name):
        return known.get(node.id)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        left, right = _value(node.left, known), _value(node.right, known)
        return left + right if isinstance(left, str) and isinstance(right, str) else None
    if isinstance(node, (ast.Tuple, ast.List)):
        parts = tuple(_value(one, known) for one in node.elts)
        return None if None in parts else parts
    return None


if __name__ == "__main__":
    sys.exit(main())
