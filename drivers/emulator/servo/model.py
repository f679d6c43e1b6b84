"""One servo axis in steps of 62.5 us: current, speed and position loop, motor and load, friction, brake torque, heat.

Rates, as in drives of that time: current loop and mechanics 62.5 us, speed loop 125 us, position loop with fine interpolation 250 us,
thermal models, gravity and disturbance torque 1 ms.  All ticks lie on one absolute grid of steps: the result does not depend on how calls
divide the steps, bit for bit.  Speed comes from the resolver converter's analogue output, position from its counter (AX-084).

The state is a plain list of floats and `run` a function over it: six axes have 96,000 steps a second, and attribute access would
cost more than the arithmetic.  `substeps` divides the integration step without touching the loops' rates (to judge the step itself).
"""

from enum import IntEnum
from math import exp, inf, pi, sin
from typing import ClassVar, Protocol

from drivers.emulator.servo.settings import INC_PER_TURN, ServoSettings

STEP_NS = 62_500
STEPS_PER_TICK = 4  # position loop
STEPS_PER_SLOW = 16  # 1 ms
NEVER = 1 << 62  # a step, or an instant, that does not come
INC_PER_RAD = INC_PER_TURN / (2.0 * pi)
_RNG_MODULUS = 2147483647.0  # Park and Miller's generator; all its products are exact in a float


def steps(seconds: float) -> int:
    """Rounded to full steps."""
    return round(seconds * 1e9 / STEP_NS)


class Trip(IntEnum):
    """Why `run` stopped before its last step."""

    NONE, FOLLOWING, OVERSPEED, WINDOW, I2T, WINDING = range(6)


class Mode(IntEnum):
    OFF, FOLLOW, RAMP = range(3)


# Indices of the state.  The first row is computed by the model, the second is set from outside.
(TH, W, TM, TR, IT, WR, LEFT, I2T, TEMP, RNG, LOAD, REST) = range(12)
(GOAL, RATE, FF, MODE, FS, FC, WLO, WHI, SMIN, SMAX, EXT, SG, KS, KO, ARMED) = range(12, 27)


def constants(s: ServoSettings, substeps: int = 1) -> tuple[float, ...]:
    """Everything `run` needs that never changes; exact one-step solutions of current loop and viscous friction."""
    h = STEP_NS * 1e-9 / substeps
    decay = exp(-h / s.current_time_constant_s)
    ca = 1.0 - decay
    mean = s.current_time_constant_s / h * ca  # mean of the remaining error over a step
    drag = s.viscous_nms_per_rad / s.inertia_kgm2
    cv = exp(-drag * h)
    hj = (1.0 - cv) / s.viscous_nms_per_rad if s.viscous_nms_per_rad > 0.0 else h / s.inertia_kgm2
    speed_ki = s.speed_gain * 2.0 * STEP_NS * 1e-9 / s.speed_integral_s
    tick_s, slow_s = STEPS_PER_TICK * STEP_NS * 1e-9, STEPS_PER_SLOW * STEP_NS * 1e-9
    return (
        *(ca, (1.0 - mean) / ca, cv, hj, h / 2.0),
        *(s.speed_gain, speed_ki, s.torque_limit_nm, s.kv_per_s / INC_PER_RAD, s.following_error_rad * INC_PER_RAD),
        *(s.quick_stop_rad_s2 * tick_s, s.overspeed_rad_s),
        *(1.0 / s.rated_torque_nm, 1.0 - exp(-slow_s / s.i2t_time_constant_s)),
        *(1.0 - exp(-slow_s / s.winding_time_constant_s), s.ambient_c, s.winding_rise_k, s.winding_trip_c),
        *(s.gravity_nm, s.gravity_arm_nm, 1.0 / s.gravity_arm_gear, s.gravity_arm_phase_rad, s.torque_noise_nm),
    )


