"""The servo model with the inputs a CiA 402 drive has: torque limit, following-error window, speed and torque set values.

Nothing of the model changes: the speed set value is the model's own ramp with slope zero, the torque set value its torque limit with the
speed demand at the speed limit, as real drives limit the speed in torque modes (AX-286).
"""

from math import inf

from drivers.emulator.servo.model import FF, GOAL, INC_PER_RAD, KO, KS, MODE, REST, STEP_NS, STEPS_PER_TICK, TH, TR, WR, Mode, Servo
from drivers.emulator.servo.settings import INC_PER_TURN, ServoSettings

_TICK_S = STEPS_PER_TICK * STEP_NS * 1e-9
_TORQUE_MAX, _WINDOW, _RAMP = 7, 9, 10  # places in drivers.emulator.servo.model.constants


class DriveServo(Servo):
    """All set values in increments, increments a second, Nm."""

    def __init__(self, settings: ServoSettings, seed: int = 1, substeps: int = 1, turns: int = 0) -> None:
        self._turns = turns
        super().__init__(settings, seed, substeps)
        self._torque_limit = settings.torque_limit_nm
        self._window = 0.0
        self.following_window(inf)

    def power_up(self) -> None:
        """A multi-turn encoder knows its turns: the counter comes up within -turns/2..turns/2 (and has wrapped if it was moved beyond)."""
        super().power_up()
        if self._turns:
            s, span = self._touch(), float(self._turns * INC_PER_TURN)
            place = s[TH] * INC_PER_RAD + self.settings.resolver_offset_inc
            s[KO] = self.settings.resolver_offset_inc - (place + span / 2.0) // span * span

    def limit_torque(self, torque_nm: float) -> None:
        """At most the limit of motor and amplifier."""
        self._torque_limit = min(torque_nm, self.settings.torque_limit_nm)
        self._constant(_TORQUE_MAX, self._torque_limit)

    def following_window(self, window_inc: float) -> None:
        """Trip.FOLLOWING beyond it; inf: never."""
        if window_inc != self._window:
            self._window = window_inc
            self._constant(_WINDOW, window_inc)

    def stop(self, deceleration_inc: float) -> None:
        """Speed control down to zero from the present measured speed."""
        self._constant(_RAMP, deceleration_inc / INC_PER_RAD * _TICK_S)
        self.ramp()

    def speed(self, speed_inc: float) -> None:
        """Speed control at this speed."""
        self._constant(_TORQUE_MAX, self._torque_limit)
        self._demand(speed_inc / INC_PER_RAD)

    def torque(self, torque_nm: float) -> None:
        """This torque, as long as the speed limit is not reached."""
        self._constant(_TORQUE_MAX, min(abs(torque_nm), self._torque_limit))
        limit = self.settings.speed_limit_rad_s
        self._demand(limit if torque_nm > 0.0 else -limit if torque_nm < 0.0 else 0.0)

    def hold(self) -> None:
        self._constant(_TORQUE_MAX, self._torque_limit)
        super().hold()

    @property
    def mode(self) -> int:
        return int(self._state[MODE])

    @property
    def slope(self) -> float:
        """Increments the counter counts for one rad of the shaft; 0 while it is stuck, negative while its sign is wrong."""
        return self._state[KS]

    @property
    def goal_inc(self) -> float:
        """Where the set values lead, in increments of the counter."""
        return self._state[GOAL]

    @property
    def torque_demand_nm(self) -> float:
        return self._state[TR]

    @property
    def measured_inc(self) -> float:
        """Measured speed, inc/s."""
        return self.measured_speed_rad_s * INC_PER_RAD

    def _demand(self, speed_rad_s: float) -> None:
        self._constant(_RAMP, 0.0)
        s = self._touch()
        s[MODE], s[REST], s[FF], s[WR] = Mode.RAMP, 0.0, 0.0, speed_rad_s

    def _constant(self, place: int, value: float) -> None:
        if self._constants[place] != value:
            self._touch()
            self._constants = (*self._constants[:place], value, *self._constants[place + 1 :])
