"""What an existing fake CiA 402 drive gets wrong; one named test each that the emulated drive does not have the defect.

The list: drives that never leave "not ready" alone, have no fault path, no ramps, integer millimetres, a homing that tests the wrong bit,
set-points without handshake, modes that are accepted and do nothing, objects without function.
"""

import pytest

from drivers.emulator.servo.settings import DriveSettings, ServoSettings
from hil_tests.lab.virtual.canopen_bus import CanopenBus, Master, rpdo1, tpdo1
from protocols.base.machine import Frame
from protocols.canopen import nmt
from protocols.canopen.types import Kind

PLAIN = ServoSettings(boot_s=0.01, charge_s=0.0, brake=False)


def enabled(mode: int, servo: ServoSettings = PLAIN) -> tuple[CanopenBus, Master]:
    bus = CanopenBus(DriveSettings(servo))
    node = bus.node()
    node.enable(mode)
    return bus, node


def cyclic(mode: int) -> tuple[CanopenBus, Master]:
    bus = CanopenBus(DriveSettings(PLAIN))
    node = bus.node()
    node.in_cycle(mode)
    return bus, node


def test_not_ready_is_left_without_any_controlword_and_6_7_15_is_enough() -> None:
    bus = CanopenBus(DriveSettings(PLAIN))
    node = bus.node()
    bus.run(0.05)
    assert node.status & 0x4F == 0x40
    for word in (6, 7, 15):
        node.control(word)
    node.until_state(0x27, limit_s=0.01)


def test_a_fault_can_be_entered_is_reported_and_fault_reset_works_in_fault_only() -> None:
    bus, node = enabled(1)
    bus.slave.cause(1, "phase_loss", True)
    bus.run(0.5)
    assert node.status & 0x4F == 0x08 and bus.heard(0x81)[0].data[:2] == b"\x30\x31"
    bus.slave.cause(1, "phase_loss", False)
    node.control(0)
    assert node.control(0x80) & 0x4F == 0x40
    node.control(6)
    assert node.control(0x86) & 0x6F == 0x21, "in ready to switch on a fault reset is nothing"


def test_fault_reaction_active_is_a_state_of_its_own_with_a_ramp() -> None:
    bus, node = enabled(3)
    node.set(0x60FF, 100_000)
    bus.run(0.5)
    node.set(0x6085, 500_000)
    bus.slave.cause(1, "over_temperature", True)
    bus.run(0.1)
    assert node.status & 0x4F == 0x0F and 20_000 < node.read(0x606C) < 80_000
    bus.run(0.3)
    assert node.status & 0x4F == 0x08


def test_disable_voltage_leaves_bit_5_clear() -> None:
    _, node = enabled(1)
    assert node.control(0) & 0x6F == 0x40


def test_quick_stop_ramps_down_as_605a_and_6085_say() -> None:
    bus, node = enabled(3)
    node.set(0x60FF, 100_000)
    bus.run(0.5)
    node.set(0x6085, 500_000)
    start = node.read(0x6064)
    node.control(2)
    bus.run(0.1)
    assert node.status & 0x6F == 0x07 and 20_000 < node.read(0x606C) < 80_000
    bus.run(0.3)
    assert node.read(0x6064) - start == pytest.approx(100_000**2 / (2 * 500_000), rel=0.1)


def test_csp_follows_sync_not_a_loop_of_its_own() -> None:
    bus, node = cyclic(8)
    bus.cycle(rpdo1(1, 15, 400))
    bus.run(0.0039)
    assert node.read(0x6062) == pytest.approx(400, abs=11), "interpolated over the cycle after its SYNC"
    bus.hand(rpdo1(1, 15, 4000))
    bus.run(0.0001)
    assert node.read(0x6062) == 400, "the next value waits for the next SYNC"


def test_csp_keeps_every_increment() -> None:
    bus, _ = cyclic(8)
    for step in range(1, 200):
        answers = bus.cycle(rpdo1(1, 15, min(100 * step, 19_900)))
    for _ in range(100):
        answers = bus.cycle(rpdo1(1, 15, 19_900))
    assert abs(tpdo1(answers[0])[1] - 19_900) <= 1


def test_csp_takes_the_next_value_before_the_last_is_reached() -> None:
    bus, node = cyclic(8)
    for step in range(1, 51):
        bus.cycle(rpdo1(1, 15, 100 * step))
    assert node.read(0x60F4) > 200 and node.read(0x6062) >= 4900, "it lags and follows all the same"


def test_a_target_beyond_the_limits_is_clipped_and_shown_not_ignored() -> None:
    bus, node = cyclic(8)
    node.set(0x607D, -500, 1)
    node.set(0x607D, 1000, 2)
    for step in range(1, 100):
        answers = bus.cycle(rpdo1(1, 15, 50 * step))
    word, position = tpdo1(answers[0])
    assert abs(position - 1000) <= 5 and word & 0x800


def test_the_velocity_is_measured_not_the_set_value_times_1000() -> None:
    bus, node = cyclic(8)
    for step in range(1, 200):
        bus.cycle(rpdo1(1, 15, 123 * step))
    assert node.read(0x606C) == pytest.approx(123 / 0.004, rel=0.02)


def test_homing_starts_with_bit_4_not_with_bit_2() -> None:
    bus, node = enabled(6)
    node.set(0x6098, 34)
    bus.run(0.2)
    assert node.read(0x6064) == pytest.approx(0, abs=3) and node.status & 0x3400 == 0x0400, "0Fh has bit 2 set: not started"
    node.control(0x1F)
    node.until(lambda: node.status & 0x1400 == 0x1400)


