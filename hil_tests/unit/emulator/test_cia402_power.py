"""Power states, option codes, brake, supervision, limits, faults of the emulated CiA 402 drive."""

import pytest

from drivers.emulator.cia402_states import STATUS, TRANSITIONS, Command, State, command_of
from drivers.emulator.settings import DriveSettings, ServoSettings
from hil_tests.lab.canopen_bus import AbortedError, CanopenBus, Master, rpdo1, tpdo1
from protocols.base.machine import Frame, FrameFault
from protocols.canopen import cobid, nmt

PLAIN = ServoSettings(boot_s=0.01, charge_s=0.0, brake=False)
BRAKED = ServoSettings(boot_s=0.01, charge_s=0.0, brake_open_s=0.040, brake_close_s=0.020)
SPEED = 100_000  # inc/s of the axis when something happens


def running(servo: ServoSettings = PLAIN, **options: int) -> tuple[CanopenBus, Master]:
    """An axis in profile velocity at SPEED; options by name below."""
    bus = CanopenBus(DriveSettings(servo))
    node = bus.node()
    node.enable(3)
    for name, value in options.items():
        node.set(int(name.removeprefix("o"), 16), value)
    node.set(0x60FF, SPEED)
    node.until(lambda: bool(node.status & 0x400))
    return bus, node


def stopping_time(bus: CanopenBus, node: Master) -> float:
    return node.until(lambda: abs(node.read(0x606C)) < 2000)


# -- the automaton ----------------------------------------------------------------------------------


def test_the_status_bits_of_all_states_are_the_standard_s_masks() -> None:
    """x0xx0000, x1xx0000, x01x0001, x01x0011, x01x0111, x00x0111, x0xx1111, x0xx1000 (bits 0..3, 5, 6)."""
    masks = [(0x4F, 0x00), (0x4F, 0x40), (0x6F, 0x21), (0x6F, 0x23), (0x6F, 0x27), (0x6F, 0x07), (0x4F, 0x0F), (0x4F, 0x08)]
    for state in State:
        fitting = [State(number) for number, (mask, bits) in enumerate(masks) if STATUS[state] & mask == bits]
        assert fitting == [state]


def test_the_commands_are_those_of_the_standard_over_all_controlwords() -> None:
    """Table "command coding" of the standard, read as masks: (bits that count, their value)."""
    table = {
        Command.SHUTDOWN: (0x87, 0x06),
        Command.SWITCH_ON: (0x8F, 0x07),
        Command.ENABLE: (0x8F, 0x0F),
        Command.DISABLE_VOLTAGE: (0x82, 0x00),
        Command.QUICK_STOP: (0x86, 0x02),
    }
    for word in range(0x10000):
        fitting = [command for command, (mask, bits) in table.items() if word & mask == bits]
        assert command_of(word) is (fitting[0] if fitting else Command.NONE) and len(fitting) <= 1


def test_the_transitions_by_command_are_2_to_12_and_16() -> None:
    assert {number for number, _ in TRANSITIONS.values()} == {2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 16}


# -- brake ------------------------------------------------------------------------------------------


def test_operation_is_enabled_when_the_brake_is_open_and_left_when_it_is_closed() -> None:
    bus = CanopenBus(DriveSettings(BRAKED))
    node = bus.node()
    bus.run(0.05)
    node.control(6)
    assert node.control(15) & 0x6F == 0x23
    assert node.until_state(0x27) == pytest.approx(0.040, abs=0.002)
    assert bus.axis().brake_open
    node.control(7)
    assert node.until_state(0x23) == pytest.approx(0.020, abs=0.003)
    assert not bus.axis().brake_open


