"""The commands that are installed: entry points of one group, each described by the first line of its module."""

import ast
import importlib.util
import pathlib
from importlib.metadata import EntryPoint

GROUP = "axisgate.commands"


def first_line(entry: EntryPoint) -> str:
    """The docstring of the command's module, read without running it."""
    try:
        found = importlib.util.find_spec(entry.module)
    except ModuleNotFoundError:
        found = None
    if found is None or found.origin is None:
        return "(not in this version)"
    text = ast.get_docstring(ast.parse(pathlib.Path(found.origin).read_bytes())) or ""
    return text.partition("\n")[0]
