"""pytest plug-in of `make mutants`: runs each marked test with each of its functions broken, in this process.

Killed means: the test failed by an assertion.  An exception of the mutant that merely ran through the test proves only that the
function was called; it is reported as `crash` and counts as not killed.  A pair of test and function that is killed gets no further
mutant, except with --mutants-every.
"""

import contextlib
import dataclasses
import pathlib
import random
import signal
import sys
import threading
import time
from collections.abc import Collection, Generator, Iterator, Mapping
from types import CodeType, FrameType, TracebackType
from typing import TYPE_CHECKING

import pytest
from _pytest.raises import RaisesExc
from _pytest.runner import runtestprotocol

from hil_tests.matrix.catalogue import MarkError, resolve
from hil_tests.matrix.content import fingerprint
from hil_tests.matrix.marks import claims_of, function_id
from hil_tests.matrix.mutant import VARIANTS, MutantError, mutated
from hil_tests.matrix.small import MOST, Small, codes, small_mutants
from hil_tests.matrix.verdicts import Pair, Trial, load_pairs, save_run
from hil_tests.purity import GUARDED_FOLDERS

if TYPE_CHECKING:
    from _typeshed import TraceFunction

LEAST_S = 45.0  # a mutant that never ends is given up after this, or ten times the sound run; tests themselves wait up to 20 s
LEAST_PURE_S = 3.0  # of processor time: tests of pure code wait for nothing, whoever else is busy
TRACED_S = 0.3
MOST_OF_A_RUN = 2  # small mutants of a function whose test starts processes
SAVE_EVERY_S = 60.0
RANK = ("hang", "skipped", "alive", "crash", "killed")  # of a test's parameters the best one counts: they are one test


class Hang(BaseException):
    """The broken test did not end."""


def drawn(every: Collection[tuple[str, str]], sample: str) -> set[tuple[str, str]]:
    """COUNT:SEED of these pairs, the same ones for the same seed."""
    count, seed = map(int, sample.split(":"))
    return set(random.Random(seed).sample(sorted(every), min(count, len(every))))


