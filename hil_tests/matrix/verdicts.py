"""From results and mutants to the coverage matrix: {"ID": {"verdict", "tests", "by", "mutant"}}."""

import json
import pathlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypedDict

from hil_tests.matrix import record
from hil_tests.matrix.catalogue import ROOT, MarkError, Row
from hil_tests.matrix.content import fingerprint
from hil_tests.matrix.reach import kinds, reach_of
from hil_tests.matrix.record import Result

RESULTS = ROOT / "build" / "matrix" / "results.json"
KEPT = ROOT / "docs" / "proof.tsv"  # verdicts of the mutants, in the tree: they outlive a machine (AX-1510)
MATRIX = ROOT / "build" / "coverage-matrix.json"


class Entry(TypedDict):
    """One row's proof; the names are the file's names."""

    verdict: str  # pass, fail, none
    tests: list[str]
    by: list[str]
    mutant: str  # killed, alive, none
    reach: str  # what comes to its functions: cell, program, command, API only


@dataclass(frozen=True, slots=True)
class Trial:
    """A small mutant of a function and how one test took it."""

    name: str  # kind_hash
    verdict: str
    line: int = 0  # 0: not known, as the tree keeps neither line nor words
    words: str = ""  # what was changed into what

    @property
    def kind(self) -> str:
        return self.name.partition("_")[0]


@dataclass(frozen=True, slots=True)
class Pair:
    """A test with one of its functions, and how it took the variants: killed, alive, crash, hang, skipped, not run ..."""

    test: str
    by: str
    ids: tuple[str, ...]
    raised: str
    returned: str
    fingerprint: str  # of the test and the function: an old result never counts for new code
    small: tuple[Trial, ...] = ()

    @property
    def killed(self) -> bool:
        return self.verdict == "killed"

    @property
    def unjudged(self) -> bool:
        """The sound test did not pass, so nothing is known of its mutants."""
        return self.raised.startswith("not run")

    @property
    def verdict(self) -> str:
        """An exception that runs through the test proves nothing: of mutants that do not raise the test must have seen one.

        killed: neither whole body is missed, and of the small changes, where the function has any, an assertion noticed one.
        """
        whole = (self.raised, self.returned)
        for word in whole:
            if word not in ("killed", "crash"):
                return word
        quiet = [trial.verdict for trial in self.small] or list(whole)
        return next((word for word in ("killed", "alive", "crash", "hang") if word in quiet), "crash")

    def as_dict(self) -> dict[str, object]:
        names = {"test": self.test, "by": self.by, "ids": list(self.ids)}
        small = [{"name": one.name, "line": one.line, "words": one.words, "verdict": one.verdict} for one in self.small]
        return {**names, "raise": self.raised, "return": self.returned, "fingerprint": self.fingerprint, "small": small}


def matrix(
    rows: Mapping[str, Row], results: Sequence[Result], pairs: Iterable[Pair], reached: Mapping[str, str] | None = None
) -> dict[str, Entry]:
    """All rows, proved or not; `reached`: what reaches each function; by default from the sources of this tree."""
    known = kinds() if reached is None else reached
    by_pair = {(pair.test, pair.by): pair for pair in pairs}
    return {name: entry([result for result in results if name in result.ids], by_pair, known) for name in rows}


def entry(results: Sequence[Result], pairs: Mapping[tuple[str, str], Pair], reached: Mapping[str, str]) -> Entry:
    outcomes = {result.outcome for result in results}
    verdict = "fail" if "failed" in outcomes else "pass" if "passed" in outcomes else "none"
    found = [pairs.get((result.test, by)) for result in results for by in result.by]
    judged = [pair for pair in found if pair is not None]
    mutant = "alive" if not all(pair.killed for pair in judged) else "killed" if judged and len(judged) == len(found) else "none"
    tests, by = sorted({result.test for result in results}), sorted({by for result in results for by in result.by})
    return {"verdict": verdict, "tests": tests, "by": by, "mutant": mutant, "reach": reach_of(by, reached)}


def load_results() -> Sequence[Result]:
    last = record.load(RESULTS)
    return last.results if last else ()


def load_run(path: pathlib.Path) -> list[Pair]:
    """The pairs of one run, with lines and words."""
    return [_pair(line) for line in json.loads(path.read_text())] if path.exists() else []


def _pair(at: Mapping[str, Any]) -> Pair:
    trials = tuple(Trial(**one) for one in at["small"])
    return Pair(at["test"], at["by"], tuple(at["ids"]), at["raise"], at["return"], at["fingerprint"], trials)


def save_run(pairs: Iterable[Pair], path: pathlib.Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps([pair.as_dict() for pair in pairs], indent=1))


def load_pairs(path: pathlib.Path | None = None) -> list[Pair]:
    """The pairs judged last whose test and function still read the same."""
    lines = (path or KEPT).read_text(encoding="utf-8").splitlines() if (path or KEPT).exists() else []
    return [pair for pair in map(_kept, lines) if current(pair)]


def _kept(line: str) -> Pair:
    test, by, mark, raised, returned, *small = line.split("\t")
    trials = tuple(Trial(name, verdict) for name, _, verdict in (one.partition("=") for one in small))
    return Pair(test, by, (), raised, returned, mark, trials)


def keep_pairs(pairs: Iterable[Pair], path: pathlib.Path | None = None) -> None:
    """One line a pair, in order: two runs of different parts meet in the tree without a conflict.  A pair not judged is left out."""
    (path or KEPT).write_text("".join(sorted(f"{line}\n" for line in _lines(pairs))), encoding="utf-8")


def _lines(pairs: Iterable[Pair]) -> Iterator[str]:
    for pair in pairs:
        if not pair.unjudged:
            small = (f"{trial.name}={trial.verdict}" for trial in pair.small)
            yield "\t".join([pair.test, pair.by, pair.fingerprint, pair.raised, pair.returned, *small])


def current(pair: Pair) -> bool:
    path, _, name = pair.test.partition("::")
    try:
        return (ROOT / path).is_file() and fingerprint(ROOT / path, name, pair.by) == pair.fingerprint
    except MarkError:
        return False  # the function is gone


def save(entries: Mapping[str, Entry]) -> None:
    MATRIX.parent.mkdir(parents=True, exist_ok=True)
    MATRIX.write_text(json.dumps(entries, indent=1) + "\n")
