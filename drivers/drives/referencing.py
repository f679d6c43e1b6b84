"""Referencing by the gateway: run towards the switch, find the encoder zero as the mode requires, then move the offset.

Mode | when the switch is seen (rho3 2.8, L3783-3891)
0    | go on in the same direction to the next encoder zero; there actual = P207; move P208
1    | compute the axis' own zero from resolver and gear factor (orientation.py), go there; actual = P207; move P208
2    | stop along the ramp; actual = P207 and the way from the encoder zero next to the edge; move P208, without one stay
3    | as mode 2 with the zero of mode 1

axisgate's: a switch actuated at the start is left first (AX-111), limits of way and time (AX-112), no stop at the zero of mode 0
(AX-113), speeds and which zero is the next one in modes 1 to 3 (AX-264, AX-265), a zero that could be either side of the edge (AX-438).
"""

from enum import Enum, auto
from typing import NamedTuple

from drivers.drives.orientation import orientation
from drivers.drives.ramp import Ramp
from drivers.drives.reference_settings import ORIENTED, STOPPING, ReferenceSettings


class RunState(Enum):
    """DONE and FAILED are reported only at a standstill of the set value."""

    RUNNING = auto()
    DONE = auto()
    FAILED = auto()


class Failure(Enum):
    """Why; the value is the text."""

    NOT_FOUND = "the reference switch was not reached within the allowed travel"
    NOT_LEFT = "the reference switch was actuated at the start and stayed so over the allowed travel"
    AMBIGUOUS = (
        "an encoder zero is between two samples of the reference switch, so the next one is not known:"
        " move the switch by half a motor turn, or reference more slowly"
    )
    TIMEOUT = "the time for referencing is over"
    ABORTED = "referencing was aborted"


class RefStep(NamedTuple):
    """Set value for the next SYNC."""

    set_inc: int
    speed_inc_s: float
    state: RunState
    why: Failure | None = None


class Leg(Enum):
    """Part of the run."""

    LEAVE = auto()  # the switch was actuated at the start: away from it
    SEEK = auto()  # towards the switch
    ZERO = auto()  # mode 0, switch seen: slowly on to the encoder zero
    APPROACH = auto()  # mode 1, switch seen: to the axis' own zero, perhaps turns back
    STOP = auto()  # modes 2 and 3, switch seen: to rest
    OFFSET = auto()  # zero passed: to the reference point
    BRAKE = auto()  # failed: to rest


