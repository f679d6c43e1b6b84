"""Figure drives.emulated_24: 24 CiA 402 drives in real time in one emulator process, every one moving; late answers by the bus' stamps.

The local bus has no wire model here: 24 drives at 4 ms are more than 1 Mbit/s carries, and it is the emulator that is measured.
"""

import contextlib
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator

from drivers.ports.can.broker import BrokerPort
from gateway.runtime.realtime import sleep_until
from hil_tests.lab.judges import bus_log as buslog
from hil_tests.lab.running.bus_running import running_bus
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid
from protocols.canopen.nmt import Command, command

Figure = dict[str, object]
DRIVES = 24
PERIOD_NS = 4_000_000
GOAL_PERCENT = 60.0
ENABLED = 0x27  # bits 0..3, 5, 6 of the statusword
SYNC = Frame(cobid.SYNC)
CSP = 8


class Master:
    """The least a master can be: set-up by SDO, then SYNC and set values on an absolute grid."""

    def __init__(self, port: BrokerPort) -> None:
        self._port = port
        self._due = time.monotonic_ns()
        self.status = dict.fromkeys(range(1, DRIVES + 1), 0)
        self.position = dict.fromkeys(range(1, DRIVES + 1), 0)
        self.target: dict[int, int] = {}

    def set_up(self) -> None:
        """CSP and synchronous PDOs in every node, then NMT start.  TimeoutError when a node does not take it."""
        for index, sub, value in ((0x1800, 2, 1), (0x1400, 2, 1), (0x6060, 0, CSP)):
            for node in self.status:
                self._write(node, bytes((0x2F, index & 255, index >> 8, sub, value, 0, 0, 0)))
        self._port.send([command(Command.START)])
        self._due = time.monotonic_ns()

    def _write(self, node: int, request: bytes) -> None:
        """Repeat until it is answered: a node that boots receives nothing."""
        for _ in range(500):
            self._port.send([Frame(cobid.sdo_request(node), request)])
            if any(frame.identifier == cobid.sdo_answer(node) and frame.data[0] == 0x60 for frame in self._hear(0.01)):
                return
        raise TimeoutError(f"node {node} does not take {request.hex(' ')}")

    def cycle(self, word: int, offset: int = 0) -> None:
        """SYNC and the set values for the next one in a burst; actual values of this one."""
        self._due += PERIOD_NS
        sleep_until(self._due)
        values = [self._set(node, word, offset) for node in self.status]
        self._port.send([SYNC, *values])
        self._hear(0.0028)

    def _set(self, node: int, word: int, offset: int) -> Frame:
        target = self.target.get(node, self.position[node]) + offset
        return Frame(cobid.rpdo(1, node), word.to_bytes(2, "little") + (target & 0xFFFFFFFF).to_bytes(4, "little"))

    def _hear(self, seconds: float) -> list[Frame]:
        time.sleep(seconds)
        frames = self._port.receive()
        for frame in frames:
            node = frame.identifier - cobid.tpdo(1, 0)
            if node in self.status:
                self.status[node] = int.from_bytes(frame.data[:2], "little")
                self.position[node] = int.from_bytes(frame.data[2:6], "little", signed=True)
        return frames

    def switch_on(self) -> None:
        """TimeoutError when one does not come."""
        for word, wanted in ((0x80, 0x40), (6, 0x21), (7, 0x23), (15, ENABLED)):
            for _ in range(1500):
                self.cycle(word)
                if all(status & 0x6F & wanted == wanted for status in self.status.values()):
                    break
            else:
                raise TimeoutError(f"not all drives show {wanted:02X}h: {self.status}")
        self.target = dict(self.position)


def emulated_24(seconds: float) -> list[Figure]:
    """One row; the share of a core over `seconds` with all axes moving."""
    with tempfile.TemporaryDirectory(prefix="axisgate-bench-") as name:
        folder = pathlib.Path(name)
        with running_bus(folder) as bus, emulator(folder, bus.name) as pid:
            master = Master(bus.port())
            master.set_up()
            master.switch_on()
            spent, began = -cpu_seconds(pid), time.monotonic_ns()
            for step in range(int(seconds * 1e9 / PERIOD_NS)):
                master.cycle(15, round(200_000 * (1 - math.cos(step * PERIOD_NS * 1e-9))))
            ended = time.monotonic_ns()
            share = 100.0 * (spent + cpu_seconds(pid)) / ((ended - began) * 1e-9)
            moved = min(abs(position - master.target[node]) for node, position in master.position.items())
            bus.stop()
            late = late_answers(bus.log_lines(), began, ended)
    met = share <= GOAL_PERCENT and late == 0 and moved > 100
    row: Figure = {"figure": "drives.emulated_24", "value": round(share, 2), "unit": "% of a core"}
    row |= {"reference": "late answers by the bus' stamps", "reference_value": late, "ratio": round(share / GOAL_PERCENT, 3)}
    row |= {"goal": f"<= {GOAL_PERCENT:g}, 0 late", "met": met}
    return [row]


def late_answers(lines: list[str], began: int, ended: int) -> int:
    """Actual values that are not there before the next SYNC, in whole cycles of the window."""
    missing, open_since = 0, 0
    seen: set[int] = set()
    answers = {cobid.tpdo(1, node) for node in range(1, DRIVES + 1)}
    for entry in buslog.read(lines):
        if not isinstance(entry, buslog.Logged) or not began <= entry.stamp_ns <= ended:
            continue
        if entry.identifier == cobid.SYNC:
            missing += len(answers - seen) if open_since else 0
            open_since, seen = entry.stamp_ns, set()
        elif entry.identifier in answers:
            seen.add(entry.identifier)
    return missing


def cpu_seconds(pid: int) -> float:
    """User and system time of a process so far."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(") ")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextlib.contextmanager
def emulator(folder: pathlib.Path, bus: str) -> Iterator[int]:
    """An emulator process with 24 nodes; its pid."""
    settings = folder / "drives.json"
    settings.write_text(
        json.dumps({"cycle_ms": PERIOD_NS / 1e6, "axes": {}, "nodes": {str(n): {"serial": n} for n in range(1, DRIVES + 1)}})
    )
    command = [
        sys.executable,
        "-m",
        "gateway.simulation.drives.process",
        "--settings",
        str(settings),
        "--bus",
        f"broker:{bus}",
        "--die-with-parent",
    ]
    process = subprocess.Popen([*command, "--record", str(folder / "drives.rec")], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        yield process.pid
    finally:
        process.terminate()
        process.communicate(timeout=10)
