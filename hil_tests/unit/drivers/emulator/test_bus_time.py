"""AX-001, AX-081: SYNC and life supervision by stamps alone; actual values in axis order; rows while SYNC is lost; working ahead."""

from dataclasses import replace
from itertools import pairwise

import pytest

from drivers.emulator.servo.record import Flag
from drivers.emulator.servo.settings import BusSettings, ServoSettings, SettingsError, from_dict, to_dict
from drivers.emulator.servodyn.axis import Fault, State
from drivers.emulator.servodyn.slave import FaultRaised, SyncLost
from hil_tests.lab.virtual.servodyn_bus import DriveBus
from protocols.base.machine import Frame

PLAIN = ServoSettings()


def state(bus: DriveBus) -> State:
    return bus.axis().state


def moving(*settings: ServoSettings, p5_ms: float = 4.0) -> DriveBus:
    bus = DriveBus(*(settings or (PLAIN,)), p5_ms=p5_ms)
    bus.enable()
    bus.move(lambda t: 200_000.0 * t)
    bus.run(0.4)
    assert bus.axis().servo.speed_rad_s > 60.0
    return bus


@pytest.mark.parametrize("p5_ms", [2.0, 4.0, 20.0])
@pytest.mark.parametrize("found_by", ["wake", "frame"])
def test_lost_sync_is_a_fault_at_its_exact_instant_whoever_finds_it(p5_ms: float, found_by: str) -> None:
    bus = moving(p5_ms=p5_ms)
    last = bus.now - bus.p5
    due = last + 2 * bus.p5 + bus.p5 // 4
    assert bus.slave.deadline() == due
    assert bus.wake(due - 1) == []
    said = bus.wake(due) if found_by == "wake" else bus.hand(Frame(100, b"", due + 3 * bus.p5))
    assert bus.events == [SyncLost(due), FaultRaised(1, Fault.SYNC_LOST, due)]
    assert said[0].identifier == 610 and said[0].data[1] == Fault.SYNC_LOST
    assert said[0].data[2:6] == bus.actual[1].position_inc.to_bytes(4, "little", signed=True) or found_by == "frame"


@pytest.mark.parametrize("p5_ms", [4.0, 10.0])
def test_the_quick_stop_begins_within_supervision_and_one_cycle_and_ends_on_the_ramp(p5_ms: float) -> None:
    bus = moving(p5_ms=p5_ms)
    last, speed = bus.now - bus.p5, bus.axis().servo.speed_rad_s
    bus.wake(last + 1_000_000_000)
    rows = [row for row in bus.rows() if row.stamp_ns > last]
    assert rows and all(row.axes[0].flags & Flag.NO_SYNC for row in rows)
    slower = next(row for row in rows if row.axes[0].speed_rad_s < speed * 0.97)
    assert slower.stamp_ns <= last + 3 * bus.p5 + bus.p5 // 4
    stopped = next(row for row in rows if row.axes[0].speed_rad_s < 1.0)
    assert (stopped.stamp_ns - last) * 1e-9 <= 2.25 * p5_ms / 1000 + speed / PLAIN.quick_stop_rad_s2 + 0.02
    assert rows[-1].axes[0].state == State.FAULT and not rows[-1].axes[0].flags & Flag.BRAKE_OPEN
    assert rows[-1].stamp_ns - last < 400_000_000, "rows end when everything is at rest"
    assert {b.stamp_ns - a.stamp_ns for a, b in pairwise(rows)} == {bus.p5}


def test_one_skipped_sync_is_no_loss_and_two_are() -> None:
    bus = moving()
    bus.now += bus.p5
    bus.cycle(20)
    assert bus.actual[1].enabled
    bus.now += 2 * bus.p5
    bus.cycle()
    assert bus.actual[1].fault_code == Fault.SYNC_LOST


