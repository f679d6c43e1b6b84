"""Run the tests of the rig in processes of their own in a complete run; repeat modules that a busy machine disturbed.

Where guests have a clock of their own, two such processes share all modules but those of ALONE (hil_tests/test_folders.py) and run
them at the same time as the pure tests and the guests: they wait more than they compute, and have the higher priority
(hil_tests/pair.py).  Then two processes share what failed.  Last come the modules of ALONE, one at a time, with whatever failed next to
another module.  A failure next to other tests gives no verdict: the module counts as not run.

A shared machine takes the processor away for tens of milliseconds, and a cell that runs on it then stops, as it must.  Witnesses
(hil_tests/lab/judges/stolen.py) record this: one of the highest priority for each processor records 10 ms and more without the
processor, one of ordinary priority 40 ms and more.  A module with a test that failed during such a time runs again at the end, complete,
in a guest with a clock of its own, where nothing is late.  What cannot run there (NO_OWN_TIME), and everything where there is no such
guest, runs on the host in a fresh process and at a slower clock (AGAIN_P5_MS): every rule under test counts in P5.  A failure without
such a time, and one that stays, is a failure.  The modules that ran again are listed above the lines of the lanes.
"""

import contextlib
import os
import pathlib
import subprocess
import sys
import time
from collections.abc import Sequence

import pytest

from hil_tests import lanes, reports
from hil_tests.lab.judges.stolen import everywhere, left_alone, stolen, witness
from hil_tests.lab.running.awake import awake
from hil_tests.pair import environment_of_tests, forget_the_dead, whole_run
from hil_tests.rig.uml import guest
from hil_tests.rig.uml.lane import Guests, folder_of, of_the_guest
from hil_tests.test_folders import ALONE, LONG, NO_OWN_TIME, of_one, unhurried

REPORTS = "AXISGATE_TEST_RIG"  # set in that process: file for its reports
CLAIMS = "AXISGATE_TEST_CLAIMS"  # set in those that share modules: folder of claims (hil_tests/pair.py)
P5 = "AXISGATE_TEST_P5"  # ms; hil_tests/lab/running/cell_running.py
AGAIN_P5_MS = (16, 32, 32, 32)  # of the repetitions
MOST_AGAIN = 35  # modules, of about forty; if more failed, the machine is not the cause
BESIDE_NAME, TOGETHER_NAME, ALONE_NAME = "beside", "together", "first"  # names of the runs, in this order
SHARERS = 2  # processes of the first two runs; each takes the next free module
WHY_AGAIN = {TOGETHER_NAME: "failed next to the pure tests; again two at a time", ALONE_NAME: "failed next to other tests; again alone"}
POLL_S = 0.2
ENDS_S = 60.0


