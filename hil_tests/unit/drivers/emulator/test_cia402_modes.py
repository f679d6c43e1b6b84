"""Modes of operation of the emulated CiA 402 drive against the standard's text, over SDO and PDO frames in virtual time."""

import math

import pytest

from drivers.emulator.servo.settings import DriveSettings, ServoSettings
from hil_tests.lab.virtual.canopen_bus import AbortedError, CanopenBus, Master, rpdo1, tpdo1

PLAIN = ServoSettings(boot_s=0.01, charge_s=0.0, brake=False)


def bus_in(mode: int, servo: ServoSettings = PLAIN, cycle_ms: float = 4.0) -> tuple[CanopenBus, Master]:
    bus = CanopenBus(DriveSettings(servo), cycle_ms=cycle_ms)
    node = bus.node()
    node.enable(mode)
    return bus, node


def set_point(node: Master, target: int, bits: int = 0) -> None:
    """The whole handshake."""
    node.set(0x607A, target)
    assert node.control(0x1F | bits) & 0x1000, "acknowledged"
    node.control(0x0F)


def reached(node: Master, limit_s: float = 5.0) -> float:
    return node.until(lambda: bool(node.status & 0x400), limit_s)


# -- profile position -----------------------------------------------------------------------------


def test_a_set_point_at_zero_is_reached_like_any_other() -> None:
    """Near 0 the rest of the way is smaller than what rounding leaves of the allowed speed."""
    _, node = bus_in(1)
    for target in (8192, 0, -5000, 0):
        set_point(node, target)
        reached(node, 1.0)
        assert abs(node.read(0x6064) - target) < 40


def test_a_trapezoid_takes_the_time_that_speed_and_ramps_say() -> None:
    _, node = bus_in(1)
    node.set(0x6081, 100_000)
    node.set(0x6083, 1_000_000)
    node.set(0x6084, 500_000)
    set_point(node, 100_000)
    took = reached(node)
    assert took == pytest.approx(1.0 + 0.1 / 2 + 0.2 / 2, abs=0.1)  # s/v + v/2a + v/2d, and the lag
    assert abs(node.read(0x6064) - 100_000) <= 20


def test_the_speed_of_a_profile_is_6081_and_never_more_than_607f() -> None:
    bus, node = bus_in(1)
    node.set(0x6081, 50_000)
    set_point(node, 200_000)
    bus.run(1.0)
    assert node.read(0x606C) == pytest.approx(50_000, rel=0.02)
    node.set(0x607F, 20_000)
    set_point(node, 0, bits=0x20)
    bus.run(1.0)
    assert node.read(0x606C) == pytest.approx(-20_000, rel=0.02)


def test_a_second_set_point_waits_and_keeps_bit_12_until_the_first_is_done() -> None:
    bus, node = bus_in(1)
    set_point(node, 40_000)
    bus.run(0.05)
    node.set(0x607A, 60_000)
    assert node.control(0x1F) & 0x1000
    assert node.control(0x0F) & 0x1000, "the buffer is taken: no further set-point may come"
    node.until(lambda: not node.status & 0x1000)
    assert node.read(0x6064) == pytest.approx(40_000, abs=900), "the first target was reached first"
    reached(node)
    assert abs(node.read(0x6064) - 60_000) <= 20


def test_a_set_point_offered_while_the_buffer_is_taken_is_left_aside() -> None:
    bus, node = bus_in(1)
    set_point(node, 40_000)
    bus.run(0.05)
    node.set(0x607A, 60_000)
    node.control(0x1F)
    node.control(0x0F)
    node.set(0x607A, -90_000)
    node.control(0x1F)
    node.control(0x0F)
    node.until(lambda: not node.status & 0x1000)
    reached(node)
    assert abs(node.read(0x6064) - 60_000) <= 20


def test_bit_4_left_set_by_a_homing_is_no_set_point() -> None:
    bus, node = bus_in(6)
    node.control(0x1F)
    bus.run(0.01)
    node.set(0x6060, 1)
    node.set(0x607A, 50_000)
    assert not node.control(0x1F) & 0x1000
    bus.run(0.2)
    assert abs(node.read(0x6064)) < 5
    node.control(0x0F)
    assert node.control(0x1F) & 0x1000


