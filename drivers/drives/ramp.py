"""A jerk-limited set value of one motor, in turns: to a speed, or to a position."""

import ruckig


class Ramp:
    """x turns, speed turns/s, acceleration turns/s2; starts at rest at 0."""

    def __init__(self, accel: float, jerk: float) -> None:
        self._solver = ruckig.Ruckig(1)
        self._input = ruckig.InputParameter(1)
        self._input.max_acceleration, self._input.max_jerk = [accel], [jerk]
        self._plan, self._trial = ruckig.Trajectory(1), ruckig.Trajectory(1)
        self._planned = False
        self._time = 0.0
        self._slow = 0.0
        self.x = self.speed = self.accel = 0.0

    @property
    def at_rest(self) -> bool:
        """The plan has ended in a standstill."""
        return not self._planned and self.speed == 0.0

    def to_speed(self, speed: float) -> bool:
        """As fast as the limits allow, then steady; False: no plan, the old one continues."""
        self._input.control_interface = ruckig.ControlInterface.Velocity
        self._input.target_velocity = [speed]
        self._input.max_velocity = [abs(speed) + abs(self.speed) + 1.0]
        return self._begin(speed)

    def to_position(self, x: float, speed: float) -> bool:
        """At most `speed` (or the present one, when that is higher), to rest there; False: no plan, the old one continues."""
        self._input.control_interface = ruckig.ControlInterface.Position
        self._input.target_position, self._input.target_velocity = [x], [0.0]
        self._input.max_velocity = [max(speed, (abs(self.speed) + self.accel**2 / (2 * self._input.max_jerk[0])) * (1 + 1e-6))]
        return self._begin(0.0)

    def advance(self, dt_s: float) -> None:
        """dt_s further along the plan."""
        if not self._planned:
            self.x += self.speed * dt_s
            return
        self._time += dt_s
        (self.x,), (self.speed,), (self.accel,) = self._plan.at_time(self._time)
        if self._time >= self._plan.duration:
            self._planned, self.speed, self.accel = False, self._slow, 0.0

    def _begin(self, end_speed: float) -> bool:
        self._input.current_position, self._input.current_velocity = [self.x], [self.speed]
        self._input.current_acceleration = [self.accel]
        try:
            self._solver.calculate(self._input, self._trial)
        except ruckig.RuckigError:
            return False
        self._plan, self._trial = self._trial, self._plan
        self._planned, self._time, self._slow = True, 0.0, end_speed
        return True
