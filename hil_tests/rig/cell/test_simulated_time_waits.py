"""AX-681: without real-time priority a simulated cell plays on a machine that takes it away; one with a page's port taken never starts."""

import contextlib
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from typing import Any

import pytest

from gateway.runtime.realtime import realtime_allowed
from gateway.runtime.supervisor_client import ask, wait_up
from hil_tests.lab.partners.hand_plc import Hand
from hil_tests.lab.running.cell_running import free_port, runtime_folder

PLAIN = ("setpriv", "--bounding-set=-sys_nice", "--inh-caps=-sys_nice")  # what a user has who is not root
WITHOUT = PLAIN if realtime_allowed() else ()
TAKEN_S, LEFT_S = 0.4, 0.6  # forty periods: much more than the drives forgive
pytestmark = pytest.mark.skipif(bool(WITHOUT) and shutil.which("setpriv") is None, reason="setpriv (util-linux) takes the priority away")


@contextlib.contextmanager
def plain_run(name: str, port: int, cell: str = "demo", without: Sequence[str] = WITHOUT) -> Iterator["subprocess.Popen[str]"]:
    """`axisgate run CELL --sim` of a user without real-time priority."""
    command = [
        *without,
        sys.executable,
        "-m",
        "gateway",
        "run",
        cell,
        "--sim",
        "--name",
        name,
        "--modbus-port",
        str(port),
        "--die-with-parent",
    ]
    run = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True)
    try:
        yield run
    finally:
        if run.poll() is None:
            run.send_signal(signal.SIGTERM)
        run.communicate(timeout=20)


def status_of(run: str) -> dict[str, Any]:
    with ask(run, "status") as connection:
        found: dict[str, Any] = json.loads(connection.makefile().readline())
    return found


def journal(run: str) -> list[str]:
    lines = pathlib.Path(status_of(run)["journal"]).read_text().splitlines()
    return [json.loads(line)["text"] for line in lines]


def pids(run: str) -> dict[str, int]:
    status = status_of(run)
    return {each["name"]: each["pid"] for each in status["processes"]}


class Thief(threading.Thread):
    """Takes the processor away from one process after the other, as a busy machine does."""

    def __init__(self, victims: list[int]) -> None:
        super().__init__(daemon=True)
        self._victims, self.taken, self.done = victims, 0, threading.Event()

    def run(self) -> None:
        while not self.done.wait(LEFT_S):
            victim = self._victims[self.taken % len(self._victims)]
            self.taken += 1
            os.kill(victim, signal.SIGSTOP)
            time.sleep(TAKEN_S)
            os.kill(victim, signal.SIGCONT)


def test_moves_end_where_they_should_while_the_machine_is_taken_away() -> None:
    port = free_port()
    with runtime_folder(), plain_run("waits", port):
        assert wait_up("waits", 60.0)
        hand = Hand("waits", port)
        found = pids("waits")
        thief = Thief([found["emulator-drives"], found["cycle"], found["broker-drives"]])
        try:
            assert hand.begin() == "drives on, referenced"
            thief.start()
            for target in (1200, 300, 900):
                said = hand.obey(str(target))
                assert said.startswith("done"), said
                assert abs(hand.one.status.word(2) - target) <= 3
            assert thief.taken >= 3
        finally:
            thief.done.set()
            if thief.is_alive():
                thief.join()
            hand.end()


@pytest.mark.parametrize("without", [WITHOUT, ()], ids=["ordinary", "as it is here"])
def test_modules_the_machine_keeps_back_are_not_silent_and_the_journal_says_who_was_late(without: Sequence[str]) -> None:
    """Inputs of a rho 3 are waited for as drives are, with and without real-time priority; one that is really away is error 381."""
    with runtime_folder(), plain_run("modules", free_port(), "rho3-servodyn", without):
        assert wait_up("modules", 60.0)
        found = pids("modules")
        (module,) = [pid for name, pid in found.items() if name.startswith("modules-")]
        thief = Thief([module, found["cycle"]])
        try:
            thief.start()
            until = time.monotonic() + 60
            while thief.taken < 6 or not any("simulated time waited" in text for text in journal("modules")):
                assert time.monotonic() < until, journal("modules")
                time.sleep(0.1)
        finally:
            thief.done.set()
            thief.join()
        assert [text for text in journal("modules") if "no transm." in text] == []
        os.kill(module, signal.SIGSTOP)
        try:
            until = time.monotonic() + 30
            while not any("no transm." in text for text in journal("modules")):
                assert time.monotonic() < until, "a module that is really away is reported"
                time.sleep(0.1)
        finally:
            os.kill(module, signal.SIGCONT)


def test_a_drive_that_is_really_gone_is_noticed_all_the_same() -> None:
    from gateway.simulation.drives.control import EmulatorControl

    port = free_port()
    with runtime_folder(), plain_run("gone", port):
        assert wait_up("gone", 60.0)
        hand = Hand("gone", port)
        try:
            hand.begin()
            EmulatorControl("gone-drives").ask("power_off", axis=2)
            hand.one.wait(lambda block: block.bit(0, 15) and block.word(1) in (16, 17), 10, "drive lost")
        finally:
            hand.end()


def test_the_clock_and_the_reason_are_said() -> None:
    with runtime_folder():
        command = [sys.executable, "-m", "gateway", "run", "demo", "--sim", "--json"]
        plan = json.loads(subprocess.run([*WITHOUT, *command], capture_output=True, text=True, check=True, timeout=60).stdout)
        assert (plan["p5_ms"], plan["stretched"]) == (10, True)
        asked = json.loads(subprocess.run([*WITHOUT, *command, "--p5", "4"], capture_output=True, text=True, check=True, timeout=60).stdout)
        assert (asked["p5_ms"], asked["stretched"]) == (4, False), "what is asked for is played"
        with_it = json.loads(subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout)
        assert (with_it["p5_ms"], with_it["stretched"]) == ((4 if WITHOUT else 10), True)


def test_a_page_whose_port_is_taken_is_reported_before_anything_runs() -> None:
    with runtime_folder() as folder, socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        command = [sys.executable, "-m", "gateway", "run", "demo", "--sim", "--name", "taken", "--web", str(port)]
        run = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
        assert run.returncode == 3 and "page:" not in run.stdout and "http" not in run.stdout
        assert f"127.0.0.1:{port} is in use by another program or run" in run.stderr and "--web PORT" in run.stderr
        assert "started" not in run.stdout and not list((folder / "run").glob("**/journal.jsonl"))
