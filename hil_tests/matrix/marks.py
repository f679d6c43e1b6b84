"""Requirement marks in a pytest run: a mark that cannot be counted fails its test; --matrix FILE writes what was proved."""

import contextlib
import pathlib

import pytest

from hil_tests.matrix import record
from hil_tests.matrix.catalogue import Claim, MarkError, claim
from hil_tests.matrix.record import Result

RANK = ("none", "skipped", "passed", "failed")  # what counts for a test function of several parameters: the right-most seen


def function_id(nodeid: str) -> str:
    """The test function: its id without the parameters."""
    return nodeid.partition("[")[0]


def claims_of(item: pytest.Item) -> list[Claim]:
    """Raises MarkError."""
    return [claim(mark.args, dict(mark.kwargs)) for mark in item.iter_markers("requirement")]


class Marks:
    """Checks the marks of every test that runs; keeps outcomes for --matrix."""

    def __init__(self, target: str | None) -> None:
        self._target = pathlib.Path(target) if target else None
        self._tree = record.tree() if target else ""  # as it is before anything runs
        self._claims: dict[tuple[str, Claim], list[str]] = {}  # test function and claim -> tests that carry it
        self._outcome: dict[str, str] = {}  # of each test

    def pytest_itemcollected(self, item: pytest.Item) -> None:
        """`-k RHO-SER-01` selects by row."""
        with contextlib.suppress(MarkError):  # told when it is set up
            for one in claims_of(item):
                item.extra_keyword_matches.update(one.ids)

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        if self._target is None:
            return
        for item in items:
            with contextlib.suppress(MarkError):  # its set-up fails with the reason
                for one in claims_of(item):  # a parameter may carry claims of its own
                    self._claims.setdefault((function_id(item.nodeid), one), []).append(item.nodeid)

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        try:
            claims_of(item)
        except MarkError as error:
            pytest.fail(str(error), pytrace=False)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "call" or report.outcome != "passed":
            name = report.nodeid
            self._outcome[name] = max(self._outcome.get(name, "none"), report.outcome, key=RANK.index)

    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int) -> None:
        if self._target is None:
            return
        results = [
            Result(name, claim.ids, claim.by, max((self._outcome.get(test, "none") for test in tests), key=RANK.index))
            for (name, claim), tests in self._claims.items()
        ]
        ended = exitstatus in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
        record.save(self._target, self._tree, ended and everything(session.config), results)


def everything(config: pytest.Config) -> bool:
    """Whether nothing but tests without a mark was left out of this run."""
    chosen = config.getoption("keyword") or config.getoption("deselect") or config.getoption("ignore")
    return not chosen and config.getoption("markexpr") in ("", "requirement") and config.args == list(config.getini("testpaths"))
