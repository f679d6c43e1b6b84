"""ROBOTstar programs: steps a second, loading 10,000 steps, START to the first set value, an input to the output it switches; and the
figures of the integrated PLC, alone and in a running cell.
"""

import functools
import math
import time
from dataclasses import replace
from itertools import pairwise

from gateway.files.robotstar import words
from gateway.pure.cell.programs import Program
from gateway.pure.image.records.planner import ProgramFacts
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.memory import Memory, Source
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.virtual import VirtualCell
from hil_tests.bench import plc_bench, reis_cell_bench
from hil_tests.bench.figure_row import EMPTY_LOOP, Figure, loop_turns, row
from hil_tests.lab.virtual.reis_bench import CELL, SOURCE, ReisCell, at, main

TURNS, INSIDE, LOADED, EDGES, STARTS = 500_000, 4, 10_000, 100, 10
FAST, LOAD_S, START_MS, BIT_CYCLES = 1e6, 0.5, 100.0, 5.0
CYCLE_MS, OUTPUT = 4.0, 2009
DENSE, APART, ROUND, LONGEST_S = 10_000, 2.0, 60.0, 900.0  # positions; mm between them; radius of the circle they lie on
LOOP = f"""MPR "P"
VAR I1
VAR I2
COPY 0, I1
LABEL "A"
ADD 1, I1
COPY I1, I2
TEST #VARIABLE, I1, #<, {TURNS}, "A"
STOP
END
"""
PART = """WRITE_BIT #AUSGANG, Pegel: {0}, Byte: 1, Bit_Nr: 6
ADD 1, I1
TEST_BIT #EINGANG, #=1, Byte: 0, Bit_Nr: 6, Marke: "L{1}"
POSITION #N, X:{1}, Y:0, Z:300, A:0, B:0, C:180
LABEL "L{1}"
"""
FOLLOW = """LABEL "A"
WAIT_BIT #EINGANG, 1, 0, 0, 0.0, "A"
WRITE_BIT #AUSGANG, 1, 1, 0
WAIT_BIT #EINGANG, 0, 0, 0, 0.0, "A"
WRITE_BIT #AUSGANG, 0, 1, 0
BRANCH "A\""""


def memory_of(text: str) -> tuple[Memory, Faults]:
    """A memory of one program."""
    faults = Faults()
    return Memory.read([Source("P.MPR", text)], words(), faults), faults


def steps_s() -> float:
    """A loop of arithmetic in virtual time."""
    memory, _ = memory_of(LOOP)
    cell = VirtualCell(memory, MODES["test2"])
    began = time.perf_counter()
    cell.run([], None, "P")
    took = time.perf_counter() - began
    assert cell.end("P")["variables"] == {"I1": TURNS, "I2": TURNS}
    return TURNS * INSIDE / took


def load_s() -> float:
    """Reads, checks and makes ready to run."""
    parts = "".join(PART.format(number % 2, number) for number in range(LOADED // len(PART.splitlines())))
    text = f'MPR "P"\nVAR I1\nTOOL T\n{parts}END\n'
    began = time.perf_counter()
    memory, faults = memory_of(text)
    cell = VirtualCell(memory, MODES["auto"])
    check(memory, faults, cell.system.names())
    assert not faults.errors and cell.select("P")
    return time.perf_counter() - began


def _moved(cell: ReisCell, before: tuple[float, ...]) -> bool:
    return cell.joints[-1] != before


def _switched(cell: ReisCell, level: bool) -> bool:
    return bool(cell.control.flag_bytes()[OUTPUT] & 1) == level


def start_ms() -> float:
    """From START to the first set value that differs, the longest of some: cycles, and what all processes calculated in them."""
    cell = ReisCell(main(f"{at(520, 0, 480)}\n{at(500, 40, 500)}\nSTOP"))
    longest = 0.0
    for _ in range(STARTS):
        before, first = cell.joints[-1], len(cell.joints)
        began = time.perf_counter()
        run = cell.start()
        cell.until(functools.partial(_moved, cell, before))
        longest = max(longest, (len(cell.joints) - first) * CYCLE_MS + (time.perf_counter() - began) * 1e3)
        cell.ends(run)
    return longest


class Whole(ReisCell):
    """A cell whose program 1 is a text that the planner reads whole."""

    def __init__(self, text: str) -> None:
        self.text = text
        super().__init__(main("STOP"), cell=replace(CELL, program=(Program(1, "dense.txt"),)))
        self.bench.dispatcher.programs = {1: ProgramFacts("dense", self.mask)}

    def _text(self, number: int) -> str:
        return self.text


def dense(positions: int, speed: int) -> tuple[float, float]:
    """Times in s of a program of rounded positions on a circle and of the same blocks as a [[program]]; both begin with a PTP."""
    angles = [number * APART / ROUND for number in range(positions + 1)]
    way = [at(round(420 + ROUND * math.cos(angle), 3), round(ROUND * math.sin(angle), 3), 480) for angle in angles]
    settings = f"BEWEG_ART #LINEAR\nBAHN_GESCHW {speed}\nBAHN_RADIUS 1.0\nUEBERSCHL #EIN"
    cell = ReisCell(main("\n".join([way[0], settings, *way[1:], "STOP"])))
    cell.run(seconds=LONGEST_S)
    whole = Whole("\n".join(cell.lines))
    job = whole.bench.dispatcher.order_program(SOURCE, 1, whole.bench.now)
    whole.until(lambda: not job.open, LONGEST_S)
    return _moving_s(cell), _moving_s(whole)


def _moving_s(cell: ReisCell) -> float:
    moved = [number for number, (a, b) in enumerate(pairwise(cell.joints)) if a != b]
    return (moved[-1] - moved[0]) * CYCLE_MS / 1e3


def bit_cycles() -> float:
    """From an input of the image to the output the program switches, 99 of 100."""
    cell = ReisCell(main(FOLLOW))
    cell.start()
    cell.bench.run(0.1)
    found = []
    for edge in range(EDGES):
        level = edge % 2 == 0
        cell.give(0, 0, level)
        began = len(cell.joints)
        cell.until(functools.partial(_switched, cell, level))
        found.append(len(cell.joints) - began)
        cell.bench.run(0.02)
    return sorted(found)[EDGES * 99 // 100 - 1]


def run() -> list[Figure]:
    """The anchor is an empty loop of Python in the same run."""
    anchor, beside = loop_turns(), EMPTY_LOOP
    streamed, whole = dense(DENSE, 100)
    return [
        row("rsv.steps", steps_s(), "1/s", FAST, beside, anchor, at_least=True),
        row("rsv.load", load_s(), "s", LOAD_S, beside, anchor),
        row("rsv.dense", streamed / whole, f"of the same [[program]], {DENSE} positions {APART:g} mm apart", 1.01, "[[program]], s", whole),
        row("rsv.start_ms", start_ms(), "ms", START_MS, beside, anchor),
        row("rsv.bit", bit_cycles(), "cycles", BIT_CYCLES, beside, anchor),
        *plc_bench.run(),
        *reis_cell_bench.figures(),
    ]
