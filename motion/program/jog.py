"""Manual mode of the rho 3: jog keys, their speeds and slopes, and the limit that holds in manual mode.

Source: rho 3 Releases part 1, L628-632 (slow -> fast after about 1.5 s; flange at most 25 cm/s), L3633-3695 (P104, P105, P122
in automatic; P128, P129, P130 the same for jogging in joint coordinates, unset ones inherit the older values; P117 for world
coordinates, up and down), L5558 (P114: fast joint jog and manual limit).  Which of P111 .. P114 is which: AX-410.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from motion.errors import MotionError

SLOW_TO_FAST_S = 1.5
FLANGE_LIMIT = 0.25  # m/s, VDI 2853


@dataclass(frozen=True, slots=True)
class JogSpeeds:
    """P111 .. P114; per axis in m/s or rad/s, world coordinates in m/s (None: there is no jogging in them)."""

    world_slow: float | None = None
    world_fast: float | None = None
    joint_slow: tuple[float, ...] = ()
    joint_fast: tuple[float, ...] = ()  # P114: also the limit of every axis in manual mode

    def __post_init__(self) -> None:
        if len(self.joint_slow) != len(self.joint_fast):
            raise MotionError(f"P113: {len(self.joint_slow)} slow and {len(self.joint_fast)} fast jog speeds")
        pairs = [(f"P113/P114 of axis {n + 1}", *both) for n, both in enumerate(zip(self.joint_slow, self.joint_fast, strict=True))]
        if self.world_slow is not None and self.world_fast is not None:
            pairs.insert(0, ("P111/P112", self.world_slow, self.world_fast))
        for name, slow, fast in pairs:
            if not 0.0 < slow <= fast:
                raise MotionError(f"{name}: slow {slow:.6g} and fast {fast:.6g} must be > 0 and slow not above fast")
        if self.world_fast is not None and not self.world_fast <= FLANGE_LIMIT + 1e-12:
            raise MotionError(
                f"P112: {self.world_fast:.6g} m/s is above {FLANGE_LIMIT} m/s, the most a flange may do in manual mode (VDI 2853)"
            )


@dataclass(frozen=True, slots=True)
class SlopeParameters:
    """One axis; None: the parameter is not set.  P104/P128 in per s2, P105/P129 share of the speed, P122/P130 in s."""

    p104: float
    p105: float | None = None
    p122: float | None = None
    p128: float | None = None
    p129: float | None = None
    p130: float | None = None

    def automatic(self) -> tuple[float, float | None, float | None]:
        """Acceleration, slope point, change time of PTP in automatic."""
        return self.p104, self.p105, self.p122

    def jogging(self) -> tuple[float, float | None, float | None]:
        """The same for jogging in joint coordinates: each unset parameter inherits the older one's value (L3669-3695)."""
        return (
            self.p104 if self.p128 is None else self.p128,
            self.p105 if self.p129 is None else self.p129,
            self.p122 if self.p130 is None else self.p130,
        )


def world_slopes(p117_up: float, p117_down: float | None = None) -> tuple[float, float]:
    """P117, up and down slope of jogging in world coordinates; an unset down slope is the up slope (L3667)."""
    return p117_up, p117_up if p117_down is None else p117_down


def manual_speed(wanted: Sequence[float], speeds: JogSpeeds) -> tuple[float, ...]:
    """Axis speeds of a move in manual mode, all slowed in the same proportion until each is within P114; signs stay."""
    if len(wanted) != len(speeds.joint_fast):
        raise MotionError(f"{len(wanted)} speeds for {len(speeds.joint_fast)} axes")
    share = min([1.0, *(top / abs(speed) for speed, top in zip(wanted, speeds.joint_fast, strict=True) if speed)])
    return tuple(speed * share for speed in wanted)


@dataclass(slots=True)
class JogKeys:
    """The keys of one kinematic: continuous jogging in joint coordinates.  Times in s of the caller's clock."""

    speeds: JogSpeeds
    _held: dict[int, int] = field(default_factory=dict)  # axis -> direction
    _since: float = 0.0  # first key of the row went down

    def press(self, axis: int, direction: int, now_s: float) -> None:
        """axis from 0; direction +1 or -1.  A further axis moves at the speed the first one has reached (L628)."""
        if not (0 <= axis < len(self.speeds.joint_fast) and direction in (-1, 1)):
            raise MotionError(f"jog key axis {axis}, direction {direction}: axes 0 .. {len(self.speeds.joint_fast) - 1}, direction -1 or 1")
        if not self._held:
            self._since = now_s
        self._held[axis] = direction

    def release(self, axis: int) -> None:
        """The key went up; with the last one the next press is slow again."""
        self._held.pop(axis, None)

    def wanted(self, now_s: float) -> tuple[float, ...]:
        """Speed of each axis now, before slopes."""
        fast = bool(self._held) and now_s - self._since >= SLOW_TO_FAST_S
        tops = self.speeds.joint_fast if fast else self.speeds.joint_slow
        return tuple(tops[axis] * self._held.get(axis, 0) for axis in range(len(tops)))
