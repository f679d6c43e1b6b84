"""Sentences as the code writes them."""

import ast


def written(node: ast.expr) -> str:
    """A text with X for each value that is filled in; "" where the node is none."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    parts = node.values if isinstance(node, ast.JoinedStr) else ()
    return "".join(str(part.value) if isinstance(part, ast.Constant) else "X" for part in parts)
