"""Power states, brake, option codes, loss of power and reset of the emulated CiA 402 drive."""

import pytest

from drivers.emulator.cia402.states import STATUS, TRANSITIONS, Command, State, command_of
from drivers.emulator.servo.settings import DriveSettings, ServoSettings
from hil_tests.lab.virtual.canopen_bus import CanopenBus, rpdo1, tpdo1
from hil_tests.lab.virtual.cia402_axis import BRAKED, PLAIN, SPEED, running, stopping_time
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid
from protocols.canopen import nmt

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


# -- power and reset --------------------------------------------------------------------------------


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
