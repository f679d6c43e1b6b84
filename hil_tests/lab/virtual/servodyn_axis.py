"""An emulated booster on its bus, switched on, and the values of its axis."""

from collections.abc import Callable
from math import pi

from drivers.emulator.servo.settings import ServoSettings
from drivers.emulator.servodyn.axis import State
from hil_tests.lab.virtual.servodyn_bus import DriveBus
from protocols.servodyn.codec import ActualValue

TURN = 2.0 * pi
PLAIN = ServoSettings()
FREE = ServoSettings(coulomb_nm=0.0, stiction_nm=0.0, viscous_nms_per_rad=0.0)


def enabled(*settings: ServoSettings, p5_ms: float = 4.0) -> DriveBus:
    bus = DriveBus(*settings, p5_ms=p5_ms)
    bus.enable()
    return bus


def state(bus: DriveBus) -> State:
    return bus.axis().state


def fault(bus: DriveBus) -> bool:
    return bus.actual[1].fault


def limit(bus: DriveBus) -> bool:
    return bus.actual[1].limit_active


def path(start: float, end: float) -> Callable[[float], float]:
    """From start to end in one second."""
    return lambda t: start + (end - start) * min(t, 1.0)


def until(bus: DriveBus, reached: Callable[[ActualValue], bool], seconds: float) -> float:
    """Run cycles until the actual value of axis 1 satisfies this; seconds of bus time it took.  Fails after `seconds`."""
    began = bus.now
    while (bus.now - began) * 1e-9 < seconds:
        bus.cycle()
        if reached(bus.actual[1]):
            return (bus.now - bus.p5 - began) * 1e-9
    raise AssertionError(f"not within {seconds} s: {bus.actual[1]}")
