"""A cable of the line process for each test, and stations of ours as processes at its far end."""

import os
import pathlib
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]


@dataclass(frozen=True, slots=True)
class Cable:
    """Ends as ports, and the record."""

    name: str
    near: str
    far: str
    record: pathlib.Path


def run(*words: str) -> "subprocess.Popen[str]":
    """A process of ours; returns when it said `ready`."""
    process = subprocess.Popen(
        [sys.executable, "-m", *words], cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=dict(os.environ)
    )
    assert process.stdout is not None
    said = process.stdout.readline().strip()
    assert said == "ready", f"{words}: {said!r}"
    return process


def end(process: "subprocess.Popen[str]") -> None:
    if process.stdin is not None:
        process.stdin.close()
    process.terminate()
    process.wait(10)
    if process.stdout is not None:
        process.stdout.close()


@pytest.fixture
def cable(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Cable]:
    monkeypatch.setenv("AXISGATE_RUNTIME", str(tmp_path / "run"))
    record = tmp_path / "line.rec"
    process = run("gateway.simulation.line.process", "--name", "tools", "--baud", "9600", "--record", str(record))
    folder = tmp_path / "run"
    yield Cable("tools", f"pty:{folder}/tools-a", f"pty:{folder}/tools-b", record)
    end(process)


@pytest.fixture
def station(cable: Cable) -> Iterator[Callable[..., None]]:
    """`station("good")` at the far end of the cable."""
    running = []

    def start(partner: str = "good", profile: str = "rho3", priority: str = "high") -> None:
        running.append(run("hil_tests.lab.partners.line_station", cable.far, partner, profile, priority))

    yield start
    for process in running:
        end(process)


def axisgate(*words: str, folder: pathlib.Path | None = None, seconds: float = 60) -> "subprocess.CompletedProcess[str]":
    """The command as a user types it."""
    command, environment = [sys.executable, "-m", "gateway", *words], os.environ | {"LC_ALL": "C.UTF-8"}
    return subprocess.run(command, cwd=folder or ROOT, capture_output=True, text=True, timeout=seconds, check=False, env=environment)