def test_a_vertical_axis_does_not_fall_between_enable_and_disable() -> None:
    bus = CanopenBus(DriveSettings(ServoSettings(boot_s=0.01, charge_s=0.0, gravity_nm=3.0)))
    node = bus.node()
    node.enable(3)
    lowest = 0.0
    for word in (7, 15, 7, 15, 2, 0, 6, 15, 7):
        node.control(word)
        for _ in range(100):
            bus.run(0.001)
            lowest = min(lowest, bus.axis().servo.position_rad)
    assert lowest > -0.25, "torque off before the brake holds would cost 0.3 rad each time"


def test_disable_voltage_lets_the_axis_coast_and_the_brake_fall() -> None:
    bus, node = running(BRAKED)
    node.control(0)
    assert node.status & 0x6F == 0x40 and node.read(0x6074) == 0
    bus.run(0.015)
    assert node.read(0x606C) > 0.8 * SPEED, "no torque, brake not yet closed"
    assert stopping_time(bus, node) < 0.05


def test_shutdown_before_the_brake_is_open_takes_the_enable_back() -> None:
    bus = CanopenBus(DriveSettings(BRAKED))
    node = bus.node()
    bus.run(0.05)
    node.control(6)
    node.control(15)
    bus.run(0.01)
    node.control(6)
    bus.run(0.2)
    assert node.status & 0x6F == 0x21 and not bus.axis().brake_open


# -- option codes -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("option", "seconds", "state"),
    [(1, 0.5, 0x40), (2, 0.1, 0x40), (3, 0.0, 0x40), (4, 0.0, 0x40), (5, 0.5, 0x07), (6, 0.1, 0x07), (7, 0.0, 0x07), (8, 0.0, 0x07)],
)
def test_605a_decides_how_quick_stop_stops_and_where_it_ends(option: int, seconds: float, state: int) -> None:
    bus, node = running(o605A=option, o6084=200_000, o6085=1_000_000)
    node.control(2)
    assert node.status & 0x6F == 0x07
    assert stopping_time(bus, node) == pytest.approx(seconds, abs=0.03)
    bus.run(0.1)
    assert node.status & 0x6F == state


def test_605a_0_takes_the_torque_away_at_once() -> None:
    _, node = running(o605A=0)
    assert node.control(2) & 0x6F == 0x40 and node.read(0x6074) == 0


def test_quick_stop_that_stays_holds_position_and_16_leads_back() -> None:
    bus, node = running(o605A=6)
    node.control(2)
    bus.run(0.2)
    there = node.read(0x6064)
    bus.slave.load_torque(1, 2.0)
    bus.run(0.2)
    assert abs(node.read(0x6064) - there) < 100
    assert node.control(15) & 0x6F == 0x27
    assert node.until(lambda: node.read(0x606C) > 0.95 * SPEED) < 0.5


def test_quick_stop_with_options_1_to_4_does_not_go_back_to_work() -> None:
    bus, node = running(o605A=1, o6084=200_000)
    node.control(2)
    bus.run(0.1)
    assert node.control(15) & 0x6F == 0x07, "no transition 16"
    node.until_state(0x40)


@pytest.mark.parametrize(("option", "seconds"), [(0, None), (1, 0.5)])
@pytest.mark.parametrize(("index", "word", "state"), [("605B", 6, 0x21), ("605C", 7, 0x23)])
def test_605b_and_605c_coast_or_slow_down(option: int, seconds: float | None, index: str, word: int, state: int) -> None:
    bus, node = running(PLAIN, **{f"o{index}": option, "o6084": 200_000})
    node.control(word)
    if seconds is None:
        assert node.status & 0x6F == state and node.read(0x6074) == 0
        return
    assert node.status & 0x6F == 0x27, "not left before it stands"
    assert stopping_time(bus, node) == pytest.approx(seconds, abs=0.03)
    node.until_state(state)


