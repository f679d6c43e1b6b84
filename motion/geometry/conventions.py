"""Angles of the three old controllers and rotations; mm and degrees outside, m and rotation matrices inside.

| control | values      | rotation            | turned in this order                      | source                            |
|---------|-------------|---------------------|-------------------------------------------|-----------------------------------|
| rho 3   | x y z a b c | Rz(c) Ry(b) Rx(a)   | c about z, b about y', a about x''        | WC_FRAME, L8817                   |
| VAL 3   | x y z rx ry rz | Rx(rx) Ry(ry) Rz(rz) | rx about x, ry about y', rz about z''  | ch. 9.3.2, L4688-4715, VAL 3 D12  |
| Reis    | x y z A B C | Rz(C) Ry(B) Rx(A)   | assumed; the other order is a setting     | A, B, C = RX, RY, RZ (D39); AX-350 |

The middle angle comes out in -90 .. 90 degrees, the others in -180 .. 180.  At a middle angle of +-90 degrees only the sum or
the difference of the outer two is known: the one that turns last is then 0 (VAL 3: rz; rho 3, Reis: a).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from motion.errors import MotionError
from motion.geometry.frames import Pose, Rotation

Angles = tuple[float, float, float]  # rad
Values = tuple[float, float, float, float, float, float]  # mm, mm, mm, deg, deg, deg
POLE = 1e-12  # cosine of the middle angle below which the outer two are indistinguishable
DEGREE = math.pi / 180


@dataclass(frozen=True, slots=True)
class Convention:
    """How a control writes an orientation as three angles; `order` names the axes in the order of turning."""

    control: str
    order: str
    names: tuple[str, str, str]
    to_rotation: Callable[[float, float, float], Rotation]  # the three angles in the order of `names`, rad
    to_angles: Callable[[Rotation], Angles]

    def pose(self, values: Sequence[float]) -> Pose:
        """(x, y, z mm, three angles deg) -> Pose; MotionError when there are not six finite numbers."""
        if len(values) != 6 or not all(map(math.isfinite, values)):
            raise MotionError(f"{self.control}: six finite numbers (mm, deg) expected, not {tuple(values)}")
        x, y, z, first, second, third = values
        position = (x * 1e-3, y * 1e-3, z * 1e-3)
        return Pose(position, self.to_rotation(first * DEGREE, second * DEGREE, third * DEGREE))

    def values(self, pose: Pose) -> Values:
        """Pose -> (x, y, z mm, three angles deg)."""
        x, y, z = pose.position
        first, second, third = self.to_angles(pose.rotation)
        return x * 1e3, y * 1e3, z * 1e3, first / DEGREE, second / DEGREE, third / DEGREE


def rotation_xyz(rx: float, ry: float, rz: float) -> Rotation:
    """Rx(rx) Ry(ry) Rz(rz): about x, then the new y', then the new z''; rad."""
    sx, cx, sy, cy, sz, cz = math.sin(rx), math.cos(rx), math.sin(ry), math.cos(ry), math.sin(rz), math.cos(rz)
    return (
        cy * cz,
        -cy * sz,
        sy,
        cx * sz + sx * sy * cz,
        cx * cz - sx * sy * sz,
        -sx * cy,
        sx * sz - cx * sy * cz,
        sx * cz + cx * sy * sz,
        cx * cy,
    )


def angles_xyz(rotation: Rotation) -> Angles:
    """(rx, ry, rz) rad of Rx Ry Rz; rz = 0 where ry is +-90 degrees."""
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = rotation
    cosine = math.sqrt(r11 * r11 + r12 * r12)
    ry = math.atan2(r13, cosine)
    if cosine < POLE:
        return _shown(math.atan2(r32, r22)), ry, 0.0
    rx = math.atan2(-r23, r33)
    s, c = math.sin(rx), math.cos(rx)
    return _shown(rx), ry, _shown(math.atan2(c * r21 + s * r31, c * r22 + s * r32))  # rz from rx: they fit together near the pole


def rotation_zyx(a: float, b: float, c: float) -> Rotation:
    """Rz(c) Ry(b) Rx(a): c about z, then b about y', then a about x''; rad."""
    sa, ca, sb, cb, sc, cc = math.sin(a), math.cos(a), math.sin(b), math.cos(b), math.sin(c), math.cos(c)
    return (
        cc * cb,
        cc * sb * sa - sc * ca,
        cc * sb * ca + sc * sa,
        sc * cb,
        sc * sb * sa + cc * ca,
        sc * sb * ca - cc * sa,
        -sb,
        cb * sa,
        cb * ca,
    )


def angles_zyx(rotation: Rotation) -> Angles:
    """(a, b, c) rad of Rz(c) Ry(b) Rx(a); a = 0 where b is +-90 degrees."""
    r11, r12, r13, r21, r22, r23, r31, _, _ = rotation
    cosine = math.sqrt(r11 * r11 + r21 * r21)
    b = math.atan2(-r31, cosine)
    if cosine < POLE:
        return 0.0, b, _shown(math.atan2(-r12, r22))
    c = math.atan2(r21, r11)
    s, k = math.sin(c), math.cos(c)
    return _shown(math.atan2(s * r13 - k * r23, k * r22 - s * r12)), b, _shown(c)


def _shown(angle: float) -> float:
    """180 degrees rather than -180, 0 rather than -0 (doubt D12)."""
    return math.pi if angle == -math.pi else angle + 0.0


RHO3 = Convention("rho 3", "zyx", ("a", "b", "c"), rotation_zyx, angles_zyx)
VAL3 = Convention("VAL 3", "xyz", ("rx", "ry", "rz"), rotation_xyz, angles_xyz)
REIS = Convention("Reis", "zyx", ("A", "B", "C"), rotation_zyx, angles_zyx)
REIS_XYZ = Convention("Reis", "xyz", ("A", "B", "C"), rotation_xyz, angles_xyz)
CONVENTIONS = {"rho3": RHO3, "val3": VAL3, "reis": REIS, "reis-xyz": REIS_XYZ}


def convention(name: str) -> Convention:
    """By the name robot files use; MotionError for another."""
    try:
        return CONVENTIONS[name]
    except KeyError:
        raise MotionError(f"angles {name!r} are unknown; known are {', '.join(CONVENTIONS)}") from None
