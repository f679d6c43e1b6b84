"""AX-001 and AX-080..089: power states of an emulated booster, its brake, faults, limits; driven over the bus in virtual time."""

from collections.abc import Callable
from dataclasses import replace
from math import exp, log, pi

import pytest

from drivers.emulator.record import Flag
from drivers.emulator.servodyn_axis import Fault, State, wrap
from drivers.emulator.servodyn_slave import FaultRaised
from drivers.emulator.settings import INC_PER_TURN, ServoSettings
from hil_tests.lab.servodyn_bus import DriveBus
from protocols.base.machine import Frame
from protocols.servodyn.codec import ActualValue

TURN = 2.0 * pi
PLAIN = ServoSettings()
FREE = ServoSettings(coulomb_nm=0.0, stiction_nm=0.0, viscous_nms_per_rad=0.0)


def enabled(*settings: ServoSettings, p5_ms: float = 4.0) -> DriveBus:
    bus = DriveBus(*settings, p5_ms=p5_ms)
    bus.enable()
    return bus


def state(bus: DriveBus) -> State:
    return bus.axis().state


def fault(bus: DriveBus) -> bool:
    return bus.actual[1].fault


def limit(bus: DriveBus) -> bool:
    return bus.actual[1].limit_active


def path(start: float, end: float) -> Callable[[float], float]:
    """From start to end in one second."""
    return lambda t: start + (end - start) * min(t, 1.0)


def until(bus: DriveBus, reached: Callable[[ActualValue], bool], seconds: float) -> float:
    """Cycles until the actual value of axis 1 says so; seconds of bus time it took.  Fails after `seconds`."""
    began = bus.now
    while (bus.now - began) * 1e-9 < seconds:
        bus.cycle()
        if reached(bus.actual[1]):
            return (bus.now - bus.p5 - began) * 1e-9
    raise AssertionError(f"not within {seconds} s: {bus.actual[1]}")


def test_switching_on_goes_through_every_state_and_off_again() -> None:
    bus = DriveBus(replace(PLAIN, gravity_nm=2.0))
    seen: list[State] = []

    def go(seconds: float) -> None:
        for _ in range(round(seconds / 0.004)):
            bus.cycle()
            if not seen or seen[-1] is not state(bus):
                seen.append(state(bus))

    go(0.1)
    bus.want[1].on = True
    go(0.1)
    bus.want[1].enable = True
    go(0.2)
    bus.move(lambda t: 10_000.0 * t)
    go(0.2)
    bus.want[1].enable = False
    go(0.4)
    assert bus.actual[1].power_on and not bus.actual[1].brake_open
    bus.want[1].on = False
    go(0.1)
    assert seen == [
        *(State.BOOTING, State.READY, State.CHARGING, State.POWERED, State.OPENING),
        *(State.ENABLED, State.STOPPING, State.CLOSING, State.POWERED, State.READY),
    ]


def test_a_booster_boots_answers_and_is_ready_after_boot_s() -> None:
    bus = DriveBus(PLAIN)
    assert until(bus, lambda actual: actual.ready, 0.2) == pytest.approx(0.052)  # the first SYNC after 50 ms
    assert len(bus.said) == 14 and not any(frame.data[0] & 0x0F for frame in bus.said[:-1])


def test_a_drive_on_bit_that_stands_at_power_up_is_no_command() -> None:
    bus = DriveBus(PLAIN)
    bus.want[1].on = True
    bus.run(0.3)
    assert not bus.actual[1].power_on
    bus.want[1].on = False
    bus.cycle(2)
    bus.want[1].on = True
    bus.run(0.1)
    assert bus.actual[1].power_on


def test_enable_without_drive_on_does_nothing() -> None:
    bus = DriveBus(PLAIN)
    bus.want[1].enable = True
    bus.run(0.3)
    assert state(bus) is State.READY


