"""An acknowledgement that comes before our own count of characters is over: a running cell and the tools with --format (AX-652).

A block of 64 words takes 0.3 s at 4800 baud, 5 s at 300.  A partner without one (a program's pty, a program behind a TCP server) has it at
once and says so; a job that waited for the line would be repeated until it fails.
"""

import contextlib
import json
import os
import pathlib
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from drivers.ports.base import runtime_dir
from drivers.ports.serial import device
from drivers.ports.serial.device import SerialPort
from drivers.ports.serial.line_format import parse_format
from gateway.runtime.supervisor_client import wait_up
from gateway.tools.line.ports import open_port
from hil_tests.lab.partners.foreign_station import ForeignStation
from hil_tests.lab.running.cell_running import COMES_UP_S, runtime_folder
from hil_tests.rig.serial.test_rfc2217 import PtySerial, Server

FORMAT = "300 8N1"  # the server's own interface is a pty, which has no parity
NAME = "early"
CELL = """
format = 1
[cell]
name = "paced"
target = "machine"
[safety]
emergency_stop = "safety relay -K1"
sto_wired = true
guard = "fence"
limit_switches = "hard-wired"
risk_assessment = "RB-1"
last_stop_test = 2026-11-19
[[line]]
name = "asking"
port = "{port}"
format = "4800 8N1"
role = "active"
[line.times]
ADT = 3000  # ms; the answer that is asked for comes early, and a machine that is late at times spoils nothing
[line.supervision]
max_silence_ms = 60000
[[db]]
number = 30
words = 64
writer = "axisgate"
line = "asking"
every_ms = 1000
at_partner = "DB10.DW0"
entries = [{{ at = "DW 3", type = "KF", from = "cell.life" }}]
[[bus]]
name = "drives"
port = "sim"
protocol = "servodyn"
cycle_ms = 20
[[axis]]
name = "X"
unit = "mm"
drive = {{ type = "servodyn", bus = "drives", module = 1 }}
limits = {{ min = -5.0, max = 1000.0, speed = 100.0, accel = 1000.0 }}
home = {{ by = "none" }}
"""
KINDS = ("tty", "pty", "tcp")
TIMES = 6  # blocks that are sent one after the other


@contextlib.contextmanager
def partner(kind: str) -> Iterator[tuple[ForeignStation, str]]:
    """A station, and the port it is reached at: a terminal by its own name, a pty, a program behind an RFC 2217 server."""
    with ForeignStation() as station:
        if kind != "tcp":
            yield station, f"{'pty:' if kind == 'pty' else ''}{station.path}"
            return
        with PtySerial(station.path, timeout=0.01) as near:
            server = Server(-1, near)
            threading.Thread(target=served, args=(server,), daemon=True).start()
            yield station, server.url
            server.listener.close()
            if server.connection is not None:
                server.connection.close()


def served(server: Server) -> None:
    """One tool after the other."""
    with contextlib.suppress(OSError):
        while True:
            server.serve()


def counters() -> dict[str, Any]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as link:
        link.settimeout(5.0)
        link.connect(str(runtime_dir() / f"{NAME}-services.sock"))
        link.sendall(b'{"op": "status"}\n')
        found: dict[str, Any] = json.loads(link.makefile().readline())["command_sources"][0]
        return found


@pytest.mark.parametrize("kind", KINDS)
def test_a_running_cell_takes_it(kind: str, tmp_path: pathlib.Path) -> None:
    with partner(kind) as (station, port), runtime_folder():
        file = tmp_path / "paced.toml"
        file.write_text(CELL.format(port=port))
        command = [sys.executable, "-m", "gateway", "run", str(file), "--name", NAME, "--p5", "20", "--die-with-parent"]
        with (tmp_path / "log").open("wb") as log:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
        try:
            assert wait_up(NAME, COMES_UP_S), (tmp_path / "log").read_text()
            until = time.monotonic() + 25
            while len(station.heard) < TIMES:
                assert time.monotonic() < until, (len(station.heard), counters(), (tmp_path / "log").read_text()[-1500:])
                time.sleep(0.05)
            lives = [block[10 + 6 : 10 + 8] for block in station.heard]
            assert len(set(lives)) == len(lives), "no block came twice"
            told = counters()
            assert told["connected"] and told["alive"] and told["own_faults"] == told["bad_blocks"] == 0, told
            assert told["own_jobs"] >= TIMES - 1
        finally:
            process.terminate()
            process.wait(15)


def axisgate(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "gateway", "line", *words]
    return subprocess.run(command, check=False, capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)


@pytest.mark.parametrize("kind", KINDS)
def test_the_tools_take_it_with_their_format(kind: str) -> None:
    with partner(kind) as (station, port):
        words = [f"{n:04X}" for n in range(60)]
        sent = axisgate("send", port, "DB10.DW3", "--type", "KH", *words, "--format", FORMAT)
        assert sent.returncode == 0, sent.stderr + sent.stdout
        assert len(station.heard) == 1, "once"
        brought = axisgate("fetch", port, "DB10.DW3", "--count", "60", "--format", FORMAT, "--json")
        assert brought.returncode == 0, brought.stderr
        assert [one["bytes"] for one in json.loads(brought.stdout)] == [word.lower() for word in words]


def test_a_break_goes_through_the_server_and_a_spoiled_character_cannot() -> None:
    with partner("tcp") as (_, url):
        port = open_port(url, FORMAT)
        try:
            assert port.send_break() and not port.spoil()
        finally:
            port.close()


@pytest.mark.parametrize("name, at_once", [("ttyACM0", True), ("tnt1", True), ("ttyGS0", True), ("ttyUSB0", False), ("ttyS4", False)])
def test_a_usb_device_that_speaks_serial_itself_answers_at_once_and_a_uart_cannot(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, name: str, at_once: bool
) -> None:
    """By the name its driver gives it, also behind /dev/serial/by-id; a terminal takes the place of the device."""
    master, slave = os.openpty()
    real = os.ttyname(slave)
    by_id = tmp_path / "usb-Maker_Converter-if00"
    by_id.symlink_to(real)
    os.set_blocking(master, False)
    true_path = os.path.realpath
    monkeypatch.setattr(os.path, "realpath", lambda path: f"/dev/{name}" if str(path) == str(by_id) else true_path(path))
    monkeypatch.setattr(device, "is_pty", lambda fd: False)
    port = SerialPort(str(by_id), parse_format("300 8N1"))
    try:
        port.write(bytes(60))
        assert port.unsent() > 50
        os.write(master, b"\x10")
        time.sleep(0.05)
        assert port.read() == [b"\x10"]
        assert (port.unsent() == 0) is at_once
    finally:
        os.read(master, 4096)
        port.close()
        os.close(master)
        os.close(slave)
