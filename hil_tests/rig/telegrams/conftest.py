"""A running cell with the host line of users.md 3.5, and the host: a station by hand from the manual's text on the line's other pty."""

import contextlib
import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from drivers.ports.base import runtime_dir
from drivers.ports.open import open_bytes
from gateway.files.find import find_config
from gateway.runtime.supervisor_client import wait_up
from hil_tests.lab.partners.by_hand_partner import ByHandPartner, Gave, Got
from hil_tests.lab.partners.sync_line import SyncLine


def host_cell() -> str:
    """The shipped cell; its [[line]] and [[telegram]] tables are the example of users.md 3.5, word for word."""
    return find_config("host-telegrams", "cells").read_text(encoding="utf-8")


Running = Callable[[str], str]


class HostRun:
    """The cell, and the host on its line."""

    def __init__(self, name: str, record: pathlib.Path) -> None:
        self.name, self.record = name, record
        self.host = ByHandPartner(priority=True)  # the cell's output_timeout is -1: it has none
        self.line = SyncLine(open_bytes(f"pty:{runtime_dir() / f'{name}-V24_1-a'}", "9600 8E1"), self.host)

    def var(self, *arguments: str) -> dict[str, Any]:
        """`axisgate var NAME [--set VALUE]` over its socket; the line is served meanwhile by nobody."""
        request = (
            {"op": "get", "address": arguments[0]} if len(arguments) == 1 else {"op": "set", "address": arguments[0], "value": arguments[1]}
        )
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as link:
            link.settimeout(5.0)
            link.connect(str(runtime_dir() / f"{self.name}-services.sock"))
            link.sendall(json.dumps(request).encode() + b"\n")
            answer = json.loads(link.makefile().readline())
        assert isinstance(answer, dict)
        return answer

    def gives(self, block: bytes) -> bool:
        """The host sends a block; True: acknowledged."""
        before = len(self.line.events)
        self.host.give(block, time.monotonic_ns())
        assert self.line.run_until(lambda: any(isinstance(e, Gave) for _, e in self.line.events[before:]), 10.0), "the cell never answered"
        return next(e.acknowledged for _, e in self.line.events[before:] if isinstance(e, Gave))

    def got(self, count: int, limit_s: float = 5.0) -> list[bytes]:
        """What the host has received, as soon as it is `count` blocks."""
        self.line.run_until(lambda: len(self._got()) >= count, limit_s)
        return self._got()

    def _got(self) -> list[bytes]:
        return [event.data for _, event in self.line.events if isinstance(event, Got)]

    def until(self, name: str, key: str, value: object, limit_s: float = 5.0) -> dict[str, Any]:
        """The variable once it has that value; the latest one when it never has."""
        answers = [self.var(name)]

        def there() -> bool:
            answers[0] = self.var(name)
            return bool(answers[0].get(key) == value)

        self.line.run_until(there, limit_s)
        return answers[0]


@contextlib.contextmanager
def cell_run(cell: str, name: str, record: pathlib.Path, sim: tuple[str, ...] = ("--sim",)) -> Iterator[None]:
    """`axisgate run CELL --sim --record FOLDER` as a process."""
    command = [sys.executable, "-m", "gateway", "run", cell, *sim, "--name", name, "--record", str(record), "--die-with-parent"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    try:
        assert wait_up(name, 20.0), process.communicate(timeout=5)[0] if process.poll() is not None else "not up in 20 s"
        yield
    finally:
        process.terminate()
        process.communicate(timeout=15)


@pytest.fixture
def running(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Running]:
    """running(CELL) runs a cell file or shipped cell under its own name, in a runtime folder of this test."""
    with contextlib.ExitStack() as stack:
        short = stack.enter_context(tempfile.TemporaryDirectory(prefix="ag"))  # a socket's path has 107 bytes
        monkeypatch.setitem(os.environ, "AXISGATE_RUNTIME", f"{short}/run")

        def start(cell: str) -> str:
            name = pathlib.Path(cell).stem
            stack.enter_context(cell_run(cell, name, tmp_path / "record"))
            return name

        yield start


@pytest.fixture
def start(tmp_path: pathlib.Path, running: Running) -> Iterator[Callable[[str], HostRun]]:
    """start(text of a cell file) runs it and gives the host's hands."""
    runs: list[HostRun] = []

    def begin(text: str) -> HostRun:
        cell = tmp_path / "tg.toml"
        cell.write_text(text, encoding="utf-8")
        runs.append(HostRun(running(str(cell)), tmp_path / "record"))
        return runs[-1]

    yield begin
    for run in runs:
        run.line.close()
