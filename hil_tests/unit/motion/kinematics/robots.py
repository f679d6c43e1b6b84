"""Robots the tests of the kinematics use, joints spread over their travel without chance, and how far two poses are apart."""

import math
from collections.abc import Iterator, Sequence

from motion.geometry.frames import Pose
from motion.geometry.limits import AxisLimits
from motion.kinematics.arm6 import Arm6, ArmGeometry
from motion.kinematics.scara import Scara

PRIMES = (2, 3, 5, 7, 11, 13, 17, 19)
TX60 = ArmGeometry(height=0.375, arm=0.29, forearm=0.31, flange=0.07, side=0.02)
GENERAL = ArmGeometry(
    height=0.5,
    arm=0.6,
    forearm=0.7,
    flange=0.1,
    delta=0.15,
    elbow=-0.1,
    side=0.02,
    signs=(1, -1, 1, -1, 1, -1),
    offsets=(0, -1.5, 0.3, 0, 0.1, 2),
)


def turning(name: str, lower: float = -math.pi, upper: float = math.pi, speed: float = 1.0) -> AxisLimits:
    """rad."""
    return AxisLimits(name, lower, upper, speed, 10.0, 100.0, "rad")


def sliding(name: str, lower: float = -4.0, upper: float = 4.0) -> AxisLimits:
    """m."""
    return AxisLimits(name, lower, upper, 1.0, 10.0, 100.0, "m")


def arm(geometry: ArmGeometry = TX60, **travel: tuple[float, float]) -> Arm6:
    """travel: of single axes, "j4" = (lower, upper) rad; the others turn half a turn both ways."""
    return Arm6(geometry, [turning(f"j{n}", *travel.get(f"j{n}", (-math.pi, math.pi))) for n in range(1, 7)])


def scara(*, down: bool = True) -> Scara:
    return Scara(0.35, 0.25, 0.3, [turning("a1"), turning("a2"), sliding("a3"), turning("a4", -2 * math.pi, 2 * math.pi)], down=down)


def spread(count: int, widths: Sequence[float]) -> Iterator[tuple[float, ...]]:
    """Points of a Halton row, each within +-width."""
    for number in range(1, count + 1):
        yield tuple(width * (2.0 * _radical(number, base) - 1.0) for width, base in zip(widths, PRIMES, strict=False))


def apart(one: Pose, two: Pose) -> float:
    """The largest difference of the twelve numbers (m or 1)."""
    return max(abs(a - b) for a, b in zip((*one.position, *one.rotation), (*two.position, *two.rotation), strict=True))


def unlike(one: Sequence[float], two: Sequence[float]) -> float:
    """The largest difference of two rows of joints."""
    return max(abs(a - b) for a, b in zip(one, two, strict=True))


def unlike_turned(one: Sequence[float], two: Sequence[float]) -> float:
    """The same, whole turns not counted."""
    return max(abs(math.remainder(a - b, 2 * math.pi)) for a, b in zip(one, two, strict=True))


def urdf(geometry: ArmGeometry, travel: float = math.pi) -> str:
    """The same arm as a URDF, joint by joint, for a judge that knows nothing of closed forms."""
    g = geometry
    joints = (
        ("0 0 1", (0, 0, 0)),
        ("0 1 0", (g.delta, 0, g.height)),
        ("0 1 0", (0, 0, g.arm)),
        ("0 0 1", (g.elbow, g.side, 0)),
        ("0 1 0", (0, 0, g.forearm)),
        ("0 0 1", (0, 0, 0)),
    )
    text = '<robot name="arm"><link name="l0"/>'
    for n, (axis, (x, y, z)) in enumerate(joints, 1):
        text += f'<link name="l{n}"/><joint name="j{n}" type="revolute"><parent link="l{n - 1}"/><child link="l{n}"/>'
        text += (
            f'<origin xyz="{x} {y} {z}"/><axis xyz="{axis}"/><limit lower="{-travel}" upper="{travel}" velocity="3" effort="1"/></joint>'
        )
    text += '<link name="flange"/><joint name="f" type="fixed"><parent link="l6"/><child link="flange"/>'
    return text + f'<origin xyz="0 0 {g.flange}"/></joint></robot>'


def _radical(number: int, base: int) -> float:
    value, part = 0.0, 1.0
    while number:
        part /= base
        number, digit = divmod(number, base)
        value += digit * part
    return value
