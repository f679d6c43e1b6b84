"""CiA 402 homing: each method finds the edge and the index its figure shows, from every side, on the real geometry of the model."""

import math

import pytest

from drivers.emulator.cia402.homing import METHODS
from drivers.emulator.servo.settings import DriveSettings, ServoSettings
from hil_tests.lab.virtual.canopen_bus import AbortedError, CanopenBus

TURN = 16384
OFFSET = 5000  # resolver reading at mechanical zero: the index does not stand on a switch
LEFT, RIGHT, LOW, HIGH = 10.0, 16.0, -40.0, 60.0  # home switch and limit switches, rad
STARTS = {"left": 0.0, "on": 13.0, "right": 25.0}


def counter(rad: float) -> float:
    return rad * TURN / (2.0 * math.pi) + OFFSET


def index_after(rad: float, direction: int) -> int:
    """The next index pulse from a place: counter a multiple of a turn."""
    turns = counter(rad) / TURN
    return (math.ceil(turns) if direction > 0 else math.floor(turns)) * TURN


# Method: (edge in rad, direction of the last leg), read off the figures of IEC 61800-7-201; with index 1..14, without 17..30
PLACES = {
    1: (LOW, +1),
    2: (HIGH, -1),
    3: (LEFT, -1),
    4: (LEFT, +1),
    5: (RIGHT, +1),
    6: (RIGHT, -1),
    7: (LEFT, -1),
    8: (LEFT, +1),
    9: (RIGHT, -1),
    10: (RIGHT, +1),
    11: (RIGHT, +1),
    12: (RIGHT, -1),
    13: (LEFT, +1),
    14: (LEFT, -1),
}
POSITIVE_SWITCH, NEGATIVE_SWITCH = (3, 4, 19, 20), (5, 6, 21, 22)  # the switch stays on to the end of the travel


def drive(start: float, method: int) -> DriveSettings:
    left = -math.inf if method in NEGATIVE_SWITCH else LEFT
    right = math.inf if method in POSITIVE_SWITCH else RIGHT
    servo = ServoSettings(
        start_rad=start,
        resolver_offset_inc=OFFSET,
        reference_switch_from_rad=left,
        reference_switch_to_rad=right,
        hard_limit_min_rad=LOW,
        hard_limit_max_rad=HIGH,
        boot_s=0.01,
        charge_s=0.0,
        brake=False,
        overspeed_rad_s=400.0,
    )
    return DriveSettings(servo)


def home(method: int, start: float, offset: int = 0) -> CanopenBus:
    bus = CanopenBus(drive(start, method))
    node = bus.node()
    node.enable(6)
    node.set(0x6098, method)
    node.set(0x607C, offset)
    node.set(0x6099, 200_000, 1)
    node.set(0x6099, 40_000, 2)
    node.set(0x609A, 2_000_000)
    node.control(0x1F)
    node.until(lambda: bool(node.status & 0x2000) or node.status & 0x1400 == 0x1400, limit_s=20.0, step_s=0.01)
    return bus


def found(bus: CanopenBus) -> float:
    """The counter at which position 0 (the home offset) lies."""
    axis = bus.axis()
    return bus.node().read(0x607C) - axis.place.shift + turns_lost(bus)


def turns_lost(bus: CanopenBus) -> int:
    """The resolver knows its turn only: whole turns between the counter and the shaft."""
    axis = bus.axis()
    return round((counter(axis.servo.position_rad) - axis.servo.counter_inc) / TURN) * TURN


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("method", sorted(PLACES))
def test_a_method_with_index_finds_the_index_its_figure_shows(method: int, start: str) -> None:
    bus = home(method, STARTS[start])
    edge, direction = PLACES[method]
    assert bus.node().status & 0x3400 == 0x1400, f"{bus.node().status:04X}h"
    assert found(bus) == index_after(edge, direction)


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("method", sorted(PLACES))
def test_a_method_without_index_finds_the_edge_itself(method: int, start: str) -> None:
    bus = home(method + 16, STARTS[start])
    edge, _ = PLACES[method]
    assert bus.node().status & 0x3400 == 0x1400
    assert found(bus) == math.floor(counter(edge))