def test_drive_on_gone_while_charging_goes_back() -> None:
    bus = DriveBus(PLAIN)
    bus.run(0.1)
    bus.want[1].on = True
    bus.cycle(3)
    assert state(bus) is State.CHARGING
    bus.want[1].on = False
    bus.cycle(2)
    assert state(bus) is State.READY
    bus.run(0.1)
    assert state(bus) is State.READY


def test_enable_gone_while_the_brake_opens_closes_it_again() -> None:
    bus = DriveBus(PLAIN)
    bus.run(0.1)
    bus.want[1].on = True
    bus.run(0.1)
    bus.want[1].enable = True
    bus.cycle(3)
    assert state(bus) is State.OPENING
    bus.want[1].enable = False
    bus.cycle(2)
    assert state(bus) is State.CLOSING
    bus.run(0.05)
    assert state(bus) is State.POWERED and not bus.actual[1].brake_open


@pytest.mark.parametrize("delay", [0.0, 0.040, 0.120])
def test_brake_opens_after_its_delay_and_only_then_the_axis_is_enabled(delay: float) -> None:
    bus = DriveBus(replace(PLAIN, brake_open_s=delay, gravity_nm=3.0))
    bus.run(0.1)
    bus.want[1].on = True
    bus.run(0.1)
    bus.want[1].enable = True
    bus.cycle()  # the set value leaves
    took = until(bus, lambda actual: actual.brake_open, 0.5)
    assert took == pytest.approx(max(delay, 0.004), abs=1e-9)
    assert bus.actual[1].enabled


@pytest.mark.parametrize("delay", [0.012, 0.060])
def test_the_brake_closes_after_standstill_and_control_holds_until_it_has(delay: float) -> None:
    bus = enabled(replace(PLAIN, brake_close_s=delay, gravity_nm=5.0))
    bus.want[1].enable = False
    bus.cycle()
    took = until(bus, lambda actual: not actual.brake_open, 0.5)
    assert took == pytest.approx(delay + 0.001, abs=0.004)  # standstill is looked for every 1 ms
    before = bus.axis().servo.position_rad
    bus.run(0.3)
    assert abs(bus.axis().servo.position_rad - before) * INC_PER_TURN / TURN < 2.0, "gravity did not move it"
    assert bus.axis().servo.torque_nm == 0.0


def test_without_a_brake_gravity_takes_the_axis() -> None:
    bus = enabled(replace(PLAIN, brake=False))
    bus.slave.load_torque(1, 5.0)
    bus.run(0.1)
    assert abs(bus.axis().servo.speed_rad_s) < 0.1, "control holds it"
    bus.want[1].enable = False
    bus.run(0.3)
    assert bus.axis().servo.speed_rad_s < -100.0


@pytest.mark.parametrize("allowed", [True, False])
def test_brake_open_request_without_control_counts_only_where_it_is_allowed(allowed: bool) -> None:
    bus = DriveBus(replace(PLAIN, brake_release=allowed, gravity_nm=0.2))
    bus.run(0.1)
    bus.want[1].on = bus.want[1].brake = True
    bus.run(0.2)
    assert bus.actual[1].brake_open is allowed and not bus.actual[1].enabled
    bus.want[1].brake = False
    bus.run(0.1)
    assert not bus.actual[1].brake_open


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
    assert bus.actual[1].fault_code == Fault.FORCED and state(bus) is State.FAULT, "a standing reset bit is no edge"
    bus.want[1].reset = False
    bus.cycle(2)
    bus.want[1].reset = True
    bus.run(0.3)
    assert not fault(bus) and state(bus) is State.READY, "drive on still stands, it is no new command"
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


def test_the_actual_value_carries_the_torque_in_permille_of_rated() -> None:
    bus = enabled(replace(FREE, gravity_nm=3.0))
    bus.run(1.0)
    assert bus.actual[1].torque_permille == pytest.approx(500, abs=2)