def run(s: list[float], c: tuple[float, ...], step: int, n: int, substeps: int) -> tuple[int, int]:  # noqa: C901, PLR0915 - one loop by hand, see below
    """Runs `n` steps from step number `step`; (steps not run, Trip) when something stopped it early, at exactly that tick.

    One long function by purpose: locals only, nothing allocated, the tests' figure emulator.six_axes_cpu decides.
    """
    (th, w, tm, tr, it, wr, left, i2t, temp, rng, load, rest, goal, rate, ff) = s[:15]
    (mode, fs, fc, wlo, whi, smin, smax, ext, sg, ks, ko, armed) = s[15:]
    (ca, cm, cv, hj, h2, kp, ki, tmax, kv, window, ramp, wmax) = c[:12]
    phase, trip, pair, one = step & 15, 0, (0,) * (2 * substeps), (0,) * substeps
    while n > 0:
        if rest and n >= 16 and not phase:
            n -= 16  # off and stuck: 16 steps would change nothing, the slow tick below still counts
        else:
            single = phase & 1 or n == 1
            for _ in one if single else pair:
                d = (tr - tm) * ca
                x = tm + d * cm - load  # mean torque over the step
                tm += d
                if w > 0.0:
                    v = w * cv + (x - fc) * hj
                    if v < 0.0:
                        v = 0.0  # friction stops, it never turns the axis round
                elif w < 0.0:
                    v = w * cv + (x + fc) * hj
                    if v > 0.0:
                        v = 0.0
                elif x > fs:
                    v = (x - fc) * hj
                elif x < -fs:
                    v = (x + fc) * hj
                else:
                    continue  # true stiction
                th += (w + v) * h2
                w = v
            if single:
                phase = phase + 1 & 15
                n -= 1
                if phase & 1:
                    break
            else:
                phase = phase + 2 & 15
                n -= 2
        if not phase & 3:
            if not phase:
                x = tm * c[12]
                x *= x
                i2t += (x - i2t) * c[13]
                temp += (c[15] + c[16] * x - temp) * c[14]
                rng = rng * 16807.0 % _RNG_MODULUS
                load = c[18] + ext + (rng * (2.0 / _RNG_MODULUS) - 1.0) * c[22]
                if c[19]:
                    load += c[19] * sin(th * c[20] + c[21])
                if mode or w:
                    rest = 0.0
                else:
                    if -1e-6 < tm < 1e-6:
                        tm = 0.0
                    rest = 1.0 if not tm and -fs <= load <= fs else 0.0
                if armed:
                    if i2t > 1.0:
                        trip = 4
                    elif temp > c[17]:
                        trip = 5
            if mode == 1.0:
                left -= 1.0
                e = (goal - rate * left if left > 0.0 else goal) - (th * ks + ko) // 1.0
                if (e > window or e < -window) and armed:
                    trip = 1
                wr = kv * e + ff
            elif mode:
                wr = wr - ramp if wr > ramp else wr + ramp if wr < -ramp else 0.0
            if wr > smax:
                wr = smax
            elif wr < smin:
                wr = smin
            if not -wmax < w * sg < wmax and armed:
                trip = 2
            if (th > whi or th < wlo) and not trip:
                trip = 3
        if mode:
            e = wr - w * sg
            x = kp * e + it
            if x > tmax:
                tr = tmax
                if e < 0.0:
                    it += ki * e  # anti-windup: at the limit only back
            elif x < -tmax:
                tr = -tmax
                if e > 0.0:
                    it += ki * e
            else:
                tr = x
                it += ki * e
        if trip:
            break
    s[:12] = th, w, tm, tr, it, wr, left, i2t, temp, rng, load, rest
    return n, trip


class Steps(Protocol):
    """Signature of `run`."""

    def __call__(self, s: list[float], c: tuple[float, ...], step: int, n: int, substeps: int, /) -> tuple[int, int]: ...


