"""`python -m hil_tests.house.dead`: definitions of the product that nothing but tests names (make lint).

A definition is dead when no product code, script or page outside of it names it.  What a decorator registers, what a base class outside
the project calls and what a requirement mark names (`by=`) is left out: a row of the manuals keeps it.  dead.toml allows a number of them
for a file.  `--lower` writes what is left there; a number never rises.
"""

import ast
import pathlib
import re
import sys
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from hil_tests.house.statements import statements_in
from hil_tests.matrix.spelled import claims

ROOT = pathlib.Path(__file__).resolve().parents[2]
ALLOWED = pathlib.Path(__file__).with_name("dead.toml")
PACKAGES = ("gateway", "drivers", "motion", "protocols")
BESIDE = ("pyproject.toml", "hatch_build.py", "Makefile", "docs/*.py", "gateway/**/*.c")  # name functions of the product, too
PLAIN = {
    "property",
    "cached_property",
    "staticmethod",
    "classmethod",
    "dataclass",
    "cache",
    "lru_cache",
    "contextmanager",
    "runtime_checkable",
}
CALLED_BY_NAME = re.compile(
    r"(?:_do|action|on|watch|visit|f)_\w+|_recv_internal|_missing_|reducer_override|data_received|get_user|"
    r"(?:pause|resume)_writing|get_buffer|buffer_updated|handle_\w+_upgrade|handle_(?:starttag|endtag|data)"
)


class Definition(NamedTuple):
    """A class, function or method."""

    path: str
    name: str  # qualified
    first: int
    last: int

    @property
    def short(self) -> str:
        return self.name.rpartition(".")[2]


class Source(NamedTuple):
    """What a file defines and what it names, with lines."""

    definitions: list[Definition]
    names: list[tuple[str, int]]


def read(path: str, text: str) -> Source:
    tree = ast.parse(text)
    return Source(list(_definitions(path, tree, "")), list(_names(tree)))


def _definitions(path: str, node: ast.AST, inside: str) -> Iterator[Definition]:
    for child in statements_in(node):
        if not isinstance(child, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            yield from _definitions(path, child, inside)
            continue
        name = f"{inside}.{child.name}" if inside else child.name
        if not (_registered(child) or child.name.startswith("__") or CALLED_BY_NAME.fullmatch(child.name)):
            yield Definition(path, name, child.lineno, child.end_lineno or child.lineno)
        if isinstance(child, ast.ClassDef):
            yield from _definitions(path, child, name)


def _registered(node: ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    called = (each.func if isinstance(each, ast.Call) else each for each in node.decorator_list)
    return any(ast.unparse(each).rpartition(".")[2] not in PLAIN for each in called)


def _names(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Names, attributes, keywords and words of short texts; an import alone does not count as a use."""
    for node in ast.walk(tree):
        match node:
            case ast.Name():
                yield node.id, node.lineno
            case ast.Attribute():
                yield node.attr, node.lineno
            case ast.keyword(arg=str(name)):
                yield name, node.value.lineno
            case ast.Constant(value=str(text)) if len(text) < 120:
                yield from ((word, node.lineno) for word in re.findall(r"[A-Za-z_]\w+", text))


def dead(sources: Mapping[str, Source], elsewhere: set[str], kept: set[str]) -> list[Definition]:
    """What is named nowhere but in itself; kept: full names `module:qualname` that a requirement mark names, or a part of them."""
    uses: dict[str, list[tuple[str, int]]] = defaultdict(list)
    for path, source in sources.items():
        for name, line in source.names:
            uses[name].append((path, line))
    return [
        each
        for source in sources.values()
        for each in source.definitions
        if each.short not in elsewhere
        and not any(path != each.path or not each.first <= line <= each.last for path, line in uses[each.short])
        and not any(name == full(each) or name.startswith(f"{full(each)}.") for name in kept)
    ]


def full(each: Definition) -> str:
    return f"{each.path.removesuffix('.py').removesuffix('/__init__').replace('/', '.')}:{each.name}"


def found() -> list[Definition]:
    """Of the tree."""
    files = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
    sources = {str(path.relative_to(ROOT)): read(str(path.relative_to(ROOT)), path.read_text(encoding="utf-8")) for path in files}
    beside = [path for pattern in BESIDE for path in ROOT.glob(pattern)]
    elsewhere = {word for path in beside for word in re.findall(r"\w+", path.read_text(encoding="utf-8"))}
    return dead(sources, elsewhere, {function for each in claims().values() for claim in each for function in claim.by})


def judged(definitions: list[Definition], limits: Mapping[str, int]) -> list[str]:
    """One line for each dead definition of a file that has more than it may."""
    counts = Counter(each.path for each in definitions)
    return [
        f"{each.path}:{each.first}: nothing but tests names {each.name}"
        for each in definitions
        if counts[each.path] > limits.get(each.path, 0)
    ]


def lowered(definitions: list[Definition], limits: Mapping[str, int]) -> dict[str, int]:
    """Limits that are left: what is dead, never more than was allowed."""
    counts = Counter(each.path for each in definitions)
    return {name: min(limit, counts[name]) for name, limit in sorted(limits.items()) if counts[name]}


def allowed() -> dict[str, int]:
    return {name: int(count) for name, count in tomllib.loads(ALLOWED.read_text(encoding="utf-8")).items()}


def main() -> int:
    definitions, limits = found(), allowed()
    if "--lower" in sys.argv[1:]:
        rows = [f'"{name}" = {count}\n' for name, count in lowered(definitions, limits).items()]
        ALLOWED.write_text(ALLOWED.read_text(encoding="utf-8").partition("\n")[0] + "\n" + "".join(rows), encoding="utf-8")
    faults = judged(definitions, limits)
    print("\n".join(faults), end="\n" if faults else "")
    print(f"dead: {len(definitions)} definitions that nothing but tests names, {sum(limits.values())} allowed in {len(limits)} files")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
