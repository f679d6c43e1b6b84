"""The steps of emulated servo axes in C; the twin: drivers.emulator.servo.model.run (AX-1020)."""

from typing import cast

from drivers.emulator.servo.model import Servo, Steps, run
from gateway.cycle.native.built import load, wanted


def use_servo(*, python: bool | None = None) -> bool:
    """From now on every emulated axis of this process runs in C if the part is built and enabled; False: its twin runs."""
    steps: Steps = run
    if not (not wanted() if python is None else python):
        try:
            steps = cast(Steps, load("servo").run)
        except ImportError:
            steps = run
    Servo.steps = staticmethod(steps)
    return steps is not run
