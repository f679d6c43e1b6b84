"""A machine that gives the services no processor is no reason to end them; services that hang are ended as before (AX-621)."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator

from hil_tests.lab.running.cell_running import P5_MS, REALTIME, CellRun, running_cell

HOG = """
import contextlib, os, time
os.sched_setaffinity(0, {int(os.environ["CPU"])})
with contextlib.suppress(OSError):
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
end = time.monotonic() + 10
while time.monotonic() < end:
    until = time.monotonic() + 0.7
    while time.monotonic() < until:
        pass
    time.sleep(0.02)
"""
LIMIT_MS, STARVED_S = 250, 2.5
HOGS = 1 if REALTIME else 12  # in the ordinary class they only take turns


@contextlib.contextmanager
def starved(pid: int) -> Iterator[None]:
    """All threads of that process get what others leave of one processor, and others leave next to nothing."""
    cpu = max(os.sched_getaffinity(0))
    threads = [int(thread) for thread in os.listdir(f"/proc/{pid}/task")]
    hogs = [subprocess.Popen([sys.executable, "-c", HOG], env=os.environ | {"CPU": str(cpu)}) for _ in range(HOGS)]
    try:
        for thread in threads:
            os.sched_setaffinity(thread, {cpu})
            os.sched_setscheduler(thread, os.SCHED_IDLE, os.sched_param(0))
        yield
    finally:
        for hog in hogs:
            hog.kill()
            hog.wait()


def life_age_ms(run: CellRun) -> float:
    return float(run.processes()["services"]["life_age_ms"])


def test_services_without_a_processor_are_not_ended_and_hung_ones_are() -> None:
    with running_cell(name="busy", plc=False, p5_ms=max(P5_MS, 20)) as run:
        pid, oldest = run.pid("services"), 0.0
        with starved(pid):
            until = time.monotonic() + STARVED_S
            while time.monotonic() < until:
                oldest = max(oldest, life_age_ms(run))
                time.sleep(0.02)
        assert oldest > LIMIT_MS, f"the machine was not busy enough to prove anything: {oldest} ms"
        assert run.pid("services") == pid, run.words()
        assert run.processes()["services"]["busy"] >= 1
        assert any("services gets no processor time: the machine is busy" in str(entry["text"]) for entry in run.journal("process"))
        time.sleep(0.5)
        os.kill(pid, signal.SIGSTOP)
        run.back("services", pid)
        assert any("services showed no life for" in str(entry["text"]) for entry in run.journal("process"))
