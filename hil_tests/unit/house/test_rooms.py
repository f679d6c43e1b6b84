"""The rooms of the house: no loose files, no upward imports, no circles, names without metaphors and with separated words."""

import ast
import functools
import pathlib
from collections.abc import Iterator, Mapping

ROOT = next(parent for parent in pathlib.Path(__file__).resolve().parents if (parent / "pyproject.toml").exists())
PACKAGES = ("gateway", "drivers", "motion", "protocols")
LOOSE = {"__init__.py", "__main__.py"}
ROOMS = (  # bottom up: a room imports only rooms below it; rooms of one row do not import one another
    ("pure",),
    ("files",),
    ("runtime",),
    ("assembly",),
    ("checks",),
    ("cell_file",),
    ("links",),
    ("recording",),
    ("cycle",),
    ("services",),
    ("interpreter",),
    ("simulation",),
    ("observer",),
    ("scope",),
    ("web", "northbound", "shadow"),
    ("processes",),
    ("conformance",),
    ("tools",),
    ("commands",),
    ("__main__",),
)
METAPHORS = ("office", "desk", "door", "paper", "picture", "sheet", "hands", "post", "tape", "told", "amiss")
REGISTRY = "gateway.registry"  # its rows import inside their functions, whatever they are of
FUSED = ("datadoor", "linedoor", "cellfile", "linejournal", "modbusdoor", "dbsignals", "fastio", "setvalues", "movefile", "onpath")


@functools.cache
def modules() -> Mapping[str, pathlib.Path]:
    found = {}
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            found[".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")] = path
    return found


@functools.cache
def imported() -> Mapping[str, list[str]]:
    """Modules that each module of the project imports anywhere in it."""
    return {module: list(imports(path, modules())) for module, path in modules().items()}


def imports(path: pathlib.Path, known: Mapping[str, pathlib.Path]) -> Iterator[str]:
    """Modules of the project that a file imports anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                yield full if full in known else node.module
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def level(module: str) -> tuple[int, str] | None:
    room = module.split(".")[1] if "." in module else ""
    return next(((number, room) for number, row in enumerate(ROOMS) if room in row), None)


def test_every_file_of_the_gateway_is_in_a_room() -> None:
    loose = [path.name for folder in (ROOT / "gateway", ROOT / "gateway/pure") for path in folder.glob("*.py")]
    assert set(loose) <= LOOSE


def test_a_room_imports_only_rooms_below_it() -> None:
    upward = []
    for module, others in imported().items():
        here = level(module) if module.startswith("gateway.") else None
        for other in others:
            there = level(other) if other.startswith("gateway.") else None
            if here and there and (there[0] > here[0] or (there[0] == here[0] and there[1] != here[1])):
                upward.append(f"{module} -> {other}")
    assert upward == []


def test_no_file_is_in_a_circle_of_imports_lazy_and_type_only_ones_counted() -> None:
    graph = {module: {other for other in others if other in modules()} for module, others in imported().items()}
    graph |= {module: set() for module in graph if module.startswith(REGISTRY)}
    assert [module for module in sorted(graph) if module in reached(graph, module)] == []


def reached(graph: Mapping[str, set[str]], start: str) -> set[str]:
    """What a module comes to by its imports, in one step or more."""
    seen: set[str] = set()
    waiting = list(graph[start])
    while waiting:
        module = waiting.pop()
        if module not in seen:
            seen.add(module)
            waiting += graph[module]
    return seen


def test_names_of_modules_are_the_nouns_of_the_field_with_separated_words() -> None:
    wrong = [module for module in modules() if any(part in (*METAPHORS, *FUSED) for part in module.rpartition(".")[2].split("_"))]
    assert wrong == []


def test_no_part_of_the_services_imports_for_types_alone() -> None:
    """A part takes what it uses: context, shared image, values, dispatcher."""
    found = [path.name for path in (ROOT / "gateway/services").rglob("*.py") if "TYPE_CHECKING" in path.read_text(encoding="utf-8")]
    assert found == []
