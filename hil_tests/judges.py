"""Modules of tests whose judges are not installed (hil_tests/requirements.lock) are left out and reported: lane judges.

`make setup` installs axisgate and its tools in 350 MB; the judges are another gigabyte, which `make test` and `make judges` fetch.
"""

import ast
import importlib.util
import pathlib
from collections.abc import Iterator
from functools import cache

JUDGES = (
    "pinocchio",
    "toppra",
    "eaik",
    "py_opw_kinematics",
    "asammdf",
    "matplotlib",
    "playwright",
    "schemathesis",
    "scipy",
    "pytest_lsp",
    "dap",
)
ROOT = pathlib.Path(__file__).resolve().parents[1]
OURS = ("hil_tests.", "motion.kinematics.urdf")  # what a test may get a judge through


def absent() -> frozenset[str]:
    """Judges that are not installed."""
    return frozenset(name for name in JUDGES if importlib.util.find_spec(name) is None)


def imported(path: pathlib.Path) -> Iterator[str]:
    """What a module imports when it is loaded."""
    for node in ast.parse(path.read_bytes()).body:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@cache
def needs(path: pathlib.Path) -> frozenset[str]:
    """Judges a module cannot be loaded without."""
    found: set[str] = set()
    for name in imported(path):
        found |= {name.partition(".")[0]} & set(JUDGES)
        file = ROOT / f"{name.replace('.', '/')}.py"
        if name.startswith(OURS) and file.is_file() and file != path:
            found |= needs(file)
    return frozenset(found)


class LeftOut:
    """What a run could not collect."""

    def __init__(self) -> None:
        self.modules: dict[str, frozenset[str]] = {}

    def ignored(self, path: pathlib.Path) -> bool:
        """Whether this module of tests cannot be loaded here; it is remembered."""
        missing = absent()
        if not missing or path.suffix != ".py" or not path.name.startswith("test_") or not (lacking := needs(path) & missing):
            return False
        self.modules[str(path)] = lacking
        return True

    def line(self) -> str:
        """Empty when nothing was left out."""
        if not self.modules:
            return ""
        names = ", ".join(sorted(frozenset().union(*self.modules.values())))
        return f"lane judges: {len(self.modules)} modules not collected ({names} not installed: make judges)"
