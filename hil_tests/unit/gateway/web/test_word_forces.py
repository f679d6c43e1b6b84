"""AX-498: data words are forced in their own type and unit, for both directions, and what was below comes back."""

import pytest

from gateway.observer.names import Entry
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.data_blocks import BlockHost, DataBlock, DataBlocks, Slot
from gateway.services.forces import MOST, Forces
from gateway.web.word_forces import forced_words
from protocols.base.step5 import Step5Type


def entry(where: str, kind: str = "word", type_: str = "KF", unit: str = "") -> Entry:
    return Entry(f"db:10:{where}", "DB 10", "a name", (), kind, type_, unit)


@pytest.mark.parametrize(
    "made, value, words",
    [
        (entry("2", unit="0.1 mm"), "-12.5", [[2, 0xFFFF, 0xFF83]]),
        (entry("2"), "0x04B0", [[2, 0xFFFF, 0x04B0]]),
        (entry("4", type_="KG"), "1200.5", [[4, 0xFFFF, 0x0B4B], [5, 0xFFFF, 0x0800]]),  # users' text, section 1
        (entry("4", type_="REAL"), "1200.5", [[4, 0xFFFF, 0x4496], [5, 0xFFFF, 0x1000]]),
        (entry("1DR", type_="KH"), "100", [[1, 0x00FF, 100]]),
        (entry("1DL", type_="KH"), "0xFF", [[1, 0xFF00, 0xFF00]]),
        (entry("0.8", "bit", "bit"), "1", [[0, 0x100, 0x100]]),
        (entry("0.8", "bit", "bit"), "0", [[0, 0x100, 0]]),
    ],
)
def test_a_value_becomes_the_words_the_plc_would_write(made: Entry, value: str, words: list[list[int]]) -> None:
    assert forced_words(made, value) == (10, words)


@pytest.mark.parametrize(
    "made, value", [(entry("2"), "40000"), (entry("2"), "many"), (entry("0.8", "bit", "bit"), "2"), (entry("1DR", type_="KH"), "256")]
)
def test_what_does_not_fit_is_refused(made: Entry, value: str) -> None:
    with pytest.raises(ValueError, match="a name"):
        forced_words(made, value)


def test_bits_of_one_word_are_forced_one_by_one() -> None:
    forces = Forces()
    forces.put_word((10, 0), 0x0100, 0x0100)
    forces.put_word((10, 0), 0x0001, 0)
    assert forces.words == {(10, 0): (0x0101, 0x0100)}
    forces.drop_word((10, 0), 0x0100)
    assert forces.words == {(10, 0): (0x0001, 0)}
    forces.drop_word((10, 0))
    assert forces.count == 0


def test_there_is_a_most_of_them() -> None:
    forces = Forces()
    for word in range(MOST):
        forces.put_word((10, word), 0xFFFF, 0)
    with pytest.raises(ValueError, match=str(MOST)):
        forces.put_word((11, 0), 0xFFFF, 0)
    forces.put_word((10, 3), 0xFFFF, 7)


def source(commands: list[Command]) -> DataBlocks:
    """DB 10 from the PLC: override in DW 1, drives on in D 0.0; DB 11 to it: A1 in DW 2."""
    slots = (Slot(10, 1, Step5Type.KF, "cell.override"), Slot(10, 0, None, "cell.reset", rising=True))
    blocks = [DataBlock(10, 4, True, slots), DataBlock(11, 4, False, (Slot(11, 2, Step5Type.KF, "axis.A1.actual"),))]
    host = BlockHost(commands.append, lambda name: 42.0, lambda name, words: None, lambda name, value: None)
    return DataBlocks(blocks, ["A1"], None, host)


def test_what_the_plc_writes_is_laid_over_and_comes_back() -> None:
    commands: list[Command] = []
    made, forces = source(commands), Forces()
    made.forced = forces.words
    made.written(10, 0, bytes.fromhex("0000 0050 0000 0000"), 1)
    forces.put_word((10, 0), 0x0001, 0x0001)
    made.forces_changed(10, 2)
    assert [command.code for command in commands] == [Code.FAULT_RESET], "a forced bit has its edge"
    made.written(10, 0, bytes.fromhex("0000 0050 0000 0000"), 3)
    assert made.fill(10)[:2] == b"\x00\x01", "the PLC's next telegram does not take it away"
    forces.drop_word((10, 0))
    made.forces_changed(10, 4)
    assert made.fill(10)[:4] == bytes.fromhex("0000 0050"), "what the PLC wrote last counts again"


def test_a_force_before_the_first_telegram_starts_nothing() -> None:
    commands: list[Command] = []
    made, forces = source(commands), Forces()
    made.forced = forces.words
    forces.put_word((10, 0), 0x0001, 0x0001)
    made.forces_changed(10, 1)
    made.written(10, 0, bytes(8), 2)
    assert commands == []


def test_what_the_plc_fetches_is_laid_over() -> None:
    made, forces = source([]), Forces()
    made.forced = forces.words
    forces.put_word((11, 2), 0xFFFF, 0x7FFF)
    assert made.fill(11)[4:6] == b"\x7f\xff"
    forces.drop_word((11, 2))
    assert made.fill(11)[4:6] == (42).to_bytes(2, "big")
