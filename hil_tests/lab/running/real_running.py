"""The demo's cell as on metal: `axisgate run` without --sim, its drive bus on a port, drives of another process on the far bus."""

import contextlib
import pathlib
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence

from gateway.assembly.plant import write_settings
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.runtime.supervisor_client import wait_up
from gateway.tools.drives.first_enable import WORDS, confirm, needed
from hil_tests.lab.running.bus_running import Bus
from hil_tests.lab.running.cell_running import P5_MS, CellRun, runtime_folder

SAFETY = """
[safety]
emergency_stop  = "none: drives are emulated"
sto_wired       = false
guard           = "none: drives are emulated"
limit_switches  = "none: drives are emulated"
risk_assessment = "none: drives are emulated"
last_stop_test  = 2026-11-12
"""
EVIDENCE = 'layout_evidence = "captures/line1.pcapng"'
FAR, NAME = "far", "metal"
CYCLE_MS = 2 * P5_MS  # an adapter takes some milliseconds of each cycle


def real_cell(folder: pathlib.Path, port: str, *, evidence: bool) -> pathlib.Path:
    """Return the demo's cell file with real ports; everything else as shipped."""
    text = read_text(find_config("demo", "cells"))
    changes = [
        ('target           = "simulation"', 'target           = "machine"'),
        ('[[bus]]\nname     = "drives"\nport     = "sim"', f'[[bus]]\nname     = "drives"\nport     = "{port}"'),
        ("cycle_ms = 4 ", f"cycle_ms = {CYCLE_MS} "),
        ('axes     = "1..6"', f'axes     = "1..6"\n{EVIDENCE if evidence else ""}'),
    ]
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / "metal.toml"
    path.write_text(text + SAFETY)
    return path


class RealRun(CellRun):
    """Made by `running_real`; `bus()` is the run's own side, `far` the bus the drives are on."""

    def __init__(self, folder: pathlib.Path, port: str, far: Bus, *, evidence: bool = True, more: Sequence[str] = ()) -> None:
        self.far = far
        cell = real_cell(folder, port, evidence=evidence)
        known = load_cell(str(cell))
        axes = needed(known, simulated=False)
        assert not axes or confirm(known, axes, lambda _: f"{WORDS} A. Tester", lambda _: None)
        self.emulator = self._emulator(folder, cell)
        super().__init__(folder, str(cell), NAME, CYCLE_MS, more)

    def _emulator(self, folder: pathlib.Path, cell: pathlib.Path) -> "subprocess.Popen[bytes]":
        settings = write_settings(load_cell(str(cell)), "drives", folder, CYCLE_MS)
        command = [sys.executable, "-m", "gateway.simulation.drives.process", "--settings", str(settings), "--bus", f"broker:{FAR}"]
        command += ["--name", f"{NAME}-drives", "--record", str(folder / "emulator-drives.rec"), "--die-with-parent"]
        with (folder / "emulator.log").open("ab") as log:
            return subprocess.Popen(command, stdout=log, stderr=log)

    def _start(self) -> "subprocess.Popen[bytes]":
        command = [sys.executable, "-m", "gateway", "run", self.cell, "--name", self.name, "--modbus-port", str(self.port)]
        command += ["--record", str(self.folder), "--die-with-parent", *self.more]
        with (self.folder / "run.log").open("ab") as log:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
        until = time.monotonic() + 60.0
        while not wait_up(self.name, 1.0):
            if process.poll() is not None or time.monotonic() > until:
                process.kill()
                process.wait()
                raise AssertionError(f"the run did not come up:\n{self.words()}")
        return process

    def stop(self, number: int = signal.SIGTERM) -> int:
        try:
            return super().stop(number)
        finally:
            self.emulator.terminate()
            self.emulator.wait(10)


class Adapter:
    """The slcan station in front of the far bus; `pull` and `plug` it."""

    def __init__(self, link: pathlib.Path) -> None:
        self._command = [sys.executable, "-m", "hil_tests.lab.partners.slcan_station", "--link", str(link), "--bus", FAR]
        self.process = self.plug()

    def plug(self) -> "subprocess.Popen[str]":
        self.process = subprocess.Popen(self._command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None and self.process.stdout.readline() == "ready\n"
        return self.process

    def pull(self) -> None:
        self.process.kill()
        self.process.communicate()


@contextlib.contextmanager
def far_bus(folder: pathlib.Path) -> Iterator[Bus]:
    """The bus the drives are on, with a log of its own as witness."""
    bus = Bus(FAR, folder / "far.log")
    try:
        yield bus
    finally:
        bus.stop()


@contextlib.contextmanager
def running_real(*, adapter: bool, evidence: bool = True) -> Iterator[tuple[RealRun, Adapter | None]]:
    """A run with PLC 2 on the far bus: through an slcan adapter, or as one of its clients."""
    with runtime_folder() as folder, far_bus(folder) as far:
        link = folder / "adapter"
        station = Adapter(link) if adapter else None
        run = RealRun(folder, f"slcan:{link}" if adapter else f"broker:{FAR}", far, evidence=evidence)
        try:
            run.plc.start()
            run.plc.wait(lambda status: True, 10)
            run.plc.synchronise()
            yield run, station
        finally:
            run.stop()
            if station is not None:
                station.pull()
