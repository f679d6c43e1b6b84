"""The life of a Modbus command source hangs on the client that commands, not on a panel that reads (AX-148)."""

import time
from collections.abc import Iterator

import pytest

from gateway.services.sources.modbus import ModbusSource
from hil_tests.lab.virtual.cell_bench import DEMO
from hil_tests.lab.virtual.source_bench import SourceBench

READ, WRITE = 4, 15


@pytest.fixture
def source() -> Iterator[ModbusSource]:
    bench = SourceBench(DEMO, clock=time.monotonic_ns)
    yield ModbusSource(bench.context("plc2"))
    bench.close()


def heard_at(source: ModbusSource, address: str, function: int) -> bool:
    """Whether this request counted as life."""
    before = source.watch.last_ns
    source._answered(address, function)
    return source.watch.last_ns != before


def test_any_client_is_life_until_somebody_has_written(source: ModbusSource) -> None:
    assert heard_at(source, "10.0.0.9:4000", READ)
    assert heard_at(source, "10.0.0.5:4001", READ)


def test_a_reading_panel_does_not_keep_a_dead_plc_alive(source: ModbusSource) -> None:
    assert heard_at(source, "10.0.0.5:4001", WRITE)
    assert not heard_at(source, "10.0.0.9:4000", READ)
    assert heard_at(source, "10.0.0.5:4001", READ)


def test_the_next_writer_takes_its_place(source: ModbusSource) -> None:
    heard_at(source, "10.0.0.5:4001", WRITE)
    assert heard_at(source, "10.0.0.5:4007", WRITE), "the PLC came back on another port"
    assert not heard_at(source, "10.0.0.5:4001", READ)
