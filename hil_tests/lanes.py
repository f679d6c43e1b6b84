"""Lanes: groups of tests that need a tool or a facility of the machine; the end of a run reports each lane in one line.

A lane whose needs are missing is skipped with one line.  With CI=true, and as root on Debian (where `make` installs what is
missing), the tests of such a lane fail instead: an empty lane must not look like a passed one.
"""

import collections
import os
import pathlib
import shutil
from collections.abc import Callable, Generator, Iterator, Mapping

import pytest

from gateway.cycle.native import built
from hil_tests.judges import LeftOut
from hil_tests.lab.running import pythons

ROOT = pathlib.Path(__file__).resolve().parent.parent
REFERENCES = ROOT / "build"  # C references: hil_tests/bench/NAME.c becomes build/NAME
NODE_MODULES = REFERENCES / "node/node_modules"  # put there by hil_tests/rig/setup.sh tools
DEBIAN = pathlib.Path("/etc/debian_version")


def _vcan() -> str | None:
    from hil_tests.rig.uml import guest, lane

    return None if lane.inside() else guest.missing()


def _mbpoll() -> str | None:
    return None if shutil.which("mbpoll") else "mbpoll not found (Debian: apt-get install mbpoll)"


def _cref() -> str | None:
    unbuilt = [source.stem for source in sorted((ROOT / "hil_tests" / "bench").glob("*.c")) if not (REFERENCES / source.stem).exists()]
    if unbuilt:
        return f"build/{', build/'.join(unbuilt)} not built (make references)"
    parts = [part for part in built.PARTS if not built.library(part).exists()]
    return f"gateway/cycle/native: {', '.join(parts)} not built (make native)" if parts else None


def _tshark() -> str | None:
    return None if shutil.which("tshark") else "tshark not found (Debian: apt-get install tshark)"


def _npm() -> str | None:
    there = shutil.which("node") and (NODE_MODULES / "modbus-serial").exists()
    return None if there else "node or build/node/node_modules/modbus-serial not found (make tools)"


def _browser() -> str | None:
    return None if shutil.which("chromium") else "chromium not found (Debian: apt-get install chromium)"


def _pythons() -> str | None:
    return pythons.missing()


NEEDS: dict[str, Callable[[], str | None]] = {
    "vcan": _vcan,
    "mbpoll": _mbpoll,
    "cref": _cref,
    "tshark": _tshark,
    "npm": _npm,
    "browser": _browser,
    "pythons": _pythons,
}  # marker = lane
FOLDERS = {"unit": "pure", "requirements": "pure", "properties": "pure", "rig": "rig", "matrix": "rig"}


def missing(lane: str) -> str | None:
    """Return in one line why this lane cannot run here; None: it can."""
    return NEEDS[lane]()


def required(environment: Mapping[str, str] = os.environ) -> bool:
    """Return whether a lane that cannot run is a failure here."""
    return environment.get("CI", "").lower() in ("true", "1") or (os.geteuid() == 0 and DEBIAN.exists())


def lane_of(nodeid: str, keywords: Mapping[str, object]) -> str:
    marked = next((lane for lane in NEEDS if lane in keywords), None)
    parts = nodeid.partition("::")[0].split("/")
    return marked or next((FOLDERS[part] for part in parts if part in FOLDERS), "other")


class Lanes:
    """Skip or fail tests that cannot run; count each test once, by its worst phase."""

    def __init__(self) -> None:
        self._worst: dict[str, str] = {}
        self._lane: dict[str, str] = {}
        self._left_out = LeftOut()

    def pytest_ignore_collect(self, collection_path: pathlib.Path) -> bool | None:
        return True if self._left_out.ignored(collection_path) else None

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if self._left_out.modules and required() and session.exitstatus == 0:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED  # an empty lane has not passed

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        for lane in NEEDS:
            reason = missing(lane) if item.get_closest_marker(lane) else None
            if reason and required():
                pytest.fail(f"lane {lane} must run here: {reason}", pytrace=False)
            if reason:
                pytest.skip(f"lane {lane}: {reason}")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._lane[report.nodeid] = lane_of(report.nodeid, report.keywords)
        rank = ("passed", "skipped", "failed")
        self._worst[report.nodeid] = max(self._worst.get(report.nodeid, "passed"), report.outcome, key=rank.index)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> Generator[None, None, None]:
        yield  # the lines of the lanes come last, right above the closing line
        terminalreporter.section("lanes")
        for line in self.lines():
            terminalreporter.write_line(line)

    def lines(self) -> Iterator[str]:
        for lane in ("pure", "rig", *NEEDS, "other"):
            counts = collections.Counter(self._worst[nodeid] for nodeid, of in self._lane.items() if of == lane)
            summary = ", ".join(f"{counts[outcome]} {outcome}" for outcome in ("passed", "failed", "skipped") if counts[outcome])
            reason = missing(lane) if lane in NEEDS and counts["skipped"] else None
            if summary or lane in NEEDS:
                yield f"lane {lane}: {summary or 'no test selected'}{f' ({reason})' if reason else ''}"
        if line := self._left_out.line():
            yield line
