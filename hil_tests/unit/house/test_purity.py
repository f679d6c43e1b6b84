"""Pure folders: direct imports against the allow list, and the guard that makes clocks and the like raise."""

import builtins
import pathlib
import random
import socket
import threading
import time
import types
from collections.abc import Callable

import pytest

from hil_tests.purity import ROOT, ImpureError, forbidden_imports, guard, pure_files

FILES = list(pure_files())


@pytest.mark.parametrize(("file", "allowed"), FILES, ids=[str(file.relative_to(ROOT)) for file, _ in FILES])
def test_a_pure_file_imports_only_what_is_on_its_list(file: pathlib.Path, allowed: frozenset[str]) -> None:
    assert forbidden_imports(file.read_text(), allowed) == []


@pytest.mark.parametrize(
    "line", ["import time", "from time import monotonic", "import os.path", "import random", "from datetime import datetime"]
)
def test_a_forbidden_import_is_found_with_its_line(line: str) -> None:
    found = forbidden_imports(f"import math\n{line}\n", frozenset({"protocols"}))
    assert [number for number, _ in found] == [2]


def test_a_listed_package_allows_what_is_below_it_and_nothing_beside_it() -> None:
    allowed = frozenset({"pymodbus.pdu"})
    assert forbidden_imports("import pymodbus.pdu.file_message", allowed) == []
    assert forbidden_imports("import pymodbus.client", allowed) == [(1, "pymodbus.client")]
    assert forbidden_imports("import pymodbus.pdux", allowed) == [(1, "pymodbus.pdux")]


def pure_code(body: str) -> Callable[[], object]:
    """A function that believes to stand in a pure module; the modules are those at run time, the guard's or not."""
    module = types.ModuleType("protocols.made_for_this_test")
    exec(f"import builtins, os, random, socket, threading, time\ndef run():\n    return {body}\n", module.__dict__)
    run: Callable[[], object] = module.__dict__["run"]
    return run


IMPURE = [
    "time.monotonic_ns()",
    "time.sleep(0)",
    "builtins.open('/dev/null')",
    "socket.socket()",
    "threading.Thread(target=print).start()",
    "random.random()",
    "random.Random(1)",
    "os.environ['PATH']",
    "os.urandom(1)",
]


@pytest.mark.parametrize("body", IMPURE)
def test_pure_code_that_is_impure_raises_while_a_pure_test_runs(body: str) -> None:
    with pytest.raises(ImpureError, match=r"protocols\.made_for_this_test"):
        pure_code(body)()


def test_impurity_is_found_through_a_library_in_between() -> None:
    with pytest.raises(ImpureError):
        pure_code("sorted([1], key=lambda _: time.time())")()


def test_the_test_itself_and_its_framework_keep_their_clock() -> None:
    assert time.monotonic() > 0
    assert random.Random(1).random() == pytest.approx(0.13436424411240122)


def test_the_guard_leaves_everything_as_it_was() -> None:
    before = (time.time, builtins.open, socket.socket.__init__, threading.Thread.start, random.random)
    with guard():
        assert time.time is not before[0]
    assert before == (time.time, builtins.open, socket.socket.__init__, threading.Thread.start, random.random)
