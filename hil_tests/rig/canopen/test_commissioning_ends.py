"""However `drive commission --mode` ends, the drive stands and is off afterwards: asked by a CANopen master that is not this project's.

All tests share one bus and its emulated drives: the first one moves the axis away, the others move it back a little each.
"""

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import can
import canopen
import pytest

from gateway.__main__ import main as axisgate
from hil_tests.lab.running.bus_running import running_bus

NODE = 2
WAY, BACK = 900.0, -900.0  # mm
STARTS = (bytes.fromhex("23ff6000"), bytes.fromhex("2b4060001f00"), bytes.fromhex("2b4060005f00"))  # 60FFh; 6040h with bit 4 of IP, PP
NO_SPEED = bytes.fromhex("23ff600000000000")
ARMED = bytes.fromhex("231610012c017f00")  # 1016h:01: node 127, 300 ms
OFF = (0x40, 0x08, 0x00)  # switch on disabled, fault, not ready: no power


class Judge:
    """The `canopen` package on the bus: only reads."""

    def __init__(self, name: str) -> None:
        self.network = canopen.Network(can.Bus(interface="broker", channel=name))
        self.network.connect()
        self.sdo = self.network.add_node(NODE).sdo
        self.sdo.MAX_RETRIES = 3
        self.started, self.armed = threading.Event(), False
        self.network.subscribe(0x600 + NODE, self._hear)

    def number(self, index: int, *, signed: bool = False) -> int:
        return int.from_bytes(self.sdo.upload(index, 0), "little", signed=signed)

    def await_moving(self) -> None:
        """Only listens, as two SDO clients of one node disturb each other: the tool's last request before the axis moves, and a while."""
        assert self.started.wait(60), "it never moved"
        time.sleep(0.5)

    def _hear(self, identifier: int, data: bytearray, stamp: float) -> None:
        heard = bytes(data)
        self.armed |= heard == ARMED
        if heard.startswith(STARTS) and heard != NO_SPEED:
            self.started.set()

    def at_rest_and_off(self) -> bool:
        before = self.number(0x6064, signed=True)
        time.sleep(0.1)
        return self.number(0x6041) & 0x4F in OFF and abs(self.number(0x6064, signed=True) - before) <= 2

    def close(self) -> None:
        self.network.disconnect()


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Judge]:
    with running_bus(tmp_path_factory.mktemp("ends"), name="ends", log=False):
        command = [sys.executable, "-m", "gateway", "emulate", "demo-402", "--bus", "broker:ends"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            assert process.stdout is not None
            while process.stdout.readline() != "ready\n":
                assert process.poll() is None
            judge = Judge("ends")
            yield judge
            judge.close()
        finally:
            process.terminate()
            process.communicate(timeout=10)


@pytest.fixture
def judge(drives: Judge) -> Judge:
    """Has heard nothing yet."""
    drives.started.clear()
    drives.armed = False
    return drives


def commission(mode: str, way: float) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "gateway", "drive", "commission", "demo-402", "A2", "--port", "broker:ends"]
    return subprocess.Popen([*command, "--mode", mode, "--way", str(way)], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)


def test_a_way_of_more_than_twenty_seconds_is_waited_for_and_the_drive_is_off_then(judge: Judge) -> None:
    """0.9 m at 5 % of 0.8 m/s."""
    tool = commission("pp", WAY)
    words = tool.communicate(timeout=60)[1]
    assert tool.returncode == 0 and float(words.split("moved it by ")[1].split()[0]) == pytest.approx(900, abs=0.5), words
    assert judge.at_rest_and_off()
    assert judge.sdo.upload(0x1016, 1) == bytes(4), "nothing is watched after an end in order"


@pytest.mark.parametrize(("mode", "number"), [("pv", signal.SIGINT), ("pp", signal.SIGTERM), ("ip", signal.SIGHUP)])
def test_a_signal_in_the_move_stops_the_drive_and_switches_it_off(judge: Judge, mode: str, number: signal.Signals) -> None:
    tool = commission(mode, BACK)
    try:
        judge.await_moving()
        tool.send_signal(number)
        words = tool.communicate(timeout=10)[1]
    finally:
        tool.kill()
    assert judge.at_rest_and_off(), f"{judge.number(0x6041):04X}h"
    assert tool.returncode == 3
    assert f"ended by {number.name}; the drive was stopped and is switched off (statusword " in words, words
    left = f"a fault {judge.number(0x603F):04X}h is left"
    assert judge.number(0x6041) & 0x4F != 0x08, f"the tool that stopped it in order leaves no fault behind, but {left}"


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_tool_that_dies_or_hangs_in_the_move_stops_its_drive(judge: Judge, number: signal.Signals) -> None:
    tool = commission("pv", BACK)
    try:
        judge.await_moving()
        assert judge.armed, "it watches node 127 for 300 ms"
        tool.send_signal(number)
        before = judge.number(0x6064, signed=True)
        time.sleep(1.0)
        assert abs(judge.number(0x6064, signed=True) - before) > 1000, "it did move when the tool died"
        assert judge.at_rest_and_off(), f"{judge.number(0x6041):04X}h"
    finally:
        tool.kill()
        tool.communicate(timeout=10)


@pytest.mark.parametrize("way", ["nan", "inf", "1e12"])
def test_a_way_that_is_none_is_a_sentence(drives: Judge, way: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert axisgate(["drive", "commission", "demo-402", "A2", "--port", "broker:ends", "--mode", "pp", "--way", way]) == 3
    assert "a way of axis A2 is a number within +-" in capsys.readouterr().err
