"""A Reis cell in a run of its own: from the input frame of a coupler to the frame of the output that its PLC sets (`plc.reaction`), and
what PLC, interpreter and page cost the cycle (`plc.cycle_p99`, `plc.skipped`).

The bus is judged by the stamps of the broker, which neither the coupler nor the gateway gives.  The cycle is judged by its trace, in blocks
that alternate: PLC stopped, no robot program, nobody looks; PLC in RUN, a robot program that moves and counts, the page open.
"""

import contextlib
import pathlib
import random
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator

import configs
from gateway.simulation.drives.control import EmulatorControl
from gateway.tools.client import ToolClient
from gateway.tools.progress import steps
from hil_tests.bench.bus_listener import BusListener
from hil_tests.bench.figure_row import Figure, row
from hil_tests.bench.plc_bench import source
from hil_tests.bench.web_bench import BLOCK_S, block, watching
from hil_tests.lab.running.cell_running import CellRun, free_port, running_cell
from hil_tests.lab.running.web_running import WebAsk, until
from protocols.base.machine import Frame

CELL, NODE = "reis-palletiser", 20
INPUT, OUTPUT = 0x180 + NODE, 0x200 + NODE  # identifiers of the coupler's first PDOs
EDGES, BLOCKS, CYCLE_MS = 300, 5, 4
CYCLES, SHARE, MORE_US = 5.0, 1.2, 30.0
PATIENCE_S = 60.0
COUPLER = f"""
[[bus]]
name     = "can0"
port     = "sim"
protocol = "canopen"
cycle_ms = {CYCLE_MS}
heartbeat_ms = 50
[[io]]
name   = "button"
device = {{ type = "canopen-401", bus = "can0", node = {NODE}, input = 0 }}
signal = "io.button"
[[io]]
name   = "lamp"
device = {{ type = "canopen-401", bus = "can0", node = {NODE}, output = 0 }}
signal = "reis.output.3.0"
on_loss = 0
[[route]]
name = "button"
from = "io.button"
to   = "704"
on_loss = "zero"
"""
FOLLOWS = "U E0.0\n= A3.0\n"
LOOP = """MPR "LOOP"
VAR ILOOP
TOOL T
MARKE "WEITER"
POSITION #N, X:884, Y:0, Z:500, A:180, B:0, C:180
KOPIERE 0, ILOOP
MARKE "ZAEHLT"
ADD 1, ILOOP
SCHR_BIT #MERKER, 1, 50, 0
TESTE #VARIABLE, ILOOP, #<, 2000, "ZAEHLT"
POSITION #N, X:884, Y:60, Z:520, A:180, B:0, C:180
SPRUNG "WEITER"
ENDE
"""


@contextlib.contextmanager
def reis_run(name: str, *more: str) -> Iterator[CellRun]:
    """The shipped palletiser with a coupler, 1,000 commands of PLC program and a robot program that never ends."""
    cells = pathlib.Path(configs.__file__).parent / "cells"
    with tempfile.TemporaryDirectory(prefix="axg-reis-") as made:
        folder = pathlib.Path(made)
        shutil.copytree(cells / CELL, folder / CELL)
        text = (cells / f"{CELL}.toml").read_text().replace(', "88" = "plc" }', " }")
        (folder / f"{CELL}.toml").write_text(text + COUPLER)
        (folder / CELL / "LOOP.MPR").write_text(LOOP)
        (folder / CELL / "PLC" / "MANY.PLC").write_text(f"PLC MANY\n{source(1_000)}\n")
        plc = folder / CELL / "PLC" / "MAIN.PLC"
        plc.write_text(plc.read_text().removesuffix("END\n") + FOLLOWS + "SU MANY\nEND\n")
        with running_cell(str(folder / f"{CELL}.toml"), name, plc=False, p5_ms=CYCLE_MS, more=more) as run:
            yield run


# ---- reaction --------------------------------------------------------------------------------------------------------------
class Ear(BusListener):
    """Stamps of the frames in which bit 0 of the coupler's inputs and outputs changes."""

    def __init__(self, bus: str) -> None:
        self.seen: dict[int, list[tuple[int, int]]] = {INPUT: [], OUTPUT: []}
        super().__init__(bus)

    def _take(self, frame: Frame) -> None:
        found = self.seen.get(frame.identifier)
        if found is not None and frame.data and (not found or found[-1][1] != frame.data[0] & 1):
            found.append((frame.stamp_ns, frame.data[0] & 1))

    def last(self, identifier: int) -> tuple[int, int]:
        """Stamp and level of the last change."""
        return self.seen[identifier][-1] if self.seen[identifier] else (0, -1)


