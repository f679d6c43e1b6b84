"""AX-403 at the data command source: patterns other than start-busy-done, numbers that select positions, answering bits in the block."""

import pytest

from gateway.cell_file.load import CellFaults, load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.data_blocks import BlockHost, DataBlocks
from gateway.pure.image.reasons import CommandState
from gateway.services.sources.rk512 import compile_block, compile_handshake, compile_pattern
from hil_tests.lab.cells.numbered_cell import numbered_cell

S5 = read_text(find_config("s5-rk512", "cells"))
MOVE = S5[S5.index("[handshake.move]") : S5.index("# ---- real contacts")]
START = '  { at = "D 0.8",  type = "bit", to = "move.start" },\n'
NUMBER = '  { at = "DW 6", type = "KF", to = "move.number" },\n'
LAST = '  { at = "DW 31",  type = "KF",  to = "line.plc.life" },\n'
PARITY = '  { at = "D 0.9", type = "bit", to = "move.parity" },\n'
SELECT = """[handshake.move]
pattern = "{pattern}"
{start}done    = "DB11.D0.9"
refused = "DB11.D0.15"
[[position]]
number = 7
at     = {{ X = 100.0, Z = 5.0 }}
speed  = 50.0
[[position]]
number = 8
at     = {{ Y = 1.0 }}
"""


def text(pattern: str, entries: str = START, start: str = 'start   = "DB10.D0.8"\n') -> str:
    return S5.replace(MOVE, SELECT.format(pattern=pattern, start=start)).replace(START, entries)


class BlockBench:
    """The command source of the S5 cell with another handshake; DB 10 as its PLC writes it."""

    def __init__(self, cell_text: str) -> None:
        cell = load_cell("s5.toml", cell_text)
        self.commands: list[Command] = []
        shake = compile_handshake(cell.handshake["move"])
        blocks, names = [compile_block(db) for db in cell.db], [axis.name for axis in cell.axis]
        host = BlockHost(self.commands.append, lambda name: 0.0, lambda name, told: None, lambda name, bit: None)
        self.source = DataBlocks(blocks, names, shake, host, selected=compile_pattern(cell))
        self.words = [0] * 32
        self.send()

    def send(self, **words: int) -> list[Command]:
        """w0=0x100: DW 0; the moves this telegram started."""
        for name, value in words.items():
            self.words[int(name[1:])] = value
        before = len(self.commands)
        self.source.written(10, 0, b"".join(word.to_bytes(2, "big") for word in self.words), 0)
        return [command for command in self.commands[before:] if command.code in (Code.PTP_ABSOLUTE, Code.PROGRAM)]

    def answer(self) -> tuple[bool, bool]:
        """(done, refused) in DB 11."""
        word = int.from_bytes(self.source.fill(11)[:2], "big")
        return bool(word & 0x200), bool(word & 0x8000)


def test_a_number_selects_its_position_once_and_is_done_until_zero() -> None:
    source = BlockBench(text("number-select", NUMBER, ""))
    (move,) = source.send(w6=7)
    assert (move.mask, move.velocity, move.targets[:3]) == (0b101, 0.5, (100.0, 0.0, 5.0))
    assert source.send() == [] == source.send(w6=7)
    source.source.move_state(CommandState.DONE)
    assert source.answer() == (True, False)
    assert source.send(w6=0) == [] and source.answer() == (False, False)
    assert source.send(w6=9) == [] and source.answer() == (False, True)
    assert source.send(w6=0) == []
    assert source.send(w6=8)[0].mask == 0b010


def test_a_number_of_a_program_orders_it_once_and_zero_lies_between_two() -> None:
    source = BlockBench(numbered_cell(number=20))
    (order,) = source.send(w5=100, w6=20)
    assert (order.code, order.mask, order.velocity, order.acceleration) == (Code.PROGRAM, 20, 1.0, 1.0)
    assert source.send() == [] == source.send(w6=7), "no second start while the first one is under way"
    source.source.move_state(CommandState.DONE)
    assert source.answer() == (True, False)
    assert source.send(w6=0) == [] and source.send(w6=21) == [] and source.answer() == (False, True)
    assert source.send(w6=0) == [] and source.send(w6=20)[0].code is Code.PROGRAM
    source.source.move_state(CommandState.REFUSED)
    assert source.answer() == (False, True)


def test_a_strobed_code_orders_a_program_at_the_speed_of_its_block() -> None:
    strobed = numbered_cell(number=20).replace('pattern = "number-select"', 'pattern = "strobe-parity"\nstart   = "DB10.D0.8"')
    source = BlockBench(strobed.replace(LAST, START + PARITY + LAST))
    (order,) = source.send(w0=0x100, w5=40, w6=20)
    assert (order.code, order.mask, order.velocity) == (Code.PROGRAM, 20, 0.4)


def test_a_strobe_takes_number_and_parity_of_the_same_telegram() -> None:
    source = BlockBench(text("strobe-parity", START + NUMBER + PARITY))
    assert source.send(w0=0x100, w6=7) == [] and source.answer() == (False, True), "7 has three ones: even parity needs the fourth"
    assert source.send(w0=0) == []
    assert source.send(w0=0x300, w6=7)[0].mask == 0b101
    source.source.move_state(CommandState.ACCEPTED)
    assert source.answer() == (True, False) and source.send() == []


@pytest.mark.parametrize("pattern", ["level-ack", "toggle"])
def test_a_bit_takes_the_targets_of_its_telegram(pattern: str) -> None:
    source = BlockBench(text(pattern))
    (move,) = source.send(w0=0x100, w2=1000, w5=50)
    assert move.targets[0] == 100.0 and source.send() == []
    source.source.move_state(CommandState.DONE)
    assert source.answer() == (True, False)
    assert len(source.send(w0=0)) == (pattern == "toggle")


def test_a_link_that_returns_with_an_unchanged_number_moves_nothing() -> None:
    source = BlockBench(text("number-select", NUMBER, ""))
    source.send(w6=7)
    source.source.restart()
    assert source.send(w6=7) == [] and source.send(w6=7) == []


@pytest.mark.parametrize(
    ("cell_text", "key"),
    [
        (text("number-select", START), "handshake.move.pattern"),
        (text("strobe-parity", START + NUMBER), "handshake.move.pattern"),
        (text("toggle", START, ""), "handshake.move.start"),
        (text("toggle").replace("number = 8", "number = 7"), "position.7.number"),
        (text("toggle").replace("Y = 1.0", "Y = 9999.0"), "position.8.at"),
        (text("toggle").replace("Y = 1.0", "Q = 1.0"), "position.8.at"),
        (numbered_cell(number=7), "position.7.number"),
    ],
)
def test_what_check_says_of_patterns_and_positions(cell_text: str, key: str) -> None:
    with pytest.raises(CellFaults) as found:
        load_cell("s5.toml", cell_text)
    assert [fault.key for fault in found.value.faults] == [key]
