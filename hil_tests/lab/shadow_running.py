"""A shadow beside a run that stands for the old control: its serial line tapped, its drive bus listened to, PLC 1 of the demo at work."""

import contextlib
import json
import os
import pathlib
import select
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

from drivers.ports.base import PortError, runtime_dir
from drivers.ports.linewire import parse_format
from drivers.ports.pty import PtyPort
from gateway.files import find_config
from hil_tests.lab.buslog import Logged, Remark, frames, read, senders
from hil_tests.lab.cell_running import CellRun, runtime_folder
from hil_tests.lab.plc1 import S5Plc
from hil_tests.lab.pty_master import PtyMaster

LINE = "plc1"
PATIENCE_S = 180.0
ASSUME = '[rc_inputs]\nassume = ["EMSTOP_OK_RCI", "CTRL_ALLOW_RCI", "FEED_ALLOW_RCI", "FEED_HOLD_N_RCI", "TRAVEL_ALLOW_RCI"]\n'


def old_cell(folder: pathlib.Path) -> pathlib.Path:
    """The demo's cell without its second PLC: everything comes over the tapped line."""
    text = pathlib.Path(find_config("demo", "cells")).read_text()
    head, owner = text.split("[rc_inputs]", 1)
    head += ASSUME + owner[owner.index("# ---- PLC 1") :]
    before, modbus = head.split("[[modbus]]", 1)
    path = folder / "old.toml"
    path.write_text(before + modbus[modbus.index("# ---- drives") :])
    return path


@dataclass
class Wire:
    """PLC - wire - old control; what passes in either direction is shown to a tap."""

    control: PtyPort
    plc: PtyMaster = field(default_factory=PtyMaster)
    taps: tuple[PtyMaster, PtyMaster] = field(default_factory=lambda: (PtyMaster(), PtyMaster()))
    said_by_shadow: bytearray = field(default_factory=bytearray)  # whatever came out of the taps' listening ends
    _stop: threading.Event = field(default_factory=threading.Event)

    def run(self) -> None:
        """In a thread of its own."""
        ends = (self.plc, self.control, *self.taps)
        with contextlib.suppress(PortError):
            while not self._stop.is_set():
                select.select([end.fileno() for end in ends], [], [], 0.05)
                for source, target, tap in ((self.plc, self.control, self.taps[0]), (self.control, self.plc, self.taps[1])):
                    for item in source.read():
                        if isinstance(item, bytes) and item:
                            target.write(item)
                            tap.write(item)
                for tap in self.taps:
                    self.said_by_shadow += b"".join(item for item in tap.read() if isinstance(item, bytes))

    def close(self) -> None:
        self._stop.set()


class Old:
    """The old control: a real run with its PLC."""

    def __init__(self, run: CellRun, wire: Wire, plc: S5Plc) -> None:
        self.run, self.wire, self.plc = run, wire, plc
        self.senders: dict[int, int] = {}

    def frames_of(self, pid: int) -> list[Logged]:
        """What the process of that pid sent on the bus."""
        text = (self.run.folder / "bus-drives.log").read_text().splitlines(keepends=True)
        entries = list(read(text))
        numbers = {number for number, who in senders([e for e in entries if isinstance(e, Remark)]).items() if who == pid}
        assert numbers, f"process {pid} never was on the bus"
        return [entry for entry in frames(text) if entry.sender in numbers]


class Shadow:
    """`axisgate run CELL --shadow` as a process."""

    def __init__(self, old: Old, cell: pathlib.Path, name: str) -> None:
        self.folder, self.name = old.run.folder, name
        taps = ",".join(f"pty:{tap.path}" for tap in old.wire.taps)
        command = [sys.executable, "-m", "gateway", "run", str(cell), "--shadow", "--tap", f"{LINE}={taps}", "--json"]
        command += ["--bus", f"broker:{old.run.name}-drives", "--p5", str(old.run.p5_ms), "--name", name, "--report", name]
        self._log = (self.folder / f"{name}.log").open("wb")
        self.process = subprocess.Popen(
            [*command, "--die-with-parent"], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self._log
        )

    def kept(self, name: str) -> dict[str, object]:
        """What one of its processes has found so far."""
        with contextlib.suppress(OSError, ValueError):
            found = json.loads((runtime_dir() / self.name / name).read_text())
            return found if isinstance(found, dict) else {}
        return {}

    def end(self) -> tuple[int, dict[str, object]]:
        """Exit code and report."""
        self.process.terminate()
        out, _ = self.process.communicate(timeout=PATIENCE_S)
        self._log.close()
        assert out, (self.folder / f"{self.name}.log").read_text()
        found = json.loads(out)
        assert isinstance(found, dict)
        return self.process.returncode, found


@contextlib.contextmanager
def old_control(name: str = "old") -> Iterator[Old]:
    """Running, its PLC sending and fetching, drives off."""
    with runtime_folder() as folder:
        run = CellRun(folder, str(old_cell(folder)), name)
        wire = Wire(PtyPort(os.fspath(runtime_dir() / f"{name}-{LINE}-a"), parse_format("9600 8E1")))
        plc = S5Plc(wire.plc.path, [axis.name for axis in run.demo.axis])
        passing = threading.Thread(target=wire.run, daemon=True)
        passing.start()
        plc.start()
        try:
            plc.wait_cycles(2)
            yield Old(run, wire, plc)
        finally:
            plc.stop()
            wire.close()
            passing.join(5)
            run.stop()


def until(holds: object, what: str) -> None:
    """Waits for it; `holds` is asked again and again."""
    assert callable(holds)
    end = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end, what
        time.sleep(0.05)
