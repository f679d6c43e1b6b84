"""The real cycle process alone on its buses: the test is supervisor (regions) and drives (actual values), nothing else runs."""

import contextlib
import dataclasses
import os
import pathlib
import pickle
import select
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence

from drivers.ports.base import CanPort
from gateway.assembly.run import Instead, make_regions, plan_run
from gateway.cell_file.load import load_cell
from gateway.pure.image.records.cell import unpack_cell_state
from gateway.runtime.regions import RegionReader, fds_to_text
from protocols.base.machine import Frame

P5_MS = 20
ACTUAL = struct.Struct("<BBih")  # AX-001: status bits, fault code, position, torque
READY = 1  # bit 0 of an actual value's status


class CycleRun:
    """One cycle process; `actual` reads what it publishes."""

    def __init__(self, cell: pathlib.Path | str, buses: Mapping[str, str]) -> None:
        plan = plan_run(load_cell(str(cell)), simulated=True, instead=Instead(p5_ms=P5_MS))
        plan = dataclasses.replace(plan, buses=dict(buses))
        self.fds = make_regions(plan)
        self._plan_fd = os.memfd_create("plan", os.MFD_CLOEXEC)
        os.write(self._plan_fd, pickle.dumps(plan))
        child = next(child for child in plan.children if child.name == "cycle")
        wanted = {name: self.fds[name] for name in child.regions}
        command = [sys.executable, "-m", child.module, "--plan", str(self._plan_fd), "--fds", fds_to_text(wanted)]
        self.process = subprocess.Popen(command, pass_fds=(self._plan_fd, *wanted.values()), start_new_session=True)
        self._axes = RegionReader(self.fds["axes"], "axes")

    def actual(self) -> list[float]:
        """Position of each axis (m, rad) as published last; none before the first cycle."""
        payload = self._axes.read()
        return [] if payload is None else [axis.actual for axis in unpack_cell_state(payload).axes]

    def stop(self) -> int:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(10)
        for fd in (*self.fds.values(), self._plan_fd):
            os.close(fd)
        return code


@contextlib.contextmanager
def running_cycle(cell: pathlib.Path | str, buses: Mapping[str, str]) -> Iterator[CycleRun]:
    run = CycleRun(cell, buses)
    try:
        yield run
    finally:
        run.stop()


class Drives:
    """Answers every SYNC on one bus with 610, 620 ...; keeps what came, one list for each cycle."""

    def __init__(self, port: CanPort, positions: Sequence[int]) -> None:
        self.port = port
        self.cycles: list[list[Frame]] = []
        self._answer = [Frame(610 + 10 * n, ACTUAL.pack(READY, 0, position, 0)) for n, position in enumerate(positions)]

    def serve(self) -> None:
        """What waits now."""
        for frame in self.port.receive():
            if frame.identifier == 100:
                self.cycles.append([])
                self.port.send(self._answer)
            if self.cycles:
                self.cycles[-1].append(frame)


def serve(run: CycleRun, buses: Sequence[Drives], cycles: int, limit_s: float = 8.0) -> None:
    """Until each bus saw so many whole cycles (the running one not counted), or process or time ended: the test asserts what came."""
    until = time.monotonic() + limit_s
    while time.monotonic() < until and run.process.poll() is None and any(len(bus.cycles) <= cycles for bus in buses):
        select.select([bus.port for bus in buses], [], [], 0.1)
        for bus in buses:
            bus.serve()
