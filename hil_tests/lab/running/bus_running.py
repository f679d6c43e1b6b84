"""A running broker for tests and benches: started with a runtime folder and a log of its own, ended without remains."""

import contextlib
import os
import pathlib
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator

from drivers.ports.can.broker import BrokerPort, socket_path
from protocols.base.machine import Frame

LIMIT_S = 10.0


class Bus:
    """One broker process and its log."""

    def __init__(self, name: str, log: pathlib.Path | None, *options: str) -> None:
        self.name, self.log = name, log
        self._command = [
            sys.executable,
            "-m",
            "gateway.simulation.bus.broker",
            "--name",
            name,
            *(["--log", str(log)] if log else []),
            *options,
        ]
        self.process = self.start()

    def start(self) -> subprocess.Popen[str]:
        """Start (again); return when the broker reports that it is ready."""
        self.process = subprocess.Popen(self._command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n", self.process.communicate()[1]
        return self.process

    def port(self) -> BrokerPort:
        """A port that is accepted already: everything sent from now on reaches it."""
        port = BrokerPort(self.name)
        wait_readable(port)
        assert port.receive() == []  # the gap record every connection begins with
        return port

    def log_lines(self) -> list[str]:
        """The whole log; call it after stop()."""
        assert self.log is not None
        return self.log.read_text().splitlines(keepends=True)

    def stop(self, number: int = signal.SIGTERM) -> tuple[int, str]:
        """End it; return its exit code and its standard error."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.process.send_signal(number)
        words = self.process.communicate(timeout=LIMIT_S)[1]
        return self.process.returncode, words


@contextlib.contextmanager
def running_bus(folder: pathlib.Path, *options: str, name: str = "t", log: bool = True) -> Iterator[Bus]:
    """A broker while inside; $AXISGATE_RUNTIME points into `folder` meanwhile."""
    before = os.environ.get("AXISGATE_RUNTIME")
    os.environ["AXISGATE_RUNTIME"] = str(folder / "run")
    bus = Bus(name, folder / f"{name}.log" if log else None, *options)
    try:
        yield bus
    finally:
        bus.stop()
        with contextlib.suppress(FileNotFoundError):
            os.unlink(socket_path(name))
        if before is None:
            del os.environ["AXISGATE_RUNTIME"]
        else:
            os.environ["AXISGATE_RUNTIME"] = before


def wait_readable(port: BrokerPort, limit_s: float = LIMIT_S) -> None:
    """AssertionError when nothing comes within `limit_s`."""
    assert select.select([port], [], [], limit_s)[0], f"{port.name}: nothing came within {limit_s} s"


def receive(port: BrokerPort, count: int, limit_s: float = LIMIT_S) -> list[Frame]:
    """At least `count` frames; AssertionError when they do not come."""
    frames: list[Frame] = []
    end = time.monotonic() + limit_s
    while len(frames) < count:
        assert time.monotonic() < end, f"{port.name}: {len(frames)} of {count} frames within {limit_s} s"
        if select.select([port], [], [], 0.1)[0]:
            frames += port.receive()
    return frames