class Mutants:
    """Replaces the running of a test by: once sound, then once for each function and variant."""

    def __init__(self, target: pathlib.Path, sample: str | None = None, known: pathlib.Path | None = None, every: bool = False) -> None:
        self._target, self._sample, self._known, self._every = target, sample, known, every
        self._raised: list[BaseException] = []
        self._chosen: set[tuple[str, str]] | None = None  # None: all of them
        self._found: dict[tuple[str, str], dict[str, str]] = {}
        self._small: dict[tuple[str, str], tuple[Small, ...]] = {}
        self._ids: dict[tuple[str, str], set[str]] = {}
        self._files: dict[str, pathlib.Path] = {}
        self._saved = time.monotonic()

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """COUNT:SEED, so many pairs by lot; or those without a current verdict.  Tests that have none of them are not run."""
        if self._sample is None and self._known is None:
            return
        pairs = {function_id(item.nodeid): _pairs(item) for item in items}
        every = {pair for some in pairs.values() for pair in some}
        if self._known is not None:
            every -= {(pair.test, pair.by) for pair in load_pairs(self._known)}
        if self._sample is not None:
            every = drawn(every, self._sample)
        self._chosen = every
        left = [item for item in items if not self._chosen.isdisjoint(pairs[function_id(item.nodeid)])]
        config.hook.pytest_deselected(items=[item for item in items if item not in left])
        items[:] = left

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> bool:
        name = function_id(item.nodeid)
        self._files[name] = item.path
        try:
            claims = claims_of(item)
        except MarkError as error:
            print(f"\n{name}: {error}")
            return True
        for claim in claims:
            for by in claim.by:
                self._ids.setdefault((name, by), set()).update(claim.ids)
        open_pairs = dict.fromkeys(by for claim in claims for by in claim.by if self._open(name, by))
        if open_pairs:
            with lines_run({code: by for by in open_pairs for code in codes(resolve(by).__code__)}) as lines:
                sound, seconds = self._run(item, None)
            if sound == "alive" and seconds > TRACED_S:
                sound, seconds = self._run(item, None)  # writing the lines down takes several times as long
            for by in open_pairs:
                self._try(item, by, sound, seconds, lines[by])
        if time.monotonic() - self._saved > SAVE_EVERY_S:
            self._save()
        return True

    def _open(self, name: str, by: str) -> bool:
        """Whether this pair is to be judged and another mutant could change its verdict."""
        if self._chosen is not None and (name, by) not in self._chosen:
            return False
        if self._every or (name, by) not in self._found:
            return True
        pair = self._pair(name, by)
        return not pair.killed or (bool(self._small[name, by]) and not any(one.verdict == "killed" for one in pair.small))

    def _try(self, item: pytest.Item, by: str, sound: str, seconds: float, lines: Collection[int]) -> None:
        name, pure = function_id(item.nodeid), is_pure(item)
        if pure and not lines and (name, by) in self._found:
            return  # this parameter does not come to the function
        known, most = self._small.get((name, by), ()), MOST if pure else MOST_OF_A_RUN
        others = (one for one in small_mutants(by, most, lines) if one.name not in {each.name for each in known})
        chosen = self._small[name, by] = (*known, *others)[:most]  # other parameters run other lines
        limit = max(LEAST_PURE_S if pure else LEAST_S, 10 * seconds)
        for variant in (*VARIANTS, *(one.name for one in chosen)):
            if self._found.get((name, by), {}).get(variant) == "killed" or (variant not in VARIANTS and not self._open(name, by)):
                continue
            verdict = self._broken(item, by, variant, limit) if sound == "alive" else f"not run: sound test: {sound}"
            self._keep(name, by, variant, verdict)

    def _broken(self, item: pytest.Item, by: str, variant: str, limit: float) -> str:
        with mutated(by, variant, children=not is_pure(item)):
            return self._run(item, limit)[0]

    def _keep(self, name: str, by: str, variant: str, verdict: str) -> None:
        seen = self._found.setdefault((name, by), {})
        if verdict not in RANK or variant not in seen or (seen[variant] in RANK and RANK.index(verdict) > RANK.index(seen[variant])):
            seen[variant] = verdict

    def _run(self, item: pytest.Item, limit: float | None) -> tuple[str, float]:
        self._raised.clear()
        item._initrequest()  # type: ignore[attr-defined]  # pytest offers no public way to run an item again
        pure = is_pure(item)
        clock = time.process_time if pure else time.monotonic
        started = clock()
        with time_limit(limit, pure):
            runtestprotocol(item, log=False, nextitem=None)  # nextitem None: no fixture made by a mutant lives on
        return judged(self._raised), clock() - started

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, call: pytest.CallInfo[None]) -> Generator[None, object, object]:
        if call.excinfo is not None:
            self._raised.append(call.excinfo.value)
        return (yield)

    def pytest_sessionfinish(self) -> None:
        self._save()

    def _save(self) -> None:
        self._saved = time.monotonic()
        pairs = (self._pair(name, by) for name, by in self._found)
        save_run((dataclasses.replace(pair, fingerprint=self._of(pair)) for pair in pairs), self._target)

    def _pair(self, name: str, by: str) -> Pair:
        """As it is judged so far."""
        seen = self._found[name, by]
        small = (one for one in self._small[name, by] if one.name in seen)
        trials = tuple(Trial(one.name, seen[one.name], one.line, one.words) for one in small)
        return Pair(name, by, tuple(sorted(self._ids[name, by])), seen["raise"], seen["return"], "", trials)

    def _of(self, pair: Pair) -> str:
        return fingerprint(self._files[pair.test], pair.test.partition("::")[2], pair.by)


def is_pure(item: pytest.Item) -> bool:
    return any(part in item.path.parts for part in GUARDED_FOLDERS)


def _pairs(item: pytest.Item) -> set[tuple[str, str]]:
    try:
        return {(function_id(item.nodeid), by) for claim in claims_of(item) for by in claim.by}
    except MarkError:
        return set()


