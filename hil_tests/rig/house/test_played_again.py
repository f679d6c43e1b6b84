"""Modules that a busy machine disturbed run again: complete runs of a small module next to a real hog (the rest: test_small_runs.py)."""

import pathlib
import subprocess

import pytest

from gateway.runtime.realtime import realtime_allowed
from hil_tests.rig.house.test_small_runs import whole_run
from hil_tests.rig.uml import guest
from hil_tests.test_folders import NO_OWN_TIME

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
    if os.environ.get("AXISGATE_GUEST_TIME") == "own":
        begin = time.monotonic()
        subprocess.run([sys.executable, "-c", ""], check=True)
        assert time.monotonic() - begin >= 0.5, "computing takes no time there, starting a program does"
        return  # nobody is late there
    begin = str(time.monotonic() + 1.5)  # all of them at once, however long each takes to start
    hogs = [subprocess.Popen([sys.executable, "-c", HOG, str(cpu), begin]) for cpu in os.sched_getaffinity(0)]
    assert [hog.wait() for hog in hogs] == [0] * len(hogs)
    time.sleep(0.1)
    assert os.environ.get("AXISGATE_TEST_P5") == "16", "the first play is spoilt"
def test_beside_it(): pass
"""


@pytest.mark.skipif(not realtime_allowed(), reason="a hog needs real-time priority")
@pytest.mark.parametrize("in_guest", [True, False])
def test_a_spoilt_module_is_played_again_whole(tmp_path: pathlib.Path, in_guest: bool) -> None:
    if in_guest and not guest.own_time():
        pytest.skip("without a guest with a clock of its own all of them run again at a slower clock")
    module = "rig/test_a_hog.py" if in_guest else f"hil_tests/rig/{NO_OWN_TIME[0]}"
    (tmp_path / module).parent.mkdir(parents=True)
    (tmp_path / module).write_text(HOGGED)
    (tmp_path / module).with_name("test_right.py").write_text("def test_right(): pass\n")
    command, environment = whole_run(tmp_path, module.partition("/")[0])
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, "3 passed" in done.stdout) == (0, True), done.stdout
    assert f"{module}: not served" in done.stdout
    assert ("again in a guest with a clock of its own" if in_guest else "again at P5 16 ms") in done.stdout
