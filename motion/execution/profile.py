"""Jerk-limited motion along one path: a thin skin over ruckig with one degree of freedom.

Inside, s runs from 0 to 1 and time is measured so that the jerk limit is 1: ruckig's fixed tolerances (1e-8 and finer)
then mean the same for a move of 1 um and one of 1 km.  Intermediate waypoints are never used: they ask a cloud service
(motion.md 0.3).  Note: ruckig's binding prints "leaked instances" on stderr when the interpreter ends; harmless.
"""

import ruckig

EDGE = 1e-10  # of the length: how far a new plan may reach beyond the end, or back, by rounding; cut off by the caller

MARGINS = (1.0, 1.0 + 1e-9, 1.0 + 1e-6)  # a state that touches the speed limit to the last bit has, for ruckig, no way on


class Profile:
    """s(t) from the present state to the end of the path, or to a speed.  Objects are allocated once; planning needs about 2 us."""

    def __init__(self) -> None:
        self._solver = ruckig.Ruckig(1)
        self._input = ruckig.InputParameter(1)
        self._current, self._trial = ruckig.Trajectory(1), ruckig.Trajectory(1)
        self._length = self._time = 1.0
        self.duration = 0.0  # s

    def configure(self, length: float, accel: float, jerk: float) -> None:
        """Path length (> 0), highest |sddot|, highest |s jerk|; s units."""
        self._length, self._time = length, (length / jerk) ** (1 / 3)
        self._input.max_acceleration = [accel * self._time**2 / length]
        self._input.max_jerk = [1.0]
        self.duration = 0.0

    def to_end(self, state: tuple[float, float, float], speed: float) -> bool:
        """Plan from (s, sdot, sddot) to rest at the end with sdot <= speed; False: no such plan, the old one stays."""
        self._input.control_interface = ruckig.ControlInterface.Position
        self._input.target_position = [1.0]
        self._input.target_velocity = [0.0]
        return any(self._plan(state, speed * margin) for margin in MARGINS)

    def to_speed(self, state: tuple[float, float, float], speed: float, latest: float | None = None) -> bool:
        """Plan from (s, sdot, sddot) to a steady speed (0: to rest) as fast as the limits allow, reached before s = latest
        (default the end); False: no such plan, the old one stays."""
        self._input.control_interface = ruckig.ControlInterface.Velocity
        self._input.target_velocity = [speed * self._time / self._length]
        return self._plan(state, self._length / self._time, 1.0 if latest is None else latest / self._length)

    def at(self, time_s: float) -> tuple[float, float, float]:
        """(s, sdot, sddot) time_s after the plan's start; beyond its end the end."""
        (s,), (v,), (a,) = self._current.at_time(time_s / self._time)
        scale = self._length / self._time
        return s * self._length, v * scale, a * scale / self._time

    def _plan(self, state: tuple[float, float, float], speed: float, latest: float | None = None) -> bool:
        scale = self._time / self._length
        start = state[0] / self._length
        self._input.current_position = [start]
        self._input.current_velocity = [state[1] * scale]
        self._input.current_acceleration = [state[2] * scale * self._time]
        self._input.max_velocity = [speed * scale]
        try:
            self._solver.calculate(self._input, self._trial)
        except ruckig.RuckigError:
            return False
        (last,), _, _ = self._trial.at_time(self._trial.duration)  # position_extrema of a speed plan counts the unused target too
        furthest = self._trial.position_extrema[0].max if latest is None else last
        if last < start - EDGE or furthest > (1.0 if latest is None else latest) + EDGE:
            return False  # would turn back or go too far: never on a path that is run forward
        self._current, self._trial = self._trial, self._current
        self.duration = float(self._current.duration) * self._time
        return True
