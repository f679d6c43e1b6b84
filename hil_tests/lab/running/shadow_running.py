"""A shadow next to a run that represents the old controller: its serial line tapped, its Modbus captured, its drive bus listened to; both
PLCs of the demo at work.
"""

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
from drivers.ports.serial.line_format import parse_format
from drivers.ports.serial.pty import PtyPort
from hil_tests.lab.judges.bus_log import Logged, Remark, frames, read, senders
from hil_tests.lab.partners.captured import CapturedWire
from hil_tests.lab.partners.plc1 import S5Plc
from hil_tests.lab.partners.pty_master import PtyMaster
from hil_tests.lab.running.cell_running import CellRun, CyclicPlc, runtime_folder

LINE, SERVER = "plc1", "plc2"
PATIENCE_S = 180.0


@dataclass
class Wire:
    """PLC - wire - old controller; what passes in either direction is shown to a tap."""

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
    """The old controller: a real run with its PLCs."""

    def __init__(self, run: CellRun, wire: Wire, plc: S5Plc, network: CapturedWire, plc2: CyclicPlc) -> None:
        self.run, self.wire, self.plc, self.network, self.plc2 = run, wire, plc, network, plc2
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

    def __init__(self, old: Old, cell: pathlib.Path | str, name: str, *more: str) -> None:
        self.folder, self.name = old.run.folder, name
        taps = ",".join(f"pty:{tap.path}" for tap in old.wire.taps)
        command = [sys.executable, "-m", "gateway", "run", str(cell), "--shadow", "--tap", f"{LINE}={taps}", "--json"]
        command += ["--tap", f"{SERVER}={old.network.fifo},127.0.0.1:{old.network.server}", *more]
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
def old_control(cell: str = "demo", name: str = "old") -> Iterator[Old]:
    """Running, its PLCs asking, drives off."""
    with runtime_folder() as folder:
        run = CellRun(folder, cell, name)
        network = CapturedWire(run.port, folder / "plc2.pcap")
        plc2 = run.plc = CyclicPlc("127.0.0.1", network.port)
        wire = Wire(PtyPort(os.fspath(runtime_dir() / f"{name}-{LINE}-a"), parse_format("9600 8E1")))
        plc = S5Plc(wire.plc.path, [axis.name for axis in run.demo.axis])
        passing = threading.Thread(target=wire.run, daemon=True)
        passing.start()
        plc.start()
        plc2.start()
        try:
            plc.wait_cycles(2)
            plc2.wait(lambda status: True, PATIENCE_S)
            plc2.synchronise()
            yield Old(run, wire, plc, network, plc2)
        finally:
            plc.stop()
            wire.close()
            passing.join(5)
            run.stop()
            network.close()


def until(holds: object, what: str) -> None:
    """Waits for it; `holds` is asked again and again."""
    assert callable(holds)
    end = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end, what
        time.sleep(0.05)
