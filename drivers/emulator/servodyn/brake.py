"""The holding brake of an emulated booster: it opens and closes in its times, or does not open any more."""

from drivers.emulator.servo.model import NEVER, steps
from drivers.emulator.servo.settings import ServoSettings


class BoosterBrake:
    """`due` is the step at which it has moved; the booster then calls `moved`."""

    def __init__(self) -> None:
        self.is_open = False
        self.due = NEVER
        self.stuck = False  # it does not open any more
        self._opens = False  # the last command

    def command(self, open_it: bool, step: int, settings: ServoSettings, *, waited_for: bool) -> None:
        """Move the brake, at this step; `waited_for`: the state changes when the brake has moved, at once if it is already in position."""
        moving = self.due != NEVER
        if moving and open_it is self._opens:
            return
        if not moving and open_it is self.is_open:
            if waited_for:
                self.due = step
            return
        self._opens = open_it
        delay = settings.brake_open_s if open_it else settings.brake_close_s
        self.due = step + (steps(delay) if settings.brake else 0)

    def moved(self, settings: ServoSettings) -> bool:
        """Its time is over; False: it was to open and did not."""
        self.is_open = self._opens and not (self.stuck and settings.brake)
        return self.is_open is self._opens
