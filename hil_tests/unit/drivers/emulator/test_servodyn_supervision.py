"""AX-001 and AX-080..089: lag, supervision, faults and limits of an emulated booster, driven over the bus in virtual time."""

from dataclasses import replace
from math import exp, log

import pytest

from drivers.emulator.servo.record import Flag
from drivers.emulator.servo.settings import INC_PER_TURN
from drivers.emulator.servodyn.axis import Fault, State
from hil_tests.lab.virtual.servodyn_axis import FREE, PLAIN, TURN, enabled, fault, limit, path, state, until


@pytest.mark.parametrize("kv", [30.0, 80.0])
@pytest.mark.parametrize("p5_ms", [2.0, 4.0, 10.0])
def test_steady_lag_is_speed_over_kv_without_feed_forward(kv: float, p5_ms: float) -> None:
    bus = enabled(replace(PLAIN, kv_per_s=kv, following_error_rad=6.0 * TURN), p5_ms=p5_ms)
    speed = 20.0 * INC_PER_TURN
    bus.move(lambda t: speed * t)
    bus.run(1.0)
    lag = [row.axes[0].set_inc - row.axes[0].position_inc for row in bus.rows()[-20:]]
    assert sum(lag) / len(lag) == pytest.approx(speed / kv, rel=0.02)
    assert max(lag) - min(lag) <= 4


def test_full_speed_feed_forward_takes_the_lag_away() -> None:
    bus = enabled(replace(PLAIN, speed_feed_forward=1.0))
    bus.move(lambda t: 20.0 * INC_PER_TURN * t)
    bus.want[1].speed_rpm = 1200
    bus.run(1.0)
    row = bus.rows()[-1].axes[0]
    assert abs(row.set_inc - row.position_inc) <= 3


def test_the_axis_comes_to_the_set_position_exactly() -> None:
    bus = enabled(replace(PLAIN, gravity_nm=3.0))
    for target in (40_000, -12_345, 7):
        base = bus.want[1].base
        begin = bus.rows()[-1].axes[0].position_inc
        bus.move(path(begin - base, target))
        bus.run(2.0)
        assert abs(bus.actual[1].position_inc - (base + target)) <= 1


def test_a_set_position_further_than_the_window_trips_and_the_axis_does_not_jump() -> None:
    bus = enabled(replace(PLAIN, following_error_rad=TURN))
    bus.move(lambda t: INC_PER_TURN + 1)
    bus.cycle(2)
    assert bus.actual[1].fault and bus.actual[1].fault_code == Fault.SET_JUMP
    bus.run(0.2)
    assert state(bus) is State.FAULT and abs(bus.actual[1].position_inc - bus.want[1].base) < 20


def test_a_blocked_axis_trips_on_its_following_error() -> None:
    bus = enabled(replace(PLAIN, following_error_rad=TURN))
    bus.slave.load_torque(1, 30.0)
    bus.cycle(3)
    bus.run(0.3)
    assert bus.actual[1].fault_code == Fault.FOLLOWING_ERROR and state(bus) is State.FAULT


@pytest.mark.parametrize("what", ["stuck_encoder", "wrong_sign"])
def test_a_lying_encoder_ends_in_a_following_error_or_overspeed_with_torque_off_and_brake(what: str) -> None:
    bus = enabled(PLAIN)
    bus.move(lambda t: 100_000.0 * t)
    bus.run(0.2)
    getattr(bus.slave, what)(1)
    bus.run(1.0)
    assert bus.actual[1].fault_code in (Fault.FOLLOWING_ERROR, Fault.OVERSPEED)
    assert not bus.actual[1].power_on and not bus.actual[1].brake_open
    assert bus.axis().servo.speed_rad_s == 0.0 and bus.axis().servo.torque_nm == 0.0


def test_overspeed_under_a_pulling_load_trips() -> None:
    bus = enabled(replace(FREE, following_error_rad=1e4, gravity_nm=0.0))
    bus.slave.load_torque(1, -40.0)
    bus.run(0.5)
    assert bus.actual[1].fault_code == Fault.OVERSPEED