def test_a_constant_life_counter_is_a_fault() -> None:
    bus = moving(PLAIN, PLAIN)
    bus.want[2].life_stands = True
    bus.cycle(6)
    assert bus.actual[2].fault_code == Fault.LIFE_LOST and bus.actual[1].enabled
    stamps = [event.stamp_ns for event in bus.events if isinstance(event, FaultRaised)]
    assert stamps == [bus.now - 6 * bus.p5 + 700_000 + 2 * bus.p5 + bus.p5 // 4]


def test_a_life_counter_that_never_ran_is_found_after_switching_on() -> None:
    bus = DriveBus(PLAIN)
    bus.want[1].life_stands = True
    bus.run(0.1)
    assert not bus.events, "without power nobody watches it"
    bus.want[1].on = True
    bus.cycle()
    switched_on = bus.now
    bus.cycle(10)
    assert bus.events == [FaultRaised(1, Fault.LIFE_LOST, switched_on + 2 * bus.p5 + bus.p5 // 4)]


def test_faults_between_two_syncs_are_said_in_order_of_time_not_of_axes() -> None:
    bus = DriveBus(PLAIN, PLAIN, p5_ms=32.0)
    bus.enable()
    bus.slave.load_torque(1, 28.0)
    bus.slave.load_torque(2, 36.0)
    said = len(bus.said)
    bus.cycle(3)
    assert [frame.identifier for frame in bus.said[said:]] == [610, 620, 620, 610, 610, 620, 610, 620]
    first, second = [event for event in bus.events if isinstance(event, FaultRaised)]
    assert (first.axis, second.axis) == (2, 1) and first.stamp_ns < second.stamp_ns


def test_silence_towards_one_axis_stops_that_axis_only() -> None:
    bus = moving(PLAIN, PLAIN, PLAIN)
    bus.want[3].silent = True
    bus.cycle(10)
    assert [bus.actual[axis].fault_code for axis in (1, 2, 3)] == [0, 0, Fault.LIFE_LOST]


def test_without_power_a_lost_sync_is_a_warning_only() -> None:
    bus = DriveBus(PLAIN)
    bus.run(0.1)
    bus.wake(bus.now + 1_000_000_000)
    assert bus.said and bus.events == [SyncLost(bus.now - bus.p5 + 9_000_000)]
    assert bus.axis().warning and state(bus) is State.READY
    bus.now += 2_000_000_000
    bus.cycle(2)
    assert not bus.actual[1].warning
    assert not bus.actual[1].fault


def test_after_a_lost_sync_nothing_moves_until_reset_and_a_new_command() -> None:
    bus = moving()
    bus.now += 1_000_000_000
    bus.run(0.5)  # SYNC is back, enable and drive on still stand
    assert bus.actual[1].fault and bus.axis().servo.speed_rad_s == 0.0
    bus.want[1].reset = True
    bus.run(0.5)
    assert not bus.actual[1].fault
    assert not bus.actual[1].power_on


def test_actual_values_follow_sync_in_axis_order_and_carry_the_latched_position() -> None:
    bus = moving(*[PLAIN] * 6)
    said = bus.hand(Frame(100, b"", bus.now))
    assert [frame.identifier for frame in said] == [610, 620, 630, 640, 650, 660]
    row = bus.rows()[-1]
    assert row.stamp_ns == bus.now and row.sync == bus.slave.counters.syncs
    assert [row.axes[n].position_inc for n in range(6)] == [bus.actual[n + 1].position_inc for n in range(6)]


def test_the_set_value_since_the_last_sync_is_activated_by_the_next() -> None:
    bus = DriveBus(PLAIN)
    bus.enable()
    bus.move(lambda t: 400.0)
    bus.hand(bus._set(1, bus.want[1])._replace(stamp_ns=bus.now - 1_000_000))
    before = bus.axis().servo.demand_inc(0)
    bus.wake(bus.now - 1)
    assert bus.axis().servo.demand_inc(0) == before, "nothing happens before SYNC"
    bus.cycle(2)
    assert bus.axis().servo.demand_inc(0) == pytest.approx(before + 400, abs=20)


def test_stamps_that_run_backwards_are_taken_as_the_latest_and_counted() -> None:
    bus = moving()
    bus.hand(Frame(100, b"", bus.now - 2 * bus.p5))
    bus.cycle(3)
    assert bus.slave.counters.out_of_order == 1 and bus.actual[1].enabled


def test_frames_handed_in_late_are_caught_up_and_counted_not_faulted() -> None:
    bus, late = moving(), moving()
    first = len(bus.trace)
    bus.run(0.4)
    frames = bus.trace[first:]
    late.slave.receive(frames, frames[-1].stamp_ns)
    assert late.slave.counters.late == 99  # of 100; the last one is not older than P5
    assert late.axis().servo._state == bus.axis().servo._state and not late.axis().fault_code


def test_working_ahead_never_changes_an_answer() -> None:
    with_it, without = moving(replace(PLAIN, torque_noise_nm=0.2)), moving(replace(PLAIN, torque_noise_nm=0.2))
    for jitter in (0, 900_000, -900_000, 30_000, -400_000, 0):
        for bus in (with_it, without):
            if bus is with_it:
                bus.slave.prepare()
            bus.hand(Frame(100, b"", bus.now + jitter))
            bus.hand(bus._set(1, bus.want[1]))
            bus.now += bus.p5
    assert with_it.said == without.said and with_it.rows() == without.rows()


def test_foreign_frames_do_not_start_the_clock() -> None:
    bus = DriveBus(PLAIN)
    assert bus.slave.receive([Frame(0x701, b"\x05", 5)], 5) == [] and bus.slave.deadline() is None


def test_a_port_that_goes_takes_the_answers_with_it_but_not_the_plant() -> None:
    bus = moving()
    bus.slave.receive([Frame(100, b"", bus.now)], bus.now)
    bus.slave.lost(bus.now)
    assert bus.slave.take_output() == []
    assert bus.axis().servo.speed_rad_s > 60.0


def test_settings_survive_the_way_through_a_dict_and_every_fault_is_named() -> None:
    settings = BusSettings(8.0, 7, {2: replace(PLAIN, hard_limit_max_rad=50.0, brake=False), 5: PLAIN})
    assert from_dict(to_dict(settings)) == settings
    raw = {"cycle_ms": 4, "axes": {"1": {"kv_per_s": 0, "stiction_nm": 0.1}, "2": {"brake": 1, "colour": 3}, "7": {}}}
    with pytest.raises(SettingsError) as caught:
        from_dict(raw)
    assert [fault.split(":")[0] for fault in caught.value.faults] == [
        *("axes.1.kv_per_s", "axes.1.stiction_nm", "axes.2.colour", "axes.2.brake"),
    ]
    assert "0.1..500 1/s" in caught.value.faults[0]
    with pytest.raises(SettingsError, match="module 7"):
        from_dict({"axes": {"7": {}}})
