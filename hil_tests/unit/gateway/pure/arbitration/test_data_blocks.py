"""The old-style command source: entries, edges, start-busy-done, and that standing bits start nothing."""

import pytest

from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.data_blocks import BlockHost, DataBlocks
from gateway.pure.image.reasons import CommandState
from gateway.services.sources.rk512 import compile_block, compile_handshake
from hil_tests.lab.virtual.cell_bench import DEMO

KG_1200_5 = bytes.fromhex("0B4B0800")


class BlockBench:
    """DB 10, 11, 12 of the demo cell with everything the command source says kept."""

    def __init__(self) -> None:
        self.commands: list[Command] = []
        self.bad: list[str] = []
        self.values: dict[str, float] = {}
        self.levels: dict[str, float] = {}
        blocks = [compile_block(db) for db in DEMO.db]
        names = [axis.name for axis in DEMO.axis]
        handshake = compile_handshake(DEMO.handshake["move"])
        host = BlockHost(
            self.commands.append,
            lambda name: self.values.get(name, 0.0),
            lambda name, words: self.bad.append(words),
            self.levels.__setitem__,
        )
        self.source = DataBlocks(blocks, names, handshake, host)

    def send(self, **words: int) -> list[int]:
        """A whole DB 10; words as dw0=..; the codes commanded by it."""
        data = bytearray(64)
        for name, value in words.items():
            at = 2 * int(name[2:])
            data[at : at + 2] = (value & 0xFFFF).to_bytes(2, "big")
        self.commands.clear()
        self.source.written(10, 0, bytes(data), 0)
        return [command.code for command in self.commands]


ON, RESET, REFERENCE, STOP, RESUME, START = 1, 1 << 2, 1 << 3, 1 << 4, 1 << 5, 1 << 8


def test_the_first_telegram_only_says_where_the_bits_are() -> None:
    source = BlockBench()
    assert source.send(dw0=ON | START | REFERENCE) == []
    assert source.send(dw0=ON | START | REFERENCE) == []


def test_drives_on_asks_for_control_and_for_the_override_that_is_set() -> None:
    source = BlockBench()
    source.send(dw0=0, dw1=80)
    assert source.send(dw0=ON, dw1=80) == [Code.REQUEST_CONTROL, Code.ENABLE, Code.OVERRIDE]
    assert source.commands[2].velocity == pytest.approx(0.8)


def test_drives_off_gives_control_back_at_rest() -> None:
    source = BlockBench()
    source.send(dw0=0)
    source.send(dw0=ON)
    assert source.send(dw0=0) == [Code.DISABLE]
    source.source.settle(at_rest=False)
    assert [c.code for c in source.commands] == [Code.DISABLE]
    source.source.settle(at_rest=True)
    assert [c.code for c in source.commands] == [Code.DISABLE, Code.RELEASE_CONTROL]


def test_start_takes_the_targets_of_the_same_telegram_once() -> None:
    source = BlockBench()
    source.send(dw0=ON)
    assert source.send(dw0=ON | START, dw2=12005, dw3=-20, dw8=50) == [Code.PTP_ABSOLUTE]
    move = source.commands[0]
    assert move.targets[:3] == pytest.approx((1200.5, -2.0, 0.0))
    assert (move.mask, move.velocity) == (0x3F, 0.5)
    assert source.send(dw0=ON | START, dw2=12005, dw3=-20, dw8=50) == [], "the same telegram again"


def test_a_lost_link_primes_the_edges_anew() -> None:
    source = BlockBench()
    source.send(dw0=ON)
    source.source.restart()
    assert source.send(dw0=ON | START, dw2=100, dw8=50) == []
    source.send(dw0=ON, dw8=50)
    assert source.send(dw0=ON | START, dw2=100, dw8=50) == [Code.PTP_ABSOLUTE]


def test_stop_comes_before_everything_else_of_the_same_telegram() -> None:
    source = BlockBench()
    source.send(dw0=ON, dw8=50)
    assert source.send(dw0=ON | STOP | RESUME | START | REFERENCE, dw8=50) == [Code.STOP, Code.REFERENCE, Code.RESUME, Code.PTP_ABSOLUTE]


def test_override_is_taken_when_it_changed_and_only_by_the_owner() -> None:
    source = BlockBench()
    source.send(dw0=ON, dw1=100)
    assert source.send(dw0=ON, dw1=50) == [], "somebody else has control"
    source.values["cell.control"] = 1.0
    assert source.send(dw0=ON, dw1=60) == [Code.OVERRIDE]
    assert source.send(dw0=ON, dw1=60) == []


def test_a_number_out_of_its_range_is_not_taken_but_reported() -> None:
    source = BlockBench()
    source.values["cell.control"] = 1.0
    source.send(dw0=ON, dw1=50, dw8=50)
    assert source.send(dw0=ON, dw1=101, dw8=50) == []
    assert "101" in source.bad[0]
    assert "0..100" in source.bad[0]


def test_kg_and_real_are_told_apart_by_the_entry() -> None:
    source = BlockBench()
    source.send(dw0=ON, dw8=50)
    source.source.written(12, 0, KG_1200_5 + KG_1200_5, 0)
    source.source.written(10, 0, (ON | START).to_bytes(2, "big"), 0)
    targets = source.commands[-1].targets
    assert targets[1] == pytest.approx(1200.5), "DD 2 is declared KG"
    assert 0 < targets[0] < 1e-30, "DD 0 is declared REAL: the same bytes are another number, which the office refuses"


@pytest.mark.parametrize(
    ("state", "busy", "done", "refused"),
    [
        (CommandState.RUNNING, 1, 0, 0),
        (CommandState.DONE, 0, 1, 0),
        (CommandState.REFUSED, 0, 0, 1),
        (CommandState.ABORTED, 0, 0, 1),
    ],
)
def test_the_handshake_bits_of_a_move(state: CommandState, busy: int, done: int, refused: int) -> None:
    source = BlockBench()
    source.send(dw0=ON, dw8=50)
    source.send(dw0=ON | START, dw8=50)
    source.source.move_state(state)
    word = int.from_bytes(source.source.fill(11)[:2], "big")
    assert (word >> 8 & 1, word >> 9 & 1, word >> 15 & 1) == (busy, done, refused)
    source.send(dw0=ON, dw8=50)
    word = int.from_bytes(source.source.fill(11)[:2], "big")
    assert (word >> 9 & 1, word >> 15 & 1) == (0, 0), "they fall with the start bit"


def test_status_words_in_their_units_and_clamped_at_the_end_of_the_type() -> None:
    source = BlockBench()
    source.values.update({"cell.ready": 1.0, "axis.A1.actual": 1200.52, "axis.A2.actual": -9999.0, "error.first.code": 17.0})
    data = source.source.fill(11)
    words = [int.from_bytes(data[n : n + 2], "big", signed=True) for n in range(0, 64, 2)]
    assert words[0] & 1 == 1
    assert (words[1], words[2], words[3]) == (17, 12005, -32768)
    assert source.source.clamped == 1