@pytest.mark.parametrize("ratio", [1.25, 1.8])
def test_i2t_trips_after_minus_t_ln_1_minus_1_over_r2(ratio: float) -> None:
    bus = enabled(replace(FREE, i2t_time_constant_s=1.5, winding_time_constant_s=1e4))
    began = bus.now
    bus.slave.load_torque(1, ratio * 6.0)
    took = until(bus, lambda actual: actual.fault, 10.0)
    assert bus.actual[1].fault_code == Fault.I2T
    assert took == pytest.approx(-1.5 * log(1.0 - 1.0 / ratio**2), rel=0.02)
    assert any(row.axes[0].flags & Flag.WARNING and not row.axes[0].fault for row in bus.rows() if row.stamp_ns > began), "warned before"


def test_the_winding_heats_up_along_its_time_constant_and_trips() -> None:
    settings = replace(FREE, i2t_time_constant_s=1e5, winding_time_constant_s=2.0, winding_warning_c=100.0, winding_trip_c=150.0)
    bus = enabled(settings)
    bus.slave.load_torque(1, 1.5 * 6.0)
    bus.run(0.2)  # the torque has settled
    begin, end = bus.axis().servo.winding_c, 25.0 + 80.0 * 1.5**2
    bus.run(1.0)
    assert bus.axis().servo.winding_c == pytest.approx(end + (begin - end) * exp(-1.0 / 2.0), rel=1e-3)
    until(bus, lambda actual: actual.fault, 10.0)
    assert bus.actual[1].fault_code == Fault.WINDING


def test_reset_waits_until_the_winding_is_cool() -> None:
    settings = replace(FREE, i2t_time_constant_s=1e5, winding_time_constant_s=0.5, winding_warning_c=100.0, winding_trip_c=120.0)
    bus = enabled(settings)
    bus.slave.load_torque(1, 12.0)
    until(bus, lambda actual: actual.fault, 5.0)
    bus.run(0.12)
    assert 100.0 < bus.axis().servo.winding_c < 120.0, "it would not trip again, it is only not cool"
    bus.slave.load_torque(1, 0.0)
    bus.want[1] = replace(bus.want[1], on=False, enable=False, reset=True)
    bus.cycle(3)
    assert bus.actual[1].fault, "still hot"
    bus.want[1].reset = False
    bus.run(1.0)
    bus.want[1].reset = True
    bus.cycle(3)
    assert not fault(bus) and bus.actual[1].ready


def test_fault_reset_is_an_edge_and_after_it_drive_on_has_to_come_anew() -> None:
    bus = enabled(PLAIN)
    bus.want[1].reset = True
    bus.cycle(3)
    bus.slave.force_fault(1)
    bus.run(0.2)
    assert bus.actual[1].fault_code == Fault.FORCED and state(bus) is State.FAULT, "a standing reset bit is not an edge"
    bus.want[1].reset = False
    bus.cycle(2)
    bus.want[1].reset = True
    bus.run(0.3)
    assert not fault(bus) and state(bus) is State.READY, "drive on is still set, it is not a new command"
    bus.want[1].on = bus.want[1].enable = False
    bus.cycle(2)
    bus.want[1].on = bus.want[1].enable = True
    bus.run(0.3)
    assert bus.actual[1].enabled


def test_a_forced_fault_stops_along_the_ramp_then_brakes() -> None:
    bus = enabled(PLAIN)
    bus.move(lambda t: 20.0 * INC_PER_TURN * t)
    bus.run(0.5)
    speed = bus.axis().servo.speed_rad_s
    bus.slave.force_fault(1, 77)
    began = bus.now
    while state(bus) is State.STOPPING:
        bus.cycle()
    assert (bus.now - began) * 1e-9 == pytest.approx(speed / PLAIN.quick_stop_rad_s2, abs=0.015)
    bus.run(0.1)
    assert bus.actual[1].fault_code == 77 and state(bus) is State.FAULT and not bus.actual[1].brake_open


def test_a_ramp_that_does_not_end_is_given_up() -> None:
    bus = enabled(replace(PLAIN, stop_timeout_s=0.1, following_error_rad=1e4, overspeed_rad_s=1e4, brake_torque_nm=80.0))
    bus.slave.load_torque(1, -60.0)
    bus.run(0.1)
    bus.want[1].enable = False
    bus.run(0.2)
    assert bus.actual[1].fault_code == Fault.STOP_TIMEOUT and not bus.actual[1].power_on


