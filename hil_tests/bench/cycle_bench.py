"""The cycle against its twin in C: same broker, same emulated drives, same priority, same waiting, 8 Modbus clients polling meanwhile.

Blocks alternate; what counts is read from the broker's log by its stamps (cycle_judge).  Only the time of computing comes from the
cycle's own trace, because nobody outside can see it.
"""

import contextlib
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

from pymodbus.exceptions import ConnectionException, ModbusIOException

from gateway.pure.image.records.trace import unpack_trace
from gateway.runtime.regions import RingReader, recv_fds
from gateway.runtime.supervisor_client import ask, wait_up
from gateway.tools.progress import Progress
from hil_tests.bench.cycle_judge import Verdict, judge, percentile
from hil_tests.bench.emulated_drives import cpu_seconds
from hil_tests.lab.partners import plc2 as modbus
from hil_tests.lab.partners.plc2 import ModbusPlc
from hil_tests.lab.running.scenario import free_port

Figure = dict[str, object]
ROOT = pathlib.Path(__file__).resolve().parents[2]
P5_MS = 4
SPIN_US, PRIORITY = 100, 40
SETTLE_S = 0.5  # of each block left out of the judgement: start-up is not the matter
CLIENTS, RATE_GOAL = 8, 10_000
SWITCH_ON_S = 10.0
NAME = "bench-cycle"


@dataclass(slots=True)
class Side:
    """What was seen of one side over all its blocks."""

    verdicts: list[Verdict] = field(default_factory=list)

    def total(self, name: str) -> int:
        return sum(getattr(verdict, name) for verdict in self.verdicts)

    def per_15000(self, name: str) -> float:
        cycles = self.total("cycles")
        return 15_000 * self.total(name) / cycles if cycles else float("nan")

    def median(self, name: str) -> float:
        """Over the blocks: one block with a guest from elsewhere on the machine does not decide."""
        return statistics.median(getattr(verdict, name) for verdict in self.verdicts) if self.verdicts else float("nan")


def figures(blocks: int = 6, seconds: float = 10.0) -> list[Figure]:
    """The seven figures of the bench; `blocks` of `seconds` for each side."""
    ours, theirs = Side(), Side()
    with tempfile.TemporaryDirectory(prefix="axisgate-bench-") as folder, running(pathlib.Path(folder)) as bench:
        repeated = alternate(bench, ours, theirs, blocks, seconds)
        compute, rates, faulted = sorted(bench.compute_ns), bench.rates, bench.faulted
    return report(ours, theirs, compute, rates, repeated, faulted)


