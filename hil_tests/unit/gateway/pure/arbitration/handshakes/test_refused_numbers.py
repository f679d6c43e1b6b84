"""AX-610: a refused, torn or void number refuses the whole command, under every handshake pattern, and nothing moves."""

import struct

import pytest

from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.data_blocks import BlockHost, DataBlocks
from gateway.pure.image.reasons import CommandState, Reason
from gateway.services.sources.rk512 import compile_block, compile_handshake, compile_pattern
from hil_tests.lab.virtual.cell_bench import CellBench
from protocols.base.step5 import Step5Type, encode

DEMO = read_text(find_config("demo", "cells"))
BEFORE, BEHIND = DEMO[: DEMO.index("[[db]]")], DEMO[DEMO.index("# ---- PLC 2") :]
BY_BIT, BY_NUMBER = ("start-busy-done", "level-ack", "toggle"), ("strobe-parity", "number-select")
PATTERNS = (*BY_BIT, *BY_NUMBER)
NAN, INFINITE, NO_KG = bytes.fromhex("7FC00000"), bytes.fromhex("FF800000"), bytes.fromhex("44961000")
ANSWERS = (8, "move.busy"), (9, "move.done"), (15, "cell.error")
IEEE_2 = bytes.fromhex("40000000")  # read as KG it would be 0
POSITIONS = """
[[position]]
number = 3
at = { A1 = 150.0, A2 = 150.0 }
speed = 50.0
[[position]]
number = 5
at = { A1 = 250.0, A2 = 250.0 }
speed = 50.0
"""
FEED_ALLOW = "entries = [\n"


def cell_text(pattern: str) -> str:
    """The demo cell with REAL and KG targets and another handshake."""
    number = pattern in BY_NUMBER
    shake = f'[handshake.move]\npattern = "{pattern}"\ndone = "DB11.D0.9"\nrefused = "DB11.D0.15"\n'
    shake += 'start = "DB10.D0.8"\n' if pattern != "number-select" else ""
    shake += 'busy = "DB11.D0.8"\n' if pattern == "start-busy-done" else ""
    entries = [
        '{ at = "DW 31", type = "KF", to = "line.plc1.life" }',
        '{ at = "D 0.1", type = "bit", to = "cell.feed_allow" }',
        '{ at = "D 0.5", type = "bit", to = "cell.resume", edge = "rising" }',
        '{ at = "DR 1", type = "KH", to = "cell.override", unit = "1 %", min = 0, max = 100 }',
        '{ at = "DD 2", type = "REAL", to = "move.A1.target", unit = "1 mm" }',
        '{ at = "DD 4", type = "KG", to = "move.A2.target", unit = "1 mm" }',
        '{ at = "DW 8", type = "KF", to = "move.speed", unit = "1 %", min = 1, max = 100 }',
        *(['{ at = "D 0.8", type = "bit", to = "move.start" }'] if pattern != "number-select" else []),
        *(['{ at = "DW 6", type = "KF", to = "move.number", min = 0, max = 8 }'] if number else []),
        *(['{ at = "D 0.9", type = "bit", to = "move.parity" }'] if pattern == "strobe-parity" else []),
    ]
    listed = ",\n".join(entries)
    blocks = f'[[db]]\nnumber = 10\nwords = 32\nwriter = "plc"\nentries = [\n{listed},\n]\n'
    blocks += '[[db]]\nnumber = 11\nwords = 4\nwriter = "axisgate"\nentries = [\n'
    blocks += ",\n".join(f'{{ at = "D 0.{bit}", type = "bit", from = "{name}" }}' for bit, name in ANSWERS) + ",\n]\n"
    return BEFORE + blocks + shake + (POSITIONS if number else "") + BEHIND


