"""`make coverage-matrix`: id -> tests -> verdict and totals per list out of a real run; writes build/coverage-matrix.json.

The run is the last `make test` if it was one of this tree; otherwise the marked tests run now.

python -m hil_tests.matrix.coverage            as said
python -m hil_tests.matrix.coverage --last     the last run, of whatever tree it was (MATRIX=--last with make)
python -m hil_tests.matrix.coverage --run      the marked tests run now, whatever is recorded
"""

import argparse
import collections
import subprocess
import sys
from collections.abc import Iterator, Mapping

from hil_tests.matrix import record, verdicts
from hil_tests.matrix.catalogue import ROOT, Row, rows
from hil_tests.matrix.reach import KINDS
from hil_tests.matrix.verdicts import Entry


def main() -> int:
    parser = argparse.ArgumentParser(prog="make coverage-matrix")
    ways = parser.add_mutually_exclusive_group()
    ways.add_argument("--last", action="store_true", help="the last run, though the tree has changed since")
    ways.add_argument("--run", action="store_true", help="run the marked tests now")
    arguments = parser.parse_args()
    last = None if arguments.run else record.load(verdicts.RESULTS)
    same = last is not None and last.tree == record.tree()
    if arguments.last and last is None:
        print("coverage-matrix: no run is recorded; make test records one", file=sys.stderr)
        return 3
    code = 0
    if last is not None and (arguments.last or (same and last.whole)):
        origin = (
            f"out of the run that ended {last.at}"
            + ("" if same else ", of another tree than this")
            + ("" if last.whole else ", which was not whole")
        )
    else:
        code, origin = run_now(), "out of a run of the marked tests just now"
    entries = verdicts.matrix(rows(), verdicts.load_results(), verdicts.load_pairs())
    verdicts.save(entries)
    print("\n".join(["", *told(entries, rows()), f"{origin}: {verdicts.MATRIX.relative_to(ROOT)}"]))
    if code not in (0, 1, 5):  # 5: no test carries a mark
        return 3
    return 1 if code == 1 or any(entry["verdict"] == "fail" for entry in entries.values()) else 0


def run_now() -> int:
    """pytest's exit code."""
    verdicts.RESULTS.unlink(missing_ok=True)
    tests = [
        sys.executable,
        "-m",
        "pytest",
        "hil_tests",
        "-m",
        "requirement",
        "-q",
        "-p",
        "no:cacheprovider",
        "--matrix",
        str(verdicts.RESULTS),
    ]
    return subprocess.run(tests, cwd=ROOT, check=False).returncode


def told(entries: Mapping[str, Entry], known: Mapping[str, Row]) -> Iterator[str]:
    for name, entry in entries.items():
        if entry["tests"]:
            yield f"{name:<12} {entry['verdict']:<5} mutant {entry['mutant']:<7} {entry['reach']:<18} {known[name].feature}"
            yield from (f"{'':<13}{test}" for test in entry["tests"])
    for source in dict.fromkeys(row.source for row in known.values()):
        mine = {name: entries[name] for name, row in known.items() if row.source == source}
        killed = sum(entry["mutant"] == "killed" for entry in mine.values())
        yield f"{source}: {counted(mine)}; {killed} with mutants killed"


def counted(entries: Mapping[str, Entry]) -> str:
    """How many of these rows are proved through what a run or a command uses, how many only through the API, how many are open."""
    reach = [entry["reach"].partition(" (")[0] if entry["verdict"] == "pass" else "open" for entry in entries.values()]
    failed = sum(entry["verdict"] == "fail" for entry in entries.values())
    count = collections.Counter(reach)
    used = sum(count[kind] for kind in KINDS[:-1])
    parts = ", ".join(f"{count[kind]} {kind}" for kind in KINDS[:-1])
    fails = f" ({failed} of them fail)" if failed else ""
    return f"{len(entries)} rows: {used} proved ({parts}), {count[KINDS[-1]]} proved API only, {count['open']} open{fails}"


if __name__ == "__main__":
    sys.exit(main())
