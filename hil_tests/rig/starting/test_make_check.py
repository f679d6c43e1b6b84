"""`make check`: lint, then the pure tests by two processes; either alone fails it, and pytest's closing line is the last of its output."""

import os
import pathlib
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
PYTEST = 'case "$*" in *pytest*) echo "$*"; echo "9 passed, 0 failed in 1.00s"; exit {code};; esac; exit 0'


def program(path: pathlib.Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


def check(tree: pathlib.Path, lint: int, tests: int) -> "subprocess.CompletedProcess[str]":
    """Of the project's Makefile where ruff and pytest end with these codes."""
    shutil.copy(ROOT / "Makefile", tree)
    for name in ("requirements.lock", "pyproject.toml", "hil_tests/requirements.lock"):
        (tree / name).parent.mkdir(exist_ok=True)
        (tree / name).touch()
    for name in ("mypy", "lint-imports"):
        program(tree / ".venv/bin" / name, "exit 0")
    program(tree / ".venv/bin/ruff", f"exit {lint}")
    program(tree / ".venv/bin/python", PYTEST.format(code=tests))
    for name in ("installed.stamp", "judges.stamp"):
        (tree / ".venv" / name).touch()
    alone = {
        name: value for name, value in os.environ.items() if not name.startswith("MAKE") and name != "MFLAGS"
    }  # not a part of `make test`
    return subprocess.run(["make", "check"], cwd=tree, env=alone, capture_output=True, text=True, check=False, timeout=60)


@pytest.mark.parametrize(("lint", "tests"), [(0, 0), (1, 0), (0, 1)])
def test_lint_and_tests_each_fail_it_and_the_tests_run_all_the_same(tmp_path: pathlib.Path, lint: int, tests: int) -> None:
    said = check(tmp_path, lint, tests)
    assert (said.returncode == 0) == (lint == tests == 0)
    assert ("lint failed" in said.stderr) == bool(lint)
    called, closing = said.stdout.splitlines()[-2:]
    assert closing == "9 passed, 0 failed in 1.00s"
    assert called.split() == "-m pytest -q --pair --durations=10 hil_tests/unit hil_tests/requirements hil_tests/properties".split()