def test_change_set_immediately_leaves_for_the_new_target_at_once() -> None:
    bus, node = bus_in(1)
    set_point(node, 400_000)
    bus.run(0.5)
    assert node.read(0x606C) > 100_000
    set_point(node, 10_000, bits=0x20)
    furthest = 0
    for _ in range(3000):
        furthest = max(furthest, node.read(0x6064))
        if node.status & 0x400:
            break
        bus.run(0.001)
    assert furthest < 150_000 and abs(node.read(0x6064) - 10_000) <= 20


def test_a_relative_set_point_counts_from_the_target_before() -> None:
    _, node = bus_in(1)
    set_point(node, 10_000)
    reached(node)
    set_point(node, 5_000, bits=0x40)
    reached(node)
    set_point(node, -1_000, bits=0x40)
    reached(node)
    assert abs(node.read(0x6064) - 14_000) <= 20


def test_change_on_set_point_passes_the_first_target_without_stopping() -> None:
    bus, node = bus_in(1)
    set_point(node, 60_000)
    bus.run(0.1)
    set_point_word = 0x1F | 0x200
    node.set(0x607A, 200_000)
    node.control(set_point_word)
    node.control(0x0F)
    slowest = math.inf
    while node.read(0x6064) < 80_000:
        if node.read(0x6064) > 40_000:
            slowest = min(slowest, node.read(0x606C))
        bus.run(0.002)
    assert slowest > 150_000
    reached(node)
    assert abs(node.read(0x6064) - 200_000) <= 20


def test_target_reached_needs_window_and_time() -> None:
    _, node = bus_in(1)
    node.set(0x6067, 5)
    node.set(0x6068, 300)
    set_point(node, 5_000)
    node.until(lambda: abs(node.read(0x6064) - 5_000) <= 5)
    assert not node.status & 0x400
    assert reached(node) >= 0.28


def test_halt_slows_down_sets_bit_10_at_rest_and_its_end_goes_on() -> None:
    bus, node = bus_in(1)
    set_point(node, 300_000)
    bus.run(0.5)
    node.control(0x10F)
    node.until(lambda: bool(node.status & 0x400))
    bus.run(0.05)
    stopped = node.read(0x6064)
    assert 20_000 < stopped < 250_000 and abs(node.read(0x606C)) < 200
    bus.run(0.3)
    assert abs(node.read(0x6064) - stopped) < 20, "it holds"
    node.control(0x0F)
    reached(node)
    assert abs(node.read(0x6064) - 300_000) <= 20


def test_a_target_beyond_607d_is_clipped_and_shown() -> None:
    _, node = bus_in(1)
    node.set(0x607D, -1_000, 1)
    node.set(0x607D, 20_000, 2)
    set_point(node, 50_000)
    assert node.status & 0x800
    reached(node)
    assert abs(node.read(0x6064) - 20_000) <= 20
    set_point(node, 0)
    assert not node.status & 0x800


# -- profile velocity -----------------------------------------------------------------------------


def test_profile_velocity_ramps_and_reports_target_reached_and_standstill() -> None:
    bus, node = bus_in(3)
    bus.run(0.1)
    assert node.status & 0x1000, "speed is 0"
    node.set(0x6083, 500_000)
    node.set(0x60FF, 100_000)
    bus.run(0.1)
    assert node.read(0x606C) == pytest.approx(50_000, abs=4_000), "0.1 s at 500000 inc/s2"
    assert not node.status & 0x1400
    bus.run(0.3)
    assert node.status & 0x1400 == 0x400 and node.read(0x606C) == pytest.approx(100_000, rel=0.01)
    node.set(0x6084, 2_000_000)
    node.set(0x60FF, -100_000)
    bus.run(0.07)
    assert node.read(0x606C) > -30_000, "down with 6084h, then up with 6083h"
    bus.run(0.4)
    assert node.read(0x606C) == pytest.approx(-100_000, rel=0.01)
    node.set(0x60FF, 0)
    bus.run(0.3)
    assert node.status & 0x1400 == 0x1400


