"""Figures of the bridge: a value written at a Modbus command source, on the CAN bus of the I/O blocks, and back at the command source
(`route.one_way_io`, `route.both_ways_io`); and over a drive, `route.one_way` and `route.both_ways` (hil_tests.bench.route_drive).

The cell is the shipped CL300 cell with a Modbus command source; its modules show as inputs what they hear as outputs, at the next SYNC.
The bus is judged by the broker's own stamps, the command source by the client's clock; both are CLOCK_MONOTONIC.  `route.one_way_io`
begins with the client's write and ends with the frame that carries the value, `route.both_ways_io` ends when the client reads it back: the
time on loopback counts against us.  Writes fall at random moments of the cycle.
"""

import random
import statistics
import time

from gateway.tools.progress import steps
from hil_tests.bench import route_drive
from hil_tests.bench.bus_listener import BusListener
from hil_tests.lab.running.joined_running import OUT_BLOCK, JoinedRun, cell_copy, running_joined
from hil_tests.lab.running.modbus_running import RawClient
from protocols.base.machine import Frame

ONE_WAY_LIMIT, BOTH_WAYS_LIMIT = 2.0, 5.0  # cycles, p99
WRITTEN, READ_BACK = 5, 6  # holding registers: RC input bytes 10, 11 and 12, 13
BLOCKS, ROUNDS = 3, 400
VALUE = 6  # byte of the block: A 94 of A 88..95
SOURCE = """
[rc_inputs]
owner = { "10" = "door", "11" = "door" }
[[modbus]]
name = "door"
[[route]]
name = "out"
from = "AB 11"
type = "u8"
to   = "AB 94"
[[route]]
name = "back"
from = "EB 94"
type = "u8"
to   = "AB 12"
"""


def measure(rounds: int, p5_ms: int, seed: int = 1) -> tuple[list[float], list[float]]:
    """(one way, both ways) in cycles."""
    with running_joined(lambda folder: cell_copy("cl300-bits", folder, more=SOURCE), "routebench", p5_ms=p5_ms) as run:
        return _rounds(run, rounds, p5_ms, random.Random(seed))


class _Ear(BusListener):
    """First stamp of each value on the bus."""

    def __init__(self, bus: str) -> None:
        self.first: dict[int, int] = {}
        self._last = -1
        super().__init__(bus)

    def _take(self, frame: Frame) -> None:
        if frame.identifier == OUT_BLOCK and frame.data[VALUE] != self._last:
            self._last = frame.data[VALUE]
            self.first[self._last] = frame.stamp_ns

    def wait(self, value: int) -> None:
        """The frame is on the bus before the client reads it back; this thread may be later."""
        end = time.monotonic() + 5.0
        while value not in self.first:
            assert time.monotonic() < end, f"value {value} was never seen on the bus"
            time.sleep(0.001)


def _rounds(run: JoinedRun, rounds: int, p5_ms: int, chance: random.Random) -> tuple[list[float], list[float]]:
    ear, period = _Ear("routebench-io"), p5_ms * 1e6
    out, back = [], []
    try:
        with RawClient(run.port) as client:
            run.until(lambda: client.ask(f"06 {WRITTEN:04x} 00ff").startswith("06"), "the command source takes a write")
            run.until(lambda: _shown(client) == 255, "the route goes round")
            for n in range(rounds):
                value = n % 250 + 1
                time.sleep(chance.uniform(1.0, 2.0) * p5_ms / 1000)
                ear.first.pop(value, None)
                began = time.monotonic_ns()
                client.ask(f"06 {WRITTEN:04x} {value:04x}")
                while _shown(client) != value:
                    if time.monotonic_ns() - began > 1_000_000_000:
                        raise AssertionError(f"value {value} did not come back within 1 s\n{run.words()}")
                ended = time.monotonic_ns()
                ear.wait(value)
                back.append((ended - began) / period)
                out.append((ear.first[value] - began) / period)
    finally:
        ear.close()
    return out, back


def _shown(client: RawClient) -> int:
    return int(client.ask(f"03 {READ_BACK:04x} 0001").split()[2], 16)


def p99(values: list[float]) -> float:
    return sorted(values)[max(0, round(0.99 * len(values)) - 1)]


def figures(blocks: int = BLOCKS, rounds: int = ROUNDS, p5_ms: int = 4) -> list[dict[str, object]]:
    """Median over the blocks of each block's p99."""
    found = []
    for seed in steps("route", range(blocks)):
        out, back = measure(rounds, p5_ms, seed)
        orders, _, seen = route_drive.measure(max(1, rounds // 4), p5_ms, seed)
        found.append((orders, seen, out, back))
    rows: list[dict[str, object]] = []
    goals = (
        ("route.one_way", ONE_WAY_LIMIT), ("route.both_ways", BOTH_WAYS_LIMIT),
        ("route.one_way_io", ONE_WAY_LIMIT), ("route.both_ways_io", BOTH_WAYS_LIMIT),
    )  # fmt: skip
    for n, (name, limit) in enumerate(goals):
        worst = [p99(block[n]) for block in found]
        value = statistics.median(worst)
        rows.append(
            {
                "figure": name,
                "value": round(value, 2),
                "unit": f"cycles of {p5_ms} ms, p99",
                "reference": "its median",
                "reference_value": round(statistics.median(each for block in found for each in block[n]), 2),
                "ratio": "",
                "goal": f"<= {limit:g}",
                "met": value <= limit,
            }
        )
    return rows
