"""The Pythons the README promises that this machine has, Debian's own among them: pure parts, and a run recorded and played again."""

import os
import subprocess
import sys

import pytest

from hil_tests.lab.running.pythons import ROOT, Other, others

pytestmark = [pytest.mark.pythons, pytest.mark.slow]
PURE = ("unit/gateway/recording", "unit/gateway/pure/routes", "unit/gateway/tools/new_cell", "requirements/p3964r", "requirements/rk512")
RUN = "hil_tests/rig/recording/test_record_and_replay.py"
PURE_S = 240.0
RUN_S = 200.0


def played(other: Other, *tests: str, seconds: float) -> str:
    """What it says of these tests; an assertion where one of them fails."""
    command = [other.python, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--color=no", *tests]
    done = subprocess.run(command, cwd=ROOT, env=other.surroundings, capture_output=True, text=True, timeout=seconds, check=False)
    assert done.returncode == 0, f"Python {other.version}: {done.stdout[-6000:]}{done.stderr[-2000:]}"
    return done.stdout


def test_debians_python_is_found_where_it_is_not_the_running_one() -> None:
    debians = "/usr/bin/python3"
    if not os.access(debians, os.X_OK):
        pytest.skip("this machine has no /usr/bin/python3")
    version = subprocess.run([debians, "-c", "import sys; print(sys.version)"], capture_output=True, text=True, check=True).stdout.strip()
    mine = subprocess.run([sys.executable, "-c", "import sys; print(sys.version)"], capture_output=True, text=True, check=True).stdout
    assert version == mine.strip() or version.split()[0] in [each.version for each in others()]


@pytest.mark.parametrize("other", others(), ids=lambda each: each.version)
def test_pure_parts_hold_on_it(other: Other) -> None:
    assert "passed" in played(other, *(f"hil_tests/{part}" for part in PURE), seconds=PURE_S)


@pytest.mark.parametrize("other", others(), ids=lambda each: each.version)
def test_a_run_is_recorded_and_played_again_on_it(other: Other) -> None:
    assert "passed" in played(other, RUN, seconds=RUN_S)
