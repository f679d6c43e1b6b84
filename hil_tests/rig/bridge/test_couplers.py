"""CiA 401 couplers of the shipped S5 cell under --sim: contacts, the watchdog, and what falls by itself when the cycle is dead."""

import contextlib
import json
import os
import signal
import time
from typing import Any

from gateway.runtime.regions import RegionReader, recv_fds
from gateway.runtime.supervisor_client import ask
from gateway.simulation.drives.control import EmulatorControl
from hil_tests.lab.running.joined_running import JoinedRun, cell_copy, running_joined

MORE = """
[[io]]
name   = "watchdog"
device = { type = "canopen-401", bus = "can0", node = 20, output = 1 }
signal = "cell.watchdog"
toggle_ms = 20
on_loss = 0
[[io]]
name   = "lamp"
device = { type = "canopen-401", bus = "can0", node = 20, output = 9 }
signal = "cell.error"
on_loss = 1
[[io]]
name   = "door"
device = { type = "canopen-401", bus = "can0", node = 20, input = 10 }
signal = "cell.safety_ok"
"""


class Coupler:
    """The emulated node 20 as its terminals are."""

    def __init__(self, run: JoinedRun) -> None:
        self._control = EmulatorControl(f"{run.name}-can0-io")

    def outputs(self) -> int:
        octets = bytes.fromhex(self._control.ask("state")["nodes"]["20"]["outputs"])
        return int.from_bytes(octets, "little")

    def wire(self, channel: int, level: bool) -> None:
        self._control.ask("wire", node=20, channel=channel, on=level)


def contact(run: JoinedRun, name: str) -> dict[str, Any]:
    return next(row for row in run.ask(op="contacts")["contacts"] if row["name"] == name)


def errors(run: JoinedRun) -> list[dict[str, Any]]:
    """What the services report, as the page reads it."""
    fds: dict[str, int] = {}
    try:
        with ask(run.name, "regions") as connection:
            fds = recv_fds(connection)
        payload = RegionReader(fds["links"], "links").read()
    finally:
        for fd in fds.values():
            os.close(fd)
    return list(json.loads((payload or b"{}").rstrip(b"\0 ") or b"{}").get("errors", []))


def test_a_dead_coupler_takes_readiness_and_is_named_in_the_errors_and_beside_its_contacts() -> None:
    with running_joined(lambda folder: cell_copy("s5-rk512", folder, more=MORE), "deadcoupler") as run:
        run.until(lambda: contact(run, "ready_contact")["quality"] == "GOOD", "the coupler is started up", 40.0)
        run.until(lambda: run.value("cell.ready") == 1, "ready")
        with ask(run.name, "status") as connection:
            status = json.loads(connection.makefile().readline())
        pid = next(process["pid"] for process in status["processes"] if process["name"].startswith("couplers"))
        os.kill(pid, signal.SIGSTOP)
        try:
            run.until(lambda: run.value("cell.ready") == 0, "ready falls: the watchdog hangs on it")
            run.until(lambda: "no answer" in contact(run, "lamp")["why"], "io list names the object", 20.0)
            assert "1000h:00" in contact(run, "lamp")["why"], contact(run, "lamp")
            told = [error["text"] for error in errors(run) if error["code"] == 45]
            assert told and "can0 node 20" in told[0] and "watchdog" in told[0] and "lamp" in told[0], told
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGCONT)
        run.until(lambda: run.value("cell.ready") == 1 and contact(run, "lamp")["why"] == "", "back", 40.0)


def toggles(coupler: Coupler) -> bool:
    """Whether the watchdog is seen at both levels within a tenth of a second."""
    levels = set()
    for _ in range(20):
        levels.add(coupler.outputs() >> 1 & 1)
        time.sleep(0.005)
    return len(levels) == 2


def cycle_pid(run: JoinedRun) -> int:
    with ask(run.name, "status") as connection:
        status = json.loads(connection.makefile().readline())
    return int(next(process["pid"] for process in status["processes"] if process["name"] == "cycle"))


def test_contacts_of_a_coupler_follow_the_cell_and_the_watchdog_stops_with_the_cycle() -> None:
    with running_joined(lambda folder: cell_copy("s5-rk512", folder, more=MORE), "contacts") as run:
        run.until(lambda: contact(run, "ready_contact")["quality"] == "GOOD", "the coupler is started up", 40.0)
        coupler = Coupler(run)
        run.until(lambda: toggles(coupler), "the watchdog toggles")
        run.until(lambda: coupler.outputs() >> 9 & 1 == contact(run, "lamp")["value"], "the lamp shows what the services say")
        coupler.wire(10, True)
        run.until(lambda: contact(run, "door")["value"] == 1 and contact(run, "door")["quality"] == "GOOD", "the input is heard")
        coupler.wire(10, False)
        run.until(lambda: contact(run, "door")["value"] == 0, "and heard again")

        refused = run.ask(op="force", name="watchdog", value=1)
        assert "never forced" in refused["error"]

        def lamp() -> int:
            return coupler.outputs() >> 9 & 1

        run.ask(op="force", name="lamp", value=0, seconds=30)
        run.until(lambda: not lamp(), "the lamp is forced out")
        run.ask(op="force", name="lamp", value=1, seconds=30)
        run.until(lamp, "the lamp is forced on")
        run.ask(op="force", name="lamp", value=None)
        run.until(lambda: lamp() == run.value("cell.error"), "and free again")

        pid = cycle_pid(run)
        run.process.send_signal(signal.SIGSTOP)  # the supervisor: it would bury the cycle at once
        os.kill(pid, signal.SIGSTOP)
        try:
            run.until(lambda: coupler.outputs() & 0b11 == 0 and lamp(), "without a cycle outputs fall by themselves")
            assert not toggles(coupler), "the watchdog stands"
        finally:
            run.process.send_signal(signal.SIGCONT)
            with contextlib.suppress(ProcessLookupError):  # the supervisor was quicker
                os.kill(pid, signal.SIGCONT)
        run.until(lambda: contact(run, "door")["quality"] == "GOOD", "everything is back", 40.0)
        run.until(lambda: toggles(coupler), "the watchdog toggles again")