SOFT = replace(PLAIN, soft_limit_min_inc=-20_000, soft_limit_max_inc=30_000)


@pytest.mark.parametrize(("direction", "limit_at"), [(1, INC_PER_TURN + 30_000), (-1, -20_000)])
def test_enable_limit_switch_takes_the_next_resolver_zero_as_zero_of_the_software_limits(direction: int, limit_at: int) -> None:
    bus = enabled(replace(SOFT, start_rad=0.5 * TURN))
    bus.want[1].limit_switch = True
    bus.cycle(2)
    bus.move(lambda t: direction * 20_000.0 * t)
    until(bus, lambda actual: actual.fault, 5.0)
    assert bus.actual[1].fault_code == Fault.SOFTWARE_LIMIT and bus.actual[1].limit_active
    trip = next(row.axes[0].position_inc for row in bus.rows() if row.axes[0].fault)
    assert trip == pytest.approx(limit_at, abs=200), "the zero is the end of the first turn, whichever was passed"


def test_software_limits_are_not_active_before_the_bit_and_only_its_first_edge_counts() -> None:
    bus = enabled(SOFT)
    bus.move(lambda t: 80_000.0 * t)
    bus.run(1.0)
    assert not bus.actual[1].fault
    bus.want[1].limit_switch = True
    bus.run(0.5)  # a zero is passed: zero = 7 turns
    bus.want[1].limit_switch = False
    bus.cycle(2)
    bus.want[1].limit_switch = True
    until(bus, lambda actual: actual.fault, 2.0)
    first = -(-80_000 // INC_PER_TURN)
    trip = next(row.axes[0].position_inc for row in bus.rows() if row.axes[0].fault)
    assert trip == pytest.approx(first * INC_PER_TURN + 30_000, abs=800)


@pytest.mark.parametrize("direction", [1, -1])
def test_a_hard_limit_switch_stops_the_axis_and_lets_it_drive_back(direction: int) -> None:
    bus = enabled(replace(PLAIN, hard_limit_min_rad=-3.0 * TURN, hard_limit_max_rad=3.0 * TURN))
    bus.move(lambda t: direction * 60_000.0 * t)
    until(bus, lambda actual: actual.fault, 3.0)
    assert bus.actual[1].fault_code == Fault.HARD_LIMIT and bus.actual[1].limit_active
    bus.run(0.3)
    beyond = bus.axis().servo.position_rad
    assert 3.0 * TURN < abs(beyond) < 3.2 * TURN
    bus.want[1] = replace(bus.want[1], on=False, enable=False, path=None, reset=True)
    bus.cycle(3)
    bus.enable()
    assert limit(bus) and not fault(bus)
    bus.move(lambda t: direction * 20_000.0 * t)
    bus.run(0.3)
    assert abs(bus.axis().servo.position_rad - beyond) < 0.01, "not one step further outwards"
    bus.move(lambda t: -direction * 20_000.0 * t)
    bus.run(1.5)
    assert not limit(bus) and not fault(bus)


def test_power_loss_is_silence_and_after_its_return_the_position_is_within_one_turn() -> None:
    bus = enabled(SOFT)
    bus.want[1].limit_switch = True
    bus.move(lambda t: 15_000.0 * t)
    bus.run(1.2)
    bus.slave.power_off(1)
    said = len(bus.said)
    bus.run(0.5)
    assert len(bus.said) == said and state(bus) is State.OFFLINE and bus.axis().servo.speed_rad_s == 0.0
    shaft = bus.axis().servo.position_rad
    bus.slave.power_on(1)
    bus.run(0.2)
    assert state(bus) is State.READY, "drive on and ENABLE LIMIT SWITCH stood all the time: no command"
    assert bus.actual[1].position_inc == int(shaft / TURN * INC_PER_TURN) % INC_PER_TURN
    bus.want[1] = replace(bus.want[1], on=False, enable=False, path=None)
    bus.enable()
    bus.move(lambda t: 60_000.0 * t)
    bus.run(2.0)
    assert not fault(bus), "software limits wait for a new edge after a new referencing"
