"""Lanes: whose tests count where, and when a missing one is a failure."""

import pathlib
import shutil
from typing import Literal

import pytest

from hil_tests import lanes
from hil_tests.lanes import ROOT, Lanes, lane_of, required


@pytest.mark.parametrize(
    ("nodeid", "keywords", "lane"),
    [
        ("hil_tests/unit/x/test_a.py::test_a", {}, "pure"),
        ("hil_tests/requirements/x/test_a.py::test_a", {}, "pure"),
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


PAGE = ROOT / "hil_tests" / "rig" / "web" / "test_page.py"


@pytest.mark.parametrize(("ci", "outcome"), [("true", "failed"), ("", "skipped")])
def test_without_chromium_the_tests_of_the_page_fail_in_ci_and_are_skipped_elsewhere(
    monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path, ci: str, outcome: str
) -> None:
    """Marked as the page's tests are."""
    assert "pytest.mark.browser" in PAGE.read_text() and "skipif" not in PAGE.read_text()
    real = shutil.which
    monkeypatch.setattr(shutil, "which", lambda name: None if name == "chromium" else real(name))
    monkeypatch.setattr(lanes, "DEBIAN", tmp_path / "nowhere")
    monkeypatch.setenv("CI", ci)

    class Page:
        def get_closest_marker(self, name: str) -> bool:
            return name == "browser"

    with pytest.raises((pytest.fail.Exception, pytest.skip.Exception)) as ended:
        Lanes().pytest_runtest_setup(Page())  # type: ignore[arg-type]  # all of an item that is asked
    assert ended.type is (pytest.fail.Exception if outcome == "failed" else pytest.skip.Exception)
    assert "chromium not found" in str(ended.value)


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
        "lane browser: no test selected",
        "lane pythons: no test selected",
    ]
