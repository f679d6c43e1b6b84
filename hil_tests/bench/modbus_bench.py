"""Our Modbus TCP server against the one pymodbus comes with: alone, next to a running 4 ms cell, and 10,000 connects that fail.

Blocks alternate, each side in a process of its own, the load is the C program.  Next to a cell, ours is the cell's own server in its
services process; theirs runs next to the same cell.
"""

import contextlib
import json
import os
import pathlib
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from gateway.pure.image.records.cell import unpack_cell_state
from gateway.runtime.regions import RegionReader, recv_fds
from gateway.runtime.supervisor_client import ask, wait_up
from gateway.tools.progress import Progress, steps
from hil_tests.lab.running.scenario import free_port

Figure = dict[str, object]
ROOT = pathlib.Path(__file__).resolve().parents[2]
LOAD = ROOT / "build/modbus_load"
BLOCKS = 5
NAME, P5_MS = "bench-modbus", 4
CONNECTS, GROWTH_LIMIT = 10_000, 1 << 20
SETTLING_S = 0.5  # after the last connection, before descriptors are counted


@dataclass(slots=True)
class Load:
    """What one block of one side gave."""

    rate: float = 0.0
    p99_us: float = 0.0


@dataclass(slots=True)
class Pair:
    """All blocks of both sides under one load."""

    ours: list[Load] = field(default_factory=list)
    theirs: list[Load] = field(default_factory=list)
    repeated: int = 0  # blocks in which a side or the load failed


