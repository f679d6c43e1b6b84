"""rho 3 Releases part 1, L11024-11026 and L7250, L7276: SYNC, set and actual identifiers; the second bus uses the same ones."""

import pytest

from drivers.emulator.servo.settings import ServoSettings
from hil_tests.lab.virtual.servodyn_bus import CODEC, DriveBus
from protocols.base.errors import ProtocolError
from protocols.base.machine import Frame
from protocols.servodyn.codec import SYNC, ActualValue, SetValue
from protocols.servodyn.plan import place


def axis_of_actual(identifier: int) -> int:
    return CODEC.decode_actual(Frame(identifier, bytes(8)))[0]


@pytest.mark.requirement("RHO-CAN-01", by="protocols.servodyn.codec:Codec.encode_set")
def test_set_values_of_axes_1_to_4_are_210_to_240_and_those_of_5_and_6_follow() -> None:
    lives = [Frame(200 + 10 * axis, bytes((0, axis)) + bytes(6)) for axis in range(1, 7)]
    assert [CODEC.encode_set(axis, SetValue(life=axis)) for axis in range(1, 7)] == lives


@pytest.mark.requirement("RHO-CAN-01", by="protocols.servodyn.codec:Codec.decode_actual")
def test_610_to_640_are_taken_as_actual_values_of_axes_1_to_4() -> None:
    assert [axis_of_actual(identifier) for identifier in (610, 620, 630, 640, 650, 660)] == [1, 2, 3, 4, 5, 6]


@pytest.mark.requirement("RHO-CAN-01", by="protocols.servodyn.codec:Codec.encode_actual")
def test_sync_is_100_without_data_and_the_drives_answer_it_in_axis_order() -> None:
    bus = DriveBus(*[ServoSettings()] * 6)
    assert Frame(100, b"") == SYNC
    assert CODEC.encode_actual(2, ActualValue(position_inc=2)) == Frame(620, bytes((0, 0, 2)) + bytes(5))
    said = [frame.identifier for frame in bus.hand(SYNC._replace(stamp_ns=bus.now))]
    assert said == [610, 620, 630, 640, 650, 660]


def where(axis: int) -> tuple[int, ...]:
    return tuple(place(axis))


@pytest.mark.requirement("RHO-CAN-02", by="protocols.servodyn.plan:place")
def test_axis_7_on_bus_2_sends_210_as_axis_1_on_bus_1_does() -> None:
    assert [where(axis) for axis in (1, 6, 7, 12)] == [(1, 1, 210, 610), (1, 6, 260, 660), (2, 1, 210, 610), (2, 6, 260, 660)]


def test_there_are_twelve_axes() -> None:
    for axis in (0, 13, -1):
        with pytest.raises(ValueError, match=r"outside 1\.\.12"):
            place(axis)


def test_values_survive_the_way_to_the_second_bus() -> None:
    axis, value = CODEC.decode_actual(CODEC.encode_actual(place(9).slot, ActualValue(position_inc=-9)))
    assert axis == 3 and value.position_inc == -9
    with pytest.raises((ProtocolError, KeyError)):
        CODEC.encode_set(7, SetValue())
