"""Design 4: restart at once, then after 1, 2, 5 s; six failures in a minute = stay down, alarm."""

import time

from hil_tests.lab.partners.plc2 import ENABLE, REQUEST
from hil_tests.lab.running.cell_running import ALL, CellRun, running_cell

WAITS_S = (0, 1, 2, 5, 5)
REFUSED, NOT_READY = 4, 30
TICK_S = 0.2  # the supervisor looks every 10 ms; the rest is the machine


def test_a_cycle_that_dies_six_times_stays_down_and_everybody_is_informed() -> None:
    with running_cell() as run:
        run.ready()
        for count, wait in enumerate(WAITS_S):
            dead, at = run.kill("cycle")
            run.back("cycle", dead)
            death, start = [entry for entry in run.journal("process") if entry["ns"] > at and "cycle" in entry["text"]][:2]
            assert death["text"] == f"cycle ended with signal SIGKILL; restart in {wait} s", count
            assert start["text"].startswith("cycle started, pid ")
            assert wait <= (start["ns"] - death["ns"]) / 1e9 <= wait + TICK_S, count
        _, at = run.kill("cycle")
        stays_down(run, at)
        told_to_the_plc(run)
        life = run.plc.wait(lambda s: True, 1).life
        run.forgive("cycle")  # whoever found out why
        run.back("cycle", 0)
        assert run.status()["alarms"] == []
        run.plc.wait(lambda s: s.life != life, 3)
        run.ready()


def stays_down(run: CellRun, at: int) -> None:
    time.sleep(0.5)
    assert (run.processes()["cycle"]["state"], run.processes()["cycle"]["pid"]) == ("down", None)
    words = "cycle ended with signal SIGKILL; 6 failures in a minute: it stays down"
    assert [entry["text"] for entry in run.journal("alarm") if entry["ns"] > at] == [words]
    assert run.status()["alarms"] == [words]
    assert not [entry for entry in run.journal("process") if entry["ns"] > at and entry["text"].startswith("cycle started")]


def told_to_the_plc(run: CellRun) -> None:
    """Its status block shows no drive that is on, its life word stands, and commands are refused in words."""
    status = run.plc.wait(lambda s: True, 1)
    assert (status.enabled, status.in_position, status.referenced, status.fault) == (0, 0, 0, ALL)
    time.sleep(0.2)
    assert run.plc.wait(lambda s: True, 1).life == status.life
    for code, mask in ((REQUEST, 0), (ENABLE, ALL)):
        refused = run.plc.command(code, mask)
        assert (refused.state, refused.reason) == (REFUSED, NOT_READY), refused
    said = run.journal("command")[-1]["text"]
    assert said == "command source 2: enable refused: the cell is not ready: the cycle does not run", said