def alternate(bench: "Bench", ours: Side, theirs: Side, blocks: int, seconds: float) -> int:
    """Blocks in turn until ours has its number; how many pairs were repeated.  Each pair is reported on stderr, as it takes a while."""
    repeated = done = 0
    bar = Progress(bench.name, blocks)
    while done < blocks and repeated <= blocks:
        bar(done)
        reference = bench.c_block(seconds)
        if any(one.incomplete > one.cycles // 50 for one in reference) or len(reference) < len(bench.logs):
            repeated += 1  # the reference itself failed: this stretch says nothing about anybody
            tell(f"{bench.name}: the reference failed, once more ({repeated})")
            continue
        mine = bench.our_block(seconds)
        if len(mine) < len(bench.logs):
            repeated += 1
            tell(f"{bench.name}: the cycle did not come up, or its drives not on, once more ({repeated})")
            continue
        theirs.verdicts += reference
        ours.verdicts += mine
        done += 1
        tell(f"{bench.name}: pair {done} of {blocks}, {seconds:g} s each, {bench.moves} moves; {counted(mine)}; in C {counted(reference)}")
    bar.close()
    return repeated


def counted(verdicts: list[Verdict]) -> str:
    """Of one block, all buses."""
    return f"skipped {sum(one.skipped for one in verdicts)}, incomplete {sum(one.incomplete for one in verdicts)}"


def tell(text: str) -> None:
    """Progress, beside the figures; over the bar, where there is one."""
    print(f"\r\x1b[K{text}" if sys.stderr.isatty() else text, file=sys.stderr, flush=True)


def report(ours: Side, theirs: Side, compute: list[int], rates: list[float], repeated: int, faulted: int) -> list[Figure]:
    """Figures with their goals.  faulted: blocks of ours in which a drive was in fault or off; they count all the same."""
    reference = f"the same cycle in C, {len(theirs.verdicts)} blocks in turn ({repeated} repeated)"

    def row(name: str, value: float, unit: str, other: float, goal: str, met: bool) -> Figure:
        ratio = round(value / other, 3) if other else None
        return {
            "figure": f"cycle.{name}", "value": round(value, 3), "unit": unit, "reference": reference,
            "reference_value": round(other, 3), "ratio": ratio, "goal": goal, "met": met,
        }  # fmt: skip

    found = []
    for name in ("skipped", "incomplete"):
        mine, other = ours.per_15000(name), theirs.per_15000(name)
        found.append(row(name, mine, "per 15,000 cycles", other, "<= C + 1 per 15,000 cycles", mine <= other + 1.0))
    p99, c99 = ours.median("sync_error_p99"), theirs.median("sync_error_p99")
    found.append(row("sync_error_p99", p99, "us", c99, "<= C + 30 us", p99 <= c99 + 30.0))
    p999, c999 = ours.median("sync_error_p999"), theirs.median("sync_error_p999")
    found.append(row("sync_error_p999", p999, "us", c999, "<= max(2 x C, 150 us)", p999 <= max(2 * c999, 150.0)))
    busy = percentile(compute, 0.999) / 1000
    limit = 0.25 * P5_MS * 1000
    found.append(row("compute_p999", busy, "us", limit, "<= 25 % of P5", busy <= limit) | {"reference": "a quarter of P5"})
    drives = row("drives_in_fault", faulted, "blocks", 0, "0", faulted == 0)
    found.append(drives | {"reference": f"{len(ours.verdicts)} blocks, drives on and moving in each"})
    rate = min(rates, default=0.0)
    found.append(row("modbus_rate", rate, "requests/s", RATE_GOAL, f">= {RATE_GOAL}", rate >= RATE_GOAL) | {"reference": "the goal"})
    return found


@dataclass(slots=True)
class Bench:
    """Broker, drives, services and load stay up; the two cycles take turns."""

    name: str
    logs: dict[str, pathlib.Path]  # bus -> the broker's log
    port: int
    plc: ModbusPlc
    p5_ms: int = P5_MS
    mask: int = 0x3F  # axes that move
    compute_ns: list[int] = field(default_factory=list)
    rates: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)  # share of a core the cycle took, per block
    moves: int = 0  # that ended well, in all blocks of ours
    faulted: int = 0  # blocks of ours in which a drive was in fault or off

    def our_block(self, seconds: float) -> list[Verdict]:
        """axisgate's cycle with drives on and a move under way; one verdict a bus."""
        self.request("release")
        if not wait_up(self.name, 20):
            return []
        if not self.switch_on(time.monotonic() + SWITCH_ON_S):
            self.faulted += 1
            self.request("hold")
            return []
        with ask(self.name, "regions") as connection:
            fds = recv_fds(connection)
        trace = RingReader(fds["trace"], "trace")
        start = time.monotonic_ns()
        stop = threading.Event()
        mover = threading.Thread(target=self._keep_moving, args=(stop,))
        watcher = threading.Thread(target=self._watch_drives, args=(stop, seen := [0]))
        mover.start()
        watcher.start()
        spent = -self._cpu_seconds()
        self._load(seconds)
        end = time.monotonic_ns()
        self.cpu.append((spent + self._cpu_seconds()) / ((end - start) * 1e-9))
        stop.set()
        mover.join()
        watcher.join()
        self.faulted += seen[0] > 0
        for _, record in trace.take(1 << 20):
            cycle = unpack_trace(record)
            if start + SETTLE_S * 1e9 < cycle.due < end:
                self.compute_ns.append(cycle.ready - cycle.answered)
        self.request("hold")
        return self._judge(start, end)

    def _cpu_seconds(self) -> float:
        return cpu_seconds(self._pid())

    def _pid(self) -> int:
        with ask(self.name, "status") as connection:
            processes = json.loads(connection.makefile().readline())["processes"]
        return int(next(process["pid"] for process in processes if process["name"] == "cycle"))

    def request(self, op: str) -> None:
        """Ask the supervisor to hold or release the cycle."""
        with ask(self.name, op, process="cycle") as connection:
            connection.recv(4096)

    def switch_on(self, until: float, stop: threading.Event | None = None) -> bool:
        """Control, drives on, referenced; again from the start while one is refused: the cycle or the drives may just be coming up."""
        codes = (modbus.REQUEST, modbus.OVERRIDE, modbus.RESET, modbus.ENABLE, modbus.REFERENCE)
        masks = (0, 0, 0, self.mask, self.mask)
        while time.monotonic() < until and not (stop and stop.is_set()):
            with contextlib.suppress(TimeoutError, ConnectionException, ModbusIOException):
                self.plc.wait(lambda s: True, 1)
                self.plc.synchronise()
                if all(self.plc.command(code, mask, timeout_s=5).state == modbus.DONE for code, mask in zip(codes, masks, strict=True)):
                    return True
            time.sleep(0.05)
        return False

    def _watch_drives(self, stop: threading.Event, seen: list[int]) -> None:
        """Counts how often a drive was in fault or off while the block ran; a figure of a cycle without moving drives says little."""
        while not stop.wait(0.05):
            status = self.plc.status
            if status is not None:
                seen[0] += bool(status.fault & self.mask) or status.enabled & self.mask != self.mask

    def _keep_moving(self, stop: threading.Event) -> None:
        """To and fro; a drive that was lost on a crowded machine is switched on again."""
        way = 100.0
        while not stop.is_set():
            ways = [way, way, way / 2, way / 5, way / 5, way / 3] * (self.mask.bit_count() // 6)
            try:
                ended = self.plc.command(modbus.PTP_RELATIVE, self.mask, 0.5, ways, timeout_s=5).state
            except (TimeoutError, ConnectionException, ModbusIOException):
                continue
            self.moves += ended == modbus.DONE
            if ended != modbus.DONE and not stop.is_set():
                self.switch_on(time.monotonic() + SWITCH_ON_S, stop)
            way = -way

    def c_block(self, seconds: float) -> list[Verdict]:
        """The twin (one for each bus), same load."""
        cycles = int(seconds * 1000 / self.p5_ms) + 1000 // self.p5_ms
        twins = []
        for bus in self.logs:
            command = [str(ROOT / "build/cycle_ref"), "--name", f"{self.name}-{bus}", "--period-us", str(self.p5_ms * 1000)]
            command += ["--cycles", str(cycles), "--spin-us", str(SPIN_US), "--priority", str(PRIORITY), "--enable"]
            twins.append(subprocess.Popen(command, stdout=subprocess.DEVNULL))
        time.sleep(0.4)
        start = time.monotonic_ns()
        self._load(seconds)
        end = time.monotonic_ns()
        for twin in twins:
            twin.terminate()
            twin.wait(5)
        return self._judge(start, end)

    def _load(self, seconds: float) -> None:
        command = [
            str(ROOT / "build/modbus_load"),
            "-p",
            str(self.port),
            "-n",
            str(CLIENTS),
            "-f",
            "4",
            "-a",
            "1000",
            "-c",
            "10",
            "-t",
            str(int(seconds)),
        ]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        with contextlib.suppress(ValueError, KeyError):
            result = json.loads(done.stdout)
            self.rates.append(result["requests"] / result["seconds"])

    def _judge(self, start: int, end: int) -> list[Verdict]:
        time.sleep(0.6)  # the broker writes its log in batches
        verdicts = []
        for log in self.logs.values():
            with log.open() as lines:
                found = judge(lines, self.p5_ms * 1_000_000, start + int(SETTLE_S * 1e9), end)
            verdicts += [max(found, key=lambda verdict: verdict.cycles)] if found else []
        return verdicts


@contextlib.contextmanager
def running(
    folder: pathlib.Path,
    cell: str = "demo",
    p5_ms: int = P5_MS,
    name: str = NAME,
    buses: tuple[str, ...] = ("drives",),
    kind: type[Bench] = Bench,
) -> Iterator[Bench]:
    """The run both sides share; everything ended and removed afterwards."""
    port = free_port(1502)
    command = [sys.executable, "-m", "gateway", "run", cell, "--sim", "--die-with-parent", "--name", name, "--p5", str(p5_ms)]
    command += ["--modbus-port", str(port), "--record", str(folder)]
    run = subprocess.Popen(command, stdout=subprocess.DEVNULL, start_new_session=True)
    plc = ModbusPlc("127.0.0.1", port)
    try:
        if not wait_up(name, 60):
            raise RuntimeError("the run for the bench did not come up")
        plc.start()
        logs = {bus: folder / f"bus-{bus}.log" for bus in buses}
        bench = kind(name, logs, port, plc, p5_ms, mask=(1 << 6 * len(buses)) - 1)
        bench.request("hold")
        yield bench
    finally:
        plc.stop()
        run.terminate()
        run.wait(20)
