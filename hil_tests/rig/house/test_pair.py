"""Two processes share the pure tests: each file belongs to one of them, and a test that neither reported has failed."""

import os
import pathlib
import subprocess
import sys
from typing import Literal

import pytest

from hil_tests import reports
from hil_tests.pair import CLAIMS, WORKER, Claims


def test_a_file_belongs_to_who_asked_first_with_all_its_tests(tmp_path: pathlib.Path, request: pytest.FixtureRequest) -> None:
    item = request.node
    ours, theirs = Claims(tmp_path), Claims(tmp_path)
    assert ours.mine(item) and ours.mine(item)
    assert not theirs.mine(item)


def test_what_was_reported_is_read_back_and_half_a_line_is_nothing(tmp_path: pathlib.Path, request: pytest.FixtureRequest) -> None:
    path, config = tmp_path / "reports.jsonl", request.config
    assert reports.read(config, path) == {}
    reporter = reports.Reporter(config, path)
    for one in (passed("setup"), pytest.TestReport("a::b", ("a", 1, "b"), {}, "failed", "why", "call"), passed("teardown")):
        reporter.pytest_runtest_logreport(one)
    path.write_text(path.read_text() + '{"nodeid": "a::c", "wh')
    found = reports.read(config, path)
    assert list(found) == ["a::b"]
    assert [(one.when, one.outcome) for one in found["a::b"]] == [("setup", "passed"), ("call", "failed"), ("teardown", "passed")]


def test_what_belongs_to_the_other_leaves_nothing_set_up(tmp_path: pathlib.Path) -> None:
    """The test before it prepared for it, and the next one that is played is in another folder."""
    (tmp_path / "conftest.py").write_text("from hil_tests.conftest import pytest_addoption, pytest_configure\n")
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers =\n    requirement\n")
    for name in ("p/test_ours.py", "p/test_theirs.py", "q/test_ours_too.py"):
        (file := tmp_path / name).parent.mkdir(exist_ok=True)
        file.write_text("def test(): pass\n")
    (tmp_path / "pair" / CLAIMS / "p.test_theirs.py").mkdir(parents=True)
    (mine := tmp_path / "pair" / "front").mkdir()
    environment = {**os.environ, WORKER: str(mine), "PYTHONPATH": str(pathlib.Path(__file__).resolve().parents[3])}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--import-mode=importlib", "p", "q"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, "2 passed" in done.stdout, "error" in done.stdout) == (0, True, False), done.stdout


def passed(when: Literal["setup", "teardown"]) -> pytest.TestReport:
    return pytest.TestReport("a::b", ("a", 1, "b"), {}, "passed", None, when)
