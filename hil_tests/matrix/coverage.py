"""`make coverage-matrix`: runs the marked tests, prints id -> tests -> verdict and totals per list, writes build/coverage-matrix.json."""

import collections
import subprocess
import sys
from collections.abc import Iterator, Mapping

from hil_tests.matrix import verdicts
from hil_tests.matrix.catalogue import ROOT, Row, rows
from hil_tests.matrix.verdicts import Entry


def main() -> int:
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
    code = subprocess.run(tests, cwd=ROOT, check=False).returncode
    entries = verdicts.matrix(rows(), verdicts.load_results(), verdicts.load_pairs())
    verdicts.save(entries)
    print()
    print("\n".join(told(entries, rows())))
    if code not in (0, 1, 5):  # 5: no test carries a mark
        return 3
    return 1 if code == 1 or any(entry["verdict"] == "fail" for entry in entries.values()) else 0


def told(entries: Mapping[str, Entry], known: Mapping[str, Row]) -> Iterator[str]:
    for name, entry in entries.items():
        if entry["tests"]:
            yield f"{name:<12} {entry['verdict']:<5} mutant {entry['mutant']:<7} {known[name].feature}"
            yield from (f"{'':<13}{test}" for test in entry["tests"])
    for source in dict.fromkeys(row.source for row in known.values()):
        mine = [entries[name] for name, row in known.items() if row.source == source]
        verdict = collections.Counter(entry["verdict"] for entry in mine)
        killed = sum(entry["mutant"] == "killed" for entry in mine)
        counts = ", ".join(f"{verdict[kind]} {kind}" for kind in ("pass", "fail", "none"))
        yield f"{source}: {len(mine)} rows, {counts}; {killed} with mutants killed"


if __name__ == "__main__":
    sys.exit(main())
