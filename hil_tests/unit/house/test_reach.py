"""What comes to a function, read from sources: a small tree made up, and the product's own."""

import pathlib

import pytest

from hil_tests.matrix import reach
from hil_tests.matrix.callgraph import CallGraph
from hil_tests.matrix.catalogue import rows
from hil_tests.matrix.proof import README, STATUS
from hil_tests.matrix.spelled import claims

SOURCES = {
    "app/__init__.py": "",
    "app/start.py": """
from app import parts
from app.parts import Machine, TABLE
def main() -> None:
    machine = Machine()
    machine.step()
    TABLE["a"]()
    later()
def later() -> None:
    from app.lazy import lazily
    lazily()
def unused() -> None:
    parts.lonely()
""",
    "app/parts.py": """
class Base:
    def inherited(self) -> None:
        never_by_name()
    def step(self) -> None: ...
class Machine(Base):
    def __init__(self) -> None:
        self.inherited()
    def step(self) -> None:
        helper()
    def silent(self) -> None:
        lonely()
class Other:
    def step(self) -> None:
        lonely()
def takes(other: Other) -> bool:
    return isinstance(other, Other)
def helper() -> None:
    takes(None)
def never_by_name() -> None: ...
def lonely() -> None: ...
def in_table() -> None: ...
TABLE = {"a": in_table}
DEAD = {"b": lonely}
""",
    "app/lazy.py": "from app.parts import helper as lazily\ndef barred() -> None: ...\n",
}


@pytest.fixture
def graph(tmp_path: pathlib.Path) -> CallGraph:
    for name, text in SOURCES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return CallGraph(tmp_path, ("app",))


def test_calls_tables_lazy_imports_bases_and_methods_of_what_is_made_are_followed(graph: CallGraph) -> None:
    found = graph.reached(["app.start:main"])
    for name in ("start:later", "parts:Machine.__init__", "parts:Machine.step", "parts:Base.inherited", "parts:never_by_name"):
        assert f"app.{name}" in found
    assert {"app.parts:in_table", "app.parts:helper", "app.parts:takes"} <= found


def test_what_is_only_named_in_annotations_isinstance_or_dead_code_is_not_reached(graph: CallGraph) -> None:
    found = graph.reached(["app.start:main"])
    assert not {"app.start:unused", "app.parts:lonely", "app.parts:Machine.silent", "app.parts:Other.step", "app.parts:DEAD"} & found
    assert "app.parts:lonely" in graph.reached(["app.start:unused"])


def test_a_barred_module_is_not_entered(graph: CallGraph) -> None:
    assert not any(name.startswith("app.parts:") for name in graph.reached(["app.start:main"], lambda module: module == "app.parts"))


def test_names_put_together_at_run_time_are_followed_where_they_are_declared(tmp_path: pathlib.Path, graph: CallGraph) -> None:
    declared = CallGraph(tmp_path, ("app",), {"app.start:later": (("app.parts", "lone"), ("app.parts", "Machine.sil"))})
    assert {"app.parts:lonely", "app.parts:Machine.silent"} <= declared.reached(["app.start:main"])
    assert "app.parts:DEAD" not in declared.reached(["app.start:main"])
    assert "app.parts:Machine.silent" not in declared.reached(["app.parts:takes"]), "only with what puts them together"


def test_every_declared_name_is_one_of_the_product() -> None:
    graph = reach.product()
    for function, found in reach.ASSEMBLED.items():
        module, _, name = function.partition(":")
        assert name in graph.modules[module].nodes
        assert [
            (other, prefix) for other, prefix in found if other not in graph.modules or (not prefix and not graph.modules[other].nodes)
        ] == []
    prefixes = {prefix for found in reach.ASSEMBLED.values() for _, prefix in found if prefix}
    named = {name for found in reach.ASSEMBLED.values() for other, _ in found for name in graph.modules[other].nodes}
    assert [prefix for prefix in prefixes if not any(name.startswith(prefix) for name in named)] == []


def test_of_the_product_the_cycle_a_serial_unit_and_a_built_in_are_a_cells_and_assess_a_command() -> None:
    kinds = reach.kinds()
    assert kinds["gateway.pure.controllers.rho3.serial.manager:LineManager.read"] == "cell"
    assert kinds["gateway.pure.languages.val3.strings:f_to_string"] == "cell"
    assert kinds["gateway.pure.cycle.core:CycleLogic._drive"] == "cell"
    assert kinds["gateway.commands.assess:main"] == "command"
    assert kinds["gateway.pure.controllers.rho3.can.rules:judge"] == "command"  # through a row of the registry
    assert kinds["gateway.processes.planner:main"] == "program"
    assert "test" not in " ".join(set(kinds.values()))


def test_every_function_a_mark_names_is_known_to_the_graph() -> None:
    named = {by for found in claims().values() for one in found for by in one.by}
    assert len(named) > 300 and named - set(reach.kinds()) == set()


def test_the_readme_counts_all_rows() -> None:
    sentence = STATUS.search(README.read_text())
    assert sentence is not None
    numbers = [int(word) for word in sentence[0].replace("(", " ").split() if word.isdigit()]
    total, proved, cell, program, command, api, still_open = numbers
    assert (total, cell + program + command, proved + api + still_open) == (len(rows()), proved, total)
