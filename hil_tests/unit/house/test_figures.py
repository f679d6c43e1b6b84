"""Figures of the house that may only fall: attributes of a class in pure rooms, parameters and lines of a function, lines of a file.

A class, function or file over the limit has a row with its figure of today; it may fall below it and not rise, and a new one is refused.
"""

import ast
import functools
import pathlib
from collections.abc import Iterator, Mapping

ROOT = next(parent for parent in pathlib.Path(__file__).resolve().parents if (parent / "pyproject.toml").exists())
PACKAGES = ("gateway", "drivers", "motion", "protocols")
PURE = ("protocols/", "motion/", "drivers/drives/", "drivers/emulator/", "gateway/pure/")
MOST_ATTRIBUTES, MOST_PARAMETERS, MOST_LINES, MOST_FILE_LINES = 15, 8, 60, 450
CLASSES: Mapping[str, int] = {}
PARAMETERS: Mapping[str, int] = {}
LINES: Mapping[str, int] = {
    "drivers/emulator/servo/model.py:run": 97,
}
FILES: Mapping[str, int] = {}
Function = ast.FunctionDef | ast.AsyncFunctionDef


def trees() -> Iterator[tuple[str, ast.Module]]:
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            yield path.relative_to(ROOT).as_posix(), ast.parse(path.read_text(encoding="utf-8"))


def attributes(node: ast.ClassDef) -> int:
    """Names its methods set on self."""
    return len(
        {
            each.attr
            for method in node.body
            if isinstance(method, Function)
            for each in ast.walk(method)
            if isinstance(each, ast.Attribute)
            and isinstance(each.ctx, ast.Store)
            and isinstance(each.value, ast.Name)
            and each.value.id == "self"
        }
    )


def is_record(node: ast.ClassDef) -> bool:
    """A dataclass or named tuple: its fields are what it is."""
    return any("dataclass" in ast.unparse(each) for each in node.decorator_list) or any("NamedTuple" in ast.unparse(b) for b in node.bases)


def parameters(node: Function) -> int:
    """self and cls left out."""
    given = node.args
    own = bool(given.args) and given.args[0].arg in ("self", "cls")
    return len(given.posonlyargs) + len(given.args) + len(given.kwonlyargs) - own


@functools.cache
def found() -> tuple[dict[str, int], dict[str, int], dict[str, int]]:
    """Classes, parameters, lines over their limits."""
    classes: dict[str, int] = {}
    wide: dict[str, int] = {}
    long: dict[str, int] = {}
    for path, tree in trees():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef) and path.startswith(PURE) and not is_record(node):
                if (count := attributes(node)) > MOST_ATTRIBUTES:
                    classes[f"{path}:{node.name}"] = count
            elif isinstance(node, Function):
                if (count := parameters(node)) > MOST_PARAMETERS:
                    wide[f"{path}:{node.name}"] = count
                if (count := (node.end_lineno or 0) - node.lineno + 1) > MOST_LINES:
                    long[f"{path}:{node.name}"] = count
    return classes, wide, long


def test_no_class_of_a_pure_room_has_too_many_attributes_and_none_gets_more() -> None:
    assert risen(found()[0], CLASSES) == {}


def test_no_function_has_too_many_parameters_and_none_gets_more() -> None:
    assert risen(found()[1], PARAMETERS) == {}


def test_no_function_is_too_long_and_none_gets_longer() -> None:
    assert risen(found()[2], LINES) == {}


def long_files() -> dict[str, int]:
    """Files with more lines than a reader takes in at once."""
    lines = {
        path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8").count("\n")
        for package in (*PACKAGES, "hil_tests")
        for path in (ROOT / package).rglob("*.py")
    }
    return {path: count for path, count in lines.items() if count > MOST_FILE_LINES}


def test_no_file_is_too_long_and_none_gets_longer() -> None:
    assert risen(long_files(), FILES) == {}


def test_a_row_that_is_no_longer_needed_is_taken_out() -> None:
    assert [
        key
        for now, rows in zip((*found(), long_files()), (CLASSES, PARAMETERS, LINES, FILES), strict=True)
        for key, count in rows.items()
        if now.get(key, 0) < count
    ] == [], "lower the figure, or take the row out"


def risen(now: Mapping[str, int], allowed: Mapping[str, int]) -> dict[str, int]:
    return {key: count for key, count in now.items() if count > allowed.get(key, 0)}


def test_the_figures_would_show_a_new_one() -> None:
    node = ast.parse("class A:\n    def f(self, a, *, b):\n        self.x, self.y = a, b\n        self.x = 1").body[0]
    assert isinstance(node, ast.ClassDef) and attributes(node) == 2
    method = node.body[0]
    assert isinstance(method, Function) and parameters(method) == 2
    assert risen({"a": 3, "b": 5}, {"a": 3, "b": 4}) == {"b": 5} and risen({"c": 1}, {}) == {"c": 1}
