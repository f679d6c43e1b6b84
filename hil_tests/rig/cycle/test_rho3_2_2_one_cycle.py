"""rho 3 Releases part 1, L11024-11026, L7250, L7276: what the cycle process sends and takes in one cycle, on one bus and on two."""

import contextlib
import math
import pathlib
import re
import struct
from collections.abc import Iterator

import pytest

from hil_tests.lab.running.bus_running import Bus, running_bus
from hil_tests.lab.running.cycle_running import Drives, running_cycle, serve
from protocols.base.machine import Frame

CYCLES = 20
ONE_CYCLE = [100, 210, 220, 230, 240, 250, 260]
TURN = 16384
FEEDS = [0.020, 0.020, 0.010, math.radians(4.5), math.radians(4.5), math.radians(7.2)]  # m, rad for a motor turn: feed / gear of the cell


@pytest.fixture
def bus(tmp_path: pathlib.Path) -> Iterator[Bus]:
    with running_bus(tmp_path) as bus:
        yield bus


def identifiers(cycle: list[Frame]) -> list[int]:
    return [frame.identifier for frame in cycle]


def positions(cycle: list[Frame]) -> list[int]:
    """Set positions of one cycle in the order of their identifiers."""
    return [struct.unpack("<i", frame.data[2:6])[0] for frame in sorted(cycle, key=lambda frame: frame.identifier)[1:]]


@pytest.mark.requirement("RHO-CAN-01", by="gateway.cycle.bus_link:BusLink.prepare")
def test_one_cycle_sends_100_and_210_to_260(bus: Bus) -> None:
    with running_cycle("demo", {"drives": f"broker:{bus.name}"}) as run:
        drives = Drives(bus.port(), [0] * 6)
        serve(run, [drives], CYCLES)
    assert len(drives.cycles) > CYCLES, "SYNC did not come"
    assert [identifiers(cycle) for cycle in drives.cycles[:CYCLES]] == [ONE_CYCLE] * CYCLES
    assert all(len(frame.data) == (0 if frame.identifier == 100 else 8) for cycle in drives.cycles for frame in cycle)


@pytest.mark.requirement("RHO-CAN-01", by="gateway.cycle.bus_link:BusLink.receive")
def test_610_to_660_are_taken_as_the_actual_values_of_axes_1_to_6(bus: Bus) -> None:
    """Axis n stands n motor turns from the zero of its encoder; off, so its set position follows."""
    turns = [1, -2, 3, -4, 5, -6]
    with running_cycle("demo", {"drives": f"broker:{bus.name}"}) as run:
        drives = Drives(bus.port(), [TURN * turn for turn in turns])
        serve(run, [drives], CYCLES)
        actual = run.actual()
    assert actual[:6] == pytest.approx([turn * feed for turn, feed in zip(turns, FEEDS, strict=True)], abs=1e-12)
    assert len(actual) == 6, "one place for each axis of the cell"
    assert positions(drives.cycles[CYCLES - 1]) == [TURN * turn for turn in turns]


@pytest.mark.requirement("RHO-CAN-02", by=("gateway.cycle.bus_link:BusLink.prepare", "gateway.cycle.bus_link:BusLink.receive"))
def test_axis_7_on_bus_2_speaks_under_the_identifiers_of_axis_1_on_bus_1(bus: Bus, tmp_path: pathlib.Path) -> None:
    first, second = [TURN * n for n in range(1, 7)], [-TURN * n for n in range(7, 13)]
    with contextlib.ExitStack() as stack:
        other = stack.enter_context(running_bus_beside(tmp_path))
        run = stack.enter_context(running_cycle(twelve_axes(tmp_path), {"drives": f"broker:{bus.name}", "more": f"broker:{other.name}"}))
        buses = [Drives(bus.port(), first), Drives(other.port(), second)]
        serve(run, buses, CYCLES)
        actual = run.actual()
    for drives in buses:
        assert len(drives.cycles) > CYCLES, "SYNC did not come"
        assert [identifiers(cycle) for cycle in drives.cycles[:CYCLES]] == [ONE_CYCLE] * CYCLES
    assert actual == pytest.approx([n * feed for n, feed in zip([*range(1, 7), *range(-7, -13, -1)], FEEDS * 2, strict=True)], abs=1e-12)
    assert [positions(drives.cycles[CYCLES - 1]) for drives in buses] == [first, second], "210 is axis 1's on bus 1 and axis 7's on bus 2"


@contextlib.contextmanager
def running_bus_beside(folder: pathlib.Path) -> Iterator[Bus]:
    """A second broker in the runtime folder of the first."""
    bus = Bus("u", folder / "u.log")
    try:
        yield bus
    finally:
        bus.stop()


def twelve_axes(folder: pathlib.Path) -> pathlib.Path:
    """The demo cell with a second bus "more" and its six axes once more, A7..A12, on it."""
    from gateway.files.find import find_config

    text = find_config("demo", "cells").read_text()
    bus = re.search(r"^\[\[bus\]\]\n(?:.+\n)+", text, re.MULTILINE)
    assert bus is not None
    axes = text[text.index("[[axis]]") : text.index("# ---- the emulated machine")]
    plants = text[text.index("[plant.axis.A1]") :]
    more = [bus[0].replace('"drives"', '"more"'), axes.replace('bus = "drives"', 'bus = "more"'), plants]
    again = [re.sub(r"\bA([1-6])\b", lambda match: f"A{int(match[1]) + 6}", part) for part in more]
    cell = folder / "twelve.toml"
    cell.write_text("\n".join([text, *again]))
    return cell