@pytest.mark.parametrize(("option", "seconds"), [(1, 0.5), (2, 0.1), (3, 0.0), (4, 0.0)])
def test_605d_decides_how_halt_stops(option: int, seconds: float) -> None:
    bus, node = running(o605D=option, o6084=200_000, o6085=1_000_000)
    node.control(0x10F)
    assert stopping_time(bus, node) == pytest.approx(seconds, abs=0.03)
    bus.run(0.02)
    assert node.status & 0x6F == 0x27 and node.status & 0x400


@pytest.mark.parametrize(("option", "seconds"), [(0, None), (1, 0.5), (2, 0.1), (3, 0.0), (4, 0.0)])
def test_605e_decides_how_a_fault_stops(option: int, seconds: float | None) -> None:
    bus, node = running(o605E=option, o6084=200_000, o6085=1_000_000)
    bus.slave.cause(1, "over_temperature", True)
    if seconds is None:
        assert node.status & 0x4F == 0x08 and node.read(0x6074) == 0
    else:
        assert node.status & 0x4F == 0x0F
        assert stopping_time(bus, node) == pytest.approx(seconds, abs=0.03)
        node.until(lambda: node.status & 0x4F == 0x08)
    assert node.read(0x603F) == 0x4210


def test_a_ramp_that_does_not_end_in_time_is_a_fault_of_its_own() -> None:
    bus, node = running(ServoSettings(boot_s=0.01, charge_s=0.0, brake=False, stop_timeout_s=0.2), o605A=1, o6084=50_000)
    node.control(2)
    bus.run(0.25)
    assert node.read(0x603F) == 0xF001 and node.status & 0x4F == 0x08 and node.read(0x6074) == 0


# -- loss of the master -----------------------------------------------------------------------------


def watched(option: int, behaviour: int = 1) -> tuple[CanopenBus, Master]:
    """Runs, and watches the gateway: node 127, 150 ms."""
    bus, node = running()
    node.set(0x1016, 127 << 16 | 150, 1)
    node.set(0x6007, option)
    node.set(0x1029, behaviour, 1)
    node.nmt(nmt.Command.START)
    for _ in range(10):
        bus.hand(nmt.heartbeat(127, nmt.State.OPERATIONAL))
        bus.run(0.05)
    assert node.status & 0x6F == 0x27
    return bus, node


@pytest.mark.parametrize(("option", "state", "code"), [(0, 0x27, 0), (1, 0x0F, 0x8130), (2, 0x40, 0), (3, 0x07, 0)])
def test_6007_decides_what_the_loss_of_the_heartbeat_does(option: int, state: int, code: int) -> None:
    bus, node = watched(option)
    before = len(bus.said)
    bus.run(0.0999)  # the last beat is 50 ms old already
    assert node.status & 0x6F == 0x27
    bus.run(0.0002)
    assert node.status & (0x4F if state == 0x0F else 0x6F) == state and node.read(0x603F) == code
    assert [frame.data[:2] for frame in bus.heard(0x81, before)] == [b"\x30\x81"], "told once"
    bus.hand(nmt.heartbeat(127, nmt.State.OPERATIONAL))
    assert bus.heard(0x81)[-1].data[:2] == b"\x00\x00" or option == 1


def test_the_consumer_begins_with_the_first_heartbeat() -> None:
    bus, node = running()
    node.set(0x1016, 127 << 16 | 150, 1)
    bus.run(1.0)
    assert node.status & 0x6F == 0x27 and not bus.heard(0x81)


@pytest.mark.parametrize(("behaviour", "state"), [(0, 127), (1, 5), (2, 4)])
def test_1029_decides_the_nmt_state_after_a_communication_error(behaviour: int, state: int) -> None:
    bus, _ = watched(0, behaviour)
    bus.run(0.2)
    assert bus.slave.seat(1).node.state == state


@pytest.mark.parametrize("command", [nmt.Command.STOP, nmt.Command.RESET_COMMUNICATION])
def test_nmt_stop_and_reset_communication_count_as_lost_connection(command: nmt.Command) -> None:
    bus, node = running()
    node.nmt(nmt.Command.START)
    node.nmt(command)
    assert bus.axis().state in (State.REACTION, State.FAULT)


