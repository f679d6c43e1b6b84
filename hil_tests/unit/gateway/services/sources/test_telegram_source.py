"""The command source of raw 3964R telegrams, built alone: blocks to named values, edges of values to telegrams."""

from collections.abc import Iterator

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.image.records.cell import Quality
from gateway.services.sources.telegrams import TelegramSource
from hil_tests.lab.virtual.source_bench import SourceBench
from protocols.p3964r.events import BlockReceived

CELL = load_cell("host-telegrams")
ORDER = b"\0\0OR" + (17).to_bytes(4, "little") + (3).to_bytes(4, "little") + b"\0\0\x20\x41" + b"AB"


@pytest.fixture
def bench() -> Iterator[SourceBench]:
    made = SourceBench(CELL)
    made.publish()
    yield made
    made.close()


def test_a_block_is_named_values_and_a_signal_and_goes_on_at_once(bench: SourceBench) -> None:
    source = TelegramSource(bench.context("V24_1"), CELL.line[0])
    source._on_event(BlockReceived(ORDER), 5)
    assert [bench.values.read(f"order.{name}") for name in ("number", "pallet", "height")] == [17, 3, 10.0]
    assert (bench.values.read("order.new"), bench.values.read("telegram.ORDER.received")) == (1, 1)
    assert bench.values.current("order.number") == 17.0 and bench.passed_on == 1 and source.watch.alive


def test_a_block_no_telegram_fits_changes_no_value(bench: SourceBench) -> None:
    source = TelegramSource(bench.context("V24_1"), CELL.line[0])
    source._on_event(BlockReceived(b"\0\0XX"), 5)
    assert source.counters()["unknown"] == 1
    with pytest.raises(KeyError):
        bench.values.read("order.number")


def test_an_edge_of_a_value_another_part_writes_sends_its_telegram_at_once(bench: SourceBench) -> None:
    source = TelegramSource(bench.context("V24_1"), CELL.line[0])
    source._on_event(BlockReceived(ORDER), 5)
    bench.values.write("order.done", 0, 10, "var")
    assert b"DN" not in sent(source)
    bench.values.write("order.done", 1, 20, "var")
    assert source.link.take_output() == b"\x02", "STX: a block wants to leave"
    assert len(source._jobs) == 1


def test_its_values_are_old_when_the_port_is_gone(bench: SourceBench) -> None:
    source = TelegramSource(bench.context("V24_1", silence_ms=0), CELL.line[0])
    source._on_event(BlockReceived(ORDER), 5)
    source.step(10)
    assert not source.watch.alive and bench.values.current("order.number") is None
    assert bench.values.named.sample("order.number").quality is Quality.STALE


def sent(source: TelegramSource) -> bytes:
    return source.link.take_output()