def test_reference_switch_closes_between_its_two_edges() -> None:
    bus = enabled(replace(PLAIN, reference_switch_from_rad=1.0 * TURN, reference_switch_to_rad=1.25 * TURN))
    bus.move(lambda t: 2.0 * INC_PER_TURN * t)
    seen = []
    for _ in range(300):
        bus.cycle()
        seen.append((bus.actual[1].position_inc / INC_PER_TURN, bus.actual[1].reference_switch))
    assert [on for turn, on in seen if 1.02 < turn < 1.23] and all(on for turn, on in seen if 1.02 < turn < 1.23)
    assert not any(on for turn, on in seen if turn < 0.98 or turn > 1.27)


def test_the_zero_of_the_encoder_lies_where_the_resolver_reads_zero() -> None:
    """Switch at 1.0..1.25 turns, resolver offset 90 degrees: the next zero in the same direction is at 1.75 turns of the shaft."""
    bus = enabled(replace(PLAIN, reference_switch_from_rad=TURN, reference_switch_to_rad=1.25 * TURN, resolver_offset_inc=4096))
    bus.move(lambda t: 2.0 * INC_PER_TURN * t)
    until(bus, lambda actual: actual.reference_switch, 2.0)
    turn = bus.actual[1].position_inc // INC_PER_TURN
    until(bus, lambda actual: actual.position_inc // INC_PER_TURN > turn, 2.0)
    passed = bus.axis().servo.position_rad / TURN
    assert 1.75 <= passed < 1.75 + 2.0 * 0.004 + 0.001


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


def test_dropped_actual_values_are_missing_once_and_dropped_set_values_hold_the_position() -> None:
    bus = enabled(PLAIN)
    bus.slave.drop_actual(1, 3)
    said = len(bus.said)
    bus.cycle(5)
    assert len(bus.said) == said + 2 and bus.slave.counters.dropped == 3
    bus.move(lambda t: 5_000.0 * t)
    bus.run(0.2)
    bus.slave.drop_set(1, 1)
    bus.cycle(6)
    assert bus.slave.counters.dropped == 4 and not bus.actual[1].fault, "one telegram lost is within the supervision time"
    assert sum(not row.axes[0].flags & Flag.NEW_SET for row in bus.rows()) == 2  # the very first SYNC and this one


def test_the_position_wraps_as_int32_and_the_axis_does_not_notice() -> None:
    bus = DriveBus(PLAIN)
    bus.run(0.1)
    servo = bus.axis().servo
    servo._touch()[-2] += 2.0**31 - 3000 - servo.counter_inc // 1.0  # KO: as if it had turned for two hours
    bus.enable()
    assert 2**31 - 3100 < bus.actual[1].position_inc < 2**31
    bus.move(lambda t: 20_000.0 * min(t, 1.0))
    bus.run(2.0)
    assert bus.actual[1].position_inc == pytest.approx(-(2**31) + 17_000, abs=100) and not bus.actual[1].fault
    assert [wrap(value) for value in (2**31 - 1, 2**31, -(2**31) - 1, 0)] == [2**31 - 1, -(2**31), 2**31 - 1, 0]


def test_a_set_value_of_wrong_length_is_counted_and_changes_nothing() -> None:
    bus = enabled(PLAIN)
    bus.hand(Frame(210, b"\x00" * 7, bus.now), Frame(999, b"", bus.now), Frame(100, b"\x01", bus.now))
    bus.cycle(3)
    assert bus.slave.counters.undecodable == 1 and bus.actual[1].enabled


def test_a_fault_inside_a_cycle_is_said_at_once_and_told_as_an_event() -> None:
    bus = enabled(PLAIN, PLAIN)
    bus.slave.force_fault(2, 50)
    frames = bus.slave.take_output()
    assert [frame.identifier for frame in frames] == [620] and frames[0].data[1] == 50
    assert next(event for event in bus.slave.wake(bus.now) if isinstance(event, FaultRaised)).axis == 2
