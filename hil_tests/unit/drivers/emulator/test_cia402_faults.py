"""Following error, limit switches, touch probes and faults to order of the emulated CiA 402 drive."""

import pytest

from drivers.emulator.servo.settings import DriveSettings, ServoSettings
from hil_tests.lab.virtual.canopen_bus import AbortedError, CanopenBus, Master
from hil_tests.lab.virtual.cia402_axis import PLAIN, SPEED, running

# -- following error --------------------------------------------------------------------------------


def blocked(window: int, time_ms: int) -> tuple[CanopenBus, Master]:
    """In position control, pushed by more than its torque limit."""
    bus = CanopenBus(DriveSettings(PLAIN))
    node = bus.node()
    node.enable(1)
    node.set(0x6065, window)
    node.set(0x6066, time_ms)
    node.set(0x6072, 50)
    return bus, node


def test_the_following_error_window_and_time_out_of_6065_and_6066() -> None:
    bus, node = blocked(1000, 100)
    bus.slave.load_torque(1, 2.0)
    node.until(lambda: abs(node.read(0x60F4)) > 1000, step_s=0.0005)
    assert node.status & 0x2000, "bit 13 in profile position"
    took = node.until(lambda: node.status & 0x4F == 0x08, step_s=0.0005)
    assert took == pytest.approx(0.100, abs=0.004) and node.read(0x603F) == 0x8611


def test_a_following_error_that_goes_in_time_is_no_fault() -> None:
    bus, node = blocked(1000, 100)
    bus.slave.load_torque(1, 2.0)
    node.until(lambda: bool(node.status & 0x2000), step_s=0.0005)
    node.set(0x6072, 3000)
    bus.run(0.5)
    assert node.status & 0x6F == 0x27 and not node.status & 0x2000


def test_no_window_no_fault_and_no_time_at_once() -> None:
    bus, node = blocked(0xFFFFFFFF, 0)
    bus.slave.load_torque(1, 2.0)
    bus.run(0.3)
    assert abs(node.read(0x60F4)) > 2000 and node.status & 0x6F == 0x27
    bus, node = blocked(1000, 0)
    bus.slave.load_torque(1, 2.0)
    node.until(lambda: abs(node.read(0x60F4)) > 1000, step_s=0.0003)
    bus.run(0.0005)
    assert node.status & 0x4F == 0x08 and node.read(0x6074) == 0, "torque off: its feedback is not to be trusted"


# -- limits and probes ------------------------------------------------------------------------------


def test_a_limit_switch_stops_the_motion_towards_it_and_lets_it_back() -> None:
    bus, node = running(ServoSettings(boot_s=0.01, charge_s=0.0, brake=False, hard_limit_max_rad=100.0))
    node.until(lambda: bool(node.status & 0x800))
    bus.run(0.2)
    assert node.read(0x60FD) & 3 == 2 and abs(node.read(0x606C)) < 2000 and node.status & 0x6F == 0x27
    assert bus.axis().servo.position_rad < 103.0
    node.set(0x60FF, -SPEED)
    node.until(lambda: not node.read(0x60FD) & 3)
    bus.run(0.5)
    assert node.read(0x606C) == pytest.approx(-SPEED, rel=0.02) and not node.status & 0x800


def probing(function: int, from_rad: float = 20.0, to_rad: float = 30.0) -> tuple[CanopenBus, Master]:
    bus = CanopenBus(DriveSettings(PLAIN, probe_1_from_rad=from_rad, probe_1_to_rad=to_rad, probe_2_from_rad=40.0, probe_2_to_rad=41.0))
    node = bus.node()
    node.enable(3)
    node.set(0x60B8, function)
    node.set(0x60FF, SPEED)
    return bus, node


def inc(rad: float) -> int:
    return int(rad * 16384 / 6.283185307179586)


def there_and_back(node: Master) -> None:
    node.until(lambda: node.read(0x6064) > inc(35.0))
    node.set(0x60FF, -SPEED)
    node.until(lambda: node.read(0x6064) < inc(15.0))


def test_touch_probe_1_keeps_the_exact_place_of_both_edges() -> None:
    _, node = probing(0x0031)
    assert node.read(0x60B9) == 0x0001
    node.until(lambda: node.read(0x60B9) == 0x0003)
    assert node.read(0x60FD) >> 16 & 1
    node.until(lambda: node.read(0x60B9) == 0x0007)
    assert abs(node.read(0x60BA) - inc(20.0)) <= 1 and abs(node.read(0x60BB) - inc(30.0)) <= 1


def test_touch_probe_2_and_the_index_pulse_as_source() -> None:
    _, node = probing(0x1100 | 0x0015)
    node.until(lambda: node.read(0x60B9) == 0x0303)
    assert node.read(0x60BA) == 16384, "the first index"
    assert abs(node.read(0x60BC) - inc(40.0)) <= 1


def test_a_probe_takes_the_first_edge_once_or_every_edge_continuously() -> None:
    for function, passes in ((0x0011, 1), (0x0013, 2)):
        bus, node = probing(function)
        there_and_back(node)
        taken = node.read(0x60BA)
        assert abs(taken - (inc(20.0) if passes == 1 else inc(30.0))) <= 1, "backwards the switch rises at its other end"
        assert bus.axis().probe.status & 2


