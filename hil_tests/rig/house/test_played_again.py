"""What a busy machine spoilt is played again, and nothing else is: a whole run of three small modules, one of them beside a real hog."""

import os
import pathlib
import subprocess
import sys

import pytest

from hil_tests.demo import realtime_allowed
from hil_tests.host import P5

HOGGED = """
import os, pathlib, subprocess, sys, time
HOG = '''
import os, sys, time
os.sched_setaffinity(0, [int(sys.argv[1])])
os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(95))
begin = float(sys.argv[2])
while time.monotonic() < begin: time.sleep(0.001)
while time.monotonic() < begin + 0.06: pass
'''
def test_that_minds_the_hog():
    begin = str(time.monotonic() + 1.5)  # all of them at once, however long each takes to start
    hogs = [subprocess.Popen([sys.executable, "-c", HOG, str(cpu), begin]) for cpu in os.sched_getaffinity(0)]
    assert [hog.wait() for hog in hogs] == [0] * len(hogs)
    time.sleep(0.1)
    assert os.environ.get("AXISGATE_TEST_P5") == "16", "the first play is spoilt"
def test_beside_it(): pass
"""
WRONG = "import time\ndef test_wrong(): assert 1 == 2\n"


@pytest.mark.skipif(not realtime_allowed(), reason="a hog needs real-time priority")
def test_a_spoilt_module_is_played_again_whole_and_a_wrong_one_is_not(tmp_path: pathlib.Path) -> None:
    (tmp_path / "rig").mkdir()
    (tmp_path / "rig" / "test_a_hog.py").write_text(HOGGED)
    (tmp_path / "rig" / "test_right.py").write_text("def test_right(): pass\n")
    (tmp_path / "conftest.py").write_text("from hil_tests.conftest import pytest_addoption, pytest_configure\n")
    (tmp_path / "pytest.ini").write_text("[pytest]\ntestpaths = rig\nmarkers =\n    requirement\n    vcan\n    mbpoll\n    cref\n")
    command = [sys.executable, "-m", "pytest", "-v", "--color=no", "-p", "no:cacheprovider"]
    root = pathlib.Path(__file__).resolve().parents[3]
    environment = {**{name: value for name, value in os.environ.items() if name != P5}, "PYTHONPATH": str(root)}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, "3 passed" in done.stdout) == (0, True), done.stdout
    assert "rig/test_a_hog.py: not served" in done.stdout and "again at P5 16 ms" in done.stdout
    (tmp_path / "rig" / "test_a_hog.py").unlink()
    (tmp_path / "rig" / "test_wrong.py").write_text(WRONG)
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert "1 failed, 1 passed" in done.stdout and "assert 1 == 2" in done.stdout
