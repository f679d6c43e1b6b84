"""Faults of a booster whose cause stands: the code, what the axis does, that a reset has no effect before the cause is gone."""

import pytest

from drivers.drives.servodyn_words import fault
from drivers.emulator.servodyn.axis import CAUSES, Fault
from hil_tests.lab.virtual.servodyn_bus import DriveBus

RPM_PATH = 16384.0  # inc/s


def moving() -> DriveBus:
    bus = DriveBus()
    bus.enable()
    bus.move(lambda t: RPM_PATH * t)
    bus.run(0.3)
    assert abs(bus.axis().servo.speed_rad_s) > 3.0
    return bus


def reset(bus: DriveBus) -> None:
    want = bus.want[1]
    want.on = want.enable = False
    want.path = None
    bus.run(0.5)
    want.reset = True
    bus.run(0.1)
    want.reset = False
    bus.run(0.1)


ROWS = [  # name, code of the booster, the closest number of the old list
    ("undervoltage", 11, 653),
    ("phase_loss", 12, 673),
    ("over_temperature", 13, 656),
    ("motor_over_temperature", 9, 658),
    ("encoder_fault", 14, 662),
]


@pytest.mark.parametrize("name, code, number", ROWS)
def test_a_cause_stops_the_axis_and_stays_until_it_is_taken_away(name: str, code: int, number: int) -> None:
    bus = moving()
    bus.slave.cause(1, name, True)
    bus.run(1.0)
    assert (bus.actual[1].fault, bus.actual[1].fault_code, bus.axis().servo.speed_rad_s) == (True, code, 0.0)
    assert fault(code).number == number, "the closest number of the old list"
    reset(bus)
    assert bus.actual[1].fault, "its cause stands"
    bus.slave.cause(1, name, False)
    reset(bus)
    assert not bus.actual[1].fault and bus.actual[1].ready
    bus.enable()


def test_without_power_the_torque_is_off_at_once_and_hot_it_still_brakes() -> None:
    blind, ramp = moving(), moving()
    blind.slave.cause(1, "phase_loss", True)
    ramp.slave.cause(1, "over_temperature", True)
    blind.run(0.012)
    ramp.run(0.012)
    assert abs(blind.axis().servo.torque_nm) < 1e-6 and abs(ramp.axis().servo.torque_nm) > 0.1


def test_a_brake_that_does_not_open_is_a_fault_and_nothing_moves() -> None:
    bus = DriveBus()
    bus.slave.stick_brake(1, True)
    before = bus.axis().servo.position_rad
    want = bus.want[1]
    bus.run(0.1)
    want.on = True
    bus.run(0.1)
    want.enable = True
    bus.run(0.5)
    assert (bus.actual[1].fault_code, bus.actual[1].enabled, bus.actual[1].brake_open) == (Fault.BRAKE, False, False)
    assert bus.axis().servo.position_rad == pytest.approx(before, abs=1e-6)
    bus.slave.stick_brake(1, False)
    reset(bus)
    bus.enable()


def test_a_jumping_encoder_shows_at_once_and_trips_the_lag() -> None:
    bus = DriveBus()
    bus.enable()
    before = bus.actual[1].position_inc
    bus.slave.jump_encoder(1, 400_000)
    bus.cycle()
    assert bus.actual[1].position_inc == pytest.approx(before + 400_000, abs=50)
    bus.run(0.2)
    assert bus.actual[1].fault_code == Fault.FOLLOWING_ERROR


def test_a_cause_from_before_power_up_shows_after_the_boot() -> None:
    bus = DriveBus()
    bus.slave.power_off(1)
    bus.slave.cause(1, "undervoltage", True)
    bus.run(0.05)
    bus.slave.power_on(1)
    bus.run(3.0)
    assert bus.actual[1].fault_code == Fault.UNDERVOLTAGE


def test_an_unknown_cause_is_refused() -> None:
    bus = DriveBus()
    with pytest.raises(KeyError, match="earthquake"):
        bus.slave.cause(1, "earthquake", True)
    assert set(CAUSES) == {"undervoltage", "phase_loss", "over_temperature", "motor_over_temperature", "encoder_fault"}