def test_homing_goes_where_its_method_says_and_takes_its_time() -> None:
    servo = ServoSettings(boot_s=0.01, charge_s=0.0, brake=False, reference_switch_from_rad=20.0, reference_switch_to_rad=25.0)
    _, node = enabled(6, servo)
    node.set(0x6098, 24)
    node.set(0x607C, 500)
    node.control(0x1F)
    took = node.until(lambda: node.status & 0x1400 == 0x1400)
    assert took > 1.0 and node.read(0x6064) > 500, "it ran to the switch at 20 rad and beyond it by its deceleration"


def test_a_homing_that_was_not_started_does_not_keep_the_drive_busy() -> None:
    bus, _ = enabled(6)
    assert not bus.axis().mode.busy
    wakes = 0
    end = bus.now + 1_000_000_000
    while (due := bus.slave.deadline()) is not None and due < end:
        bus.slave.wake(due)
        wakes += 1
    assert wakes < 500, "looks after the axis and rows of the record, no loop"


def test_a_set_point_is_a_handshake() -> None:
    bus, node = enabled(1)
    node.set(0x607A, 5000)
    bus.run(0.1)
    assert abs(node.read(0x6064)) < 3, "no bit 4, no motion"
    assert node.control(0x1F) & 0x1000
    node.set(0x607A, 9000)
    bus.run(0.05)
    assert node.control(0x1F) & 0x1000, "bit 4 stands: no new edge"
    assert not node.control(0x0F) & 0x1000
    node.until(lambda: bool(node.status & 0x400))
    assert abs(node.read(0x6064) - 5000) <= 20


def test_ip_interpolates_over_the_time_of_60c2() -> None:
    bus, node = cyclic(7)
    node.set(0x60C2, 40, 1)
    node.set(0x60C1, 4000, 1)
    bus.run(0.004)
    bus.hand(rpdo1(1, 0x1F, 0), Frame(0x80))
    places = []
    for _ in range(4):
        bus.run(0.010)
        places.append(node.read(0x6062))
    assert places == [pytest.approx(1000 * step, abs=30) for step in (1, 2, 3, 4)]


def test_pv_has_ramps() -> None:
    bus, node = enabled(3)
    node.set(0x6083, 200_000)
    node.set(0x60FF, 100_000)
    bus.run(0.25)
    assert node.read(0x606C) == pytest.approx(50_000, rel=0.05)


@pytest.mark.parametrize(("mode", "index", "value"), [(9, 0x60FF, 40_000), (10, 0x6071, 200)])
def test_csv_and_cst_move_the_axis(mode: int, index: int, value: int) -> None:
    bus, node = cyclic(mode)
    node.set(index, value)
    for _ in range(30):
        bus.cycle(rpdo1(1, 15, 0))
    assert node.read(0x6064) > 1000


def test_modes_that_do_nothing_are_refused() -> None:
    bus = CanopenBus()
    node = bus.node()
    bus.run(0.05)
    supported = node.read(0x6502)
    for mode in (2, 4, 5, 11):
        assert not supported >> (mode - 1) & 1
        with pytest.raises(AssertionError, match="06090030"):
            node.set(0x6060, mode)


def test_6065_6067_and_607d_act() -> None:
    _, node = enabled(1)
    node.set(0x6065, 50)
    node.set(0x607A, 200_000)
    node.control(0x1F)
    node.until(lambda: node.read(0x603F) == 0x8611)
    _, node = enabled(1)
    node.set(0x607A, 8_000)
    node.set(0x6067, 4000)
    node.control(0x1F)
    node.control(0x0F)
    node.until(lambda: bool(node.status & 0x400))
    assert abs(node.read(0x6064) - 8000) > 20, "a wide window is reached early"
    node.set(0x607D, -100, 1)
    node.set(0x607D, 100, 2)
    node.set(0x607A, -5000)
    node.control(0x1F)
    node.control(0x0F)
    node.until(lambda: abs(node.read(0x6064) + 100) <= 5)


def test_the_drive_stops_when_its_master_dies() -> None:
    bus, node = enabled(3)
    node.set(0x1016, 127 << 16 | 150, 1)
    node.set(0x60FF, 100_000)
    for _ in range(20):
        bus.hand(nmt.heartbeat(127, nmt.State.OPERATIONAL))
        bus.run(0.05)
    assert node.read(0x606C) == pytest.approx(100_000, rel=0.02)
    bus.run(0.5)
    assert abs(node.read(0x606C)) < 100 and node.read(0x603F) == 0x8130


def test_every_object_of_the_data_sheet_answers_with_its_type() -> None:
    """Nothing stands in the EDS that the drive does not have."""
    bus = CanopenBus()
    node = bus.node()
    bus.run(0.05)
    objects = bus.slave.seat(1).node.objects
    for entry in objects.dictionary:
        if entry.index == 0x1003 and entry.sub:
            continue  # 08000024h while there is no error
        if not entry.access.readable:
            continue
        data = objects.upload(entry.key)
        assert isinstance(data, bytes), f"{entry}: {data}"
        assert entry.type.kind in (Kind.TEXT, Kind.BYTES) or len(data) == entry.type.size, str(entry)
    assert node.read(0x1000) == 0x20192
