"""`make mutants`: each function named by a requirement mark is broken in several ways; its test must fail by an assertion.

python -m hil_tests.matrix.mutants                       all pairs of test and function
python -m hil_tests.matrix.mutants -k EXPRESSION         those of some tests, as pytest's -k
python -m hil_tests.matrix.mutants --sample 60 --seed 7  so many, drawn by lot
python -m hil_tests.matrix.mutants --missing             those whose test or function is new or has changed: a whole run goes on
python -m hil_tests.matrix.mutants --every               all small mutants of each, though one of them was noticed
python -m hil_tests.matrix.mutants --page                docs/proof.md again out of what is recorded

Writes docs/proof.tsv, one line a pair, completes build/coverage-matrix.json and writes docs/proof.md.  A run of a part leaves the
verdicts of the others, as long as their tests and functions read the same (AX-1510).
"""

import argparse
import collections
import os
import pathlib
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence

from gateway.cycle.native.built import PYTHON_ONLY  # what is broken is Python: its twins in C would not notice
from hil_tests.matrix import proof, spelled, verdicts
from hil_tests.matrix.catalogue import ROOT, claim, rows
from hil_tests.matrix.verdicts import Pair
from hil_tests.rig.uml import guest, lane

THIS_RUN = ROOT / "build" / "matrix" / "mutants-run.json"
GUEST_RESULTS = ROOT / "build" / "uml" / "mutants.json"


def main() -> int:
    parser = argparse.ArgumentParser(prog="make mutants")
    parser.add_argument(
        "-k", default="", metavar="EXPRESSION", help="only these tests, as pytest's -k; ids of rows (RHO-SER-01) count as names"
    )
    parser.add_argument("--sample", type=int, metavar="COUNT", help="only so many pairs of test and function, drawn by lot")
    parser.add_argument("--seed", type=int, default=0, help="of the lot (0)")
    parser.add_argument("--missing", action="store_true", help="only pairs without a verdict of this test and function; may be interrupted")
    parser.add_argument("--every", action="store_true", help="try all small mutants of a pair, though one was noticed")
    parser.add_argument("--only", default="hil_tests", metavar="FOLDER", help="only tests of this folder (hil_tests)")
    parser.add_argument("--page", action="store_true", help="run nothing; write docs/proof.md out of what is recorded")
    arguments = parser.parse_args()
    if arguments.sample is not None and arguments.sample < 1:
        parser.error(f"--sample {arguments.sample}: at least 1 pair")
    keep(left_over(verdicts.KEPT.stat().st_mtime_ns if verdicts.KEPT.exists() else 0))
    run: list[Pair] = []
    if not arguments.page:
        lot = ["--mutants-sample", f"{arguments.sample}:{arguments.seed}"] if arguments.sample else []
        known = ["--mutants-known", str(verdicts.KEPT)] if arguments.missing else []
        files = files_of(arguments.only, arguments.missing)
        chosen = [*files, *lot, *known, *(["--mutants-every"] if arguments.every else [])]
        code = judge(arguments.k, chosen) if files else 0
        if code not in (0, 2, 5):  # 2: interrupted; what was judged counts
            return 3
        run = left_over()
        keep(run)
    pairs = verdicts.load_pairs()
    verdicts.save(verdicts.matrix(rows(), verdicts.load_results(), pairs))
    if not arguments.k:
        sample = f"{arguments.sample} pairs drawn by lot with seed {arguments.seed}" if arguments.sample else ""
        proof.write(run if arguments.sample else pairs, sample)
    told = {(pair.test, pair.by): pair for pair in [*pairs, *run]}
    return tell(list(told.values()) if arguments.page or arguments.missing else run)


def left_over(since_ns: int = 0) -> list[Pair]:
    """What the last run has judged and this tree still holds, on this machine and in the guest; that of a run that was killed as well.

    `since_ns`: no results written before; verdicts that came into the tree later count more.
    """
    paths = [path for path in (THIS_RUN, GUEST_RESULTS) if path.exists() and path.stat().st_mtime_ns > since_ns]
    return [pair for path in paths for pair in verdicts.load_run(path) if verdicts.current(pair)]


