"""Drive parameters of an emulated booster: which it accepts and stores, and their effect.

Numbers and meanings: rho 3 Releases part 5, 7.3 (L7549-7578); units, ranges and the transport are axisgate's own (AX-266, AX-267).
Written from these tables, not from the gateway's side.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf, pi

from drivers.emulator.servo.settings import INC_PER_TURN, ServoSettings, SettingsError
from protocols.servodyn.parameters import Answer, Request, Status, Value

RPM = 2.0 * pi / 60.0
STORE, CLOCK, SPEED_GAIN, SPEED_INTEGRAL, POSITION_GAIN, LIMIT_CW, LIMIT_CCW = 1, 4, 5, 6, 7, 8, 9
CURRENT_AUTO, SPEED_AUTO, STOP_SLOPE, BRAKE_SPEED, LAG, SCALING, ZERO_SHIFT, DIRECTION, HEAT = 10, 12, 15, 16, 18, 21, 22, 23, 24
INC = {1: 1, 2: 2, 3: 4}  # position scaling -> resolver increments for one of the telegram's


@dataclass(frozen=True, slots=True)
class Rule:
    """Permitted values of a parameter."""

    kind: type
    low: float
    high: float


def _int(low: float, high: float) -> Rule:
    return Rule(int, low, high)


def _real(low: float, high: float) -> Rule:
    return Rule(float, low, high)


_BOOL = Rule(bool, 0, 1)
RULES: Mapping[int, Rule] = {
    STORE: _BOOL, 2: _int(0, 65535), 3: _int(0, 65535), CLOCK: _int(1, 32), SPEED_GAIN: _real(1e-6, 1000), SPEED_INTEGRAL: _real(0.1, 1e5),
    POSITION_GAIN: _real(0.1, 500), LIMIT_CW: _int(-(2**31), 2**31 - 1), LIMIT_CCW: _int(-(2**31), 2**31 - 1),
    CURRENT_AUTO: _real(1, 1000), 11: _real(1, 1000), SPEED_AUTO: _real(1, 20000), 13: _real(1, 20000), 14: _real(1, 1000),
    STOP_SLOPE: _real(10, 1e7), BRAKE_SPEED: _real(0.01, 1000), 17: _int(0, 1 << 24), LAG: _real(1e-4, 100), 19: _real(1, 10000),
    20: _real(0.01, 10), SCALING: _int(1, 3), ZERO_SHIFT: _int(0, INC_PER_TURN - 1), DIRECTION: _BOOL, HEAT: _BOOL, 50: _BOOL,
}  # fmt: skip


@dataclass
class ParameterStore:
    """The parameters of one booster: in RAM until the supply fails, in EEPROM those sent while number 1 was TRUE."""

    factory: ServoSettings
    eeprom: dict[int, Value] = field(default_factory=dict)
    ram: dict[int, Value] = field(default_factory=dict)

    def take(self, request: Request, power_on: bool) -> Answer:
        """Judges one request; the answer carries the resulting value in the drive."""
        rule = RULES.get(request.number)
        stored = self.ram.get(request.number, 0)
        if rule is None:
            return Answer(request.number, Status.UNKNOWN, 0, request.sequence)
        if power_on:
            return Answer(request.number, Status.DRIVES_ON, stored, request.sequence)
        if type(request.value) is not rule.kind or not rule.low <= request.value <= rule.high or not self._possible(request):
            return Answer(request.number, Status.RANGE, stored, request.sequence)
        self.ram[request.number] = request.value
        if self.ram.get(STORE):
            self.eeprom[request.number] = request.value
        return Answer(request.number, Status.TAKEN, request.value, request.sequence)

    def restart(self) -> None:
        """Power returns: unsaved values are lost."""
        self.ram = dict(self.eeprom)

    @property
    def scale(self) -> int:
        """Resolver increments for one increment of the telegrams (number 21)."""
        return INC[int(self.ram.get(SCALING, 1))]

    def settings(self, values: Mapping[int, Value] | None = None) -> ServoSettings:
        """Factory settings with the parameters worked in.  Raises SettingsError where they contradict each other."""
        taken = self.ram if values is None else values
        base, made = self.factory, dict[str, float]()
        for number, name, factor in _PLAIN:
            if number in taken:
                made[name] = float(taken[number]) * factor
        scale = INC[int(taken.get(SCALING, 1))]
        if LIMIT_CW in taken:
            made["soft_limit_max_inc"] = int(taken[LIMIT_CW]) * scale
        if LIMIT_CCW in taken:
            made["soft_limit_min_inc"] = -int(taken[LIMIT_CCW]) * scale
        if CURRENT_AUTO in taken:
            made["torque_limit_nm"] = max(base.rated_torque_nm * float(taken[CURRENT_AUTO]) / 100.0, base.rated_torque_nm)
        speed = made.get("speed_limit_rad_s", base.speed_limit_rad_s)
        if SPEED_AUTO in taken:
            made["overspeed_rad_s"] = max(base.overspeed_rad_s, 1.2 * speed)
        if LAG in taken:
            made["following_error_rad"] = max(1.2 * speed * float(taken[LAG]), 0.01)  # max lag = speed x Kev_SI (L7569)
        if HEAT in taken and not taken[HEAT]:
            made |= {"winding_warning_c": inf, "winding_trip_c": inf}
        return _replaced(base, made)

    def _possible(self, request: Request) -> bool:
        """Together with the other parameters it makes an axis that can be."""
        try:
            self.settings({**self.ram, request.number: request.value})
        except SettingsError:
            return False
        return True


_PLAIN = (  # number -> setting, factor
    (SPEED_GAIN, "speed_gain_nms_per_rad", 1.0),
    (SPEED_INTEGRAL, "speed_integral_s", 0.001),
    (POSITION_GAIN, "kv_per_s", 1.0),
    (SPEED_AUTO, "speed_limit_rad_s", RPM),
    (STOP_SLOPE, "quick_stop_rad_s2", RPM),
    (BRAKE_SPEED, "brake_lock_speed_rad_s", RPM),
)


def _replaced(base: ServoSettings, made: Mapping[str, float]) -> ServoSettings:
    """`replace` with values of mixed kinds; a heat limit switched off is none of the settings' own range."""
    heat = {name: value for name, value in made.items() if value == inf}
    settings = replace(base)
    for name, value in made.items():
        if name not in heat:
            object.__setattr__(settings, name, value)
    settings.__post_init__()
    for name, value in heat.items():
        object.__setattr__(settings, name, value)
    return settings
