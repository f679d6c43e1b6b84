"""Six failures in a minute: every process but the cycle is tried again slowly; `axisgate status|stop|release` (AX-621)."""

import json
import os
import signal
import subprocess
import sys
import time

from hil_tests.lab.running.cell_running import P5_MS, CellRun, running_cell

ALARM = "line-plc1 ended with signal SIGKILL; 6 failures in a minute: it is started again every 10 s"


def axisgate(*arguments: str) -> tuple[int, str, str]:
    command = [sys.executable, "-m", "gateway", *arguments]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, check=False)
    return done.returncode, done.stdout.strip(), done.stderr.strip()


def killed_six_times(run: CellRun, name: str) -> None:
    for _ in range(5):
        dead, _ = run.kill(name)
        run.back(name, dead)
    run.kill(name)
    time.sleep(0.3)


def test_a_process_that_died_six_times_comes_back_slowly_or_at_once_when_it_is_released() -> None:
    with running_cell(name="slow", plc=False, p5_ms=max(P5_MS, 20)) as run:
        assert axisgate("status")[0] == 0
        killed_six_times(run, "line-plc1")
        at = time.monotonic()
        found = run.processes()["line-plc1"]
        assert (found["state"], found["pid"]) == ("waiting", None)
        code, out, _ = axisgate("status", "slow")
        assert code == 1 and f"  alarm: {ALARM}; next: axisgate release slow" in out.splitlines(), out
        run.back("line-plc1", 0, 15.0)
        assert 8.0 < time.monotonic() - at < 13.0, "tried again by itself, and not at once"
        assert run.status()["alarms"] == [ALARM], "it stands until the process has lived for a minute or is released"
        run.kill("line-plc1")
        time.sleep(0.2)
        assert [entry["text"] for entry in run.journal("alarm") if "failures in" in entry["text"]] == [ALARM], "reported once"
        assert axisgate("release", "slow", "nobody")[0] == 2
        assert axisgate("release") == (0, "run 'slow': line-plc1 released", "")
        run.back("line-plc1", 0, 3.0)
        assert run.status()["alarms"] == [] and json.loads(axisgate("status", "--json")[1])["alarms"] == []
        assert axisgate("release") == (0, "run 'slow': every process is up, nothing to release", "")
        assert axisgate("stop", "other")[0] == 3
        assert axisgate("stop") == (0, "run 'slow' has ended", "")
        assert run.process.wait(5) == 0
        code, _, err = axisgate("status")
        assert code == 3 and err == "axisgate status: no run is active; start one with: axisgate run CELL --sim"


def test_a_process_that_cannot_be_ended_at_once_does_not_hold_up_the_watch() -> None:
    with running_cell(name="ends", plc=False, p5_ms=max(P5_MS, 20)) as run:
        dead = run.pid("services")
        os.kill(dead, signal.SIGSTOP)
        run.back("services", dead)
        assert run.processes()["services"]["restarts"] == 1
