"""Emulated drives for one tool: a local bus and the drives of one [[bus]] on it, for as long as the tool lives."""

import contextlib
import os
import pathlib
import subprocess
import sys
import tempfile
from collections.abc import Iterator

from drivers.ports.base import PortError
from gateway.assembly.plant import write_settings
from gateway.pure.cell.cell import Bus, Cell

END_S = 10.0


MODULES = {"broker": "gateway.simulation.bus.broker", "emulator": "gateway.simulation.drives.process"}


@contextlib.contextmanager
def simulated_drives(cell: Cell, bus: Bus) -> Iterator[str]:
    """URL of the local bus the drives hang on; raises PortError when they do not start."""
    name = f"drives-{os.getpid()}"
    url = f"broker:{name}"
    with contextlib.ExitStack() as stack:
        folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="axisgate-drives-")))
        settings = write_settings(cell, bus.name, folder, bus.cycle_ms)
        stack.enter_context(_running("broker", "--name", name))
        stack.enter_context(_running("emulator", "--settings", str(settings), "--bus", url))
        yield url


@contextlib.contextmanager
def _running(process_of: str, *arguments: str) -> Iterator[None]:
    command = [sys.executable, "-m", MODULES[process_of], *arguments, "--die-with-parent"]
    # a session of its own: Ctrl-C is for the tool, which stops the drive first
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)
    assert process.stdout is not None
    try:
        if "ready\n" not in iter(process.stdout.readline, ""):
            raise PortError(f"the simulated {process_of} did not start; its output is above")
        yield
    finally:
        process.terminate()
        try:
            process.communicate(timeout=END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