def test_max_profile_velocity_limits_profile_velocity() -> None:
    bus, node = bus_in(3)
    node.set(0x607F, 60_000)
    node.set(0x60FF, 500_000)
    bus.run(0.5)
    assert node.read(0x606C) == pytest.approx(60_000, rel=0.01)


# -- cyclic modes ---------------------------------------------------------------------------------


def cyclic(mode: int, servo: ServoSettings = PLAIN, cycle_ms: float = 4.0) -> tuple[CanopenBus, Master]:
    bus = CanopenBus(DriveSettings(servo), cycle_ms=cycle_ms)
    node = bus.node()
    node.in_cycle(mode)
    return bus, node


def test_csp_reaches_each_set_value_one_cycle_after_the_sync_that_took_it() -> None:
    bus, node = cyclic(8)
    for step in range(1, 101):
        bus.cycle(rpdo1(1, 15, 100 * step))
    rows = [row.axes[0] for row in bus.rows() if row.axes[0].flags & 4 and not row.axes[0].flags & 1]
    assert [row.set_inc for row in rows[-50:]] == [100 * step for step in range(50, 100)], "the value of cycle k stands at SYNC k+1"
    assert rows[-1].set_inc - rows[-1].position_inc == pytest.approx(100 / 0.004 / 80, abs=8), "lag = speed / kv"
    assert node.status & 0x1000


def test_csp_in_increments_not_in_thousands() -> None:
    bus, _ = cyclic(8)
    for step in range(1, 60):
        answers = bus.cycle(rpdo1(1, 15, min(step * 37, 1999)))
    for _ in range(100):
        answers = bus.cycle(rpdo1(1, 15, 1999))
    assert abs(tpdo1(answers[0])[1] - 1999) <= 1


def test_csp_without_a_new_value_stays_where_the_last_one_pointed() -> None:
    bus, _ = cyclic(8)
    for step in range(1, 51):
        bus.cycle(rpdo1(1, 15, 100 * step))
    for _ in range(100):
        answers = bus.cycle()
    word, position = tpdo1(answers[0])
    assert abs(position - 5000) <= 2 and word & 0x6F == 0x27


def test_csp_counts_on_through_the_end_of_int32() -> None:
    bus, node = cyclic(8)
    bus.axis().place.shift = 0x7FFFFF00
    node.set(0x607A, node.read(0x6064))
    position = node.read(0x6064)
    for _ in range(60):
        position += 100
        answers = bus.cycle(rpdo1(1, 15, position))
    for _ in range(60):
        answers = bus.cycle(rpdo1(1, 15, position))
    assert tpdo1(answers[0])[1] < 0, "the counter has wrapped"
    assert abs(tpdo1(answers[0])[1] - (position - 2**32)) <= 2


def test_csp_jumps_when_607a_was_not_set_to_6064_before() -> None:
    """What a gateway must do before switching on: ours shows what happens when it does not."""
    bus = CanopenBus(DriveSettings(ServoSettings(start_rad=100.0, boot_s=0.01, charge_s=0.0, brake=False)))
    node = bus.node()
    node.in_cycle(8)
    node.set(0x607A, node.read(0x6064) + 100_000)
    for _ in range(20):
        bus.cycle()
    assert node.read(0x603F) == 0x8611 and node.status & 0x4F == 0x08


def test_the_velocity_offset_takes_the_lag_away() -> None:
    lags = []
    for offset in (0, 25_000):
        servo = ServoSettings(boot_s=0.01, charge_s=0.0, brake=False, speed_feed_forward=1.0)
        bus, node = cyclic(8, servo)
        node.set(0x60B1, offset)
        for step in range(1, 151):
            bus.cycle(rpdo1(1, 15, 100 * step))
        lags.append(abs(node.read(0x60F4)))
    assert lags[0] > 250 and lags[1] < 60


