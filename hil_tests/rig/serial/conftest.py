"""A line process of one's own for each test, in a runtime folder of its own."""

import os
import pathlib
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import pytest

from drivers.ports.base import BytePort
from drivers.ports.open import open_bytes
from drivers.ports.serial.line_format import Record, parse_record
from gateway.simulation.line.control import LineControl
from protocols.base.machine import Damage


class Rig:
    """One running line process: ports, hands, record."""

    def __init__(self, name: str, folder: pathlib.Path, *options: str) -> None:
        self.name, self._record = name, folder / f"{name}.rec"
        command = [sys.executable, "-m", "gateway.simulation.line.process", "--name", name, "--record", str(self._record), *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n", self.process.communicate(timeout=5)[1]
        self.control = LineControl(name)
        self.baud = str(self.control.status()["baud"])

    def url(self, side: str) -> str:
        """Address of side "a" or "b"."""
        return "pty:" + LineControl.path(self.name, side)

    def port(self, side: str) -> BytePort:
        """Opens a side."""
        return open_bytes(self.url(side), f"{self.baud} 8E1")

    def record(self) -> Record:
        """Everything up to now."""
        self.control.status()
        with self._record.open(encoding="ascii") as file:
            return parse_record(file)

    def end(self) -> int:
        """SIGTERM and its exit code."""
        self.control.close()
        if self.process.poll() is None:
            self.process.terminate()
        code = self.process.wait(timeout=5)
        for stream in (self.process.stdout, self.process.stderr):
            assert stream is not None
            stream.close()
        return code


@pytest.fixture
def runtime(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> pathlib.Path:
    """A runtime folder nobody else uses."""
    folder = tmp_path / "run"
    monkeypatch.setenv("AXISGATE_RUNTIME", str(folder))
    return folder


@pytest.fixture
def line(runtime: pathlib.Path, tmp_path: pathlib.Path) -> Iterator[Callable[..., Rig]]:
    """line("--baud", "9600") starts a line process; all are ended after the test."""
    rigs: list[Rig] = []

    def start(*options: str) -> Rig:
        rigs.append(Rig(f"wire{len(rigs)}", tmp_path, *options))
        return rigs[-1]

    yield start
    for rig in rigs:
        rig.end()


def pace_ns(stamps: list[int]) -> float:
    """Time of one character: the median over stretches of half the length, so that one late wake of the machine does not count."""
    half = len(stamps) // 2
    return statistics.median((later - earlier) / half for earlier, later in zip(stamps, stamps[half:], strict=False))


def hear(port: BytePort, enough: Callable[[list[bytes | Damage]], bool], limit_s: float = 5.0) -> list[bytes | Damage]:
    """Reads until enough has come or the limit is over; good characters one by one."""
    items: list[bytes | Damage] = []
    end = time.monotonic() + limit_s
    while not enough(items) and time.monotonic() < end:
        for item in port.read():
            items += [bytes((byte,)) for byte in item] if isinstance(item, bytes) else [item]
        os.sched_yield() if items else time.sleep(0.0005)
    return items
