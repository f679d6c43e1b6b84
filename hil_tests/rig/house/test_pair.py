"""Two processes share the pure tests: each file belongs to one of them, and what neither told has failed."""

import pathlib
from typing import Literal

import pytest

from hil_tests import reports
from hil_tests.pair import Claims


def test_a_file_belongs_to_who_asked_first_with_all_its_tests(tmp_path: pathlib.Path, request: pytest.FixtureRequest) -> None:
    item = request.node
    ours, theirs = Claims(tmp_path), Claims(tmp_path)
    assert ours.mine(item) and ours.mine(item)
    assert not theirs.mine(item)


def test_what_was_told_is_read_back_and_half_a_line_is_nothing(tmp_path: pathlib.Path, request: pytest.FixtureRequest) -> None:
    path, config = tmp_path / "reports.jsonl", request.config
    assert reports.read(config, path) == {}
    reporter = reports.Reporter(config, path)
    for one in (passed("setup"), pytest.TestReport("a::b", ("a", 1, "b"), {}, "failed", "why", "call"), passed("teardown")):
        reporter.pytest_runtest_logreport(one)
    path.write_text(path.read_text() + '{"nodeid": "a::c", "wh')
    told = reports.read(config, path)
    assert list(told) == ["a::b"]
    assert [(one.when, one.outcome) for one in told["a::b"]] == [("setup", "passed"), ("call", "failed"), ("teardown", "passed")]


def passed(when: Literal["setup", "teardown"]) -> pytest.TestReport:
    return pytest.TestReport("a::b", ("a", 1, "b"), {}, "passed", None, when)
