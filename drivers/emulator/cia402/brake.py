"""Standstill of an emulated CiA 402 drive: its holding brake, and the stop along a ramp that may end in it."""

from dataclasses import dataclass

from drivers.emulator.cia402.states import State
from drivers.emulator.servo.model import NEVER, steps
from drivers.emulator.servo.settings import ServoSettings


@dataclass(slots=True)
class DriveStop:
    """The stop under way; `after`: the state it leads to, None: the axis holds."""

    active: bool = False
    after: State | None = None
    by: int = NEVER  # the step at which torque is switched off in any case

    @property
    def leads_out(self) -> bool:
        """Operation is on its way to its end."""
        return self.active and self.after is not None

    def begin(self, after: State | None, by: int) -> None:
        self.active, self.after, self.by = True, after, by


class DriveBrake:
    """`due` is the step at which it has moved.  Enabling waits for it (`opening`), the end of a stop as well (`closing`)."""

    def __init__(self) -> None:
        self.is_open = False
        self.stuck = False  # it does not open (mechanically), whatever is commanded
        self.due = NEVER
        self.opening = self.closing = False
        self._opens = False  # the last command

    def nothing_waits(self) -> None:
        self.opening = self.closing = False

    def command(self, open_it: bool, step: int, settings: ServoSettings) -> None:
        """Move the brake, at this step; without a brake, or if it is already in position, a waiting transition continues at once."""
        self._opens = open_it
        if open_it is self.is_open or not settings.brake:
            self.is_open = open_it
            self.due = step if self.opening or self.closing else NEVER
        else:
            self.due = step + steps(settings.brake_open_s if open_it else settings.brake_close_s)

    def moved(self) -> None:
        self.due, self.is_open = NEVER, self._opens
