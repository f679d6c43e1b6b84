"""380 and 381 of a running cell: a module that is silent stands among the cell's errors, and is good again by itself (AX-431)."""

import json
import os
import pathlib
import signal
import time
from collections.abc import Callable
from typing import Any

from gateway.files import find_config, read_text
from gateway.image import RegionReader, recv_fds
from gateway.processes.supervisor import ask
from hil_tests.lab.cell_running import CellRun, running_cell
from hil_tests.rig.rho3can.test_11_1_two_controls import IO_BUS
from protocols.base.machine import Ns

LIMIT_S = 15.0


def cell(folder: pathlib.Path) -> pathlib.Path:
    path = folder / "withio.toml"
    blocks = {"inputs": "{ bus = 2, start = 88, length = 4, id = 541 }", "outputs": "{ bus = 2, start = 92, length = 4, id = 471 }"}
    path.write_text(read_text(find_config("demo", "cells")) + IO_BUS.format(count=1, **blocks))
    return path


def wait(condition: Callable[[], bool]) -> bool:
    end = time.monotonic() + LIMIT_S
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.05)
    return True


def modules(run: CellRun) -> int:
    """The process of the emulated I/O modules."""
    pids = {name: row["pid"] for name, row in run.processes().items()}
    (pid,) = [pid for name, pid in pids.items() if "io" in name and "drives" not in name and "broker" not in name]
    return int(pid)


def errors(run: CellRun) -> list[dict[str, Any]]:
    fds: dict[str, int] = {}
    try:
        with ask(run.name, "regions") as connection:
            fds = recv_fds(connection)
        payload = RegionReader(fds["links"], "links").read()
    finally:
        for fd in fds.values():
            os.close(fd)
    return list(json.loads((payload or b"{}").rstrip(b"\0 ") or b"{}").get("errors", []))


def entries(run: CellRun, since: Ns) -> list[str]:
    return [str(entry["text"]) for entry in run.journal("error") if entry["ns"] > since and entry["code"] == 381]


def test_a_silent_module_is_error_381_of_the_cell_while_it_is_silent(tmp_path: pathlib.Path) -> None:
    with running_cell(str(cell(tmp_path)), "cellio", plc=False) as run:
        good = wait(lambda: 381 not in [row["code"] for row in errors(run)])
        since, pid = time.monotonic_ns(), modules(run)
        os.kill(pid, signal.SIGSTOP)
        try:
            stands = wait(lambda: 381 in [row["code"] for row in errors(run)])
            words = [row["text"] for row in errors(run) if row["code"] == 381]
        finally:
            os.kill(pid, signal.SIGCONT)
        again = wait(lambda: 381 not in [row["code"] for row in errors(run)])
        told = entries(run, since)
    assert good and stands and again
    assert words == ["no transm. CAN2 I1: no data from input block 1 on CAN 2: check plug, cable, module or the coupled control"]
    assert told[0] == f"381 {words[0]}" and f"381 {words[0]}: good again" in told