def reaction_cycles(edges: int = EDGES, seed: int = 1) -> list[float]:
    """Of each edge at the terminal, at random moments of the cycle: frame of the output minus frame of the input."""
    chance, found = random.Random(seed), []
    with reis_run("plcreaction") as run:
        ear, coupler = Ear(f"{run.name}-can0"), EmulatorControl(f"{run.name}-can0-io")
        try:
            in_run(run)
            until(lambda: _answers(coupler, ear), "the PLC's output is on the bus", PATIENCE_S)
            for number in steps("plc, reaction", range(edges)):
                level = number % 2
                time.sleep(chance.uniform(6.0, 8.0) * CYCLE_MS / 1000)
                coupler.ask("wire", node=NODE, channel=0, on=bool(level))
                until(_both(ear, level), f"edge {number} came back", PATIENCE_S)
                found.append((ear.last(OUTPUT)[0] - ear.last(INPUT)[0]) / 1e6 / CYCLE_MS)
        finally:
            ear.close()
    return found


def _both(ear: Ear, level: int) -> Callable[[], bool]:
    return lambda: ear.last(INPUT)[1] == level and ear.last(OUTPUT)[1] == level and ear.last(OUTPUT)[0] >= ear.last(INPUT)[0]


def _answers(coupler: EmulatorControl, ear: Ear) -> bool:
    """Both levels have been seen, the high one last."""
    for level in (0, 1):
        coupler.ask("wire", node=NODE, channel=0, on=bool(level))
        time.sleep(0.5)
        if ear.last(OUTPUT)[1] != level or ear.last(INPUT)[1] != level:
            return False
    return True


def in_run(run: CellRun) -> None:
    """The PLC scans."""
    with contextlib.closing(ToolClient(run.name)) as tool:
        until(lambda: tool.ask("plc", do="status")["state"] == "RUN", "the PLC is in RUN", PATIENCE_S)


# ---- cycle -----------------------------------------------------------------------------------------------------------------
@contextlib.contextmanager
def at_work(run: CellRun, web: WebAsk) -> Iterator[None]:
    """PLC, robot program and page."""
    words = [sys.executable, "-m", "gateway", "program", "run", run.cell, "LOOP", "--ready", "--name", run.name]
    with contextlib.closing(ToolClient(run.name)) as tool:
        tool.ask("plc", do="start", name="")
        in_run(run)
        program = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            until(lambda: runs(tool) or program.poll() is not None, "the robot program runs", PATIENCE_S)
            assert program.poll() is None, program.communicate()[0]
            with watching(web):
                yield
        finally:
            program.send_signal(signal.SIGINT)
            program.wait(PATIENCE_S)
        tool.ask("plc", do="stop")


def runs(tool: ToolClient) -> bool:
    """The robot program is a process, and has written its marker, which stays set after it."""
    return bool(tool.ask("process", do="list")["processes"]) and bool(tool.ask("get", address="M50.0")["value"])


def cycle_blocks(blocks: int = BLOCKS) -> tuple[list[tuple[float, int]], list[tuple[float, int]]]:
    """p99 of SYNC's lateness in us and skipped SYNCs of each block: at rest, at work."""
    port, idle, busy = free_port(), list[tuple[float, int]](), list[tuple[float, int]]()
    with reis_run("plccycle", "--web", str(port)) as run:
        web = WebAsk(port)
        until(web.answers, "the page answers", PATIENCE_S)
        in_run(run)
        with contextlib.closing(ToolClient(run.name)) as tool:
            tool.ask("plc", do="stop")
        for _ in steps("plc, cycle", range(blocks)):
            idle.append(block(run))
            with at_work(run, web):
                busy.append(block(run))
    return idle, busy


def figures(edges: int = EDGES, blocks: int = BLOCKS) -> list[Figure]:
    """plc.reaction, plc.cycle_p99, plc.skipped."""
    cycles = sorted(reaction_cycles(edges))
    idle, busy = cycle_blocks(blocks)
    quiet, loaded = (statistics.median(p99 for p99, _ in found) for found in (idle, busy))
    skips = [statistics.median(skipped for _, skipped in found) for found in (idle, busy)]
    beside = f"the same run at rest, us; {blocks} alternating blocks of {BLOCK_S:g} s"
    return [
        row(
            "plc.reaction",
            cycles[len(cycles) * 99 // 100 - 1],
            f"cycles of {CYCLE_MS} ms, p99",
            CYCLES,
            "its median",
            statistics.median(cycles),
        ),
        row("plc.cycle_p99", loaded, "us", SHARE * quiet + MORE_US, beside, quiet),
        row("plc.skipped", skips[1], "SYNC in a block", skips[0], beside.replace(", us", ""), skips[0]),
    ]
