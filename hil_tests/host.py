"""The rig's tests of a whole run, in a process of their own, one module after the other; what a busy machine spoilt is played again.

A shared machine takes the processor away for tens of milliseconds, and a cell that runs on it then stops, as it must.  Two witnesses
(hil_tests/lab/stolen.py) write it down: one of the highest priority for 10 ms and more in which nobody ran, an ordinary one for 40 ms
and more in which such a process was not served.  A module of which a test failed while they saw that is played again at the end,
whole, in a fresh process and at a slower clock (AGAIN_P5_MS): every rule under test counts in P5.  A failure without such a time, and
one that stays, is a failure.  What was played again stands above the lanes' lines.
"""

import contextlib
import json
import os
import pathlib
import subprocess
import sys
import time
from collections.abc import Sequence

import pytest

from hil_tests import lanes, reports
from hil_tests.lab.stolen import left_alone, stolen, witness
from hil_tests.pair import forget_the_dead, whole_run
from hil_tests.rig.uml.lane import of_the_guest

REPORTS = "AXISGATE_TEST_RIG"  # set in that process: file for its reports
P5 = "AXISGATE_TEST_P5"  # ms; hil_tests/lab/cell_running.py
AGAIN_P5_MS = (16, 32)  # of the first and the second repetition
MOST_AGAIN = 25  # modules; more than these is no matter of the machine
POLL_S = 0.2


class Child:
    """One process that runs these tests; its reports are read as they come."""

    def __init__(self, config: pytest.Config, folder: pathlib.Path, name: str, ids: Sequence[str], p5_ms: int | None = None) -> None:
        self._config, self._folder = config, folder
        self._results: dict[str, list[pytest.TestReport]] = {}
        self._read = 0
        self._file, self.log = folder / f"{name}.jsonl", folder / f"{name}.log"
        self._stolen = {folder / f"{name}.stolen": (), folder / f"{name}.not-served": ("--ordinary",)}
        listed = folder / f"{name}.txt"
        listed.write_text("\n".join(ids))
        self._watch = contextlib.ExitStack()
        for file, options in self._stolen.items():
            self._watch.enter_context(witness(file, *options))
        slower = {} if p5_ms is None else {P5: str(p5_ms)}
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "--color=no", f"@{listed}"]
        with self.log.open("wb") as log:
            environment = {**os.environ, REPORTS: str(self._file), **slower}
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, env=environment)

    def wait(self, ids: Sequence[str]) -> reports.Reports:
        """Until these tests have ended, or the process has."""
        while True:
            alive = self._process.poll() is None
            self._take()
            if not alive or all(any(r.when == "teardown" for r in self._results.get(name, ())) for name in ids):
                return self._results
            time.sleep(POLL_S)

    def end(self) -> None:
        if self._process.poll() is None:
            self._process.terminate()
        self._process.wait()
        self._watch.close()

    def spoilt(self, ids: Sequence[str]) -> list[tuple[float, float]]:
        """Times at which nobody ran while these tests did (s, wall clock)."""
        found = [report for name in ids for report in self._results.get(name, ())]
        times = [each for file in self._stolen if file.exists() for each in stolen(file)]
        since, to = min((r.start for r in found), default=0.0), max((r.stop for r in found), default=time.time())
        return [each for each in times if not left_alone(since, to, [each])]

    def _take(self) -> None:
        if not self._file.exists():
            return
        with self._file.open("rb") as file:
            file.seek(self._read)
            data = file.read()
        lines = data[: data.rfind(b"\n") + 1]
        self._read += len(lines)
        for line in lines.splitlines():
            report = self._config.hook.pytest_report_from_serializable(config=self._config, data=json.loads(line))
            self._results.setdefault(report.nodeid, []).append(report)


class Host:
    """Only in a whole run; a selection is run here, as it stands."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._folder = config.rootpath / "build" / "rig" / str(os.getpid())
        self._child: Child | None = None
        self._modules: dict[str, list[pytest.Item]] = {}
        self._again: dict[str, list[pytest.Item]] = {}
        self._told: list[str] = []

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        if not whole_run(self._config) or not on_host(item):
            return None
        reports.no_time_out()
        if self._child is None:
            self._start(item.session)
        assert self._child is not None
        module = module_of(item)
        ids = [each.nodeid for each in self._modules[module]]
        results = self._child.wait(ids)
        if reports.all_well(ids, results) or not self._child.spoilt(ids):
            reports.replay(item, nextitem, results, f"the rig's process did not report the end of this test; see {self._child.log}")
        else:
            self._again.setdefault(module, []).append(item)
            item.session._setupstate.teardown_exact(nextitem)
        if nextitem is None:
            self._play_again()
        return True

    def pytest_sessionfinish(self) -> None:
        if self._child is not None:
            self._child.end()

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if self._told:
            terminalreporter.section("played again")
            for line in self._told:
                terminalreporter.write_line(line)

    def _start(self, session: pytest.Session) -> None:
        forget_the_dead(self._folder.parent)
        self._folder.mkdir(parents=True)
        for item in session.items:
            if on_host(item):
                self._modules.setdefault(module_of(item), []).append(item)
        self._child = Child(self._config, self._folder, "first", [each.nodeid for module in self._modules.values() for each in module])

    def _play_again(self) -> None:
        assert self._child is not None
        for number, p5_ms in enumerate(AGAIN_P5_MS, start=1):
            spoilt = {module: times for module, items in self._again.items() if (times := self._child.spoilt(ids_of(items)))}
            if not spoilt or len(self._again) > MOST_AGAIN:
                break
            self._told += [f"{module}: {away(times)}; again at P5 {p5_ms} ms" for module, times in spoilt.items()]
            self._child.end()
            ids = [name for module in spoilt for name in ids_of(self._again[module])]
            self._child = Child(self._config, self._folder, f"again{number}", ids, p5_ms)
            results = self._child.wait(ids)
            for module in spoilt:
                if reports.all_well(ids_of(self._again[module]), results) or not self._child.spoilt(ids_of(self._again[module])):
                    self._tell(self._again.pop(module), results)
        for items in self._again.values():
            self._tell(items, self._child.wait(()))

    def _tell(self, items: Sequence[pytest.Item], results: reports.Reports) -> None:
        assert self._child is not None
        for item in items:
            reports.tell(item, results, f"the rig's process did not report the end of this test; see {self._child.log}")


def on_host(item: pytest.Item) -> bool:
    return lanes.lane_of(item.nodeid, item.keywords) != "pure" and not of_the_guest(item)


def module_of(item: pytest.Item) -> str:
    return item.nodeid.partition("::")[0]


def ids_of(items: Sequence[pytest.Item]) -> list[str]:
    return [item.nodeid for item in items]


def away(times: Sequence[tuple[float, float]]) -> str:
    longest = max((to - since for since, to in times), default=0.0)
    return f"not served {len(times)} times, at most {longest * 1000:.0f} ms"
