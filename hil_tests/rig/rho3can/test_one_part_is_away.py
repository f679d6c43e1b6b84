"""One part of a running cell is away: it is told, the others go on, and it is good again by itself (AX-431; a figure of the drives)."""

import json
import os
import pathlib
import signal
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from gateway.files.find import find_config, read_text
from gateway.pure.image.records.cell import AxisFlag
from gateway.runtime.regions import RegionReader, recv_fds
from gateway.runtime.supervisor_client import ask
from gateway.simulation.drives.control import EmulatorControl
from hil_tests.lab.judges.bus_log import Logged
from hil_tests.lab.running.cell_running import CellRun, running_cell
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


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[CellRun]:
    with running_cell(str(cell(tmp_path_factory.mktemp("cell"))), "cellio", plc=False) as found:
        yield found


def test_a_silent_module_is_error_381_of_the_cell_while_it_is_silent(run: CellRun) -> None:
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
    assert told[0] == f"381 {words[0]}" and f"381 {words[0]}: recovered" in told


DEAD, BACK_S = 2, 2.0  # the third axis


def lost(run: CellRun) -> list[int]:
    return [n for n, axis in enumerate(run.state().axes[:6]) if axis.flags & AxisFlag.LOST]


def order(run: CellRun, what: str) -> None:
    control = EmulatorControl(f"{run.name}-drives")
    control.ask(what, axis=DEAD + 1)
    control.close()


def spoken(run: CellRun, since: Ns) -> dict[int, list[Ns]]:
    """Stamps of the actual values, by axis."""
    frames = [entry for entry in run.bus() if isinstance(entry, Logged) and entry.stamp_ns > since]
    return {n: [frame.stamp_ns for frame in frames if frame.identifier == 610 + 10 * n] for n in range(6)}


def test_the_others_speak_on_when_one_drive_is_dead_and_it_is_good_again_when_it_speaks(run: CellRun) -> None:
    assert wait(lambda: not lost(run))
    order(run, "power_off")
    off = time.monotonic_ns()
    told = wait(lambda: lost(run) == [DEAD])
    time.sleep(0.5)
    alone = lost(run)
    on = time.monotonic_ns()
    order(run, "power_on")
    back = wait(lambda: not lost(run))
    good = time.monotonic_ns()
    written = wait(lambda: all(stamps[-1:] > [good] for stamps in spoken(run, off).values()))  # the log is handed over in batches
    assert told and alone == [DEAD] and back and written
    stamps = spoken(run, off)
    between = {n: len([stamp for stamp in stamps[n] if stamp < on]) for n in stamps}
    assert between.pop(DEAD) <= 2, "what was on its way"
    assert min(between.values()) > 20 and max(between.values()) - min(between.values()) <= 2, between
    first = next(stamp for stamp in stamps[DEAD] if stamp > on)
    assert (good - first) / 1e9 < BACK_S
