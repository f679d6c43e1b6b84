"""Set values in steps of time: a trapezoid to a target, a ramp to a speed.  Pure arithmetic, increments and seconds.

The target may change at any step: the generator only knows its position, its speed and its limits (CiA 402 "change set immediately").
"""

from math import sqrt

CLOSE = 1e-6  # increments: nearer to 0 the allowed speed is lost in rounding, and the target would never be reached


class Trapezoid:
    """`step` advances `position` and `speed` by dt; arrives exactly, and overshoots only if the target jumped back."""

    def __init__(self, position: float, speed: float = 0.0) -> None:
        self.position, self.speed = position, speed
        self.target = position
        self.top = self.acceleration = self.deceleration = 0.0

    @property
    def arrived(self) -> bool:
        return self.position == self.target and self.speed == 0.0

    def step(self, dt: float) -> None:
        rest = self.target - self.position
        sign = 1.0 if rest > 0.0 or (rest == 0.0 and self.speed < 0.0) else -1.0
        speed, rest = self.speed * sign, rest * sign  # both as seen towards the target
        down = self.deceleration * dt
        if speed < 0.0:
            speed = min(speed + down, 0.0)
        else:
            allowed = self.deceleration * (sqrt(dt * dt + 2.0 * rest / self.deceleration) - dt)
            wanted = min(allowed, self.top)
            speed = min(speed + self.acceleration * dt, wanted) if speed <= wanted else max(speed - down, wanted)
            if (speed * dt >= rest or rest < CLOSE) and speed <= down:
                self.position, self.speed = self.target, 0.0
                return
        self.speed = speed * sign
        self.position += self.speed * dt


def towards(speed: float, wanted: float, acceleration: float, deceleration: float, dt: float) -> float:
    """One step of a speed ramp; through zero it decelerates first."""
    if speed * wanted < 0.0:
        change = deceleration * dt
        return 0.0 if abs(speed) <= change else speed - change if speed > 0.0 else speed + change
    change = (acceleration if abs(wanted) > abs(speed) else deceleration) * dt
    return wanted if abs(wanted - speed) <= change else speed + change if wanted > speed else speed - change