class Servo:
    """The state of one axis and the interventions at it.  `step` counts from power-up of the bus."""

    steps: ClassVar[Steps] = staticmethod(run)  # or the same in C (AX-1020)

    def __init__(self, settings: ServoSettings, seed: int = 1, substeps: int = 1) -> None:
        self.settings, self.step = settings, 0
        self._substeps = substeps
        self._constants = constants(settings, substeps)
        self._ahead: list[float] | None = None
        self._ahead_step = 0
        self._state = s = [0.0] * 27
        s[TH], s[TEMP], s[RNG] = settings.start_rad, settings.ambient_c, float(seed % 2147483646 + 1)
        s[WLO], s[WHI] = -inf, inf
        s[SMIN], s[SMAX] = -settings.speed_limit_rad_s, settings.speed_limit_rad_s
        s[LOAD] = settings.gravity_nm + settings.gravity_arm_nm * sin(
            settings.start_rad / settings.gravity_arm_gear + settings.gravity_arm_phase_rad
        )
        self.close_brake()
        self.power_up()

    # -- running --------------------------------------------------------------------------------

    def run_to(self, step: int) -> Trip:
        """Runs up to `step`; a trip ends the run at the tick that found it (see self.step)."""
        if self._ahead is not None and step >= self._ahead_step:
            self._state, self.step, self._ahead = self._ahead, self._ahead_step, None
        n = step - self.step
        if n <= 0:
            return Trip.NONE
        left, trip = self.steps(self._state, self._constants, self.step, n, self._substeps)
        self.step = step - left
        return Trip(trip) if trip else Trip.NONE

    def prepare(self, step: int) -> None:
        """Runs ahead on a copy, so that the answer to the next SYNC is nearly ready; forgotten when anything is changed before."""
        if self._ahead is None and step > self.step:
            ahead = self._state[:]
            _, trip = self.steps(ahead, self._constants, self.step, step - self.step, self._substeps)
            if not trip:
                self._ahead, self._ahead_step = ahead, step

    # -- looking --------------------------------------------------------------------------------

    @property
    def position_rad(self) -> float:
        return self._state[TH]

    @property
    def speed_rad_s(self) -> float:
        return self._state[W]

    @property
    def measured_speed_rad_s(self) -> float:
        return self._state[W] * self._state[SG]

    @property
    def speed_demand_rad_s(self) -> float:
        return self._state[WR]

    @property
    def torque_nm(self) -> float:
        return self._state[TM]

    @property
    def i2t(self) -> float:
        """1.0 trips."""
        return self._state[I2T]

    @property
    def winding_c(self) -> float:
        return self._state[TEMP]

    def latch(self, rest_ns: int) -> tuple[float, int]:
        """Shaft position in rad and counter in inc (unwrapped), `rest_ns` after the last step."""
        s = self._state
        position = s[TH] + s[W] * rest_ns * 1e-9
        return position, int((position * s[KS] + s[KO]) // 1.0)

    def demand_inc(self, rest_ns: int) -> float:
        """Set position of the fine interpolator, `rest_ns` after the last step."""
        s = self._state
        left = s[LEFT] - self._ticks(rest_ns)
        return s[GOAL] - s[RATE] * left if left > 0.0 else s[GOAL]

    def turn_bounds_rad(self) -> tuple[int, float, float]:
        """Number of the counter's present turn and the shaft positions of its two ends (lower, upper)."""
        turn = int(self.counter_inc // INC_PER_TURN)
        if self.stuck:
            return turn, -inf, inf
        ends = sorted((self.shaft_rad(turn * INC_PER_TURN), self.shaft_rad((turn + 1) * INC_PER_TURN)))
        return turn, ends[0], ends[1]

    def jump(self, increments: int) -> None:
        """The counter jumps (a fault of the encoder)."""
        self._touch()[KO] += increments

    @property
    def counter_inc(self) -> float:
        return self._state[TH] * self._state[KS] + self._state[KO]

    @property
    def stuck(self) -> bool:
        return self._state[KS] == 0.0

    def shaft_rad(self, counter_inc: float) -> float:
        """Shaft position at which the counter shows this; not defined while the encoder is stuck."""
        return (counter_inc - self._state[KO]) / self._state[KS]

    def _ticks(self, rest_ns: int) -> float:
        return ((self.step & 3) + rest_ns / STEP_NS) / STEPS_PER_TICK

    # -- acting ---------------------------------------------------------------------------------

    def power_up(self) -> None:
        """The counter knows the position within one turn only, as a resolver does."""
        s = self._touch()
        s[KS], s[SG] = INC_PER_RAD, 1.0
        offset = float(self.settings.resolver_offset_inc)
        s[KO] = offset - (s[TH] * INC_PER_RAD + offset) // INC_PER_TURN * INC_PER_TURN
        s[ARMED] = 1.0

    def off(self) -> None:
        """No torque demand."""
        s = self._touch()
        s[MODE], s[TR], s[IT], s[WR], s[FF] = Mode.OFF, 0.0, 0.0, 0.0, 0.0

    def hold(self) -> None:
        """Position control at the present counter."""
        s = self._touch()
        s[MODE], s[REST], s[RATE], s[LEFT], s[FF] = Mode.FOLLOW, 0.0, 0.0, 0.0, 0.0
        s[GOAL] = self.counter_inc // 1.0

    def follow(self, goal_inc: float, rest_ns: int, cycle_ns: int, feed_forward_rad_s: float) -> None:
        """New goal at `rest_ns` after the last step, reached by interpolation one cycle later."""
        demand = self.demand_inc(rest_ns)
        s = self._touch()
        ticks = cycle_ns / (STEP_NS * STEPS_PER_TICK)
        s[GOAL], s[RATE], s[LEFT] = goal_inc, (goal_inc - demand) / ticks, ticks + self._ticks(rest_ns)
        s[FF] = feed_forward_rad_s * self.settings.speed_feed_forward

    def ramp(self) -> None:
        """Speed control down to zero along the emergency-stop ramp, from the present measured speed."""
        s = self._touch()
        s[MODE], s[REST], s[FF], s[WR] = Mode.RAMP, 0.0, 0.0, s[W] * s[SG]

    def retune(self, settings: ServoSettings) -> None:
        """Other settings from the next step on; for a booster without power.  Start position and mechanics stay."""
        s = self._touch()
        self.settings, self._constants = settings, constants(settings, self._substeps)
        s[SMIN], s[SMAX] = -settings.speed_limit_rad_s, settings.speed_limit_rad_s

    def arm(self, on: bool) -> None:
        """Trips on following error, overspeed and heat."""
        self._touch()[ARMED] = 1.0 if on else 0.0

    def watch(self, low_rad: float, high_rad: float) -> None:
        """Trip.WINDOW outside these shaft positions (looked at every 250 us)."""
        s = self._touch()
        s[WLO], s[WHI] = low_rad, high_rad

    def block(self, direction: int) -> None:
        """No speed demand in this direction (+1, -1); 0: both are free."""
        s, limit = self._touch(), self.settings.speed_limit_rad_s
        s[SMIN], s[SMAX] = 0.0 if direction < 0 else -limit, 0.0 if direction > 0 else limit

    def open_brake(self) -> None:
        s = self._touch()
        s[FS], s[FC], s[REST] = self.settings.stiction_nm, self.settings.coulomb_nm, 0.0

    def close_brake(self) -> None:
        s = self._touch()
        extra = self.settings.brake_torque_nm if self.settings.brake else 0.0
        s[FS], s[FC], s[REST] = self.settings.stiction_nm + extra, self.settings.coulomb_nm + extra, 0.0

    def load_torque(self, torque_nm: float) -> None:
        """External torque at the motor shaft against positive motion; acts from the next 1 ms tick."""
        s = self._touch()
        s[EXT], s[REST] = torque_nm, 0.0

    def encoder(self, factor: int) -> None:
        """1 true, -1 counts backwards, 0 stuck; the counter continues from its present value."""
        s = self._touch()
        counter = self.counter_inc
        s[SG], s[KS] = float(factor), factor * INC_PER_RAD
        s[KO] = counter - s[TH] * s[KS]

    def _touch(self) -> list[float]:
        self._ahead = None
        return self._state
