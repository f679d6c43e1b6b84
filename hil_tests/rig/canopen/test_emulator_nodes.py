"""The emulator process with CiA 402 nodes: alone and beside boosters on one bus, orders by its control socket, records of both."""

import contextlib
import json
import os
import pathlib
import select
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest

from drivers.emulator.servo import record
from drivers.emulator.servo.settings import BusSettings, DriveSettings, ServoSettings, to_dict
from drivers.ports.can.broker import BrokerPort
from gateway.simulation.control_requests import BadCommandError
from gateway.simulation.drives.control import EmulatorControl
from hil_tests.lab.running.bus_running import Bus, running_bus
from protocols.base.machine import Frame
from protocols.canopen import nmt

CYCLE_MS = 20.0
SERVO = ServoSettings(boot_s=0.05, charge_s=0.0)


@contextlib.contextmanager
def emulator(folder: pathlib.Path, bus: Bus, settings: BusSettings) -> Iterator[tuple[BrokerPort, EmulatorControl]]:
    """The process, a port that hears from before it starts, its control."""
    file = folder / "drives.json"
    file.write_text(json.dumps(to_dict(settings)))
    port = bus.port()
    options = ["--settings", str(file), "--bus", f"broker:{bus.name}", "--record", str(folder / "drives.rec")]
    process = subprocess.Popen([sys.executable, "-m", "gateway.simulation.drives.process", *options], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        control = EmulatorControl(bus.name)
        yield port, control
        control.ask("quit")
        assert process.wait(timeout=10) == 0
        control.close()
    finally:
        port.close()
        process.kill()
        process.communicate()


@pytest.fixture
def bus(tmp_path: pathlib.Path) -> Iterator[Bus]:
    with running_bus(tmp_path, log=False) as running:
        yield running


def until(port: BrokerPort, identifier: int, data: bytes | None = None, limit_s: float = 5.0) -> Frame:
    end = time.monotonic() + limit_s
    while (left := end - time.monotonic()) > 0:
        select.select([port], [], [], left)
        for frame in port.receive():
            if frame.identifier == identifier and (data is None or frame.data[: len(data)] == data):
                return frame
    raise AssertionError(f"{identifier:03X}h was not heard within {limit_s} s")


def test_a_node_boots_by_itself_and_answers_orders(bus: Bus, tmp_path: pathlib.Path) -> None:
    with emulator(tmp_path, bus, BusSettings(CYCLE_MS, 1, {}, {7: DriveSettings(SERVO)})) as (port, control):
        until(port, 0x707, b"\x00")
        port.send([nmt.command(nmt.Command.START, 7)])
        until(port, 0x187)
        port.send([Frame(0x607, bytes.fromhex("2b17100064000000"))])  # heartbeat 100 ms
        until(port, 0x587, bytes.fromhex("60171000"))
        first = until(port, 0x707, b"\x05")
        second = until(port, 0x707, b"\x05")
        assert 0.05 < (second.stamp_ns - first.stamp_ns) * 1e-9 < 0.2
        asked = time.monotonic()
        control.ask("phase_loss", node=7, on=True)
        until(port, 0x087, b"\x30\x31")
        assert time.monotonic() - asked < 0.1, "an order acts at once, also on a quiet bus"
        state = control.state()["nodes"]["7"]
        assert state["state"] == "fault" and state["error_code"] == 0x3130 and state["nmt"] == "operational"
        control.ask("phase_loss", node=7, on=False)
        control.ask("power_off", node=7)
        assert control.state()["nodes"]["7"]["silent"] is True
        control.ask("power_on", node=7)
        until(port, 0x707, b"\x00")
        control.ask("refuse", node=7, index=0x1000, sub=0, code=0x060A0023)
        port.send([Frame(0x607, bytes.fromhex("4000100000000000"))])
        assert until(port, 0x587).data == bytes.fromhex("8000100023000a06")
        for word, node in (("undervoltage", 8), ("nonsense", 7), ("drop_set", 7)):
            with pytest.raises(BadCommandError):
                control.ask(word, node=node)


def test_boosters_and_nodes_share_a_bus_and_keep_a_record_each(bus: Bus, tmp_path: pathlib.Path) -> None:
    settings = BusSettings(CYCLE_MS, 1, {1: SERVO}, {7: DriveSettings(SERVO)})
    with emulator(tmp_path, bus, settings) as (port, control):
        until(port, 0x707, b"\x00")
        port.send([Frame(0x607, bytes.fromhex("2f00180201000000")), nmt.command(nmt.Command.START, 7)])
        until(port, 0x587)
        for _ in range(10):
            port.send([Frame(100), Frame(0x080)])
            until(port, 0x187)
        state = control.state()
        assert set(state["axes"]) == {"1"} and set(state["nodes"]) == {"7"}
        control.ask("stuck_encoder", axis=1)
        control.ask("force_fault", node=7)
        until(port, 0x087, b"\x00\xff")
    boosters = record.read((tmp_path / "drives.rec").read_bytes())
    nodes = record.read((tmp_path / "drives.rec.nodes").read_bytes())
    assert boosters.axes == (1,) and nodes.axes == (7,)
    for found in (boosters, nodes):
        assert sum(1 for row in found.rows if not row.axes[0].flags & record.Flag.NO_SYNC) == 10


def test_settings_of_a_node_are_checked_with_its_name(bus: Bus, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "wrong.json"
    file.write_text(
        json.dumps({"axes": {}, "nodes": {"200": {}, "5": {"serial": -1}, "6": {"eds": 3, "tpdo_delay_us": "x", "nothing": 1}}})
    )
    done = subprocess.run(
        [sys.executable, "-m", "gateway.simulation.drives.process", "--settings", str(file), "--bus", f"broker:{bus.name}"],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ,
    )
    assert done.returncode == 2
    for words in ("nodes.5.serial: -1", "nodes.6.eds", "nodes.6.tpdo_delay_us", "nodes.6.nothing"):
        assert words in done.stderr, done.stderr
