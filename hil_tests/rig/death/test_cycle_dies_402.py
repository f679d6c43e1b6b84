"""Issue 4, controller loss with CiA 402 drives: each in quick stop within its supervision time + 1 cycle, by bus stamps."""

import os
import signal
import time
from collections.abc import Iterator

import pytest

from drivers.emulator.cia402.states import State
from hil_tests.lab.judges import bus_log as buslog
from hil_tests.lab.judges.judge import Judge
from hil_tests.lab.running.cell_running import P5_NS, CellRun, Disturbed, patience_s, running_cell
from hil_tests.rig.canopen.test_demo_402 import configured

REPETITIONS = int(os.environ.get("AXISGATE_LOSSES", "1"))  # with the four of the boosters 5 for each way; 25 in `make soak`
HEARTBEAT_ID, HEARTBEAT_NS = 0x77F, 50_000_000
SUPERVISION_NS = 3 * HEARTBEAT_NS  # users.md 3.3: 50 ms x 3
STANDSTILL_RAD_S = 0.5


@pytest.fixture(scope="module")
def cell() -> Iterator[CellRun]:
    with running_cell("demo-402", "loss402") as run:
        configured(run)
        yield run


@pytest.mark.timeout(patience_s(20.0, REPETITIONS))
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "stopped"])
def test_drives_stop_by_themselves_when_the_heartbeat_stays_away(cell: CellRun, number: signal.Signals) -> None:
    def recover() -> None:
        cell.forgive("cycle")
        configured(cell)
        cell.plc.synchronise()
        cell.ready()
        cell.home_again()

    def once(count: int) -> None:
        loss(cell, number)
        recover()

    cell.forgive("cycle")
    cell.ready()
    cell.repeat(REPETITIONS, once, recover)


def loss(run: CellRun, number: signal.Signals) -> None:
    """In the middle of a move; the last heartbeat on the bus is when the drives' time began."""
    run.forget()
    run.under_way(0.1)
    dead, at = run.kill("cycle", number)
    run.back("cycle", dead)
    last = last_heartbeat(run, dead, at)
    rows = list(Judge(run.demo, run.record()).between(at - 2 * P5_NS, time.monotonic_ns()))
    before = [row for row in rows if row.stamp_ns <= at]
    if not before or max(abs(axis.speed_rad_s) for axis in before[-1].axes) < 1.0:
        raise Disturbed("it was not in the middle of a move")
    after = [row for row in rows if row.stamp_ns > at]
    for place in range(6):
        stopping = next(row for row in after if row.axes[place].state != State.ENABLED)
        assert stopping.stamp_ns - last <= SUPERVISION_NS + P5_NS, f"axis {place + 1}: {(stopping.stamp_ns - last) / 1e6} ms"
        assert stopping.axes[place].state in (State.QUICK_STOP, State.REACTION, State.FAULT, State.DISABLED)
    rest = next(row.stamp_ns for row in after if all(abs(axis.speed_rad_s) < STANDSTILL_RAD_S for axis in row.axes))
    assert rest - last < SUPERVISION_NS + 500_000_000, "a quick stop of a slow move"
    assert not any(axis.state == State.ENABLED for row in after if row.stamp_ns > rest for axis in row.axes)


def last_heartbeat(run: CellRun, dead: int, at: int) -> int:
    """Bus stamp of the last heartbeat the dead process sent."""
    entries = run.bus()
    senders = {number for number, pid in buslog.senders(e for e in entries if isinstance(e, buslog.Remark)).items() if pid == dead}
    stamps = [e.stamp_ns for e in entries if isinstance(e, buslog.Logged) and e.identifier == HEARTBEAT_ID and e.sender in senders]
    assert stamps and stamps[-1] <= at + 2 * P5_NS, "the heartbeat went on after the death"
    if at - stamps[-1] > HEARTBEAT_NS + 2 * P5_NS:
        raise Disturbed(f"the last heartbeat was sent {(at - stamps[-1]) / 1e6} ms before the death")
    return stamps[-1]
