"""A broker, a page, a northbound process or an adapter that hangs is found by its life counter and started again (AX-626)."""

import os
import pathlib
import signal
import time

import pytest

from gateway.assembly.run import Instead, plan_run
from gateway.cell_file.load import load_cell
from gateway.runtime.life import VARIABLE, Life
from hil_tests.lab.running.cell_running import P5_MS, free_port, running_cell
from hil_tests.lab.running.joined_running import cell_copy

MORE = '\n[northbound.metrics]\nbind = "127.0.0.1:{port}"\n'


def test_hung_page_northbound_and_broker_are_started_again(tmp_path: pathlib.Path) -> None:
    cell = cell_copy("host-telegrams", tmp_path, more=MORE.format(port=free_port()))
    with running_cell(str(cell), name="loops", plc=False, p5_ms=max(P5_MS, 20), more=("--web", str(free_port()))) as run:
        names = ("web", "northbound", next(name for name in run.processes() if name.startswith("broker-")))
        until = time.monotonic() + 30
        while any((run.processes()[name]["life_age_ms"] or 1e9) > 1000 for name in names):
            assert time.monotonic() < until, run.processes()
            time.sleep(0.1)
        dead = {name: run.pid(name) for name in names}
        for pid in dead.values():
            os.kill(pid, signal.SIGSTOP)
        for name, pid in dead.items():
            run.back(name, pid, 25.0)
            assert any(str(entry["text"]).startswith(f"{name} showed no life for") for entry in run.journal("process"))


def test_every_process_that_runs_on_the_machine_has_a_life_counter_and_its_own(tmp_path: pathlib.Path) -> None:
    cell = load_cell(str(cell_copy("host-telegrams", tmp_path, more=MORE.format(port=9999))))
    plan = plan_run(cell, simulated=False, slug="metal", instead=Instead("slcan:/dev/ttyACM0", web_port=8480))
    lives = {child.name: child.life for child in plan.children}
    assert all(lives.values()), lives
    assert len(set(lives.values())) == len(lives)
    assert {"web", "northbound"} < set(lives) and any(name.startswith("adapter-") for name in lives)


def test_a_process_started_by_hand_has_nobody_to_show_life_to(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    Life().beat()
    with (tmp_path / "other").open("w+") as file:
        monkeypatch.setenv(VARIABLE, str(file.fileno()))
        Life().beat()
        assert VARIABLE not in os.environ and (tmp_path / "other").stat().st_size == 0
