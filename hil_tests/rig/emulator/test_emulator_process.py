"""The emulator as its own process on a broker: real sockets, real stamps; P5 20 ms, as the master here is a test."""

import contextlib
import json
import os
import pathlib
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import pytest

from drivers.emulator.servo import record
from drivers.emulator.servo.settings import BusSettings, ServoSettings, to_dict
from drivers.ports.can.broker import BrokerPort
from gateway.simulation.control_requests import BadCommandError
from gateway.simulation.drives.control import EmulatorControl
from hil_tests.lab.virtual.servodyn_bus import CODEC
from protocols.base.machine import Frame
from protocols.servodyn.codec import SYNC, ActualValue, SetValue

P5_S = 0.020
DRIVES = (1, 2, 6)


def start(module: str, *options: str) -> subprocess.Popen[str]:
    process = subprocess.Popen([sys.executable, "-m", module, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    ready, _, _ = select.select([process.stdout], [], [], 20.0)
    assert ready and process.stdout.readline() == "ready\n", process.communicate(timeout=5)
    return process


def end(process: subprocess.Popen[str]) -> int:
    if process.poll() is None:
        process.terminate()
    process.communicate(timeout=10)
    return process.returncode


class Rig:
    """A broker, an emulator on it, and the master of the bus."""

    def __init__(self, folder: pathlib.Path) -> None:
        self.settings, self.record_file = folder / "drives.json", folder / "drives.rec"
        plain = ServoSettings(gravity_nm=1.0, torque_noise_nm=0.02)
        self.settings.write_text(json.dumps(to_dict(BusSettings(P5_S * 1000, 5, dict.fromkeys(DRIVES, plain)))))
        self.broker = start("gateway.simulation.bus.broker", "--name", "rig")
        self.emulator = start(
            "gateway.simulation.drives.process",
            "--settings",
            str(self.settings),
            "--bus",
            "broker:rig",
            "--name",
            "rig",
            "--record",
            str(self.record_file),
        )
        self.control = EmulatorControl("rig")
        self.port = BrokerPort("rig")
        self.actual: dict[int, ActualValue] = {}
        self.heard: list[Frame] = []
        self.goals = dict.fromkeys(DRIVES, 0)
        self.on = self.enable = self.reset = False
        self._life = 0

    def listen(self, seconds: float) -> None:
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0:
            select.select([self.port], [], [], left)
            for frame in self.port.receive():
                self.heard.append(frame)
                axis, value = CODEC.decode_actual(frame)
                self.actual[axis] = value

    def cycle(self) -> None:
        self._life = (self._life + 1) & 0xFF
        self.port.send([SYNC])
        self.listen(P5_S / 2)
        frames = []
        for axis in DRIVES:
            seen = self.actual.get(axis, ActualValue())
            if not seen.enabled:
                self.goals[axis] = seen.position_inc
            frames.append(CODEC.encode_set(axis, SetValue(self.enable, self.on, False, self.reset, False, self._life, self.goals[axis])))
        self.port.send(frames)
        self.listen(P5_S / 2)

    def until(self, reached: Callable[[], bool], seconds: float, what: str) -> None:
        limit = time.monotonic() + seconds
        while not reached():
            assert time.monotonic() < limit, f"{what} not within {seconds} s: {self.actual} {self.control.state()}"
            self.cycle()

    def all(self, bit: str) -> bool:
        return set(self.actual) == set(DRIVES) and all(bool(getattr(value, bit)) for value in self.actual.values())

    def switch_on(self) -> None:
        self.on = self.enable = self.reset = False
        self.until(lambda: self.all("ready"), 5.0, "ready")
        self.on = True
        self.until(lambda: self.all("power_on"), 5.0, "power")
        self.enable = True
        self.until(lambda: self.all("enabled"), 5.0, "control")

    def close(self) -> None:
        self.control.close()
        self.port.close()
        end(self.emulator)
        end(self.broker)


@pytest.fixture
def rig(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
    monkeypatch.setenv("AXISGATE_RUNTIME", str(tmp_path / "run"))
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    made = Rig(tmp_path)
    with contextlib.suppress(PermissionError):  # a master that sleeps longer than 2 x P5 would fault the drives, as it should
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(25))
    yield made
    with contextlib.suppress(PermissionError):
        os.sched_setscheduler(0, *before)
    made.close()


def test_drives_switch_on_move_and_keep_a_record(rig: Rig) -> None:
    rig.switch_on()
    start_at = dict(rig.goals)
    for step in range(1, 51):
        rig.goals = {axis: start_at[axis] + 200 * step for axis in DRIVES}
        rig.cycle()
    rig.until(lambda: all(abs(rig.actual[axis].position_inc - rig.goals[axis]) <= 2 for axis in DRIVES), 5.0, "target")
    cycles = [frame.identifier for frame in rig.heard]
    assert cycles[-3:] == [610, 620, 660]
    assert rig.control.ask("flush")["record_lost"] == 0
    kept = record.read(rig.record_file.read_bytes())
    rows = [row for row in kept.rows if not row.axes[0].flags & record.Flag.NO_SYNC]  # the master has stopped by now
    assert kept.axes == DRIVES and len(rows) > 60
    assert rows[-1].axes[0].position_inc == pytest.approx(rig.goals[1], abs=3)
    assert [row.sync for row in rows] == list(range(1, len(rows) + 1))
    assert end(rig.emulator) == 0
    assert not (rig.record_file.parent / "run" / "emulator-rig.sock").exists()


def test_a_dead_master_means_quick_stop_and_a_fault_on_the_bus(rig: Rig) -> None:
    rig.switch_on()
    start_at = dict(rig.goals)
    for step in range(1, 30):
        rig.goals = {axis: start_at[axis] + 1000 * step for axis in DRIVES}
        rig.cycle()
    rig.heard.clear()
    rig.listen(0.5)
    told = [frame for frame in rig.heard if frame.data[1] == 1]
    assert told, rig.control.state()
    assert [frame.identifier for frame in told] == [610, 620, 660], "each drive says its fault once"
    state = rig.control.state()
    assert all(axis["state"] == "fault" and axis["speed_rad_s"] == 0.0 for axis in state["axes"].values())
    rig.control.ask("flush")
    rows = record.read(rig.record_file.read_bytes()).rows
    last = max(row.stamp_ns for row in rows if not row.axes[0].flags & record.Flag.NO_SYNC)
    braking = next(row for row in rows if row.stamp_ns > last and row.axes[0].fault == 1)
    assert (braking.stamp_ns - last) * 1e-9 <= 3 * P5_S


def test_a_broker_that_returns_finds_the_plant_as_it_was(rig: Rig) -> None:
    rig.switch_on()
    start_at = dict(rig.goals)
    for step in range(1, 40):
        rig.goals = {axis: start_at[axis] + 400 * step for axis in DRIVES}
        rig.cycle()
    before = rig.control.state()["axes"]["2"]["counter_inc"]
    end(rig.broker)
    time.sleep(0.5)
    assert rig.control.state()["connected"] is False
    rig.broker = start("gateway.simulation.bus.broker", "--name", "rig")
    rig.port.reconnect()
    rig.until(lambda: rig.control.state()["connected"] is True, 2.0, "reconnection")
    rig.actual.clear()
    rig.on = rig.enable = False
    rig.until(lambda: rig.all("fault"), 2.0, "fault on the bus")
    assert abs(rig.actual[2].position_inc - before) < 6000, "run out along the ramp, not forgotten"
    rig.reset = True
    rig.until(lambda: not any(value.fault for value in rig.actual.values()), 2.0, "reset")
    rig.switch_on()


def test_a_stopped_emulator_catches_up_by_stamps_and_says_how_late_it_was(rig: Rig) -> None:
    rig.switch_on()
    rig.emulator.send_signal(signal.SIGSTOP)
    for _ in range(20):
        rig.cycle()
    rig.emulator.send_signal(signal.SIGCONT)
    rig.until(lambda: len(rig.heard) > 0 and rig.control.state()["counters"]["late"] >= 15, 2.0, "catch-up")
    rig.cycle()
    rig.cycle()
    assert rig.all("enabled"), "no SYNC was missing on the bus, so nothing is lost"


def test_faults_to_order_and_wrong_orders(rig: Rig) -> None:
    rig.switch_on()
    rig.control.ask("force_fault", axis=6, code=42)
    rig.until(lambda: rig.actual[6].fault_code == 42, 2.0, "fault 42")
    rig.control.ask("power_off", axis=1)
    rig.until(lambda: rig.control.state()["axes"]["1"]["state"] == "offline", 1.0, "offline")
    rig.heard.clear()
    rig.cycle()
    rig.cycle()
    assert 610 not in [frame.identifier for frame in rig.heard]
    for order in ({"axis": 3}, {"axis": 9}, {}):
        with pytest.raises(BadCommandError, match=r"module 3 is not on this bus|axis: "):
            rig.control.ask("wrong_sign", **order)
    with pytest.raises(BadCommandError, match="is not a command"):
        rig.control.ask("dance")
    rig.control.ask("quit")
    assert rig.emulator.wait(timeout=5) == 0


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('{"axes": {"1": {"kv_per_s": -1}}}', "axes.1.kv_per_s: -1 1/s is outside"),
        ("{nonsense", "Expecting property name"),
        ('{"speed": 1}', "speed: unknown"),
    ],
)
def test_bad_settings_are_reported_and_exit_2(text: str, told: str, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "bad.json"
    file.write_text(text)
    command = [sys.executable, "-m", "gateway.simulation.drives.process", "--settings", str(file), "--bus", "broker:none"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
    assert done.returncode == 2 and told in done.stderr and "Traceback" not in done.stderr
