"""AX-591: while a cell runs by the clock the processors of a virtual machine do not sleep, and nobody else loses anything by it."""

import os
import pathlib
import signal
import subprocess
import sys
import time
from collections.abc import Callable

import pytest

from hil_tests.lab.running.awake import awake

VIRTUAL = "vendor_id\t: GenuineIntel\nflags\t\t: fpu tsc hypervisor lahf_lm\n"
OTHERS = {
    "a machine of its own": "vendor_id\t: GenuineIntel\nflags\t\t: fpu tsc lahf_lm\n",
    "a guest of user-mode-linux": "vendor_id\t: User Mode Linux\nflags\t\t: fpu tsc hypervisor\n",
    "no flags": "processor\t: 0\n",
}


@pytest.fixture
def cpuinfo(tmp_path: pathlib.Path) -> pathlib.Path:
    file = tmp_path / "cpuinfo"
    file.write_text(VIRTUAL)
    return file


def settled(pid: int) -> bool:
    """Whether it got as far as its loop: the class comes last."""
    return os.sched_getscheduler(pid) == os.SCHED_IDLE


def until(true: Callable[[], bool]) -> None:
    end = time.monotonic() + 20
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_each_processor_has_somebody_who_wants_it_behind_all_others(cpuinfo: pathlib.Path) -> None:
    processors = os.sched_getaffinity(0)
    with awake(cpuinfo) as keepers:
        until(lambda: all(settled(each.pid) for each in keepers))
        assert sorted(min(os.sched_getaffinity(each.pid)) for each in keepers) == sorted(processors)
        assert all(len(os.sched_getaffinity(each.pid)) == 1 for each in keepers)
        assert all(os.getsid(each.pid) == each.pid for each in keepers), "groups of their own, so that the group's nice value counts"
        groups = [pathlib.Path(f"/proc/{each.pid}/autogroup") for each in keepers]
        assert all(group.read_text().split()[-1] == "19" for group in groups if group.exists())
    assert all(each.poll() is not None for each in keepers), "they end with what they were for"


def test_they_die_with_a_parent_that_could_not_end_them(cpuinfo: pathlib.Path) -> None:
    begin = f"import pathlib, time\nfrom hil_tests.lab.running.awake import awake\nwith awake(pathlib.Path({str(cpuinfo)!r})) as keepers:\n"
    code = begin + "    print(*[each.pid for each in keepers], flush=True)\n    time.sleep(60)"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        pids = [int(each) for each in parent.stdout.readline().split()]
        until(lambda: all(settled(each) for each in pids))
        parent.send_signal(signal.SIGKILL)
        parent.wait()
    assert pids
    until(lambda: not any(pathlib.Path(f"/proc/{each}").exists() for each in pids))


@pytest.mark.parametrize("text", OTHERS.values(), ids=OTHERS)
def test_nothing_is_started_elsewhere(cpuinfo: pathlib.Path, text: str) -> None:
    cpuinfo.write_text(text)
    with awake(cpuinfo) as keepers:
        assert keepers == []


def test_nothing_is_started_where_nobody_says_what_the_machine_is(tmp_path: pathlib.Path) -> None:
    with awake(tmp_path / "none") as keepers:
        assert keepers == []
