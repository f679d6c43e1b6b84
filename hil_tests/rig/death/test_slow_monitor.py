"""Issue 2: a bus monitor that is stopped for 10 s leaves the cycle's counts unchanged; the broker disconnects it and says so."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass

import pytest

from drivers.ports.can.broker import broker_stats
from hil_tests.bench.cycle_judge import judge
from hil_tests.lab.judges import bus_log as buslog
from hil_tests.lab.running.cell_running import REALTIME, CellRun, Disturbed, patience_s, running_cell

P5_MS = 4 if REALTIME else 10
P5_NS = P5_MS * 1_000_000
# At P5 10 ms (no real-time priority) 10 s of frames fit into the queue of 16,384 and the socket's buffer: then it takes longer
STOPPED_S = max(10.0, 25_000 * P5_MS / 13_000)
MONITOR = "import can, sys\nbus = can.Bus(interface='broker', channel=sys.argv[1])\nprint('ready', flush=True)\nwhile True: bus.recv()"


@dataclass(frozen=True)
class Counts:
    """Of one stretch of the run."""

    skipped: int
    incomplete: int
    cycles: int
    on_the_bus: int  # skipped and incomplete by the bus' own log


def counted(run: CellRun, seconds: float) -> Counts:
    before, start = run.state(), time.monotonic_ns()
    time.sleep(seconds)
    end, after = time.monotonic_ns(), run.state()
    time.sleep(0.3)  # the log follows
    lines = (run.folder / "bus-drives.log").read_text().splitlines(keepends=True)
    (verdict,) = judge(lines, P5_NS, start, end)
    assert verdict.lost == 0 and verdict.cycles > 0.9 * seconds * 1e9 / P5_NS
    return Counts(
        after.skipped - before.skipped, after.incomplete - before.incomplete, verdict.cycles, verdict.skipped + verdict.incomplete
    )


@pytest.mark.timeout(patience_s(STOPPED_S + 6.0))
def test_a_stopped_monitor_costs_the_cycle_nothing() -> None:
    with running_cell(plc=False, p5_ms=P5_MS) as run:
        time.sleep(1.0)

        def once(count: int) -> None:
            without, overflows = counted(run, 2.0), broker_stats("death-drives")["overflows"]
            monitor = subprocess.Popen([sys.executable, "-c", MONITOR, "death-drives"], stdout=subprocess.PIPE)
            try:
                assert monitor.stdout is not None and monitor.stdout.readline() == b"ready\n"
                os.kill(monitor.pid, signal.SIGSTOP)
                stopped = counted(run, STOPPED_S)
                assert broker_stats("death-drives")["overflows"] == overflows + 1
            finally:
                monitor.kill()
                monitor.communicate()
            remarks = [entry.text for entry in run.bus() if isinstance(entry, buslog.Remark)]
            assert any("too slow" in text and f"pid {monitor.pid};" in text for text in remarks), remarks
            more = (stopped.skipped, stopped.incomplete, stopped.on_the_bus)
            if more != (0, 0, 0) and max(more) < stopped.cycles // 20:  # a bus that waits for its slowest would lose nearly all
                raise Disturbed(f"with a stopped monitor {stopped}, without one {without}: the machine may have been busy")
            assert more == (0, 0, 0), f"without a monitor {without}, with a stopped one {stopped}"

        run.repeat(1, once, lambda: None)
