"""The life of a Modbus command source hangs on the client that commands, not on a panel that reads (AX-148)."""

import os
from collections.abc import Iterator

import pytest

from gateway.assembly.axes import axis_facts, make_planner
from gateway.assembly.run import DOOR_BYTES, CommandSource
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import OnLoss
from gateway.pure.arbitration.link_watch import LinkWatch
from gateway.runtime.regions import RegionWriter, create_region
from gateway.services.sources.base import SourceContext
from gateway.services.sources.modbus import ModbusSource
from hil_tests.lab.virtual.cell_bench import DEMO
from protocols.base.machine import ms

READ, WRITE = 4, 15


@pytest.fixture
def door() -> Iterator[ModbusSource]:
    fd = create_region("door-2", DOOR_BYTES)
    office = CommandDispatcher(axis_facts(DEMO), make_planner(DEMO), 1)
    watch = LinkWatch(ms(500), False)
    yield ModbusSource(
        SourceContext(CommandSource(2, "plc2", "modbus"), office, watch, OnLoss.STOP, RegionWriter(fd), lambda *_, **__: None)
    )
    os.close(fd)


def heard_at(door: ModbusSource, address: str, function: int) -> bool:
    """Whether this request counted as life."""
    before = door.watch.last_ns
    door._answered(address, function)
    return door.watch.last_ns != before


def test_any_client_is_life_until_somebody_has_written(door: ModbusSource) -> None:
    assert heard_at(door, "10.0.0.9:4000", READ)
    assert heard_at(door, "10.0.0.5:4001", READ)


def test_a_reading_panel_does_not_keep_a_dead_plc_alive(door: ModbusSource) -> None:
    assert heard_at(door, "10.0.0.5:4001", WRITE)
    assert not heard_at(door, "10.0.0.9:4000", READ)
    assert heard_at(door, "10.0.0.5:4001", READ)


def test_the_next_writer_takes_its_place(door: ModbusSource) -> None:
    heard_at(door, "10.0.0.5:4001", WRITE)
    assert heard_at(door, "10.0.0.5:4007", WRITE), "the PLC came back on another port"
    assert not heard_at(door, "10.0.0.5:4001", READ)
