"""What the deaths of the simulated world do, and of the supervisor.

Emulator: no telegrams, so after two cycles the drives are lost and everything is off; the new one's axes stand at their power-up place.
Broker: no bus for anybody; the drives miss SYNC and stop by themselves; cycle and emulator find the new one.  Both: drives off,
references void (AX-110), nothing moves without fresh commands.  Supervisor: every process of its run ends with it.
"""

import os
import signal
import time

import pytest

from drivers.emulator.servo.record import Flag
from drivers.emulator.servodyn.axis import State
from hil_tests.lab.judges.judge import Judge
from hil_tests.lab.partners.plc2 import ABORTED
from hil_tests.lab.running.cell_running import P5_NS, CellRun, gone, left_over, patience_s, running_cell, runtime_folder, special_files

DRIVE_FAULT, DRIVE_LOST = 16, 17
REST_RAD_S = 0.5


def killed_in_a_move(run: CellRun, process: str) -> int:
    """Stamp of the death; returns when the process is back, the command aborted and half a second over."""
    run.under_way(0.1)
    dead, at = run.kill(process)
    status = run.plc.wait(lambda s: s.toggle == run.plc.toggle and s.state == ABORTED, 3)
    assert status.reason in (DRIVE_FAULT, DRIVE_LOST), status
    run.back(process, dead)
    time.sleep(0.8)
    status = run.plc.wait(lambda s: True, 1)
    assert (status.enabled, status.referenced) == (0, 0), status
    return at


def recover(run: CellRun) -> None:
    """Fresh commands, and all works again."""
    run.ready()
    run.home_again()


def emulator_dies(run: CellRun) -> None:
    killed_in_a_move(run, "emulator-drives")
    judge = Judge(run.demo, run.record())  # of the new one: it begins with its power-up
    assert judge.moved(0, time.monotonic_ns()) <= 2.0
    assert not any(axis.flags & (Flag.ENABLED | Flag.POWER_ON) for row in judge.rows for axis in row.axes)
    recover(run)


def broker_dies(run: CellRun) -> None:
    at = killed_in_a_move(run, "broker-drives")
    now = time.monotonic_ns()
    judge = Judge(run.demo, run.record())
    last = max(row.stamp_ns for row in judge.between(0, at + P5_NS) if not row.axes[0].flags & Flag.NO_SYNC)
    assert max(abs(axis.speed_rad_s) for axis in judge.at(last).axes) > 1.0, "it was not in the middle of a move"
    rows = [row for row in judge.between(last, now) if row.stamp_ns > last]
    stopping = next(row for row in rows if all(axis.state != State.ENABLED for axis in row.axes))
    assert stopping.stamp_ns - last <= 3 * P5_NS, f"{(stopping.stamp_ns - last) / 1e6} ms"
    rest = next(row.stamp_ns for row in rows if all(abs(axis.speed_rad_s) < REST_RAD_S for axis in row.axes))
    assert judge.moved(rest + 200_000_000, now) <= 2.0
    recover(run)


@pytest.mark.timeout(2 * patience_s(15.0))
def test_emulator_and_broker_are_killed_in_a_move() -> None:
    with running_cell() as run:
        run.ready()
        cycle = run.pid("cycle")
        run.repeat(1, lambda count: emulator_dies(run), lambda: recover(run))
        run.repeat(1, lambda count: broker_dies(run), lambda: recover(run))
        assert run.pid("cycle") == cycle, "the cycle survived both"


def test_nothing_survives_a_killed_supervisor_and_the_next_run_of_that_name_starts() -> None:
    with runtime_folder() as folder:
        run = CellRun(folder, "demo", "orphans")
        names = set(run.processes())
        assert len(left_over(folder)) > len(names), "supervisor, its children and the log's writer"
        os.kill(run.pid("emulator-drives"), signal.SIGSTOP)  # not even one that hangs
        run.process.kill()
        run.process.wait()
        gone(folder)
        again = CellRun(folder, "demo", "orphans")
        assert set(again.processes()) == names
        assert again.stop() == 0
        gone(folder)
        assert special_files(folder) == []


def test_a_hung_child_delays_no_orderly_end() -> None:
    with runtime_folder() as folder:
        run = CellRun(folder, "demo", "stopped")
        for process in ("emulator-drives", "line-plc1"):
            os.kill(run.pid(process), signal.SIGSTOP)
        start = time.monotonic()
        assert run.stop(signal.SIGINT) == 0
        assert time.monotonic() - start < 5.0
        gone(folder)
        assert special_files(folder) == []