def load(port: int, clients: int, seconds: float) -> Load | None:
    """One block; None when a request was not answered rightly."""
    command = [str(LOAD), "-p", str(port), "-n", str(clients), "-f", "4", "-a", "0", "-c", "10", "-t", str(seconds)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    with contextlib.suppress(ValueError, KeyError):
        told = json.loads(done.stdout)
        if not told["errors"] and told["requests"]:
            return Load(told["requests"] / told["seconds"], told["p99_us"])
    return None


def paired(ours: int, theirs: int, clients: int, seconds: float) -> Pair:
    """BLOCKS of each side in turn; who begins changes.  A block that failed is repeated and counted."""
    pair = Pair()
    turn, shown = 0, Progress(f"modbus, {clients} clients alone", BLOCKS)
    while len(pair.ours) < BLOCKS and pair.repeated < BLOCKS:
        shown(len(pair.ours))
        turn += 1
        first, second = (ours, theirs) if turn % 2 else (theirs, ours)
        one, other = load(first, clients, seconds), load(second, clients, seconds)
        if one is None or other is None:
            pair.repeated += 1
            continue
        pair.ours.append(one if turn % 2 else other)
        pair.theirs.append(other if turn % 2 else one)
    shown.close()
    return pair


def ratio(name: str, pair: Pair, goal: float) -> Figure:
    """Requests a second: the median of the ratios of neighbouring blocks."""
    ratios = [mine.rate / other.rate for mine, other in zip(pair.ours, pair.theirs, strict=True)]
    value = statistics.median(ratios) if ratios else 0.0
    other = _median(pair.theirs, "rate")
    return _row(name, round(value, 3), "x", round(other), round(value, 3), f">= {goal} x pymodbus", value >= goal)


def _median(loads: list[Load], name: str) -> float:
    return statistics.median(getattr(each, name) for each in loads) if loads else 0.0


def _row(name: str, value: float, unit: str, other: float, times: float | None, goal: str, met: bool) -> Figure:
    return {
        "figure": f"modbus.{name}", "value": value, "unit": unit, "reference": "pymodbus' own server",
        "reference_value": other, "ratio": times, "goal": goal, "met": met,
    }  # fmt: skip


@contextlib.contextmanager
def served(kind: str) -> Iterator[tuple[int, int]]:
    """Port and process of a server alone."""
    command = [sys.executable, "-m", "hil_tests.bench.modbus_served", kind]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        assert server.stdout is not None
        try:
            yield int(server.stdout.readline()), server.pid
        finally:
            server.kill()


def alone(seconds: float) -> list[Figure]:
    """Nothing else runs."""
    with served("ours") as (ours, _), served("pymodbus") as (theirs, _):
        eight, one, many = (paired(ours, theirs, clients, seconds) for clients in (8, 1, 64))
    mine, other = _median(many.ours, "p99_us"), _median(many.theirs, "p99_us")
    times = round(mine / other, 3) if other else None
    found = [ratio("alone_8", eight, 2.0), ratio("alone_1", one, 1.2)]
    return [*found, _row("alone_p99_64", mine, "us", other, times, "<= pymodbus' p99", 0 < mine <= other)]


@contextlib.contextmanager
def cell(folder: pathlib.Path) -> Iterator[tuple[int, Callable[[], int]]]:
    """A running demo cell at 4 ms: the port of its Modbus server, and how many cycles it has skipped."""
    port = free_port(1502)
    command = [sys.executable, "-m", "gateway", "run", "demo", "--sim", "--die-with-parent", "--name", NAME]
    command += ["--p5", str(P5_MS), "--modbus-port", str(port)]
    run = subprocess.Popen(command, stdout=subprocess.DEVNULL, start_new_session=True, cwd=folder)
    try:
        if not wait_up(NAME, 60):
            raise RuntimeError("the cell for the bench did not come up")
        with ask(NAME, "regions") as connection:
            axes = RegionReader(recv_fds(connection)["axes"], "axes")

        def skipped() -> int:
            payload = axes.read()
            return 0 if payload is None else unpack_cell_state(payload).skipped

        yield port, skipped
    finally:
        run.terminate()
        run.wait(20)


def beside(seconds: float) -> list[Figure]:
    """With a 4 ms cell running; skipped cycles are counted over the blocks of each side."""
    counts = {"ours": 0, "theirs": 0}
    with tempfile.TemporaryDirectory() as folder, cell(pathlib.Path(folder)) as (ours, skipped), served("pymodbus") as (theirs, _):
        pairs = []
        for clients in (8, 1):
            pair = Pair()
            for turn in steps(f"modbus, {clients} clients beside a cell", range(BLOCKS)):
                for side in (("ours", "theirs"), ("theirs", "ours"))[turn % 2]:
                    before = skipped()
                    block = load(ours if side == "ours" else theirs, clients, seconds)
                    counts[side] += skipped() - before
                    getattr(pair, side).append(block or Load())
            pairs.append(pair)
    eight, one = pairs
    p99 = _median(eight.ours, "p99_us")
    found = [_ratio_beside("cell_8", eight, 1.4), _ratio_beside("cell_1", one, 1.15)]
    found.append(_row("cell_p99", p99, "us", _median(eight.theirs, "p99_us"), None, "<= 3000 us", 0 < p99 <= 3000))
    extra = counts["ours"] <= counts["theirs"] + 1
    return [*found, _row("cell_skipped", counts["ours"], "cycles", counts["theirs"], None, "not more than beside pymodbus + 1", extra)]


def _ratio_beside(name: str, pair: Pair, goal: float) -> Figure:
    whole = Pair([*pair.ours], [each if each.rate else Load(float("inf")) for each in pair.theirs])
    return ratio(name, whole, goal)


# ------------------------------------------------------------------------------------------------------------- connects


def resident(pid: int) -> int:
    """Bytes of a process in memory."""
    return int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def descriptors(pid: int) -> int:
    return len(os.listdir(f"/proc/{pid}/fd"))


def failed_connects(port: int, count: int) -> None:
    """Partners that go wrong each in its way: reset at once, half a frame, a header that cannot be, closed without a word."""
    for n in range(count):
        with socket.create_connection(("127.0.0.1", port), timeout=10) as client:
            match n % 4:
                case 0:
                    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # a reset
                case 1:
                    client.sendall(b"\0\1\0\0\0\6\1")
                case 2:
                    client.sendall(b"\0\1\0\0\0\0")
                    client.recv(1)


def growth(count: int = CONNECTS) -> tuple[int, int]:
    """(bytes, descriptors) a server alone has grown by after so many failed connects; a tenth of them comes before, to warm up."""
    with served("ours") as (port, pid):
        failed_connects(port, max(count // 10, 200))
        kept = _settled(port, pid)
        memory = resident(pid)
        failed_connects(port, count)
        more = _settled(port, pid) - kept
        return resident(pid) - memory, more


def _settled(port: int, pid: int) -> int:
    """Descriptors once the last connections have been looked at: a request gets its answer, and the client's own end is seen as well."""
    for _ in range(3):
        assert load(port, 1, 0.1) is not None
    least, end = descriptors(pid), time.monotonic() + SETTLING_S
    while time.monotonic() < end:
        time.sleep(0.05)
        least = min(least, descriptors(pid))
    return least


def connects() -> list[Figure]:
    """10,000 of them."""
    grown, more = growth()
    words = f"after {CONNECTS} failed connects"
    memory = _row("connects_memory", grown, "bytes", GROWTH_LIMIT, None, f"< 1 MiB {words}", grown < GROWTH_LIMIT)
    fds = _row("connects_descriptors", more, "descriptors", 0, None, f"no more {words}", more == 0)
    return [row | {"reference": "the goal"} for row in (memory, fds)]


def figures(seconds: float = 2.0) -> list[Figure]:
    """All of them; `seconds` for each block."""
    return [*alone(seconds), *beside(seconds), *connects()]