@pytest.mark.parametrize(("method", "direction"), [(33, -1), (34, +1)])
def test_33_and_34_go_to_the_next_index(method: int, direction: int) -> None:
    assert found(home(method, 1.0)) == index_after(1.0, direction)


@pytest.mark.parametrize("method", [35, 37])
def test_35_and_37_take_the_place_where_the_axis_stands(method: int) -> None:
    bus = home(method, 1.0, offset=777)
    assert bus.node().read(0x6064) == 777
    assert abs(bus.axis().servo.position_rad - 1.0) < 0.01, "nothing moved"


def test_the_home_offset_is_the_position_of_home() -> None:
    bus = home(24, 0.0, offset=-1234)
    node = bus.node()
    place = bus.axis().servo.position_rad
    assert abs(node.read(0x6064) - (-1234 + counter(place) - counter(LEFT))) <= 2
    assert abs(place - LEFT) > 0.001, "it stopped beyond the edge, by its deceleration"


def test_all_supported_methods_are_listed_and_others_are_an_error() -> None:
    bus = home(15, 0.0)
    node = bus.node()
    bus.run(0.01)
    assert node.status & 0x3400 == 0x2400  # homing error, speed 0
    assert any(frame.data[:2] == b"\x13\x86" for frame in bus.heard(0x81)), "emergency 8613h"
    assert node.read(0x60E3, 0) == len(METHODS) == 32
    assert {node.read(0x60E3, sub) for sub in range(1, 33)} == METHODS


@pytest.mark.parametrize("method", [3, 19, 6])
def test_a_limit_switch_where_the_figure_has_none_is_an_error(method: int) -> None:
    """The home switch is missing: the axis runs to the limit switch."""
    servo = ServoSettings(hard_limit_min_rad=LOW, hard_limit_max_rad=HIGH, boot_s=0.01, charge_s=0.0, brake=False)
    bus = CanopenBus(DriveSettings(servo))
    node = bus.node()
    node.enable(6)
    node.set(0x6098, method)
    node.set(0x6099, 200_000, 1)
    node.control(0x1F)
    node.until(lambda: node.status & 0x2400 == 0x2400, limit_s=20.0, step_s=0.01)
    assert not node.status & 0x1000 and node.status & 0x6F == 0x27, "an error of the homing, no fault"
    assert abs(node.read(0x606C)) < 100


def test_bit_4_taken_away_interrupts_and_a_new_edge_begins_again() -> None:
    bus = CanopenBus(drive(0.0, 24))
    node = bus.node()
    node.enable(6)
    node.set(0x6098, 24)
    assert node.control(0x0F) & 0x3400 == 0x0400  # not started
    assert node.control(0x1F) & 0x3400 == 0x0000  # in progress
    bus.run(0.3)
    assert node.read(0x606C) > 10_000
    node.control(0x0F)
    node.until(lambda: node.status & 0x3400 == 0x0400)
    assert abs(node.read(0x606C)) < 100 and not bus.axis().place.homed
    node.control(0x1F)
    node.until(lambda: node.status & 0x3400 == 0x1400, limit_s=20.0)
    assert found(bus) == math.floor(counter(LEFT))


def test_halt_stops_a_homing() -> None:
    bus = CanopenBus(drive(0.0, 24))
    node = bus.node()
    node.enable(6)
    node.set(0x6098, 24)
    node.control(0x1F)
    bus.run(0.3)
    node.control(0x11F)
    node.until(lambda: bool(node.status & 0x400))
    bus.run(0.05)
    assert abs(node.read(0x606C)) < 100 and not bus.axis().place.homed


def test_a_method_beyond_the_data_sheet_is_refused() -> None:
    bus = CanopenBus(drive(0.0, 24))
    bus.run(0.1)
    with pytest.raises(AbortedError) as caught:
        bus.node().set(0x6098, 38)
    assert caught.value.code == 0x06090031