def test_csv_follows_60ff_with_each_sync_inside_60c5() -> None:
    bus, node = cyclic(9)
    node.set(0x60FF, 50_000)
    bus.run(0.004)
    assert abs(node.read(0x606C)) < 100, "no SYNC, no change"
    for _ in range(25):
        bus.cycle(rpdo1(1, 15, 0))
    assert node.read(0x606C) == pytest.approx(50_000, rel=0.01)
    node.set(0x60C6, 500_000)
    node.set(0x60FF, 0)
    for _ in range(10):
        bus.cycle(rpdo1(1, 15, 0))
    assert 20_000 < node.read(0x606C) < 40_000, "0.04 s at 500000 inc/s2"


def test_cst_gives_the_torque_and_limits_the_speed() -> None:
    bus, node = cyclic(10)
    node.set(0x6071, 300)
    for _ in range(10):
        bus.cycle(rpdo1(1, 15, 0))
    assert node.read(0x6077) == pytest.approx(300, abs=3)
    assert node.read(0x606C) > 0
    inertia, torque = PLAIN.inertia_kgm2, 0.3 * PLAIN.rated_torque_nm
    speed = bus.axis().servo.speed_rad_s
    for _ in range(25):
        bus.cycle(rpdo1(1, 15, 0))
    gained = bus.axis().servo.speed_rad_s - speed
    assert gained == pytest.approx((torque - PLAIN.coulomb_nm) / inertia * 0.1, rel=0.05)
    for _ in range(150):
        bus.cycle(rpdo1(1, 15, 0))
    assert bus.axis().servo.speed_rad_s == pytest.approx(PLAIN.speed_limit_rad_s, rel=0.02) and node.status & 0x6F == 0x27
    node.set(0x6071, -300)
    for _ in range(10):
        bus.cycle(rpdo1(1, 15, 0))
    assert node.read(0x6077) == pytest.approx(-300, abs=3)


def test_6072_limits_the_torque_in_position_modes_too() -> None:
    bus, node = bus_in(1)
    node.set(0x6072, 100)
    node.set(0x6065, 0xFFFFFFFF)
    set_point(node, 400_000)
    peak = 0
    for _ in range(100):
        bus.run(0.001)
        peak = max(peak, abs(node.read(0x6077)))
    assert 95 <= peak <= 100


def test_ip_starts_with_bit_4_and_uses_60c2() -> None:
    bus, node = cyclic(7, cycle_ms=4.0)
    node.set(0x60C2, 20, 1)
    node.set(0x60C2, -3, 2)
    node.set(0x60C1, 2000, 1)
    for _ in range(5):
        bus.cycle(rpdo1(1, 0x0F, 0))
    assert abs(node.read(0x6064)) < 5 and not node.status & 0x1000, "not active without bit 4"
    bus.run(0.016)
    bus.hand(rpdo1(1, 0x1F, 0))
    bus.cycle()
    assert node.status & 0x1000
    bus.run(0.010)
    assert node.read(0x6062) == pytest.approx(1000, abs=120), "half of the way after half of 60C2h"
    bus.run(0.010)
    assert node.read(0x6062) == 2000


# -- which modes there are ------------------------------------------------------------------------


def test_every_mode_of_6502_can_be_chosen_and_shows_in_6061() -> None:
    bus = CanopenBus()
    node = bus.node()
    bus.run(0.1)
    assert node.read(0x6502) == 0x3E5
    for mode in range(-5, 12):
        if mode == 0 or (mode > 0 and 0x3E5 >> (mode - 1) & 1):
            node.set(0x6060, mode)
            assert node.read(0x6061) == mode
        else:
            with pytest.raises(AbortedError) as caught:
                node.set(0x6060, mode)
            assert caught.value.code == 0x06090030


def test_a_new_mode_in_motion_holds_until_its_first_set_value() -> None:
    bus, node = bus_in(1)
    set_point(node, 400_000)
    bus.run(0.5)
    node.set(0x6060, 6)
    bus.run(0.3)
    there = node.read(0x6064)
    bus.run(0.2)
    assert abs(node.read(0x6064) - there) < 5 and node.status & 0x6F == 0x27
