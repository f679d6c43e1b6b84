"""`make check`: lint, then the pure tests by two processes; either alone fails it, and pytest's closing line is the last of its output.

`make test`: lint beside the branches of the serial protocols, then all tests; each alone fails it.
"""

import os
import pathlib
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
COVERAGE = 'case "$*" in *"coverage run"*) touch begun; exit {code};; *"coverage report"*) exit 0;; esac'
RUFF = "for _ in $(seq 200); do test -e begun && exit {code}; sleep 0.05; done; echo not beside the branches; exit 9"
PYTEST = 'case "$*" in *pytest*) echo "$*"; echo "9 passed, 0 failed in 1.00s"; exit {code};; esac; exit 0'


def program(path: pathlib.Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


def make(tree: pathlib.Path, *target: str, ruff: str, python: str) -> "subprocess.CompletedProcess[str]":
    """Of the project's Makefile with these programs in place of ruff and Python."""
    shutil.copy(ROOT / "Makefile", tree)
    for name in ("requirements.lock", "pyproject.toml", "hil_tests/requirements.lock"):
        (tree / name).parent.mkdir(exist_ok=True)
        (tree / name).touch()
    for name in ("mypy", "lint-imports"):
        program(tree / ".venv/bin" / name, "exit 0")
    program(tree / ".venv/bin/ruff", ruff)
    program(tree / ".venv/bin/python", python)
    for name in ("installed.stamp", "judges.stamp"):
        (tree / ".venv" / name).touch()
    alone = {
        name: value for name, value in os.environ.items() if not name.startswith("MAKE") and name != "MFLAGS"
    }  # not a part of `make test`
    return subprocess.run(["make", *target], cwd=tree, env=alone, capture_output=True, text=True, check=False, timeout=60)


@pytest.mark.parametrize(("lint", "tests"), [(0, 0), (1, 0), (0, 1)])
def test_lint_and_tests_each_fail_it_and_the_tests_run_all_the_same(tmp_path: pathlib.Path, lint: int, tests: int) -> None:
    said = make(tmp_path, "check", ruff=f"exit {lint}", python=PYTEST.format(code=tests))
    assert (said.returncode == 0) == (lint == tests == 0)
    assert ("lint failed" in said.stderr) == bool(lint)
    called, closing = said.stdout.splitlines()[-2:]
    assert closing == "9 passed, 0 failed in 1.00s"
    assert called.split() == "-m pytest -q --pair --durations=10 hil_tests/unit hil_tests/requirements hil_tests/properties".split()


@pytest.mark.parametrize(("lint", "branches", "tests"), [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
def test_lint_and_branches_run_beside_each_other_and_each_fails_the_run(
    tmp_path: pathlib.Path, lint: int, branches: int, tests: int
) -> None:
    there = [word for name in ("references", "native", "kernel", "pythons") for word in ("-o", name)]
    python = f"{COVERAGE.format(code=branches)}; {PYTEST.format(code=tests)}"
    said = make(tmp_path, "test", *there, ruff=RUFF.format(code=lint), python=python)
    assert (said.returncode == 0) == (lint == branches == tests == 0), said
    assert ("lint failed" in said.stderr) == bool(lint) and ("is not tested" in said.stderr) == bool(branches)
    assert "not beside" not in said.stdout and said.stdout.splitlines()[-1] == "9 passed, 0 failed in 1.00s"
