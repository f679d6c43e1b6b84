"""A cell that joins values, run as real processes, and partners written by hand on its buses."""

import contextlib
import json
import os
import pathlib
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from drivers.ports.base import CanPort, runtime_dir
from drivers.ports.can.open import open_can
from gateway.files.find import find_config, read_text
from gateway.runtime.supervisor_client import wait_up
from hil_tests.lab.running.cell_running import P5_MS, free_port, runtime_folder
from protocols.base.machine import Frame

UP_S, LIMIT_S = 60.0, 15.0
SYNC = 100
OUT_BLOCK = 471  # first output block of an I/O bus (rho3 2.2)


class JoinedRun:
    """One run; made by `running_joined`."""

    def __init__(self, cell: pathlib.Path, name: str, folder: pathlib.Path, *more: str) -> None:
        self.name, self.port, self.folder = name, free_port(), folder
        command = [
            sys.executable,
            "-m",
            "gateway",
            "run",
            str(cell),
            "--sim",
            "--name",
            name,
            "--modbus-port",
            str(self.port),
            "--die-with-parent",
        ]
        with (folder / "run.log").open("wb") as log:
            self.process = subprocess.Popen([*command, *more], stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
        until = time.monotonic() + UP_S
        while not wait_up(name, 1.0):
            if self.process.poll() is not None or time.monotonic() > until:
                self.stop()
                raise AssertionError(f"the run did not come up:\n{self.words()}")

    def words(self) -> str:
        """The last lines it printed."""
        return "\n".join((self.folder / "run.log").read_text(errors="replace").splitlines()[-25:])

    def stop(self) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            try:
                self.process.wait(15)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()

    def ask(self, **request: object) -> dict[str, Any]:
        """One request to the services; they may be starting (again)."""
        end = time.monotonic() + LIMIT_S
        while True:
            try:
                return self._ask(request)
            except (OSError, ValueError):
                assert time.monotonic() < end, f"the services do not answer\n{self.words()}"
                time.sleep(0.05)

    def _ask(self, request: dict[str, object]) -> dict[str, Any]:
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(5)
            connection.connect(str(runtime_dir() / f"{self.name}-services.sock"))
            connection.sendall(json.dumps(request).encode() + b"\n")
            found: dict[str, Any] = json.loads(connection.makefile().readline())
            return found

    def value(self, address: str) -> Any:
        """As `axisgate var` reads it."""
        return self.ask(op="get", address=address).get("value")

    def until(self, condition: Callable[[], object], what: str, limit_s: float = LIMIT_S) -> None:
        """Waits; an AssertionError with the run's words when it does not come."""
        end = time.monotonic() + limit_s
        while not condition():
            assert time.monotonic() < end, f"not within {limit_s} s: {what}\n{self.words()}"
            time.sleep(0.01)


class Modules:
    """The partner of the I/O blocks of a bus: answers each SYNC with its own blocks and keeps what it receives, in a thread of its own."""

    def __init__(self, bus: str, says: dict[int, bytes]) -> None:
        self.says = dict(says)
        self.heard: dict[int, bytes] = {}
        self.speaking = True
        self._stop = threading.Event()
        self._port: CanPort = open_can(f"broker:{bus}")
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        while not self._stop.is_set():
            if not select.select([self._port], (), (), 0.05)[0]:
                continue
            for frame in self._port.receive():
                if frame.identifier == SYNC and self.speaking:
                    self._port.send([Frame(identifier, data) for identifier, data in self.says.items()])
                elif frame.identifier != SYNC:
                    self.heard[frame.identifier] = frame.data

    def close(self) -> None:
        self._stop.set()
        self._thread.join(5)
        self._port.close()


def cell_copy(name: str, folder: pathlib.Path, *changes: tuple[str, str], more: str = "") -> pathlib.Path:
    """A shipped cell with some words changed and tables added."""
    text = read_text(find_config(name, "cells"))
    for old, new in changes:
        assert text.count(old) == 1, f"{name}: {old!r} stands there {text.count(old)} times"
        text = text.replace(old, new)
    path = folder / f"{name}.toml"
    path.write_text(f"{text}\n{more}\n")
    return path


@contextlib.contextmanager
def running_joined(make: Callable[[pathlib.Path], pathlib.Path], name: str, *more: str, p5_ms: int = P5_MS) -> Iterator[JoinedRun]:
    """`make` writes the cell into a folder of the run; ended in order afterwards."""
    with runtime_folder() as folder:
        os.makedirs(folder / "run", mode=0o700, exist_ok=True)
        run = JoinedRun(make(folder), name, folder, "--p5", str(p5_ms), *more)
        try:
            yield run
        finally:
            run.stop()
