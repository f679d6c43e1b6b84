"""Lanes: whose tests count where, and when a missing one is a failure."""

import pathlib
from typing import Literal

import pytest

from hil_tests import lanes
from hil_tests.lanes import Lanes, lane_of, required


@pytest.mark.parametrize(
    ("nodeid", "keywords", "lane"),
    [
        ("hil_tests/unit/x/test_a.py::test_a", {}, "pure"),
        ("hil_tests/conformance/x/test_a.py::test_a", {}, "pure"),
        ("hil_tests/properties/test_a.py::test_a[rig]", {}, "pure"),
        ("hil_tests/rig/serial/test_a.py::test_a", {}, "rig"),
        ("hil_tests/rig/vcan/test_a.py::test_a", {"vcan": 1}, "vcan"),
        ("hil_tests/rig/modbus/test_a.py::test_a", {"mbpoll": 1, "slow": 1}, "mbpoll"),
        ("hil_tests/bench/test_a.py::test_a", {}, "other"),
    ],
)
def test_a_test_counts_in_one_lane(nodeid: str, keywords: dict[str, object], lane: str) -> None:
    assert lane_of(nodeid, keywords) == lane


@pytest.mark.parametrize(("uid", "ci", "must"), [(1000, "", False), (1000, "true", True), (1000, "false", False), (0, "", True)])
def test_a_missing_lane_fails_in_ci_and_as_root_on_debian(
    monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path, uid: int, ci: str, must: bool
) -> None:
    (tmp_path / "debian_version").touch()
    monkeypatch.setattr(lanes, "DEBIAN", tmp_path / "debian_version")
    monkeypatch.setattr("os.geteuid", lambda: uid)
    assert required({"CI": ci}) is must


def test_root_elsewhere_than_on_debian_may_skip(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    monkeypatch.setattr(lanes, "DEBIAN", tmp_path / "nowhere")
    assert required({}) is False


Outcome = Literal["passed", "failed", "skipped"]
Phase = Literal["setup", "call", "teardown"]
PHASES: tuple[Phase, ...] = ("setup", "call", "teardown")


def report(nodeid: str, outcome: Outcome, when: Phase, keywords: dict[str, Literal[1]]) -> pytest.TestReport:
    return pytest.TestReport(nodeid, ("", 0, ""), keywords, outcome, None, when)


def test_each_test_counts_once_by_its_worst_phase_and_an_empty_lane_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(lanes.NEEDS, "mbpoll", lambda: "mbpoll not found")
    plugin = Lanes()
    for when in PHASES:
        plugin.pytest_runtest_logreport(report("a", "passed", when, {"vcan": 1}))
        plugin.pytest_runtest_logreport(report("b", "failed" if when == "teardown" else "passed", when, {"vcan": 1}))
    plugin.pytest_runtest_logreport(report("c", "skipped", "setup", {"mbpoll": 1}))
    assert list(plugin.lines()) == [
        "lane vcan: 1 passed, 1 failed",
        "lane mbpoll: 1 skipped (mbpoll not found)",
        "lane cref: no test selected",
        "lane tshark: no test selected",
        "lane npm: no test selected",
        "lane pythons: no test selected",
    ]
