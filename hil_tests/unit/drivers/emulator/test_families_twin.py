"""The same axis as SERVODYN booster and as CiA 402 drive: the same set values give the same path, increment by increment."""

import math

from drivers.emulator.servo.settings import DriveSettings, ServoSettings
from hil_tests.lab.virtual import servodyn_bus
from hil_tests.lab.virtual.canopen_bus import CanopenBus, rpdo1
from protocols.base.machine import Frame

SERVO = ServoSettings(boot_s=0.01, charge_s=0.01, gravity_nm=1.0, torque_noise_nm=0.05)
CYCLES = 500
SET_DELAY_S = 0.0007  # after SYNC, as the lab's SERVODYN master sends


def path(seconds: float) -> int:
    return round(8000.0 * (1.0 - math.cos(2.0 * math.pi * 0.7 * seconds)))


def servodyn_path() -> list[tuple[int, int]]:
    bus = servodyn_bus.DriveBus(SERVO, seed=3)
    bus.enable()
    start = bus.actual[1].position_inc
    bus.move(path)
    first = len(bus.rows())
    bus.cycle(CYCLES)
    return [(row.axes[0].set_inc - start, row.axes[0].position_inc - start) for row in bus.rows()[first:]]


def cia402_path() -> list[tuple[int, int]]:
    bus = CanopenBus(DriveSettings(SERVO), seed=3)
    node = bus.node()
    node.in_cycle()
    start = node.read(0x607A)
    for _ in range(100):
        sync_then(bus, start)
    first = len(bus.rows())
    for number in range(CYCLES):
        sync_then(bus, start + path(number * 0.004))
    return [(row.axes[0].set_inc - start, row.axes[0].position_inc - start) for row in bus.rows()[first:]]


def sync_then(bus: CanopenBus, position: int) -> None:
    bus.hand(Frame(0x80))
    bus.run(SET_DELAY_S)
    bus.hand(rpdo1(1, 15, position))
    bus.run(0.004 - SET_DELAY_S)


def test_one_line_swaps_the_family_and_not_the_path() -> None:
    old, new = servodyn_path(), cia402_path()
    assert len(old) == len(new) == CYCLES and max(actual for _, actual in old) > 15_000
    assert max(abs(a[0] - b[0]) for a, b in zip(old, new, strict=True)) <= 1, "set values"
    shift = old[0][1] - new[0][1]
    assert abs(shift) <= 10, "where each stood when it began: friction and noise"
    worst = max(abs(a[1] - b[1]) for a, b in zip(old[50:], new[50:], strict=True))
    assert worst <= 3, f"{worst} increments apart"
