"""`python -m hil_tests.matrix.spelled`: requirement marks of rows or functions that are not there; no test is imported (make lint)."""

import ast
import pathlib
import sys
from collections.abc import Iterator

from hil_tests.matrix.catalogue import ROOT, MarkError, claim


def main() -> int:
    faults = [fault for path in sorted((ROOT / "hil_tests").rglob("*.py")) for fault in faults_of(path)]
    print("\n".join(faults), end="\n" if faults else "")
    return 1 if faults else 0


def faults_of(path: pathlib.Path) -> Iterator[str]:
    """Of one file.  Marks made of more than text and the file's own constants are judged when their tests run."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    known: dict[str, object] = {}
    for line in tree.body:
        if isinstance(line, ast.Assign) and isinstance(line.targets[0], ast.Name):
            known[line.targets[0].id] = _value(line.value, known)
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "requirement":
            ids = tuple(_value(one, known) for one in node.args)
            words = {one.arg: _value(one.value, known) for one in node.keywords if one.arg}
            if None in ids or None in words.values():
                continue
            try:
                claim(ids, words)
            except MarkError as error:
                yield f"{path.relative_to(ROOT) if path.is_relative_to(ROOT) else path}:{node.lineno}: {error}"


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
