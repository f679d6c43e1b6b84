"""Speed law of belt type 2: the robot reaches the end of a block when the belt does, with the programmed acceleration.

Source: rho 3 Releases part 1, TO04 section 15 (L6097-6105, L6237): the speed is estimated anew in every interpolation cycle, so that
long blocks collect no error; the programmed speed is not looked at, the programmed acceleration is.
"""

from dataclasses import dataclass
from math import inf

HALVINGS = 60


@dataclass(frozen=True, slots=True)
class Pace:
    """Along a block: highest speed, acceleration and deceleration, in units of its way per s."""

    top: float = inf
    accel: float = inf
    decel: float = inf

    def _ramps(self, now: float, cruise: float, end: float) -> tuple[float, float]:
        """Time of both ramps now -> cruise -> end, and the way they cost against driving at `cruise` all the time."""
        up, down = cruise - now, cruise - end
        first = self.accel if up > 0.0 else self.decel
        last = self.decel if down > 0.0 else self.accel
        return abs(up) / first + abs(down) / last, up * abs(up) / (2.0 * first) + down * abs(down) / (2.0 * last)

    def cruise(self, way: float, time: float, now: float, end: float) -> float:
        """The steady speed with which `way` is made in `time`, from speed `now` to speed `end`; `top` where none is high enough."""
        if way <= 0.0:
            return 0.0
        if time <= 0.0:
            return self.top
        low, high = 0.0, min(self.top, 4.0 * (way / time + now + end))
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            lasts, costs = self._ramps(now, middle, end)
            fits = lasts <= time or middle <= max(now, end)  # otherwise both ramps do not fit: faster is only later
            if fits and middle * time - costs < way:
                low = middle
            else:
                high = middle
        return low if low * time - self._ramps(now, low, end)[1] >= way * (1.0 - 1e-6) else self.top

    def next_speed(self, rest: float, time: float, now: float, end: float, period: float) -> float:
        """Speed after the next period: towards the cruising speed, never so fast that the end could not be reached at `end`."""
        wanted = self.cruise(rest, time, now, end)
        lowest, highest = now - self.decel * period, now + self.accel * period
        speed = min(wanted, highest, self.top, self.last_speed(rest, now, end, period))
        return max(speed, lowest, 0.0)

    def last_speed(self, rest: float, now: float, end: float, period: float) -> float:
        """Return the highest speed after one period from which `end` can still be reached in the remaining way."""
        if self.decel == inf:
            return inf
        half = 0.5 * self.decel * period
        room = half * half - 2.0 * half * now + 2.0 * self.decel * rest + end * end
        return float(max(room, 0.0) ** 0.5) - half