class Plc:
    """A PLC behind its data command source, the office and the emulated drives of the demo cell; drives on, referenced, at 0."""

    def __init__(self, pattern: str) -> None:
        self.pattern, self.toggle, self.told = pattern, False, list[str]()
        cell = load_cell("numbers.toml", cell_text(pattern))
        self.bench = CellBench(cell=cell).ready()
        shake = compile_handshake(cell.handshake["move"])
        host = BlockHost(self._command, self._value, lambda name, words: self.told.append(words), lambda name, bit: None, self._refuse)
        blocks, axes = [compile_block(db) for db in cell.db], [axis.name for axis in cell.axis]
        self.source = DataBlocks(blocks, axes, shake, host, selected=compile_pattern(cell))
        self.words = bytearray(64)
        self.put(a1=100.0, a2=100.0, speed=50, override=100)
        self.send()

    @staticmethod
    def _value(name: str) -> float:
        return float(name == "cell.control")

    def _command(self, command: Command) -> None:
        self.bench.dispatcher.command(1, command, self.bench.now)
        self.bench._hand_over()

    def _refuse(self, code: Code, words: str) -> None:
        self.bench.dispatcher.refuse(1, code, Reason.FORMAT_SUSPICION, words)

    def put(self, **words: float | bytes) -> None:
        """Into the PLC's own copy of DB 10: a1, a2, speed, override, number; bytes as they are."""
        for name, value in words.items():
            word, kind = {"a1": (2, Step5Type.REAL), "a2": (4, Step5Type.KG)}.get(name, (0, Step5Type.KF))
            word = word or {"speed": 8, "override": 1, "number": 6}[name]
            data = value if isinstance(value, bytes) else encode(kind, value if kind is not Step5Type.KF else int(value))
            self.words[2 * word : 2 * word + len(data)] = data

    def send(self, first: int = 0, words: int = 32) -> None:
        """Words of DB 10 as one SEND, and what the cell makes of them."""
        self.source.written(10, first, bytes(self.words[2 * first : 2 * (first + words)]), self.bench.now)
        self.run(0.02)

    def bits(self, *, start: bool, number: int = 3) -> None:
        """The request in the PLC's copy: bit, number and parity as the pattern has them."""
        if self.pattern == "toggle":
            self.toggle ^= start
            start = self.toggle
        if self.pattern in BY_NUMBER:
            self.put(number=number if start or self.pattern == "strobe-parity" else 0)
        self.words[0] = int(start) | (number.bit_count() & 1) << 1

    def run(self, seconds: float) -> None:
        self.bench.run(seconds)
        jobs = [job for code, job in self.bench.dispatcher.source(1).by_code.items() if code in (Code.PTP_ABSOLUTE, Code.PROGRAM)]
        if jobs:
            self.source.move_state(max(jobs, key=lambda job: job.id).state)

    def refused(self) -> bool:
        """The refused bit as the PLC fetches it."""
        return bool(self.source.fill(11)[0] & 0x80)

    def outcome(self) -> tuple[CommandState, Reason]:
        job = self.bench.dispatcher.source(1).last
        assert job is not None
        return job.state, job.reason

    def stands(self, seconds: float = 1.5) -> list[float]:
        self.run(seconds)
        return [round(place, 1) for place in self.bench.actual()[:2]]


TARGETS: list[dict[str, float | bytes]] = [
    {"a1": NAN},
    {"a1": INFINITE},
    {"a2": NO_KG},
    {"a2": IEEE_2},
    {"speed": 0},
    {"speed": 101},
    {"override": 101},
]
NUMBERS: list[dict[str, float | bytes]] = [{"number": 9}, {"number": -3}, {"override": 101}]


def moved(pattern: str) -> tuple[Plc, list[float]]:
    """After one good move, its request let go; the place it led to."""
    plc = Plc(pattern)
    plc.bits(start=True)
    plc.send()
    there = plc.stands()
    assert there == ([150.0, 150.0] if pattern in BY_NUMBER else [100.0, 100.0])
    plc.bench.settle(plc.bench.give(Code.PTP_ABSOLUTE, mask=3, targets=(0.0, 0.0)))
    if pattern != "toggle":
        plc.bits(start=False)
        plc.send()
    return plc, [0.0, 0.0]


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_refused_number_of_the_same_telegram_refuses_the_whole_command_and_a_good_one_is_taken_again(pattern: str) -> None:
    plc, home = moved(pattern)
    good = bytes(plc.words[2:])
    for bad in NUMBERS if pattern in BY_NUMBER else TARGETS:
        plc.put(a1=250.0, a2=250.0)
        plc.bits(start=True, number=5)
        plc.put(**bad)
        plc.send()
        assert plc.stands(0.2) == home and plc.refused() and plc.outcome() == (CommandState.REFUSED, Reason.FORMAT_SUSPICION), bad
        plc.words[2:] = good
        if pattern != "toggle":
            plc.bits(start=False)
            plc.send()
            assert not plc.refused()
    plc.bits(start=True, number=5)
    plc.send()
    assert plc.stands() != home and not plc.refused()