def test_bus_off_counts_as_lost_connection_and_its_end_is_told() -> None:
    bus, node = running()
    node.nmt(nmt.Command.START)
    bus.slave.bus_off(1)
    assert bus.axis().state in (State.REACTION, State.FAULT)
    assert not bus.hand(Frame(0x601, bytes.fromhex("4041600000000000"))), "it hears nothing"
    bus.run(0.5)
    bus.slave.bus_on(1)
    bus.wake(bus.now)
    codes = [int.from_bytes(frame.data[:2], "little") for frame in bus.heard(0x81)]
    assert 0x8140 in codes


def test_a_bus_off_of_the_whole_interface_ends_with_the_next_frame() -> None:
    bus, node = running()
    bus.slave.error_frame(FrameFault.BUS_OFF, bus.now)
    assert bus.axis().state in (State.REACTION, State.FAULT)
    assert node.status & 0x4F in (0x0F, 0x08)


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


# -- SYNC -------------------------------------------------------------------------------------------


def synced(tolerance_us: int = 0, faults: int = 3) -> tuple[CanopenBus, Master]:
    bus = CanopenBus(DriveSettings(PLAIN))
    node = bus.node()
    bus.run(0.05)
    node.set(0x2001, tolerance_us, 1)
    node.set(0x2001, faults, 2)
    node.in_cycle()
    for _ in range(20):
        bus.cycle(rpdo1(1, 15, 0))
    return bus, node


def sync_after(bus: CanopenBus, seconds: float) -> None:
    bus.run(seconds)
    bus.hand(Frame(0x80))


def test_one_missing_sync_is_borne_two_are_8700() -> None:
    bus, node = synced()
    sync_after(bus, 0.008)
    assert node.status & 0x6F == 0x27
    bus.run(0.00899)
    assert node.status & 0x6F == 0x27
    bus.run(0.00002)
    assert node.status & 0x4F in (0x0F, 0x08) and node.read(0x603F) == 0x8700


def test_jitter_beyond_the_tolerance_three_times_in_a_row_is_8700() -> None:
    bus, node = synced(tolerance_us=50)
    for late in (0.00006, -0.00012, 0.00018):
        assert node.status & 0x6F == 0x27
        sync_after(bus, 0.004 + late)
    assert node.read(0x603F) == 0x8700 and node.read(0x2001, 6) == 3


def test_jitter_within_the_tolerance_is_borne_and_shown() -> None:
    bus, node = synced(tolerance_us=50)
    for number in range(100):
        sync_after(bus, 0.004 + (0.00002 if number % 2 else -0.00002))
    assert node.status & 0x6F == 0x27 and node.read(0x2001, 5) == 1
    assert 15 <= node.read(0x2001, 4) <= 30, "the loop's grid is steady: 20 us of jitter are no 40 us of phase"
    node.set(0x2010, 1)
    assert node.read(0x2001, 4) == 0


def test_the_period_of_sync_is_60c2_else_1006_and_a_reset_takes_it_back() -> None:
    bus = CanopenBus(DriveSettings(PLAIN), cycle_ms=4.0)
    node, axis = bus.node(), bus.axis()
    bus.run(0.05)
    assert axis.period_ns == 4_000_000
    node.set(0x1006, 10_000)
    assert axis.period_ns == 10_000_000
    node.set(0x60C2, 8, 1)
    assert axis.period_ns == 8_000_000
    node.set(0x60C2, 0, 1)
    node.nmt(nmt.Command.RESET_COMMUNICATION)
    bus.run(0.05)
    assert axis.period_ns == 4_000_000


def test_a_drive_without_power_or_in_a_profile_mode_does_not_need_sync() -> None:
    bus, node = running()
    bus.run(1.0)
    assert node.status & 0x6F == 0x27


