"""Whether a belt is at rest or runs, its averaged speed, and when its errors are looked at.

Source: rho 3 Releases part 1, TO04 section 15.2-15.3 (L6133-6219): special function 15.  Speeds are those of full interpolation cycles
(increments per cycle, so they change in steps).
"""

from collections import deque
from dataclasses import dataclass, field
from enum import Enum
from statistics import fmean

from motion.errors import MotionError

DEFAULT_M = 5e-6  # per interpolation cycle: both thresholds after start-up
AVERAGED = 10  # interpolation cycles at most
SAME = 1e-9  # m/s: a threshold that is reached is not exceeded


class Motion(Enum):
    """STOPPED: below "belt stopped"; RUNNING: above "belt running"; SLOW: between them."""

    STOPPED, SLOW, RUNNING = "stopped", "slow", "running"


STOPPED = Motion.STOPPED  # a name in an Enum is looked up slowly, and this one is in every period


@dataclass(slots=True)
class Watch:
    """One belt.  cycle_s: interpolation cycle.  Call update() once a cycle with the unaveraged speed (m/s or rad/s)."""

    cycle_s: float
    stop: float = field(init=False)  # threshold "belt stopped", per s
    run: float = field(init=False)  # threshold "belt running"
    patience: int = field(init=False, default=0)  # cycles without tolerance monitoring after a change
    motion: Motion = field(init=False, default=Motion.STOPPED)
    speed: float = field(init=False, default=0.0)  # the speed passed to a robot: averaged while running
    raw: float = field(init=False, default=0.0)
    _recent: deque[float] = field(init=False, default_factory=lambda: deque(maxlen=AVERAGED))
    _wait: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        if not 0.0 < self.cycle_s < 1.0:
            raise MotionError(f"interpolation cycle {self.cycle_s:g} s is outside 0 .. 1")
        self.stop = self.run = DEFAULT_M / self.cycle_s

    def parametrise(self, stop: float, run: float, time_s: float) -> None:
        """Special function 15; the time is rounded to full interpolation cycles."""
        if not (0.0 <= stop < 1e6 and 0.0 <= run < 1e6 and 0.0 <= time_s < 3600.0):
            raise MotionError(f"belt thresholds {stop:g}, {run:g} per s and time {time_s:g} s: finite numbers from 0 are needed")
        self.stop, self.run, self.patience = stop, run, round(time_s / self.cycle_s)

    def update(self, speed: float) -> None:
        """One interpolation cycle further."""
        before, self.raw = self.motion, speed
        size = abs(speed)
        if size < self.stop or size <= SAME:
            self.motion = Motion.STOPPED
        elif size > self.run:
            self.motion = Motion.RUNNING
        else:
            self.motion = Motion.SLOW
        self._wait = max(self._wait - 1, 0)
        started = before is Motion.STOPPED and self.motion is not Motion.STOPPED
        slowed = before is Motion.RUNNING and self.motion is Motion.SLOW
        if started or slowed:
            self._wait = self.patience
        if self.motion is not Motion.RUNNING:
            self._recent.clear()
            self.speed = 0.0 if self.motion is Motion.STOPPED else speed
            return
        self._recent.append(speed)
        self.speed = fmean(self._recent)

    @property
    def judges_tolerance(self) -> bool:
        """Errors 944 .. 953 are looked for: not while the belt is at rest, nor for the set time after a start or a slow-down."""
        return self.motion is not Motion.STOPPED and self._wait == 0

    @property
    def judges_direction(self) -> bool:
        """Errors 928 .. 937 are looked for."""
        return self.motion is not Motion.STOPPED