@pytest.mark.parametrize("pattern", BY_BIT)
def test_a_number_refused_earlier_refuses_the_start_that_comes_alone(pattern: str) -> None:
    plc, home = moved(pattern)
    for bad in TARGETS:
        good = bytes(plc.words[2:])
        plc.put(**{"a1": 250.0, "a2": 250.0, **bad})
        plc.send(1, 31)
        assert not plc.refused()
        plc.bits(start=True)
        plc.send(0, 1)
        assert plc.stands(0.2) == home and plc.refused() and plc.outcome() == (CommandState.REFUSED, Reason.FORMAT_SUSPICION), bad
        plc.words[2:] = good
        if pattern != "toggle":
            plc.bits(start=False)
        plc.send(1, 31)
        plc.send(0, 1)
        if pattern == "toggle":
            plc.bits(start=True)  # the good request that takes the refusal back
            plc.send(0, 1)
            plc.stands()
            plc.bench.settle(plc.bench.give(Code.PTP_ABSOLUTE, mask=3, targets=(0.0, 0.0)))


@pytest.mark.parametrize("pattern", PATTERNS)
def test_no_number_outlives_a_lost_link(pattern: str) -> None:
    plc, home = moved(pattern)
    plc.source.restart()
    plc.send(0, 1)  # where the bits stand
    if pattern == "number-select":
        plc.send(6, 1)
    plc.bits(start=True)
    plc.send(6, 1) if pattern == "number-select" else plc.send(0, 1)
    assert plc.stands(0.2) == home and plc.refused() and plc.outcome() == (CommandState.REFUSED, Reason.FORMAT_SUSPICION)
    if pattern != "toggle":
        plc.bits(start=False)
    plc.send()
    plc.bits(start=True)
    plc.send()
    assert plc.stands() != home, "all of it written again"


def test_a_single_target_that_was_not_written_again_refuses_the_others() -> None:
    plc, home = moved("start-busy-done")
    plc.source.restart()
    plc.send(0, 2)
    plc.send(4, 8)  # A2 and speed, not A1
    plc.bits(start=True)
    plc.send(0, 2)
    assert plc.stands(0.2) == home and plc.outcome()[1] is Reason.FORMAT_SUSPICION


def test_half_of_a_double_word_is_no_target() -> None:
    plc, home = moved("start-busy-done")
    plc.put(a1=struct.pack(">f", 250.0))
    plc.send(2, 1)
    plc.bits(start=True)
    plc.send(0, 2)
    assert plc.stands(0.2) == home and plc.refused()
    plc.bits(start=False)
    plc.send()
    plc.bits(start=True)
    plc.send()
    assert plc.stands() == [250.0, 100.0]


@pytest.mark.parametrize("pattern", PATTERNS)
def test_what_is_set_when_the_link_returns_starts_nothing_in_whatever_pieces_it_comes(pattern: str) -> None:
    plc, home = moved(pattern)
    plc.source.restart()
    plc.bits(start=True, number=5)
    for word in (2, 3, 4, 5, 8, 1, 6, 0):
        plc.send(word, 2 if word in (2, 4) else 1)
    assert plc.stands(0.2) == home and not plc.refused()


def test_a_refused_override_neither_resumes_nor_runs_at_the_old_one() -> None:
    plc, _ = moved("start-busy-done")
    plc.put(a1=300.0, a2=300.0)
    plc.bits(start=True)
    plc.send()
    plc.run(0.3)
    plc.bench.settle(plc.bench.give(Code.STOP))
    rest = plc.stands()
    plc.put(override=150)
    plc.words[1] |= 1 << 5
    plc.send()
    assert plc.stands() == rest and plc.outcome() == (CommandState.REFUSED, Reason.FORMAT_SUSPICION)
