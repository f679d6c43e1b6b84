"""`make mutants`: each function named by a requirement mark is broken in two ways; its test must fail by an assertion.

python -m hil_tests.matrix.mutants [-k EXPRESSION]     (writes build/matrix/mutants.json, completes build/coverage-matrix.json)
"""

import argparse
import json
import os
import subprocess
import sys

from gateway.native.built import PYTHON_ONLY  # what is broken is Python: its twins in C would not notice
from hil_tests.matrix import verdicts
from hil_tests.matrix.catalogue import ROOT, rows
from hil_tests.matrix.verdicts import Pair
from hil_tests.rig.uml import guest, lane

GUEST_RESULTS = ROOT / "build" / "uml" / "mutants.json"


def main() -> int:
    parser = argparse.ArgumentParser(prog="make mutants")
    parser.add_argument(
        "-k", default="", metavar="EXPRESSION", help="only these tests, as pytest's -k; ids of rows (RHO-SER-01) count as names"
    )
    arguments = parser.parse_args()
    verdicts.MUTANTS.unlink(missing_ok=True)
    command = order("requirement and not vcan", arguments.k, str(verdicts.MUTANTS))
    code = subprocess.run(command, cwd=ROOT, check=False, env={**os.environ, lane.ON_HOST: "1", PYTHON_ONLY: "1"}).returncode
    if code not in (0, 5):
        return 3
    add_guest(arguments.k)
    pairs = verdicts.load_pairs()
    verdicts.save(verdicts.matrix(rows(), verdicts.load_results(), pairs))
    return tell(pairs)


def order(marks: str, expression: str, target: str) -> list[str]:
    plug_in = ["-p", "hil_tests.matrix.mutant_plugin", "--mutants", target, "-o", "timeout=0", "-p", "no:cacheprovider"]
    return [sys.executable, "-m", "pytest", "hil_tests", "-q", "-m", marks, "-k", expression, *plug_in]


def add_guest(expression: str) -> None:
    """Marked tests on vcan0 meet their mutants inside the guest."""
    collect = [*order("requirement and vcan", expression, str(GUEST_RESULTS)), "--collect-only"]
    if guest.missing() or subprocess.run(collect, cwd=ROOT, check=False, capture_output=True).returncode != 0:
        return
    GUEST_RESULTS.unlink(missing_ok=True)
    environment = {
        PYTHON_ONLY: "1",
        "AXISGATE_RUNTIME": "/run/axisgate",
        "AXISGATE_GUEST_REPORTS": str(GUEST_RESULTS.with_suffix(".jsonl")),
    }
    command = order("requirement and vcan", expression, str(GUEST_RESULTS))
    guest.Guest(GUEST_RESULTS.parent / "mutants", 1800, serial_pair=True, environment=environment).run(command)
    both = [*json.loads(verdicts.MUTANTS.read_text()), *json.loads(GUEST_RESULTS.read_text())]
    verdicts.MUTANTS.write_text(json.dumps(both, indent=1))


def tell(pairs: list[Pair]) -> int:
    alive = [pair for pair in pairs if not pair.killed]
    for pair in alive:
        print(f"{pair.test}\n    by {pair.by}: raise {pair.raised}, return {pair.returned}")
    print(f"mutants: {len(pairs)} (test, function) pairs, {len(pairs) - len(alive)} killed, {len(alive)} not killed")
    return 1 if alive else 0


if __name__ == "__main__":
    sys.exit(main())
