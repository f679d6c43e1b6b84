"""The position sent to a drive in every cycle: the actual one before it holds, then frozen, then the demanded one if it may be sent."""

from drivers.drives.family import Event
from drivers.drives.limits import fits_int32


class HeldPosition:
    """`inc` is the value sent.  `jump_inc`: the first demanded position has to be so close to the held one; `step_inc`: every later one."""

    def __init__(self, jump_inc: int, step_inc: int) -> None:
        self.inc = 0
        self._jump, self._step = jump_inc, step_inc
        self._fresh = True  # no demanded position accepted since it follows the actual one
        self._refused = False

    def follow(self, actual_inc: int) -> None:
        """Not in control: set = actual."""
        self.inc, self._fresh, self._refused = actual_inc, True, False

    def take(self, inc: int) -> Event | None:
        """A demanded position; JUMP or RANGE, reported once until a good one comes, when it is not sent and the last one stays."""
        if not fits_int32(inc):
            return self._refuse(Event.RANGE)
        if abs(inc - self.inc) > (self._jump if self._fresh else self._step):
            return self._refuse(Event.JUMP)
        self.inc, self._fresh, self._refused = inc, False, False
        return None

    def strayed(self, actual_inc: int) -> bool:
        """The axis is further from the held position than a first step may be."""
        return abs(actual_inc - self.inc) > self._jump

    def _refuse(self, why: Event) -> Event | None:
        before, self._refused = self._refused, True
        return None if before else why
