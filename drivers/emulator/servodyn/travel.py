"""The travel of one emulated booster: hard limits along the shaft, software limits from the resolver zero on, once that was found."""

from math import inf

from drivers.emulator.servo.model import Servo
from drivers.emulator.servo.settings import INC_PER_TURN, ServoSettings


class BoosterTravel:
    """The model watches one window; `crossed` decides what it means when the axis leaves it."""

    def __init__(self) -> None:
        self.beyond = 0  # the limit that the axis is beyond: +1, -1; 0: none
        self._turn = 0
        self._zero_wanted = False
        self._zero_inc: int | None = None

    def forget(self) -> None:
        """The supply was gone: no zero is known or sought."""
        self._zero_wanted, self._zero_inc = False, None

    def seek_zero(self, servo: Servo, settings: ServoSettings) -> None:
        """The next resolver zero that is passed becomes the zero of the software limits."""
        if not self._zero_wanted:
            self._zero_wanted = True
            self.look_around(servo, settings)

    def look_around(self, servo: Servo, settings: ServoSettings) -> None:
        """Sets the window: between the limits, or beyond one of them, or the present turn while the zero is sought."""
        low, high = self._limits(servo, settings)
        position = servo.position_rad
        self.beyond = 1 if position > high else -1 if position < low else 0
        bounds = ((-inf, low), (low, high), (high, inf))[self.beyond + 1]
        if self._zero_wanted and self._zero_inc is None:
            self._turn, lower, upper = servo.turn_bounds_rad()
            bounds = max(bounds[0], lower), min(bounds[1], upper)
        servo.watch(*bounds)

    def crossed(self, servo: Servo, settings: ServoSettings) -> bool:
        """The window was left: a resolver zero, a limit outwards, or back inside.  Whether `beyond` has changed."""
        if self._zero_wanted and self._zero_inc is None:
            turn = int(servo.counter_inc // INC_PER_TURN)
            if turn != self._turn:
                self._zero_inc = max(turn, self._turn) * INC_PER_TURN
        before = self.beyond
        self.look_around(servo, settings)
        return self.beyond != before

    def _limits(self, servo: Servo, settings: ServoSettings) -> tuple[float, float]:
        low, high = settings.hard_limit_min_rad, settings.hard_limit_max_rad
        if self._zero_inc is not None and not servo.stuck:
            ends = [servo.shaft_rad(self._zero_inc + limit) for limit in (settings.soft_limit_min_inc, settings.soft_limit_max_inc)]
            low, high = max(low, min(ends)), min(high, max(ends))
        return low, high
