"""What the emulated CiA 402 drive does when its master, its bus or its SYNC stays away."""

import dataclasses

import pytest

from drivers.emulator.cia402.states import State
from drivers.emulator.servo.settings import DriveSettings
from gateway.assembly.plant import bus_settings
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from hil_tests.lab.virtual.canopen_bus import CanopenBus, Master, rpdo1
from hil_tests.lab.virtual.cia402_axis import PLAIN, running
from protocols.base.machine import Frame, FrameFault
from protocols.canopen import nmt

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


def test_bus_off_counts_as_lost_connection_and_its_end_is_reported() -> None:
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


@pytest.mark.parametrize("late", [0.6, 0.83, 0.98])
def test_a_sync_late_by_most_of_a_period_and_the_next_in_time_are_one_beside_the_grid(late: float) -> None:
    bus, node = synced()
    for after in (1 + late, 1 - late, *[1.0] * 20):
        sync_after(bus, 0.004 * after)
        assert node.status & 0x6F == 0x27
    assert node.read(0x2001, 6) <= 1


@pytest.mark.parametrize("place", range(6))
def test_a_late_sync_while_the_loop_locks_is_not_its_grid(place: int) -> None:
    bus, node = synced()
    node.set(0x60C2, 4, 1)  # the loop begins anew
    for after in (*[1.0] * place, 1.45, 0.55, *[1.0] * 20):
        sync_after(bus, 0.004 * after)
        assert node.status & 0x6F == 0x27


@pytest.mark.parametrize("period", [0.5, 0.7, 1.3])
def test_sync_of_another_period_is_8700(period: float) -> None:
    bus, node = synced()
    node.set(0x60C2, 4, 1)
    for _ in range(40):
        sync_after(bus, 0.004 * period)
    assert node.status & 0x4F in (0x0F, 0x08) and node.read(0x603F) == 0x8700


def test_the_drives_of_a_simulated_cell_supervise_sync_as_real_ones_do() -> None:
    """As `run --sim` starts them: built of the shipped cell, at its clock."""
    cell = load_cell("demo-402.toml", read_text(find_config("demo-402", "cells")))
    settings = bus_settings(cell, cell.bus[0].name, float(cell.cycle_ms))
    number, first = next(iter(sorted(settings.nodes.items())))
    bus = CanopenBus(cycle_ms=float(cell.cycle_ms), nodes={number: dataclasses.replace(first, servo=PLAIN)})
    node = bus.node(number)
    bus.run(0.05)
    node.in_cycle()
    period = cell.cycle_ms / 1000
    for _ in range(20):
        bus.cycle(rpdo1(number, 15, 0))
    for late in (0.3, -0.6, 0.9):  # of a period: each a quarter and more beside the drive's own grid
        assert node.status & 0x6F == 0x27
        sync_after(bus, period * (1 + late))
    assert node.read(0x603F) == 0x8700


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
