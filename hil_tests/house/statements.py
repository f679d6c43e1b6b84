"""Statements of a syntax tree without its expressions, which are ten times as many."""

import ast
from collections.abc import Iterator

HOLD = ("body", "handlers", "orelse", "finalbody", "cases")  # fields with lists of statements


def statements_in(node: ast.AST) -> Iterator[ast.AST]:
    """Those directly inside, in the order of the source; clauses of try and match count as statements."""
    for name in HOLD:
        found = getattr(node, name, ())
        if isinstance(found, list):
            yield from found
