"""Frames of CAN FD on a live bus are shown and counted: an adapter with python-can's own protocol on a pty.  Never a traceback."""

import contextlib
import json
import os
import pathlib
import subprocess
import sys
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator

import can
import pytest

from gateway.commands.bus import main
from hil_tests.lab.running.bus_running import Bus, running_bus

CLASSIC = b"t1232AABB\r"
FD = b"d1238" + 8 * b"01" + b"\r"
FAST = b"b1239" + b"".join(b"%02X" % n for n in range(12)) + b"\r"  # 12 bytes at the second bit rate
LONG = b"D18FEF10FF" + 64 * b"5A" + b"\r"  # extended, 64 bytes
SECONDS = 4.0


@contextlib.contextmanager
def adapter() -> Iterator[str]:
    """An slcan adapter that says one classic frame and three of CAN FD every 20 ms.  Source: python-can's slcan, Lawicel's protocol."""
    master, slave = os.openpty()
    tty.setraw(master)
    ended = threading.Event()

    def says() -> None:
        os.set_blocking(master, False)
        while not ended.wait(0.02):
            with contextlib.suppress(BlockingIOError):
                os.read(master, 4096)  # the commands that open it
            with contextlib.suppress(BlockingIOError):
                os.write(master, CLASSIC + FD + FAST + LONG)

    thread = threading.Thread(target=says)
    thread.start()
    try:
        yield f"slcan:{os.ttyname(slave)}?sleep_after_open=0"
    finally:
        ended.set()
        thread.join()
        termios.tcflush(master, termios.TCIOFLUSH)
        os.close(master)
        os.close(slave)


def axisgate(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "gateway", "bus", *words]
    told = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
    assert "Traceback" not in told.stderr and told.returncode == 0, told
    return told


def test_monitor_shows_every_frame_of_can_fd_beside_the_classic_ones() -> None:
    with adapter() as url:
        lines = axisgate("monitor", url, "--count", "16").stdout.splitlines()
        assert len(lines) == 16
        assert any("FD, 8 bytes: 01 01 01" in line for line in lines)
        assert any("FD, fast, 12 bytes: 00 01 02 03" in line for line in lines)
        assert any("FD, 64 bytes: 5a 5a" in line and "18FEF10F" in line.upper() for line in lines)
        assert any("aa bb" in line and "FD" not in line for line in lines)
        told = [json.loads(line) for line in axisgate("monitor", url, "--count", "16", "--json").stdout.splitlines()]
        assert {len(one["data"]) // 2 for one in told if one.get("fd")} == {8, 12, 64}
        assert {one["fast"] for one in told if one.get("fd") and len(one["data"]) == 24} == {True}
        assert {one["data"] for one in told if not one.get("fd")} == {"aabb"}


def test_the_summary_and_the_recording_count_them(tmp_path: pathlib.Path) -> None:
    with adapter() as url:
        lines = axisgate("monitor", url, "--seconds", str(SECONDS), "--summary", "--dbc", "servodyn_gc.dbc").stdout.splitlines()
        assert [line.split("  FD, ")[1] for line in lines if "  FD, " in line] == ["12 bytes", "64 bytes"], "the last of each identifier"
        assert any(line.endswith("frames of CAN FD, not in the load: drives and couplers here speak classic CAN") for line in lines)
        fd = int(next(line for line in lines if "frames of CAN FD" in line).split()[0])
        classic = int(next(line for line in lines if "load " in line).split()[0])
        assert classic > 5 and abs(fd - 3 * classic) <= 3
        told = axisgate("log", url, "-o", str(tmp_path / "bus.log"), "--seconds", str(SECONDS)).stdout
        assert "frames of CAN FD passed over" in told
    assert len((tmp_path / "bus.log").read_text().splitlines()) == int(told.split()[0]) > 5


@pytest.mark.parametrize("command", [("--nmt", "start"), ("--node", "5", "--read", "1018:1"), ("--frame", "201#06")])
def test_a_tool_that_talks_is_not_disturbed_by_them(command: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    with can.Bus(interface="virtual", channel="fd", protocol=can.CanProtocol.CAN_FD) as other:
        message = can.Message(arbitration_id=0x585, is_extended_id=False, is_fd=True, data=bytes(64))
        task = other.send_periodic(message, 0.02)
        code = main(["send", "virtual:fd", *command])
        task.stop()
    assert code in (0, 1) and "Traceback" not in capsys.readouterr().err


@pytest.fixture
def local(tmp_path: pathlib.Path) -> Iterator[Bus]:
    with running_bus(tmp_path, name="fdrun", log=False) as bus:
        yield bus


def test_the_adapter_of_a_run_hands_on_what_is_classic_and_reports_the_rest_once(local: Bus) -> None:
    with adapter() as url:
        command = [sys.executable, "-m", "gateway.processes.can_adapter", "--bus", "broker:fdrun", "--port", url]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        listener = local.port()
        frames: list[tuple[int, bytes]] = []

        def heard() -> bool:
            frames.extend((frame.identifier, frame.data) for frame in listener.receive())
            return len(frames) > 20

        try:
            wait(heard)
        finally:
            process.terminate()
            told = process.communicate(timeout=10)[0]
            listener.close()
    assert set(frames) == {(0x123, b"\xaa\xbb")}
    assert told.count("frames of CAN FD on the bus: they are ignored") == 1 and "Traceback" not in told, told


def wait(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 20
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)
