"""Issue 2, bad input and death; design 4: cycle dead or hung -> no SYNC -> drives quick-stop within their supervision time + 1 cycle."""

import os
import re
import signal
import time
from collections.abc import Iterator

import pytest

from drivers.emulator.servo.record import Flag
from drivers.emulator.servodyn.axis import State
from hil_tests.lab.judges import bus_log as buslog
from hil_tests.lab.judges.judge import Judge
from hil_tests.lab.partners.plc2 import ABORTED
from hil_tests.lab.running.cell_running import P5_NS, CellRun, Disturbed, patience_s, running_cell

REPETITIONS = int(os.environ.get("AXISGATE_LOSSES", "4"))  # with one of CiA 402 drives 5 for each way; 25 in `make soak`: 100 in all
SUPERVISION_NS = 2 * P5_NS  # of the drives (AX-001)
SYNC, FAULT_BIT = 100, 0x08
ACTUALS = frozenset(range(610, 661, 10))
LIFE_LIMIT_NS = max(5 * P5_NS, 50_000_000)
STANDSTILL_RAD_S = 0.5


@pytest.fixture(scope="module")
def cell() -> Iterator[CellRun]:
    with running_cell() as run:
        yield run


@pytest.mark.timeout(patience_s(15.0, REPETITIONS))
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "stopped"])
def test_drives_stop_by_themselves_and_nothing_moves_until_a_fresh_command(cell: CellRun, number: signal.Signals) -> None:
    def recover() -> None:
        cell.forgive("cycle")
        cell.ready()
        cell.home_again()

    def once(count: int) -> None:
        death(cell, number)
        recover()

    assert len(os.listdir(f"/proc/{cell.pid('cycle')}/task")) == 1, "the cycle owns its process"
    cell.forgive("cycle")
    cell.ready()
    cell.repeat(REPETITIONS, once, recover)


def death(run: CellRun, number: signal.Signals) -> None:
    """In the middle of a move; then everything the rules say about the time after it."""
    run.forget()
    start = run.under_way(0.1)
    dead, at = run.kill("cycle", number)
    run.back("cycle", dead)
    buried(run, number, at)
    time.sleep(0.6)  # the old command stands, PLC 2 polls
    status = run.plc.wait(lambda s: s.toggle == run.plc.toggle and s.state == ABORTED, 3)
    assert (status.enabled, status.referenced, status.override) == (0, 0, 0.0), status
    record = run.record()
    judge = Judge(run.demo, record)
    end = time.monotonic_ns()
    last = last_sync(run, dead, at)
    before = judge.at(last)
    assert max(abs(axis.speed_rad_s) for axis in before.axes) > 1.0, "it was not in the middle of a move"
    rows = [row for row in judge.between(start, end) if row.stamp_ns > last]
    for module in range(6):
        stopping = next(row for row in rows if row.axes[module].state != State.ENABLED)
        assert stopping.stamp_ns - last <= SUPERVISION_NS + P5_NS, f"module {module + 1}: {(stopping.stamp_ns - last) / 1e6} ms"
    told = first_faults(run, last)
    assert set(told) == ACTUALS
    late = max(told.values()) - last
    if late > SUPERVISION_NS + P5_NS:
        raise Disturbed(f"the emulator itself was late: its telegrams came after {late / 1e6} ms of bus time")
    rest = next(row.stamp_ns for row in rows if all(abs(axis.speed_rad_s) < STANDSTILL_RAD_S for axis in row.axes))
    assert rest - last < 500_000_000, "a quick stop of a slow move"
    assert judge.moved(rest + 200_000_000, end) <= 2.0
    assert not any(axis.flags & Flag.ENABLED for row in rows if row.stamp_ns > rest for axis in row.axes)


def buried(run: CellRun, number: int, at: int) -> None:
    """The supervisor knew why, and when."""
    entry = next(entry for entry in run.journal("process") if entry["ns"] > at and entry.get("child") == "cycle")
    if number == signal.SIGKILL:
        if "showed no life" in entry["text"]:
            raise Disturbed("the supervisor itself was late: it saw the silence before the death")
        assert entry["text"] == "cycle ended with signal SIGKILL; restart in 0 s"
        return
    match = re.fullmatch(r"cycle showed no life for (\d+) ms and was ended; restart in 0 s", entry["text"])
    assert match, entry["text"]
    assert (int(match[1]) + 1) * 1_000_000 >= LIFE_LIMIT_NS
    if entry["ns"] - at > LIFE_LIMIT_NS + 100_000_000:
        raise Disturbed(f"the supervisor itself was late: {(entry['ns'] - at) / 1e6} ms")


def last_sync(run: CellRun, dead: int, at: int) -> int:
    """Bus stamp of the last SYNC the dead process sent."""
    entries = run.bus()
    senders = {number for number, pid in buslog.senders(e for e in entries if isinstance(e, buslog.Remark)).items() if pid == dead}
    assert senders, f"the log knows no sender of pid {dead}"
    stamps = [e.stamp_ns for e in entries if isinstance(e, buslog.Logged) and e.identifier == SYNC and e.sender in senders]
    assert stamps and stamps[-1] <= at + 2 * P5_NS, "SYNC went on after the death"
    if at - stamps[-1] > 2 * P5_NS:
        raise Disturbed(f"the last SYNC was sent {(at - stamps[-1]) / 1e6} ms before the death")
    return stamps[-1]


def first_faults(run: CellRun, since: int) -> dict[int, int]:
    """Identifier -> bus stamp of the first telegram with the fault bit."""
    found: dict[int, int] = {}
    for entry in run.bus():
        if isinstance(entry, buslog.Logged) and entry.stamp_ns > since and entry.identifier in ACTUALS and entry.data[0] & FAULT_BIT:
            found.setdefault(entry.identifier, entry.stamp_ns)
    return found