def keep(run: Iterable[Pair]) -> None:
    """A verdict of this test and function stays when the run could not give one: the machine was busy, say."""
    judged = [pair for pair in run if not pair.unjudged]
    if judged:
        verdicts.keep_pairs({(pair.test, pair.by): pair for pair in [*verdicts.load_pairs(), *judged]}.values())


def files_of(folder: str, missing: bool) -> list[str]:
    """Test files with marks below `folder`, or itself: thousands of tests without one need not be collected.

    `missing`: only those with a pair without a verdict, as far as their marks can be read without running them.
    """
    root = ROOT / folder
    paths = sorted(root.rglob("test_*.py")) if root.is_dir() else [root]
    marked = [path for path in paths if "mark.requirement(" in path.read_text(encoding="utf-8")]
    if missing:
        judged = {(pair.test, pair.by) for pair in verdicts.load_pairs()}
        marked = [path for path in marked if not judged.issuperset(_pairs(path))]
    return [str(path.relative_to(ROOT)) for path in marked]


def _pairs(path: pathlib.Path) -> Iterator[tuple[str, str]]:
    name = path.relative_to(ROOT)
    for mark in spelled.marks_of(path):
        for by in claim(mark.ids, mark.words).by:
            yield f"{name}::{mark.test}", by


def judge(expression: str, chosen: Sequence[str]) -> int:
    """pytest's exit code; what it found is in THIS_RUN and GUEST_RESULTS."""
    for path in (THIS_RUN, GUEST_RESULTS):
        path.unlink(missing_ok=True)
    command = order("requirement and not vcan", expression, THIS_RUN, chosen)
    running = subprocess.Popen(command, cwd=ROOT, env={**os.environ, lane.ON_HOST: "1", PYTHON_ONLY: "1"})
    try:
        code = running.wait()
    except KeyboardInterrupt:
        code = running.wait()  # the terminal interrupts it as well; it writes down what it has judged
    if code == 0 and "--mutants-sample" not in chosen:  # a lot is drawn among the tests of this machine
        add_guest(expression, chosen)
    return code


def order(marks: str, expression: str, target: pathlib.Path, chosen: Sequence[str] = ("hil_tests",)) -> list[str]:
    plug_in = ["-p", "hil_tests.matrix.mutant_plugin", "--mutants", str(target), "-o", "timeout=0", "-p", "no:cacheprovider"]
    return [sys.executable, "-m", "pytest", *chosen, "-q", "-m", marks, "-k", expression, *plug_in]


def add_guest(expression: str, chosen: Sequence[str]) -> None:
    """Marked tests on vcan0 meet their mutants inside the guest."""
    command = order("requirement and vcan", expression, GUEST_RESULTS, chosen)
    collect = [*command, "--collect-only"]
    if guest.missing() or subprocess.run(collect, cwd=ROOT, check=False, capture_output=True).returncode != 0:
        return
    GUEST_RESULTS.unlink(missing_ok=True)
    environment = {
        PYTHON_ONLY: "1",
        "AXISGATE_RUNTIME": "/run/axisgate",
        "AXISGATE_GUEST_REPORTS": str(GUEST_RESULTS.with_suffix(".jsonl")),
    }
    guest.Guest(GUEST_RESULTS.parent / "mutants", 1800, serial_pair=True, environment=environment).run(command)


def tell(pairs: list[Pair]) -> int:
    """0: nine of ten pairs are killed without a crash."""
    for pair in pairs:
        if not pair.killed:
            print(f"{pair.test}\n    by {pair.by}: {pair.verdict}; raise {pair.raised}, return {pair.returned}")
            survivors = [trial for trial in pair.small if trial.verdict != "killed"]
            print(
                "".join(
                    f"        {f'line {trial.line}: {trial.words}' if trial.words else trial.name}: {trial.verdict}\n"
                    for trial in survivors
                ),
                end="",
            )
    count = collections.Counter(pair.verdict.partition(":")[0] for pair in pairs)
    words = ", ".join(f"{number} {word}" for word, number in count.most_common())
    print(f"mutants: {len(pairs)} (test, function) pairs: {words or 'none'}; goal {proof.GOAL:.0%} killed without a crash")
    return 0 if proof.share(pairs) >= proof.GOAL else 1


if __name__ == "__main__":
    sys.exit(main())
