"""Where a belt is now and will be: an alpha-beta filter on its increments, and prediction by the known delay (motion.md C.7, E 7).

The delay is that from the moment a measuring system is read to the moment the set value made of it acts.  At a stop or start the filter
would overrun for a while (which causes the largest errors), so its acceleration is tracked as well: a third, slow gain (alpha-beta-gamma);
at a standstill, known by the belt's threshold, the prediction ends where the belt is.
"""

from dataclasses import dataclass, field

from motion.errors import MotionError

ALPHA, BETA, GAMMA = 0.25, 0.035, 0.001  # for one sample a ms: AX-446


@dataclass(slots=True)
class Tracker:
    """period_s: between two samples; delay_s: how far ahead ahead() looks.  m or rad."""

    period_s: float
    delay_s: float
    alpha: float = ALPHA
    beta: float = BETA
    gamma: float = GAMMA
    place: float = field(init=False, default=0.0)
    speed: float = field(init=False, default=0.0)
    accel: float = field(init=False, default=0.0)
    _known: bool = field(init=False, default=False)

    def __post_init__(self) -> None:
        if not (0.0 < self.period_s < 1.0 and 0.0 <= self.delay_s < 1.0 and 0.0 < self.alpha < 1.0 and 0.0 < self.beta < 2.0):
            raise MotionError(f"belt filter: period {self.period_s:g} s, delay {self.delay_s:g} s, gains {self.alpha:g}, {self.beta:g}")

    def update(self, measured: float, *, at_rest: bool = False) -> None:
        """One sample; standing: the belt is below its threshold "stopped"."""
        if not self._known or at_rest:
            self.place = measured if not self._known else self.place + self.alpha * (measured - self.place)
            self.speed = self.accel = 0.0
            self._known = True
            return
        h = self.period_s
        place, speed = self.place + h * (self.speed + 0.5 * h * self.accel), self.speed + h * self.accel
        off = measured - place
        self.place, self.speed = place + self.alpha * off, speed + self.beta / h * off
        self.accel += self.gamma / (h * h) * off

    def ahead(self) -> float:
        """Where the belt will be when a set value made now acts."""
        d = self.delay_s
        return self.place + d * (self.speed + 0.5 * d * self.accel)