# -- limits and probes --------------------------------------------------------------------------------


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
def test_an_edge_stands_when_the_function_is_written_just_behind_it(at_rad: float) -> None:
    """The model looks every 250 us: what it has passed since then was forgotten by the write."""
    bus, node = probing(0x0011, at_rad)
    axis = bus.axis()
    while axis.servo.position_rad < 21.0:
        bus.run(60e-6)
        axis.advance(bus.now)
        axis.objects.written[0x60B8, 0](0x0011)
    assert node.read(0x60B9) == 0x0003 and abs(node.read(0x60BA) - inc(at_rad)) <= 1


# -- faults to order ----------------------------------------------------------------------------------


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


# -- power and reset ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("turns", "kept"), [(0, False), (4096, True)])
def test_after_a_loss_of_power_a_multi_turn_encoder_knows_where_it_is(turns: int, kept: bool) -> None:
    servo = ServoSettings(start_rad=100.0, boot_s=0.01, charge_s=0.0, brake=False)
    bus = CanopenBus(DriveSettings(servo, multiturn_turns=turns))
    node = bus.node()
    node.enable(6)
    node.set(0x6098, 35)
    node.set(0x607C, 5000)
    node.control(0x1F)
    bus.run(0.01)
    assert node.read(0x6064) == 5000 and node.read(0x2005) == 1
    bus.slave.power_off(1)
    assert not bus.hand(Frame(0x601, bytes.fromhex("4041600000000000")))
    bus.run(0.1)
    bus.slave.power_on(1)
    bus.run(0.1)
    assert node.status & 0x4F == 0x40 and node.read(0x2005) == kept
    assert (abs(node.read(0x6064) - 5000) <= 2) is kept


def test_a_multi_turn_encoder_moved_beyond_its_range_comes_back_wrapped() -> None:
    servo = ServoSettings(start_rad=0.0, boot_s=0.01, charge_s=0.0, brake=False)
    bus = CanopenBus(DriveSettings(servo, multiturn_turns=8))
    node = bus.node()
    node.enable(1)
    node.set(0x607A, 5 * 16384)
    node.control(0x1F)
    node.until(lambda: bool(node.status & 0x400))
    bus.slave.power_off(1)
    bus.run(0.1)
    bus.slave.power_on(1)
    bus.run(0.1)
    assert abs(node.read(0x6064) - (5 - 8) * 16384) < 50


def test_a_reset_of_the_node_stops_boots_and_keeps_the_position() -> None:
    bus, node = running(BRAKED)
    node.set(0x607C, 77)
    node.nmt(nmt.Command.RESET_NODE)
    assert bus.axis().state is State.NOT_READY
    bus.run(0.5)
    assert len(bus.heard(0x701)) == 2 and node.status & 0x6F == 0x40
    assert node.read(0x607C) == 0, "not stored"
    assert node.read(0x6064) > 1000 and abs(node.read(0x606C)) < 100


def test_two_drives_on_one_bus_do_not_touch_each_other() -> None:
    bus = CanopenBus(DriveSettings(PLAIN), DriveSettings(PLAIN))
    one, two = bus.node(1), bus.node(2)
    one.in_cycle()
    two.in_cycle()
    for step in range(1, 51):
        answers = bus.cycle(rpdo1(1, 15, 100 * step), rpdo1(2, 15, -50 * step))
    bus.slave.cause(1, "phase_loss", True)
    for step in range(51, 101):
        answers = bus.cycle(rpdo1(1, 15, 0), rpdo1(2, 15, -50 * step))
    assert [frame.identifier for frame in answers] == [cobid.tpdo(1, 1), cobid.tpdo(1, 2)]
    assert tpdo1(answers[0])[0] & 0x4F == 0x08
    assert tpdo1(answers[1])[0] & 0x6F == 0x27 and tpdo1(answers[1])[1] == pytest.approx(-5000, abs=300)
