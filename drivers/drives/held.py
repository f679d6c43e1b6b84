"""The position sent to a drive in every cycle: the actual one before it holds, then frozen, then the demanded one if it may be sent."""

from drivers.drives.family import Event
from drivers.drives.limits import fits_int32


class HeldPosition:
    """`inc` is the value sent.  `jump`: the first demanded position has to be so close to the held one; `step`: every later one."""

    __slots__ = ("fresh", "inc", "jump", "refused", "step")

    def __init__(self, jump_inc: int, step_inc: int) -> None:
        self.inc = 0
        self.jump, self.step = jump_inc, step_inc
        self.fresh = True  # no demanded position accepted since it follows the actual one
        self.refused = False  # the last demanded position was not sent

    def follow(self, actual_inc: int) -> None:
        """Not in control: set = actual."""
        self.inc, self.fresh, self.refused = actual_inc, True, False

    def take(self, inc: int) -> Event | None:
        """A demanded position; JUMP or RANGE, reported once until a good one comes, when it is not sent and the last one stays."""
        if not fits_int32(inc):
            return self._refuse(Event.RANGE)
        if abs(inc - self.inc) > (self.jump if self.fresh else self.step):
            return self._refuse(Event.JUMP)
        self.inc, self.fresh, self.refused = inc, False, False
        return None

    def strayed(self, actual_inc: int) -> bool:
        """The axis is further from the held position than a first step may be."""
        return abs(actual_inc - self.inc) > self.jump

    def _refuse(self, why: Event) -> Event | None:
        before, self.refused = self.refused, True
        return None if before else why
