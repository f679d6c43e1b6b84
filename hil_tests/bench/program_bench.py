"""BAPS2 programs: statements a second in a dry run, how long 100,000 lines take to be read and checked; in a cell, the processor time of
permanent loops, how many blocks the interpreter hands on, and the figures of program_cell_figures.
"""

import pathlib
import time
import tomllib

from gateway.assembly.interpreter import robots_of_cell
from gateway.pure.languages.baps2.cell_run import CellRun
from gateway.pure.languages.baps2.dry_run import DryRun
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.words import Words, words_of
from gateway.pure.languages.base.hosting import PathState, View
from hil_tests.bench import program_cell_figures
from hil_tests.bench.figure_row import EMPTY_LOOP, Figure, loop_turns, row
from hil_tests.lab.virtual.baps2_bench import CELL, HEAD, VirtualPort

LINES, TURNS, INSIDE = 100_000, 400_000, 6
FAST, QUICK_S = 2e6, 3.0
LOOP = f"""PROGRAM P
INTEGER : I, J, K
BINARY : B
BEGIN
REPEAT {TURNS} TIMES
I = I + 1
J = I MOD 100
IF J = 50 THEN
K = K + J
B = K > J
J = K / 3
REPEAT_END
PROGRAM_END
"""
PART = "I = I + {0} * J\nIF I > 10 THEN R = R * 2.5\nMOVE LINEAR TO P{0}\nWAIT 0.5\n"
LOOPS, P5, CYCLES = 16, 4_000_000, 500
IO_LOOP = """;;PROCESS_KIND = PERMANENT
PROGRAM L{0}
INPUT : 1 = A, 2 = B, 3 = C
OUTPUT : {0} = X
BEGIN
AGAIN:
IF A = 1 AND B = 0 THEN X = 1 ELSE X = C
JUMP AGAIN
PROGRAM_END
"""
MOVES = (
    HEAD
    + """PROGRAM M
INTEGER : I
POINT : P
BEGIN
V = 500, R = 5
AGAIN:
I = (I + 1) MOD 100
P = (100 + I * 2, 60, 40, 12)
MOVE LINEAR VIA P
JUMP AGAIN
PROGRAM_END
"""
)
LOOPS_CPU, BLOCKS_S = 0.15, 500.0


def words() -> Words:
    """The shipped words."""
    root = pathlib.Path(__file__).resolve().parents[2]
    return words_of(tomllib.loads((root / "configs/languages/baps2.toml").read_text(encoding="utf-8"))["words"])


def statements_s() -> float:
    """A loop of arithmetic, checked to 32 bits, with its lines."""
    memory = Memory({"P.QLL": LOOP.encode()})
    library = Library(words(), memory)
    library.unit("P")
    run = DryRun(library, memory, Feed())
    began = time.perf_counter()
    run.run("P")
    return TURNS * INSIDE / (time.perf_counter() - began)


def parse_s() -> float:
    """Reads and checks one long program."""
    text = "PROGRAM P\nINTEGER : I, J\nREAL : R\nBEGIN\n" + "".join(PART.format(at % 50) for at in range(LINES // 4)) + "PROGRAM_END\n"
    library = Library(words(), Memory({}))
    began = time.perf_counter()
    library.check("P.QLL", text)
    return time.perf_counter() - began


class AtOnce(VirtualPort):
    """A cell whose axes are at the end of each block in the next turn."""

    def __init__(self) -> None:
        super().__init__(1)
        self.tickets: list[int] = []
        self.blocks = 0
        self.view = View(set=(100.0, 60.0, 40.0, 12.0))

    def ask_path(self, ticket: int, program: str, robot: int) -> None:
        self.tickets.append(ticket)

    def line(self, job: int, text: str) -> None:
        self.blocks += text.startswith("linear")


def hosted(port: VirtualPort, files: dict[str, str]) -> CellRun:
    """The interpreter's inside."""
    memory = Memory({name: text.encode() for name, text in files.items()})
    return CellRun(Library(words(), memory), memory, port, robots_of_cell(CELL), P5)


def loops_cpu() -> float:
    """Share of a processor that 16 permanent loops take which read three inputs and set an output, one turn each 4 ms."""
    port = VirtualPort(1)
    programs = hosted(port, {f"L{n}.QLL": IO_LOOP.format(n) for n in range(1, LOOPS + 1)})
    for n in range(1, LOOPS + 1):
        programs.start_run(f"L{n}", n, 0)
    began = time.process_time()
    for cycle in range(CYCLES):
        programs.turn(cycle * P5)
        port.said.clear()
    return (time.process_time() - began) / (CYCLES * P5 / 1e9)


def blocks_s() -> float:
    """Blocks a second, where the axes never make it wait: by the turns of 4 ms, or by its processor time where that is longer."""
    port = AtOnce()
    programs = hosted(port, {"M.QLL": MOVES})
    programs.start_run("M", 1, 0)
    began = time.process_time()
    for cycle in range(CYCLES):
        programs.turn(cycle * P5)
        while port.tickets:
            programs.path_given(port.tickets.pop(), 7)
        port.view = View(set=port.view.set, paths=(PathState(7, port.blocks),))
    return port.blocks / max(time.process_time() - began, CYCLES * P5 / 1e9)


def run(*, short: bool = False) -> list[Figure]:
    """All figures; the anchor is an empty loop of Python in the same run.  `short`: fewer repetitions in cell and editor."""
    anchor = loop_turns()
    return [
        row("program.statements_s", statements_s(), "1/s", FAST, EMPTY_LOOP, anchor, at_least=True),
        row("program.loops_cpu", loops_cpu(), "of a core", LOOPS_CPU, EMPTY_LOOP, anchor),
        row("program.blocks_s", blocks_s(), "1/s", BLOCKS_S, EMPTY_LOOP, anchor, at_least=True),
        row("program.parse_s", parse_s(), "s", QUICK_S, EMPTY_LOOP, anchor),
        *program_cell_figures.run(words(), LOOP, EMPTY_LOOP, anchor, short=short),
    ]
