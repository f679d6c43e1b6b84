"""The rig's tests of a whole run, in a process of their own, one module after the other; tests that a busy machine disturbed run again.

All modules but those of ALONE (hil_tests/test_folders.py) are played beside the pure tests and the guests, where those have a clock of
their own, by two processes like that: they wait more than they compute, and pure tests and guests stand behind them (hil_tests/pair.py).
When all these have ended, two processes share what failed there.  ALONE is played last, one module at a time, with whatever failed beside
another module.  A failure beside something else is no verdict: the module counts as not played.

A shared machine takes the processor away for tens of milliseconds, and a cell that runs on it then stops, as it must.  Witnesses
(hil_tests/lab/judges/stolen.py) write it down: one of the highest priority a processor for 10 ms and more in which nobody ran there, an
ordinary one for 40 ms and more in which such a process was not served.  A module of which a test failed while they saw that is played
again at the end, whole, in a guest with a clock of its own, where nothing is late.  What cannot be played there (NO_OWN_TIME), or
everything where there is no such guest, is played on the host in a fresh process and at a slower clock (AGAIN_P5_MS): every rule under
test counts in P5.  A failure without such a time, and one that stays, is a failure.  What ran again is listed above the lanes' lines.
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
from hil_tests.pair import forget_the_dead, surroundings, whole_run
from hil_tests.rig.uml import guest
from hil_tests.rig.uml.lane import Guests, folder_of, of_the_guest
from hil_tests.test_folders import ALONE, LONG, NO_OWN_TIME, of_one, unhurried

REPORTS = "AXISGATE_TEST_RIG"  # set in that process: file for its reports
CLAIMS = "AXISGATE_TEST_CLAIMS"  # set in those that share modules: folder of claims (hil_tests/pair.py)
P5 = "AXISGATE_TEST_P5"  # ms; hil_tests/lab/running/cell_running.py
AGAIN_P5_MS = (16, 32, 32, 32)  # of the repetitions
MOST_AGAIN = 35  # modules, of some forty; more than these is no matter of the machine
BESIDE_NAME, TOGETHER_NAME, ALONE_NAME = "beside", "together", "first"  # of the plays, in this order
SHARERS = 2  # processes of the first two: they share the modules as they come to them
WHY_AGAIN = {TOGETHER_NAME: "failed beside the pure tests; again by two at a time", ALONE_NAME: "failed beside others; again alone"}
POLL_S = 0.2
ENDS_S = 60.0


class Child:
    """One process that runs these tests; its reports are read as they come."""

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
        self._told = reports.Coming(config, file)
        self._stolen = {**everywhere(folder / f"{name}.stolen"), folder / f"{name}.not-served": "--ordinary"}
        listed = folder / f"{name}.txt"
        listed.write_text("\n".join(ids))
        self._watch = contextlib.ExitStack()
        if quiet:  # beside the pure tests no processor sleeps anyhow
            self._watch.enter_context(awake())
        for seen, option in self._stolen.items():
            self._watch.enter_context(witness(seen, option))
        slower = {} if p5_ms is None else {P5: str(p5_ms)}
        sharing = {} if claims is None else {CLAIMS: str(claims)}
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "--color=no", f"@{listed}"]
        with self.log.open("wb") as log:
            environment = surroundings(**{REPORTS: str(file)}, **slower, **sharing)
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, env=environment)

    def wait(self, ids: Sequence[str]) -> reports.Reports:
        """Waits until these tests or the process have ended."""
        while True:
            alive, results = self.look()
            if not alive or reports.ended(ids, results):
                return results
            time.sleep(POLL_S)

    def look(self) -> tuple[bool, reports.Reports]:
        """Whether the process lives, and what it has reported until now."""
        alive = self._process.poll() is None
        return alive, self._told.take()

    def leave(self) -> None:
        """All its tests have ended: it may finish."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(ENDS_S)
        self.end()

    def end(self) -> None:
        if self._process.poll() is None:
            self._process.terminate()
        self._process.wait()
        self._watch.close()

    def spoilt(self, ids: Sequence[str]) -> list[tuple[float, float]]:
        """Times at which no process got the processor while these tests ran (s, wall clock)."""
        results = self._told.take()
        found = [report for name in ids for report in results.get(name, ())]
        times = [each for file in self._stolen if file.exists() for each in stolen(file)]
        since, to = min((r.start for r in found), default=0.0), max((r.stop for r in found), default=time.time())
        return [each for each in times if not left_alone(since, to, [each])]


