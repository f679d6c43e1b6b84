"""Purity: which modules pure folders may import (checked on the source), and a guard that lets calls of clocks, files, sockets and
random numbers raise (at run time).

The guard is active while a test of hil_tests/unit, requirements or properties runs.  It raises only when pure code is on the
stack between the call and the test: pytest, Hypothesis and the tests themselves may use clocks.
"""

import ast
import builtins
import contextlib
import functools
import io
import os
import pathlib
import random
import socket
import sys
import threading
import time
import types
from collections.abc import Callable, Generator, Iterator
from typing import Any

import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent

HARMLESS = frozenset(
    "__future__ abc array binascii bisect collections copy dataclasses decimal difflib enum fractions functools heapq html itertools "
    "json math numbers operator re statistics string struct textwrap types typing unicodedata zlib".split()
)
# Pure folders (and single files, which others may then import): what they may import besides HARMLESS.
ALLOWED: dict[str, frozenset[str]] = {
    "protocols": frozenset({"protocols"}),
    "protocols/modbus": frozenset({"protocols", "pymodbus.pdu", "pymodbus.constants"}),
    "motion": frozenset({"motion", "numpy", "ruckig", "pinocchio"}),
    "motion/kinematics/urdf_chain.py": frozenset({"motion", "xml.etree.ElementTree"}),
    "drivers/drives": frozenset({"protocols", "drivers.drives", "ruckig", "numpy"}),
    "drivers/emulator": frozenset({"protocols", "drivers.emulator"}),
    "gateway/pure": frozenset({"protocols", "motion", "drivers.drives", "gateway.pure"}),
    "gateway/pure/languages/val3": frozenset({"motion", "gateway.pure", "xml.parsers.expat", "xml.sax.saxutils", "datetime"}),
    "gateway/pure/languages/base/collecting.py": frozenset({"contextlib", "gc"}),  # no collections while a long source is read
    "gateway/pure/cell": frozenset({"gateway.pure", "annotated_types"}),  # ranges of the columns
    "gateway/pure/cell/cell.py": frozenset({"gateway.pure", "annotated_types", "datetime"}),  # the type of a date in the file
}
PURE_MODULES = ("protocols.", "motion.", "drivers.drives.", "drivers.emulator.", "gateway.pure.")
GUARDED_FOLDERS = ("unit", "requirements", "properties")
OUTSIDE = (
    "hil_tests",
    "_pytest",
    "pytest",
    "hypothesis",
    "pluggy",
    "importlib",
)  # found first on the stack: the pure code did not make the call


class ImpureError(AssertionError):
    """Pure code asked for the time, a file, a socket, a thread, the environment or a random number."""


# ------------------------------------------------------------------------------------------------------ on the source


def pure_files() -> Iterator[tuple[pathlib.Path, frozenset[str]]]:
    """Yield every pure file with the modules it may import; the longest matching entry of ALLOWED applies."""
    seen: set[pathlib.Path] = set()
    for place in sorted(ALLOWED, key=len, reverse=True):
        path = ROOT / place
        for file in [path] if path.suffix else sorted(path.rglob("*.py")):
            if file.exists() and file not in seen:
                seen.add(file)
                yield file, ALLOWED[place]


def imports_of(source: str) -> Iterator[tuple[int, str]]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.lineno, "." * node.level + (node.module or "")


def forbidden_imports(source: str, allowed: frozenset[str]) -> list[tuple[int, str]]:
    """Return lines and modules that are on neither list; a listed module allows its submodules."""

    def legal(module: str) -> bool:
        return module.partition(".")[0] in HARMLESS or any(f"{module}.".startswith(f"{name}.") for name in allowed)

    return [(line, module) for line, module in imports_of(source) if not legal(module)]


# -------------------------------------------------------------------------------------------------------- at run time


GUARDS: dict[tuple[object, str], tuple[Callable[..., Any], Callable[..., Any]]] = {}  # made once: they are set 13,000 times in a run


def _targets() -> Iterator[tuple[object, str]]:
    clocks = (
        "time time_ns monotonic monotonic_ns perf_counter perf_counter_ns process_time process_time_ns sleep clock_gettime clock_gettime_ns"
    )
    yield from ((time, name) for name in clocks.split())
    randomness = "random randint randrange choice choices shuffle sample uniform gauss normalvariate betavariate getrandbits randbytes"
    yield from ((random, name) for name in randomness.split())
    yield from ((os, name) for name in ("open", "urandom", "getenv", "system", "fork", "popen"))
    yield from ((builtins, "open"), (io, "open"), (socket.socket, "__init__"), (threading.Thread, "start"))
    yield from ((type(os.environ), "__getitem__"), (random.Random, "__init__"))
    numpy = sys.modules.get("numpy.random")
    if numpy is not None:
        yield from ((numpy, name) for name in ("random", "rand", "randn", "randint", "default_rng", "normal", "uniform"))


def impure_caller(frame: types.FrameType | None) -> str | None:
    """Return the pure module nearest on the stack, unless the test or its framework is nearer."""
    while frame is not None:
        name = str(frame.f_globals.get("__name__", ""))
        if f"{name}.".startswith(PURE_MODULES):
            return f"{name}:{frame.f_lineno}"
        if name.partition(".")[0] in OUTSIDE:
            return None
        frame = frame.f_back
    return None


def _guarded(original: Callable[..., Any], what: str) -> Callable[..., Any]:
    @functools.wraps(original)
    def guard(*args: Any, **kwargs: Any) -> Any:
        caller = impure_caller(sys._getframe(1))
        if caller is not None:
            raise ImpureError(f"pure code at {caller} called {what}; pass the value as an argument")
        return original(*args, **kwargs)

    return guard


def _set_guards() -> Iterator[tuple[object, str, object]]:
    """Set each guard and yield what was there before."""
    for owner, name in _targets():
        original = vars(owner)[name]
        known = GUARDS.get((owner, name))
        if known is None or known[0] is not original:  # the first time, or a fixture has put something else there
            known = GUARDS[owner, name] = (original, _guarded(original, f"{getattr(owner, '__name__', owner)}.{name}"))
        setattr(owner, name, known[1])
        yield owner, name, original


@contextlib.contextmanager
def guard() -> Iterator[None]:
    before = list(_set_guards())
    try:
        yield
    finally:
        for owner, name, original in reversed(before):
            setattr(owner, name, original)


def guarded(path: pathlib.Path) -> bool:
    try:
        parts = path.relative_to(ROOT / "hil_tests").parts
    except ValueError:
        return False
    return parts[0] in GUARDED_FOLDERS


class Purity:
    """Activate the guard around every pure test."""

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Generator[None, object, object]:
        with guard() if guarded(item.path) else contextlib.nullcontext():
            return (yield)
