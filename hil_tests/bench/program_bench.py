"""BAPS2 programs: statements a second in a dry run, and how long 100,000 lines take to be read and checked."""

import pathlib
import time
import tomllib

from gateway.pure.languages.baps2.dry_run import DryRun
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.words import Words, words_of
from hil_tests.bench.figure_row import Figure, row

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


def run() -> list[Figure]:
    """Both figures; the anchor is an empty loop of Python in the same run."""
    began = time.perf_counter()
    for _ in range(10_000_000):
        pass
    anchor = 10_000_000 / (time.perf_counter() - began)
    return [
        row("program.statements_s", statements_s(), "1/s", FAST, "turns of an empty Python loop a second", anchor, at_least=True),
        row("program.parse_s", parse_s(), "s", QUICK_S, "turns of an empty Python loop a second", anchor),
    ]
