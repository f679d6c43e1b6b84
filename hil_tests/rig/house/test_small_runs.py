"""Complete runs of small modules: which process runs what, at the same time as which, and what runs again without a disturbance."""

import os
import pathlib
import re
import subprocess
import sys

import pytest

from hil_tests.host import P5
from hil_tests.rig.uml import guest
from hil_tests.test_folders import ALONE

BESIDE = """
import pathlib
def times(name):
    with open(name, "a") as file: file.write("x")
    return pathlib.Path(name).stat().st_size
def test_that_fails_the_first_time(): assert times("first") >= 2
def test_that_always_fails(): assert times('always') == 0
def test_that_is_well(): pass
"""
ZEALOUS = BESIDE.replace("def test_that_always_fails(): assert times('always') == 0\n", "").replace('"first"', '"zeal"')
AT_LAST = "import pathlib\ndef test_alone(): assert pathlib.Path('first').stat().st_size >= 2\n"
NO_WORKER = "import os, pathlib, time\nassert 'AXISGATE_TEST_WORKER' not in os.environ, 'a test run started here would be a worker, too'\n"
BY_US = """
def test_worker():
    until = time.monotonic() + 60
    while not pathlib.Path('worker').exists():
        assert time.monotonic() < until
        time.sleep(0.05)
"""
STANDS_BEHIND = f"""
def test_that_stands_behind_the_cells():
    assert os.nice(0) >= min({os.nice(0)} + 5, 19) and os.getsid(0) != {os.getsid(0)}
"""
BY_WORKER = "def test_worker(): pathlib.Path('worker').touch()\n"
MEETS = """
import pathlib, time
def test_meets_the_other():
    pathlib.Path({mine!r}).touch()
    until = time.monotonic() + 60
    while not pathlib.Path({other!r}).exists():
        assert time.monotonic() < until
        time.sleep(0.05)
"""
WRONG = "import time\ndef test_wrong(): assert 1 == 2\n"


def test_a_wrong_one_is_not(tmp_path: pathlib.Path) -> None:
    (tmp_path / "rig").mkdir()
    (tmp_path / "rig" / "test_right.py").write_text("def test_right(): pass\n")
    (tmp_path / "rig" / "test_wrong.py").write_text(WRONG)
    command, environment = whole_run(tmp_path, "rig")
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert "1 failed, 1 passed" in done.stdout and "assert 1 == 2" in done.stdout


@pytest.mark.skipif(not guest.own_time() or os.cpu_count() == 1, reason="needs a guest with a clock of its own")
def test_what_is_shared_by_two_processes_and_what_failed_there_is_judged_alone(tmp_path: pathlib.Path) -> None:
    """Two modules wait for each other: one process would never end them.  So do two that are named nowhere, and the pure tests' two."""
    texts = {"bus_tools/test_beside.py": BESIDE, ALONE[0]: AT_LAST}
    texts |= {"completion/test_us.py": NO_WORKER + BY_US + STANDS_BEHIND, "motion/test_worker.py": NO_WORKER + BY_WORKER}
    for folder in ("bus_tools", "named_nowhere"):
        for mine, other in ((f"{folder}-one", f"{folder}-two"), (f"{folder}-two", f"{folder}-one")):
            texts[f"{folder}/test_{mine}.py"] = MEETS.format(mine=mine, other=other)
    texts["named_nowhere/test_zealous.py"] = ZEALOUS
    for name, text in texts.items():
        (file := tmp_path / "hil_tests/rig" / name).parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    command, environment = whole_run(tmp_path, "hil_tests")
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert "1 failed, 12 passed" in done.stdout and "test_that_always_fails" in done.stdout, done.stdout
    assert done.stdout.count("hil_tests/rig/bus_tools/test_beside.py: failed next to other tests; again alone") == 1, done.stdout
    assert done.stdout.count("hil_tests/rig/named_nowhere/test_zealous.py: failed next to the pure tests; again two at a time") == 1, (
        done.stdout
    )
    assert not re.search(r"(one|two)\.py: failed", done.stdout), done.stdout
    assert len((tmp_path / "always").read_text()) >= 2, (
        "with the pure tests, then without them; more often where the machine was busy then, too"
    )


def test_a_selection_is_shared_by_two_processes_and_closes_with_one_line(tmp_path: pathlib.Path) -> None:
    """As `make check` does it: a failure of either process fails the run, and its closing line has the sums."""
    for name, text in {
        "a": NO_WORKER + BY_US + WRONG,
        "m": "def test_between(): pass\n",
        "z": "import pathlib\n" + BY_WORKER + WRONG,
    }.items():
        (file := tmp_path / f"hil_tests/unit/test_{name}.py").parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    command, environment = whole_run(tmp_path, "elsewhere")
    command += ["--pair", "--durations=10", "hil_tests/unit"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    lines = [line for line in done.stdout.splitlines() if re.search(r"(passed|failed|error).* in [0-9.]+s", line)]
    assert done.returncode == 1 and len(lines) == 1 and lines == done.stdout.splitlines()[-1:], done.stdout
    assert "2 failed, 3 passed" in lines[0]
    assert "slowest 10 durations" in done.stdout


def whole_run(folder: pathlib.Path, tests: str) -> tuple[list[str], dict[str, str]]:
    """A project of its own with axisgate's way to run its tests: command and environment."""
    (folder / "conftest.py").write_text("from hil_tests.conftest import pytest_addoption, pytest_configure\n")
    (folder / "pytest.ini").write_text(f"[pytest]\ntestpaths = {tests}\nmarkers =\n    requirement\n    vcan\n    mbpoll\n    cref\n")
    root = pathlib.Path(__file__).resolve().parents[3]
    environment = {**{name: value for name, value in os.environ.items() if name != P5}, "PYTHONPATH": str(root)}
    return [sys.executable, "-m", "pytest", "-v", "--color=no", "-p", "no:cacheprovider"], environment
