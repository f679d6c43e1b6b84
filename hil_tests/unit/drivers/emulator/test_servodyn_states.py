"""AX-001 and AX-080..089: power states of an emulated booster, its brake, its encoder, its telegrams; in virtual time."""

from dataclasses import replace

import pytest

from drivers.emulator.servo.record import Flag
from drivers.emulator.servo.settings import INC_PER_TURN
from drivers.emulator.servodyn.axis import State
from drivers.emulator.servodyn.commanded import wrap
from drivers.emulator.servodyn.slave import FaultRaised
from hil_tests.lab.virtual.servodyn_axis import FREE, PLAIN, TURN, enabled, state, until
from hil_tests.lab.virtual.servodyn_bus import DriveBus
from protocols.base.machine import Frame


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


def test_a_drive_on_bit_that_is_set_at_power_up_is_no_command() -> None:
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


def test_a_fault_inside_a_cycle_is_said_at_once_and_reported_as_an_event() -> None:
    bus = enabled(PLAIN, PLAIN)
    bus.slave.force_fault(2, 50)
    frames = bus.slave.take_output()
    assert [frame.identifier for frame in frames] == [620] and frames[0].data[1] == 50
    assert next(event for event in bus.slave.wake(bus.now) if isinstance(event, FaultRaised)).axis == 2