class Child:
    """A process that runs these tests; its reports are read while it runs."""

    def __init__(
        self,
        config: pytest.Config,
        folder: pathlib.Path,
        name: str,
        ids: Sequence[str],
        p5_ms: int | None = None,
        claims: pathlib.Path | None = None,
        quiet: bool = True,
    ) -> None:
        file, self.log = folder / f"{name}.jsonl", folder / f"{name}.log"
        self._reports = reports.Incoming(config, file)
        self._stolen = {**everywhere(folder / f"{name}.stolen"), folder / f"{name}.not-served": "--ordinary"}
        listed = folder / f"{name}.txt"
        listed.write_text("\n".join(ids))
        self._watch = contextlib.ExitStack()
        if quiet:  # while the pure tests run, no processor is idle
            self._watch.enter_context(awake())
        for seen, option in self._stolen.items():
            self._watch.enter_context(witness(seen, option))
        slower = {} if p5_ms is None else {P5: str(p5_ms)}
        sharing = {} if claims is None else {CLAIMS: str(claims)}
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "--color=no", f"@{listed}"]
        with self.log.open("wb") as log:
            environment = environment_of_tests(**{REPORTS: str(file)}, **slower, **sharing)
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, env=environment)

    def wait(self, ids: Sequence[str]) -> reports.Reports:
        """Wait until these tests or the process have ended; return all reports."""
        while True:
            alive, results = self.look()
            if not alive or reports.ended(ids, results):
                return results
            time.sleep(POLL_S)

    def look(self) -> tuple[bool, reports.Reports]:
        """Return whether the process runs, and its reports so far."""
        alive = self._process.poll() is None
        return alive, self._reports.take()

    def leave(self) -> None:
        """Let the process finish: all its tests have ended."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(ENDS_S)
        self.end()

    def end(self) -> None:
        if self._process.poll() is None:
            self._process.terminate()
        self._process.wait()
        self._watch.close()

    def spoilt(self, ids: Sequence[str]) -> list[tuple[float, float]]:
        """Return the times at which no process got the processor while these tests ran (s, wall clock)."""
        results = self._reports.take()
        found = [report for name in ids for report in results.get(name, ())]
        times = [each for file in self._stolen if file.exists() for each in stolen(file)]
        since, to = min((r.start for r in found), default=0.0), max((r.stop for r in found), default=time.time())
        return [each for each in times if not left_alone(since, to, [each])]


class Together:
    """Several processes that share modules: each takes the next free one."""

    def __init__(self, config: pytest.Config, folder: pathlib.Path, name: str, modules: Sequence[Sequence[str]]) -> None:
        claims = folder / f"{name}-claims"
        claims.mkdir()
        self._children = []
        turn = [each for ids in modules for each in ids]
        for number in range(SHARERS):
            quiet = name != BESIDE_NAME and number == 0
            self._children.append(Child(config, folder, f"{name}-{number + 1}", turn, claims=claims, quiet=quiet))
        self.log = folder

    def wait(self, ids: Sequence[str]) -> reports.Reports:
        while True:
            looks = [child.look() for child in self._children]
            results = {name: of_test for _, found in looks for name, of_test in found.items()}
            if reports.ended(ids, results) or not any(alive for alive, _ in looks):
                return results
            time.sleep(POLL_S)

    def spoilt(self, ids: Sequence[str]) -> list[tuple[float, float]]:
        return []

    def leave(self) -> None:
        for child in self._children:
            child.leave()

    def end(self) -> None:
        for child in self._children:
            child.end()


class InGuests:
    """The last run of modules, in guests with a clock of their own, which a busy machine cannot disturb."""

    def __init__(self, config: pytest.Config, modules: Sequence[Sequence[str]]) -> None:
        self.log = folder_of(config) / "again"
        self._guests = Guests(config, self.log, modules, starts=True)

    def wait(self, ids: Sequence[str]) -> reports.Reports:
        return self._guests.results()

    def spoilt(self, ids: Sequence[str]) -> list[tuple[float, float]]:
        return []

    def leave(self) -> None:
        self._guests.results()

    def end(self) -> None:
        self._guests.end()


class Host:
    """Start these processes in a complete run only; a selection runs in this process."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._folder = config.rootpath / "build" / "rig" / str(os.getpid())
        self._children: dict[str, Child | Together | InGuests] = {}  # in the order of their starts; only the last one can still run
        self._modules: dict[str, list[pytest.Item]] = {}
        self._waiting: dict[str, list[pytest.Item]] = {}  # modules whose verdict is not reported yet
        self._by: dict[str, Child | Together | InGuests] = {}  # where the module ran last
        self._again: list[str] = []  # lines of the summary

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        if not whole_run(self._config):
            return
        for item in session.items:
            if on_host(item):
                self._modules.setdefault(module_of(item), []).append(item)
        modules = [module for module, items in self._modules.items() if not of_one(items[0], ALONE)]
        if modules and guest.own_time() and (os.cpu_count() or 1) > 1 and not session.testsfailed:
            self._share(BESIDE_NAME, modules)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        module = module_of(item)
        if module not in self._modules or not on_host(item):
            return None
        reports.no_time_out()
        while module not in self._by:
            self._next()
        ids = ids_of(self._modules[module])
        child = self._by[module]
        results = child.wait(ids)
        settled = reports.all_passed(ids, results) or (not self._shared(child) and not child.spoilt(ids))
        if settled:
            reports.replay(item, nextitem, results, f"the rig's process did not report the end of this test; see {child.log}")
        else:
            self._waiting.setdefault(module, []).append(item)
            item.session._setupstate.teardown_exact(nextitem)
        if nextitem is None:
            self._repeat()
        return True

    def pytest_sessionfinish(self) -> None:
        for child in self._children.values():
            child.end()

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if self._again:
            terminalreporter.section("run again")
            for line in self._again:
                terminalreporter.write_line(line)

    def _next(self) -> None:
        """Start the next run of the modules without a verdict: two at a time, then alone."""
        self._all_left()
        modules = [each for each in self._modules if each not in self._by or self._unsettled(each)]
        together = [each for each in modules if not of_one(self._modules[each][0], ALONE)]
        shared = TOGETHER_NAME not in self._children and len(together) > 1 and (os.cpu_count() or 1) > 1
        name, modules = (TOGETHER_NAME, together) if shared else (ALONE_NAME, modules)
        self._again += [f"{module}: {WHY_AGAIN[name]}" for module in modules if module in self._waiting]
        if shared:
            self._share(name, modules)
        else:
            self._launch(name, modules)

    def _share(self, name: str, modules: Sequence[str]) -> None:
        """Start with the long ones, so that no process waits for the last one."""
        self._begin()
        modules = sorted(modules, key=lambda each: not of_one(self._modules[each][0], LONG))
        self._children[name] = played = Together(self._config, self._folder, name, [ids_of(self._modules[each]) for each in modules])
        self._by.update(dict.fromkeys(modules, played))

    def _start(self, name: str, modules: Sequence[str], p5_ms: int) -> None:
        """Start a process that runs these modules when the previous one has ended."""
        self._all_left()
        self._launch(name, modules, p5_ms)

    def _all_left(self) -> None:
        """Wait until every run has reported its last result."""
        for child in self._children.values():
            child.wait([each for module, by in self._by.items() if by is child for each in ids_of(self._modules[module])])
            child.leave()

    def _launch(self, name: str, modules: Sequence[str], p5_ms: int | None = None) -> None:
        self._begin()
        ids = [each for module in modules for each in ids_of(self._modules[module])]
        self._children[name] = child = Child(self._config, self._folder, name, ids, p5_ms)
        self._by.update(dict.fromkeys(modules, child))

    def _unsettled(self, module: str) -> bool:
        """Return whether it failed while other tests ran, which gives no verdict."""
        ids = ids_of(self._modules[module])
        return module in self._waiting and self._shared(self._by[module]) and not reports.all_passed(ids, self._by[module].wait(ids))

    def _begin(self) -> None:
        if not self._children:
            forget_the_dead(self._folder.parent)
            self._folder.mkdir(parents=True)

    def _shared(self, child: Child | Together | InGuests) -> bool:
        return isinstance(child, Together)

    def _repeat(self) -> None:
        while any(self._unsettled(module) for module in list(self._waiting)):
            self._next()
        self._report_settled()
        self._again_in_guests()
        for number, p5_ms in enumerate(AGAIN_P5_MS, start=1):
            spoilt = self._spoilt()
            if not spoilt or len(self._waiting) > MOST_AGAIN:
                break
            self._again += [f"{module}: {away(times)}; again at P5 {p5_ms} ms" for module, times in spoilt.items()]
            self._start(f"again{number}", list(spoilt), p5_ms)
            self._report_settled()
        for module in list(self._waiting):
            self._report(module)

    def _again_in_guests(self) -> None:
        if not guest.own_time() or lanes.missing("vcan") is not None:
            return
        spoilt = {module: times for module, times in self._spoilt().items() if not of_one(self._modules[module][0], NO_OWN_TIME)}
        if spoilt:
            self._again += [f"{module}: {away(times)}; again in a guest with a clock of its own" for module, times in spoilt.items()]
            for child in self._children.values():
                child.leave()
            self._children["guests"] = played = InGuests(self._config, [ids_of(self._modules[module]) for module in spoilt])
            self._by.update(dict.fromkeys(spoilt, played))
            self._report_settled()

    def _spoilt(self) -> dict[str, list[tuple[float, float]]]:
        """Return the times at which no process was served while a module without a verdict ran, by module."""
        return {module: times for module, items in self._waiting.items() if (times := self._by[module].spoilt(ids_of(items)))}

    def _report_settled(self) -> None:
        """Report the modules that passed, or failed without a disturbance."""
        for module, items in list(self._waiting.items()):
            ids = ids_of(items)
            if reports.all_passed(ids, self._by[module].wait(ids)) or not self._by[module].spoilt(ids):
                self._report(module)

    def _report(self, module: str) -> None:
        child = self._by[module]
        for item in self._waiting.pop(module):
            reports.pass_on(item, child.wait(()), f"the rig's process did not report the end of this test; see {child.log}")


def on_host(item: pytest.Item) -> bool:
    return not unhurried(item) and not of_the_guest(item)


def module_of(item: pytest.Item) -> str:
    return item.nodeid.partition("::")[0]


def ids_of(items: Sequence[pytest.Item]) -> list[str]:
    return [item.nodeid for item in items]


def away(times: Sequence[tuple[float, float]]) -> str:
    longest = max((to - since for since, to in times), default=0.0)
    return f"not served {len(times)} times, at most {longest * 1000:.0f} ms"