@contextlib.contextmanager
def lines_run(functions: Mapping[CodeType, str]) -> Iterator[dict[str, set[int]]]:
    """The lines of each function that run meanwhile in this process, by its name."""
    lines: dict[str, set[int]] = {name: set() for name in functions.values()}

    def called(frame: FrameType, _event: str, _argument: object) -> "TraceFunction | None":
        name = functions.get(frame.f_code)
        if name is None:
            return None

        def stepped(inner: FrameType, event: str, _argument: object) -> "TraceFunction":
            if event == "line":
                lines[name].add(inner.f_lineno)
            return stepped

        return stepped

    before = sys.gettrace()
    sys.settrace(called)
    threading.settrace(called)
    try:
        yield lines
    finally:
        sys.settrace(before)
        threading.settrace(before)


def judged(raised: list[BaseException]) -> str:
    """One word for how a run ended."""
    if not raised:
        return "alive"
    if any(isinstance(error, Hang) for error in raised):
        return "hang"
    if any(is_assertion(error) for error in raised):
        return "killed"
    return "skipped" if isinstance(raised[0], pytest.skip.Exception) else "crash"


def is_assertion(error: BaseException) -> bool:
    """Return whether a test failed by a check of its own: assert, pytest.fail, a pytest.raises without its exception."""
    if isinstance(error, BaseExceptionGroup):
        return all(is_assertion(inner) for inner in error.exceptions)
    return isinstance(error, (AssertionError, pytest.fail.Exception))


@contextlib.contextmanager
def time_limit(seconds: float | None, of_processor: bool = False) -> Iterator[None]:
    def strike(_number: int, _frame: FrameType | None) -> None:
        raise Hang(f"no end after {seconds:.0f} s")

    if seconds is None:
        yield
        return
    timer, number = (signal.ITIMER_PROF, signal.SIGPROF) if of_processor else (signal.ITIMER_REAL, signal.SIGALRM)
    previous = signal.signal(number, strike)
    signal.setitimer(timer, seconds, 5.0)
    try:
        yield
    finally:
        signal.setitimer(timer, 0)
        signal.signal(number, previous)


def strict_raises() -> None:
    """pytest.raises(X) that meets a mutant's exception has been answered wrongly: that is the test's own no."""
    original = RaisesExc.__exit__

    def leave(
        self: "RaisesExc[BaseException]", kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        handled = original(self, kind, error, trace)
        if not handled and isinstance(error, MutantError):
            pytest.fail(f"DID NOT RAISE what was asked for, but {error!r}")
        return handled

    RaisesExc.__exit__ = leave  # type: ignore[method-assign]  # pytest has no hook for this; only `make mutants` loads it


def quick_hypothesis() -> None:
    import hypothesis

    phases = (hypothesis.Phase.explicit, hypothesis.Phase.generate)  # a failure is enough, nobody reads the smallest one
    checks = tuple(hypothesis.HealthCheck)
    hypothesis.settings.register_profile(
        "mutants", phases=phases, derandomize=True, database=None, deadline=None, report_multiple_bugs=False, suppress_health_check=checks
    )
    hypothesis.settings.load_profile("mutants")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--mutants", metavar="FILE", help="break each `by` function in turn and write here how the tests took it")
    parser.addoption("--mutants-sample", metavar="COUNT:SEED", help="only so many pairs of test and function, drawn by lot")
    parser.addoption("--mutants-known", metavar="FILE", help="not the pairs whose verdict, of this test and function, stands in it")
    parser.addoption("--mutants-every", action="store_true", help="all small mutants of a pair, though one was noticed")


def pytest_configure(config: pytest.Config) -> None:
    strict_raises()
    quick_hypothesis()
    config.option.tbstyle = "native"  # pytest's own styles fail at an instruction of a mutant that has no line
    target, known = pathlib.Path(config.getoption("--mutants")), config.getoption("--mutants-known")
    every = config.getoption("--mutants-every")
    mutants = Mutants(target, config.getoption("--mutants-sample"), pathlib.Path(known) if known else None, every)
    config.pluginmanager.register(mutants, "axisgate-mutants")