@pytest.mark.parametrize("at_rad", [20.1, 20.3])
def test_an_edge_is_kept_when_the_function_is_written_just_behind_it(at_rad: float) -> None:
    """The model looks every 250 us: what it has passed since then was forgotten by the write."""
    bus, node = probing(0x0011, at_rad)
    axis = bus.axis()
    while axis.servo.position_rad < 21.0:
        bus.run(60e-6)
        axis.advance(bus.now)
        axis.objects.written[0x60B8, 0](0x0011)
    assert node.read(0x60B9) == 0x0003 and abs(node.read(0x60BA) - inc(at_rad)) <= 1


# -- faults to order --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "code", "register"),
    [
        ("undervoltage", 0x3220, 0x05),
        ("overvoltage", 0x3210, 0x05),
        ("phase_loss", 0x3130, 0x05),
        ("over_temperature", 0x4210, 0x09),
        ("motor_over_temperature", 0x4310, 0x09),
        ("short_circuit", 0x2340, 0x03),
        ("encoder_fault", 0x7303, 0x21),
        ("motor_blocked", 0x7121, 0x21),
    ],
)
def test_a_cause_gives_the_standard_s_code_and_stays_until_it_goes(name: str, code: int, register: int) -> None:
    bus, node = running()
    bus.slave.cause(1, name, True)
    assert node.read(0x603F) == code and node.read(0x1001) == register
    assert bus.heard(0x81)[-1].data[:3] == code.to_bytes(2, "little") + bytes((register,))
    bus.run(1.5)
    assert node.status & 0x4F == 0x08
    node.control(0)
    assert node.control(0x80) & 0x4F == 0x08, "the cause stands"
    bus.slave.cause(1, name, False)
    node.control(0)
    assert node.control(0x80) & 0x4F == 0x40 and node.read(0x603F) == 0 and node.read(0x1001) == 0
    assert bus.heard(0x81)[-1].data == bytes(8)
    assert node.read(0x1003, 0) == 1 and node.read(0x1003, 1) & 0xFFFF == code


def test_no_switching_on_without_dc_link() -> None:
    bus = CanopenBus()
    node = bus.node()
    bus.run(0.1)
    bus.slave.cause(1, "undervoltage", True)
    assert not node.status & 0x10 and node.read(0x6079) == 0
    bus.slave.cause(1, "undervoltage", False)
    node.control(0x80)
    assert node.control(6) & 0x3F == 0x31 and node.read(0x6079) == 560_000


def test_a_stuck_encoder_ends_in_a_following_error() -> None:
    bus, node = running()
    node.set(0x6060, 1)
    node.set(0x607A, 400_000)
    node.control(0x1F)
    bus.run(0.1)
    bus.slave.stuck_encoder(1)
    node.until(lambda: node.status & 0x4F == 0x08)
    assert node.read(0x603F) in (0x8611, 0x7310)


def test_a_wrong_sign_runs_away_and_is_caught() -> None:
    bus, node = running()
    bus.slave.wrong_sign(1)
    node.until(lambda: node.status & 0x4F == 0x08)
    assert node.read(0x603F) in (0x8611, 0x7310) and node.read(0x6074) == 0


def test_a_jump_of_the_encoder_is_a_following_error() -> None:
    bus = CanopenBus(DriveSettings(PLAIN))
    node = bus.node()
    node.enable(1)
    bus.slave.jump_encoder(1, 20_000)
    node.until(lambda: node.status & 0x4F == 0x08)
    assert node.read(0x603F) == 0x8611


def test_a_brake_that_does_not_open_ends_in_a_following_error() -> None:
    bus = CanopenBus(DriveSettings(ServoSettings(boot_s=0.01, charge_s=0.0, brake_torque_nm=30.0)))
    node = bus.node()
    bus.slave.stick_brake(1, True)
    node.enable(1)
    node.set(0x607A, 400_000)
    node.control(0x1F)
    node.until(lambda: node.status & 0x4F == 0x08)
    assert node.read(0x603F) == 0x8611 and abs(node.read(0x6064)) < 50


def test_overload_warns_and_trips() -> None:
    servo = ServoSettings(boot_s=0.01, charge_s=0.0, brake=False, i2t_time_constant_s=0.5)
    bus = CanopenBus(DriveSettings(servo))
    node = bus.node()
    node.enable(1)
    bus.slave.load_torque(1, 9.0)
    node.until(lambda: bool(node.status & 0x80))
    node.until(lambda: node.status & 0x4F in (0x0F, 0x08))
    assert node.read(0x603F) == 0x2350


def test_local_control_refuses_the_controlword() -> None:
    bus = CanopenBus()
    node = bus.node()
    bus.run(0.1)
    bus.slave.local_control(1, True)
    assert not node.status & 0x200
    with pytest.raises(AbortedError) as caught:
        node.control(6)
    assert caught.value.code == 0x08000021
    bus.slave.local_control(1, False)
    assert node.control(6) & 0x6F == 0x21
