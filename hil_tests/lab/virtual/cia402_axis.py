"""An emulated CiA 402 drive whose axis runs when something happens."""

from drivers.emulator.servo.settings import DriveSettings, ServoSettings
from hil_tests.lab.virtual.canopen_bus import CanopenBus, Master

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