class Referencing:
    """One run of one axis; step() once per SYNC."""

    def __init__(self, settings: ReferenceSettings, position_inc: int) -> None:
        self._settings = settings
        self._origin = position_inc
        turn = settings.inc_per_turn
        self._ramp = Ramp(settings.accel_inc_s2 / turn, settings.jerk_inc_s3 / turn)
        self._leg: Leg | None = None
        self._time = 0.0
        self._target = 0.0  # of OFFSET, turns from the origin
        self._zero: float | None = None  # where the actual value is P207
        self._off_inc = position_inc  # last place where the switch was not actuated
        self._why: Failure | None = None
        self._state = RunState.RUNNING
        self.zero_inc: float | None = None  # where the axis reads 0; known from the encoder zero on
        self.switch_to_zero_inc: int | None = None  # shows the fitter how safely the switch is placed

    def abort(self) -> None:
        """To rest; FAILED is reported there."""
        self._fail(Failure.ABORTED)

    def step(self, position_inc: int, reference_switch: bool, dt_s: float) -> RefStep:
        """position_inc, reference_switch: of the same actual value."""
        if self._state is not RunState.RUNNING:
            return self._answer()
        self._time += dt_s
        if self._time > self._settings.timeout_s:
            self._fail(Failure.TIMEOUT)
        elif abs(position_inc - self._origin) > self._settings.way_inc and self._leg in (Leg.LEAVE, Leg.SEEK, Leg.ZERO):
            self._fail(Failure.NOT_LEFT if self._leg is Leg.LEAVE else Failure.NOT_FOUND)
        self._decide(position_inc, reference_switch)
        self._ramp.advance(dt_s)
        self._judge_rest()
        return self._answer()

    def _answer(self) -> RefStep:
        turn = self._settings.inc_per_turn
        return RefStep(self._origin + round(self._ramp.x * turn), self._ramp.speed * turn, self._state, self._why)

    def _decide(self, position_inc: int, switch: bool) -> None:
        settings = self._settings
        match self._leg:
            case None:
                self._run(Leg.LEAVE if switch else Leg.SEEK, -settings.seek_inc_s if switch else settings.seek_inc_s)
            case Leg.LEAVE if not switch:
                self._run(Leg.SEEK, settings.seek_inc_s)  # the ramp turns the axis round beyond the edge
            case Leg.SEEK if switch:
                self._found(position_inc)
            case Leg.SEEK:
                self._off_inc = position_inc
            case Leg.ZERO if self._zero is not None and (position_inc - self._zero) * settings.direction >= 0:
                self._take_zero(self._zero)
            case _:
                pass

    def _found(self, position_inc: int) -> None:
        """The edge: determine the zero, and the next motion of the axis."""
        settings = self._settings
        if settings.mode == 0:
            self._zero = self._next_zero(position_inc)
            self.switch_to_zero_inc = round(abs(self._zero - position_inc))
            if self._zero == self._next_zero(self._off_inc):
                self._run(Leg.ZERO, settings.slow_inc_s)
            else:
                self._fail(Failure.AMBIGUOUS)
            return
        found = orientation(position_inc, settings.inc_per_turn, settings.gear if settings.mode in ORIENTED else 1.0)
        self._zero, self.switch_to_zero_inc = found.zero_inc, round(abs(found.deviation_inc))
        if settings.mode == 1:
            self._target, self._leg = self._turns(found.zero_inc), Leg.APPROACH
            self._move()
        else:
            self._run(Leg.STOP, 0.0)

    def _take_zero(self, zero: float) -> None:
        """From here on the axis position is known; only the offset remains."""
        settings = self._settings
        self.zero_inc = zero - settings.position_inc
        stays = settings.mode in STOPPING and settings.offset_inc == 0.0  # the zero itself is not approached (L3855)
        self._target = self._ramp.x if stays else self._turns(zero + settings.offset_inc)
        self._leg = Leg.OFFSET
        self._move()

    def _turns(self, position_inc: float) -> float:
        return (position_inc - self._origin) / self._settings.inc_per_turn

    def _next_zero(self, position_inc: int) -> int:
        """Position = 0 mod inc_per_turn strictly after position_inc, in the direction of the run."""
        turn, direction = self._settings.inc_per_turn, self._settings.direction
        return direction * (direction * position_inc // turn + 1) * turn

    def _run(self, leg: Leg, speed_inc_s: float) -> None:
        if self._ramp.to_speed(self._settings.direction * speed_inc_s / self._settings.inc_per_turn):
            self._leg = leg

    def _move(self) -> None:
        if not self._ramp.to_position(self._target, self._settings.speed_inc_s / self._settings.inc_per_turn):
            self._ramp.to_speed(0.0)  # from rest there is always a way; _judge_rest sees to it

    def _fail(self, why: Failure) -> None:
        if self._state is RunState.RUNNING and self._leg is not Leg.BRAKE:
            self._why, self._leg, self.zero_inc = why, Leg.BRAKE, None
            self._ramp.to_speed(0.0)

    def _judge_rest(self) -> None:
        if not self._ramp.at_rest:
            return
        if self._leg is Leg.BRAKE:
            self._state = RunState.FAILED
        elif self._leg in (Leg.OFFSET, Leg.APPROACH) and abs(self._ramp.x - self._target) > 1e-7:
            self._move()
        elif self._leg in (Leg.APPROACH, Leg.STOP) and self._zero is not None:
            self._take_zero(self._zero)
        elif self._leg is Leg.OFFSET:
            self._state = RunState.DONE
