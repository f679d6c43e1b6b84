"""Issue 2: SIGKILL of services: motion ends as configured, services back in 3 s, links by themselves; a command is taken once (AX-141)."""

import os
import pathlib
import re
import signal
import time

import pytest

from drivers.emulator.servodyn.axis import State
from hil_tests.lab.judges import bus_log as buslog
from hil_tests.lab.judges.judge import Judge, Move, SetPath
from hil_tests.lab.partners.plc2 import PTP, REQUEST
from hil_tests.lab.running.cell_running import ALL, HOME, TARGET, CellRun, Disturbed, patience_s, running_cell

REPETITIONS = 5
BACK_S = 3.0
RESYNCHRONISED = 20
SETTLED_NS = 300_000_000
SPEED = 0.06  # 1.3 s, of which the cycle needs 0.25 s to notice
DEMO = pathlib.Path(__file__).parents[3] / "configs" / "cells" / "demo.toml"


def cell_that(folder: pathlib.Path, ending: str) -> str:
    """The demo's cell with another on_services_loss."""
    text, changed = re.subn(r'on_services_loss = "\w+"', f'on_services_loss = "{ending}"', DEMO.read_text())
    assert changed == 1
    path = folder / "cell.toml"
    path.write_text(text)
    return str(path)


@pytest.mark.timeout(patience_s(12.0, REPETITIONS))
@pytest.mark.parametrize("ending", ["stop_on_path", "finish_move"])
def test_motion_ends_as_configured_and_services_come_back_without_moving_anything(tmp_path: pathlib.Path, ending: str) -> None:
    with running_cell(cell_that(tmp_path, ending)) as run:

        def once(count: int) -> None:
            death(run, finishes=ending == "finish_move")

        def recover() -> None:
            run.forgive("services")
            run.ready()
            run.home_again()

        run.ready()
        run.repeat(REPETITIONS, once, recover)


def death(run: CellRun, *, finishes: bool) -> None:
    """In the middle of a move; the cycle lives on, so drives stay on and references stand."""
    start = run.under_way(SPEED)
    connects, cycle = run.plc.reconnects, run.pid("cycle")
    dead, at = run.kill("services")
    back = run.back("services", dead)
    status = run.plc.wait(lambda s: s.reason == RESYNCHRONISED, 3)  # the old command stands, it is only adopted
    assert run.plc.reconnects == connects + 1, "the Modbus link came back by itself, once"
    assert (back - at) / 1e9 <= BACK_S
    assert status.owner == 0, "nobody has control after a start"
    time.sleep(1.2 if finishes else 0.8)  # in which nothing may begin
    now = time.monotonic_ns()
    judge = Judge(run.demo, run.record())
    if run.pid("cycle") != cycle or any(axis.state != State.ENABLED for row in judge.between(start, now) for axis in row.axes):
        raise Disturbed("the drives did not stay on")
    assert max(abs(axis.speed_rad_s) for axis in judge.at(at).axes) > 1.0, "it was not in the middle of a move"
    rest = judge.rest_after(at, now)
    assert rest is not None and 0.0 < rest < 2.0, rest
    missed = judge.missed_by(Move(start, now, HOME, TARGET))
    if finishes:
        assert missed <= 2.0, f"the move was to be finished; {missed} increments are missing"
    else:
        assert missed > 1000.0 and rest < 1.0, "the move was to be stopped on its path, long before its target"
    assert judge.moved(at + round(rest * 1e9) + SETTLED_NS, now) <= 2.0
    run.forgive("services")
    run.command(REQUEST)
    run.command(PTP, ALL, 0.3, TARGET)  # sent afresh, it is taken
    run.arrived(TARGET)
    path = SetPath(run.demo, [e for e in run.bus() if isinstance(e, buslog.Logged) and e.stamp_ns > start])
    assert path.off_line(Move(start, time.monotonic_ns(), HOME, TARGET)) <= 1.0, "increments beside the path"
    run.home_again()


def test_a_spare_is_ready_takes_over_and_is_replaced() -> None:
    """AX-561; a spare that dies itself is replaced, too."""
    with running_cell() as run:
        first = run.spare("services")
        os.kill(first, signal.SIGKILL)
        second = run.spare("services", not_these={first})
        dead, _ = run.kill("services")
        run.back("services", dead)
        assert run.pid("services") == second
        assert run.spare("services", not_these={first, second}) not in (dead, second)


def test_a_hung_services_process_is_ended_and_replaced(tmp_path: pathlib.Path) -> None:
    with running_cell() as run:
        dead, at = run.kill("services", signal.SIGSTOP)
        back = run.back("services", dead)
        assert (back - at) / 1e9 <= BACK_S
        text = next(entry["text"] for entry in run.journal("process") if entry["ns"] > at and entry.get("child") == "services")
        match = re.fullmatch(r"services showed no life for (\d+) ms and was ended; restart in 0 s", text)
        assert match and int(match[1]) >= 250, text
        run.plc.wait(lambda s: s.enabled == 0, 3)