class Together:
    """Several such processes that share modules: each takes the next free one."""

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
            results = {name: told for _, found in looks for name, told in found.items()}
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
    """Modules run by guests with a clock of their own, which a busy machine cannot disturb: this is their last run."""

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
    """Registers the hosts in a whole run only; a selection runs in this process."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._folder = config.rootpath / "build" / "rig" / str(os.getpid())
        self._children: dict[str, Child | Together | InGuests] = {}  # in the order of their starts; at most the last one runs
        self._modules: dict[str, list[pytest.Item]] = {}
        self._waiting: dict[str, list[pytest.Item]] = {}  # modules whose verdict is not reported yet
        self._by: dict[str, Child | Together | InGuests] = {}  # who played the module last
        self._told: list[str] = []

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
        settled = reports.all_well(ids, results) or (not self._beside(child) and not child.spoilt(ids))
        if settled:
            reports.replay(item, nextitem, results, f"the rig's process did not report the end of this test; see {child.log}")
        else:
            self._waiting.setdefault(module, []).append(item)
            item.session._setupstate.teardown_exact(nextitem)
        if nextitem is None:
            self._play_again()
        return True

    def pytest_sessionfinish(self) -> None:
        for child in self._children.values():
            child.end()

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if self._told:
            terminalreporter.section("played again")
            for line in self._told:
                terminalreporter.write_line(line)

    def _next(self) -> None:
        """Starts the next run of what has no verdict yet: two at a time, then alone."""
        self._all_left()
        modules = [each for each in self._modules if each not in self._by or self._unsettled(each)]
        together = [each for each in modules if not of_one(self._modules[each][0], ALONE)]
        shared = TOGETHER_NAME not in self._children and len(together) > 1 and (os.cpu_count() or 1) > 1
        name, modules = (TOGETHER_NAME, together) if shared else (ALONE_NAME, modules)
        self._told += [f"{module}: {WHY_AGAIN[name]}" for module in modules if module in self._waiting]
        if shared:
            self._share(name, modules)
        else:
            self._launch(name, modules)

    def _share(self, name: str, modules: Sequence[str]) -> None:
        """The long ones first, so that no process waits for the last one."""
        self._begin()
        modules = sorted(modules, key=lambda each: not of_one(self._modules[each][0], LONG))
        self._children[name] = played = Together(self._config, self._folder, name, [ids_of(self._modules[each]) for each in modules])
        self._by.update(dict.fromkeys(modules, played))

    def _start(self, name: str, modules: Sequence[str], p5_ms: int) -> None:
        """Starts a process that runs these modules, when the one before has ended."""
        self._all_left()
        self._launch(name, modules, p5_ms)

    def _all_left(self) -> None:
        """Every run has reported its last result."""
        for child in self._children.values():
            child.wait([each for module, by in self._by.items() if by is child for each in ids_of(self._modules[module])])
            child.leave()

    def _launch(self, name: str, modules: Sequence[str], p5_ms: int | None = None) -> None:
        self._begin()
        ids = [each for module in modules for each in ids_of(self._modules[module])]
        self._children[name] = child = Child(self._config, self._folder, name, ids, p5_ms)
        self._by.update(dict.fromkeys(modules, child))

    def _unsettled(self, module: str) -> bool:
        """Whether it failed while other tests ran, which is no verdict."""
        ids = ids_of(self._modules[module])
        return module in self._waiting and self._beside(self._by[module]) and not reports.all_well(ids, self._by[module].wait(ids))

    def _begin(self) -> None:
        if not self._children:
            forget_the_dead(self._folder.parent)
            self._folder.mkdir(parents=True)

    def _beside(self, child: Child | Together | InGuests) -> bool:
        return isinstance(child, Together)

    def _play_again(self) -> None:
        while any(self._unsettled(module) for module in list(self._waiting)):
            self._next()
        self._tell_settled()
        self._again_in_guests()
        for number, p5_ms in enumerate(AGAIN_P5_MS, start=1):
            spoilt = self._spoilt()
            if not spoilt or len(self._waiting) > MOST_AGAIN:
                break
            self._told += [f"{module}: {away(times)}; again at P5 {p5_ms} ms" for module, times in spoilt.items()]
            self._start(f"again{number}", list(spoilt), p5_ms)
            self._tell_settled()
        for module in list(self._waiting):
            self._tell(module)

    def _again_in_guests(self) -> None:
        if not guest.own_time() or lanes.missing("vcan") is not None:
            return
        spoilt = {module: times for module, times in self._spoilt().items() if not of_one(self._modules[module][0], NO_OWN_TIME)}
        if spoilt:
            self._told += [f"{module}: {away(times)}; again in a guest with a clock of its own" for module, times in spoilt.items()]
            for child in self._children.values():
                child.leave()
            self._children["guests"] = played = InGuests(self._config, [ids_of(self._modules[module]) for module in spoilt])
            self._by.update(dict.fromkeys(spoilt, played))
            self._tell_settled()

    def _spoilt(self) -> dict[str, list[tuple[float, float]]]:
        """Times of modules whose verdict is open, because no process was served while they ran."""
        return {module: times for module, items in self._waiting.items() if (times := self._by[module].spoilt(ids_of(items)))}

    def _tell_settled(self) -> None:
        """Modules that passed, or failed without a disturbance."""
        for module, items in list(self._waiting.items()):
            ids = ids_of(items)
            if reports.all_well(ids, self._by[module].wait(ids)) or not self._by[module].spoilt(ids):
                self._tell(module)

    def _tell(self, module: str) -> None:
        child = self._by[module]
        for item in self._waiting.pop(module):
            reports.tell(item, child.wait(()), f"the rig's process did not report the end of this test; see {child.log}")


def on_host(item: pytest.Item) -> bool:
    return not unhurried(item) and not of_the_guest(item)


def module_of(item: pytest.Item) -> str:
    return item.nodeid.partition("::")[0]


def ids_of(items: Sequence[pytest.Item]) -> list[str]:
    return [item.nodeid for item in items]


def away(times: Sequence[tuple[float, float]]) -> str:
    longest = max((to - since for since, to in times), default=0.0)
    return f"not served {len(times)} times, at most {longest * 1000:.0f} ms"
