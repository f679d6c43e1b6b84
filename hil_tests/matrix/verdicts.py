"""From results and mutants to the coverage matrix: {"ID": {"verdict", "tests", "by", "mutant"}}."""

import hashlib
import importlib.util
import json
import pathlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypedDict

from hil_tests.matrix import record
from hil_tests.matrix.catalogue import ROOT, Row
from hil_tests.matrix.record import Result

RESULTS = ROOT / "build" / "matrix" / "results.json"
MUTANTS = ROOT / "build" / "matrix" / "mutants.json"
MATRIX = ROOT / "build" / "coverage-matrix.json"


class Entry(TypedDict):
    """One row's proof; the names are the file's names."""

    verdict: str  # pass, fail, none
    tests: list[str]
    by: list[str]
    mutant: str  # killed, alive, none


@dataclass(frozen=True, slots=True)
class Pair:
    """A test with one of its functions, and how it took the two variants: killed, alive, crash, hang, skipped, not run ..."""

    test: str
    by: str
    ids: tuple[str, ...]
    raised: str
    returned: str
    fingerprint: str  # of the test file and the function's module: an old result never counts for new code

    @property
    def killed(self) -> bool:
        return (self.raised, self.returned) == ("killed", "killed")

    def as_dict(self) -> dict[str, object]:
        names = {"test": self.test, "by": self.by, "ids": list(self.ids)}
        return {**names, "raise": self.raised, "return": self.returned, "fingerprint": self.fingerprint}


def fingerprint(test_file: pathlib.Path, by: str) -> str:
    spec = importlib.util.find_spec(by.partition(":")[0])
    module = pathlib.Path(spec.origin) if spec and spec.origin else None
    return hashlib.sha256(test_file.read_bytes() + (module.read_bytes() if module else b"")).hexdigest()[:16]


def matrix(rows: Mapping[str, Row], results: Sequence[Result], pairs: Iterable[Pair]) -> dict[str, Entry]:
    """All rows, proved or not."""
    by_pair = {(pair.test, pair.by): pair for pair in pairs}
    return {name: entry([result for result in results if name in result.ids], by_pair) for name in rows}


def entry(results: Sequence[Result], pairs: Mapping[tuple[str, str], Pair]) -> Entry:
    outcomes = {result.outcome for result in results}
    verdict = "fail" if "failed" in outcomes else "pass" if "passed" in outcomes else "none"
    found = [pairs.get((result.test, by)) for result in results for by in result.by]
    judged = [pair for pair in found if pair is not None]
    mutant = "alive" if not all(pair.killed for pair in judged) else "killed" if judged and len(judged) == len(found) else "none"
    tests, by = sorted({result.test for result in results}), sorted({by for result in results for by in result.by})
    return {"verdict": verdict, "tests": tests, "by": by, "mutant": mutant}


def load_results() -> Sequence[Result]:
    last = record.load(RESULTS)
    return last.results if last else ()


def load_pairs() -> list[Pair]:
    """The pairs of the last `make mutants` whose test file and module are still the same."""
    lines = json.loads(MUTANTS.read_text()) if MUTANTS.exists() else []
    pairs = [Pair(at["test"], at["by"], tuple(at["ids"]), at["raise"], at["return"], at["fingerprint"]) for at in lines]
    return [pair for pair in pairs if current(pair)]


def current(pair: Pair) -> bool:
    file = ROOT / pair.test.partition("::")[0]
    return file.exists() and fingerprint(file, pair.by) == pair.fingerprint


def save(entries: Mapping[str, Entry]) -> None:
    MATRIX.parent.mkdir(parents=True, exist_ok=True)
    MATRIX.write_text(json.dumps(entries, indent=1) + "\n")
