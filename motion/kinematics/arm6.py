"""Six-axis arm with a spherical wrist: forward, analytic inverse with all branches, VAL 3 configuration flags.

Geometry (m; all joints 0 = arm straight up, the base's x forwards): axis 2 is `height` over the base and `delta` forwards
of axis 1; the upper arm `arm` leads to the elbow, the forearm `forearm` to the wrist, `elbow` forwards of it; the wrist centre is
`side` to the left (y) of axis 1's plane and `flange` behind the flange.  These are the seven lengths of Brandstoetter, Angerer,
Hofbaur, "An analytical solution of the inverse kinematics problem of industrial serial manipulators with an ortho-parallel
basis and a spherical wrist" (2014); the solution here is written without their angles psi, so it needs fewer functions.

Flags (VAL 3 ch. 9.7.4, L5308-5333), with geometric angles j:
    righty     <=>  arm sin(j2) + forearm sin(j2+j3) + elbow cos(j2+j3) + delta < 0
    epositive  <=>  j3 - stretched >= 0, where stretched = -atan2(elbow, forearm)
    wpositive  <=>  j5 >= 0
On RX/TX arms `elbow` is 0: VAL 3 prints no such term, and j3 >= 0 (AX-351: why an arm with an elbow offset needs both).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.geometry.frames import Pose
from motion.geometry.limits import AxisLimits
from motion.kinematics.base import Branch, Configuration, Elbow, Joints, Shoulder, Unreachable, Wrist, beyond
from motion.kinematics.choice import Chooser, wrapped

POLE = 5e-10  # sine of j5 below which axes 4 and 6 turn about one line
NEAR_POLE = 1e-4  # sine of j5 below which j6 is taken from j4, so that their sum keeps its digits
LOST = 1e-10  # m: a wrist centre this near to axis 2 leaves j2 open, this near to axis 1 leaves j1 open
LOST_SQUARE = LOST * LOST
BORDER = 1e-12  # m and rad: rounding at the border between two configurations; on it: lefty, epositive
SLACK = 1e-13  # m2: how far rounding may put a wrist centre inside the side offset
SHORT = 8e-10  # m: how far rounding may put it beyond a stretched or folded arm

FLAGS = tuple(  # [lefty][epositive][wpositive]
    tuple(tuple(Configuration(s, e, w) for w in (Wrist.NEGATIVE, Wrist.POSITIVE)) for e in (Elbow.NEGATIVE, Elbow.POSITIVE))
    for s in (Shoulder.RIGHTY, Shoulder.LEFTY)
)

# j1, its cosine and sine, j2, j3, sine and cosine of j2 + j3, flags by the sign of j5
_Arm = tuple[float, float, float, float, float, float, float, tuple[Configuration, ...]]


@dataclass(frozen=True, slots=True)
class ArmGeometry:
    """Lengths in m; angle of the geometry = sign * joint + offset (rad)."""

    height: float
    arm: float
    forearm: float
    flange: float
    delta: float = 0.0
    elbow: float = 0.0
    side: float = 0.0
    signs: tuple[int, int, int, int, int, int] = (1, 1, 1, 1, 1, 1)
    offsets: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        lengths = (self.height, self.arm, self.forearm, self.flange, self.delta, self.elbow, self.side)
        if not all(map(math.isfinite, (*lengths, *self.offsets))) or self.arm <= 0 or math.hypot(self.forearm, self.elbow) <= 0:
            raise MotionError(f"an arm needs finite lengths, and an upper arm and a forearm longer than 0: {self}")
        if any(sign not in (1, -1) for sign in self.signs):
            raise MotionError(f"signs of axes are 1 or -1, not {self.signs}")


class Arm6:
    """Kinematics of one arm; q: (6,) rad; poses of the flange in the base, m."""

    axes = 6

    def __init__(self, geometry: ArmGeometry, limits: Sequence[AxisLimits]) -> None:
        if len(limits) != 6:
            raise MotionError(f"an arm has 6 axes, {len(limits)} limits are given")
        self.geometry, self.limits = geometry, tuple(limits)
        g = geometry
        self._chooser = Chooser(limits)
        paces = [1.0 / axis.speed for axis in limits]
        beside = min(2.0 * paces[3] / math.hypot(*paces), 1.0)  # rad: joint 4 of the other wrist is half a turn off, more than all steps
        self._beside = tuple((k, axis.lower, axis.upper, beside) for k, axis in enumerate(limits))
        self._plain = g.signs == (1, 1, 1, 1, 1, 1) and not any(g.offsets)
        reach = math.hypot(g.forearm, g.elbow)
        psi = math.atan2(g.elbow, g.forearm)
        borders = ((g.arm + reach) ** 2, (g.arm - reach) ** 2)  # squares of the farthest and the nearest wrist centre
        slack = (-2.0 * (g.arm + reach) * SHORT, -2.0 * abs(g.arm - reach) * SHORT)
        squares = (g.arm * g.arm + reach * reach, g.arm * g.arm - reach * reach)
        self._fixed = (g.height, g.delta, g.side, g.arm, g.flange, reach, psi, math.sin(psi), math.cos(psi), *borders, *slack, *squares)

    # ------------------------------------------------------------------------------------------------ joints -> pose

    def forward(self, q: Sequence[float]) -> Pose:
        """(6,) rad -> flange in the base."""
        g = self.geometry
        t1, t2, t3, t4, t5, t6 = q if self._plain else self._angles(q)
        s1, c1, s2, c2, s23, c23 = math.sin(t1), math.cos(t1), math.sin(t2), math.cos(t2), math.sin(t2 + t3), math.cos(t2 + t3)
        s4, c4, s5, c5, s6, c6 = math.sin(t4), math.cos(t4), math.sin(t5), math.cos(t5), math.sin(t6), math.cos(t6)
        forwards = g.delta + g.arm * s2 + g.forearm * s23 + g.elbow * c23
        up = g.height + g.arm * c2 + g.forearm * c23 - g.elbow * s23
        nx, ny, nz = c4 * c5 * c6 - s4 * s6, s4 * c5 * c6 + c4 * s6, -s5 * c6  # the wrist seen from the forearm
        ox, oy, oz = -c4 * c5 * s6 - s4 * c6, -s4 * c5 * s6 + c4 * c6, s5 * s6
        ax, ay, az = c4 * s5, s4 * s5, c5
        nf, of, af = c23 * nx + s23 * nz, c23 * ox + s23 * oz, c23 * ax + s23 * az
        r13, r23, r33 = c1 * af - s1 * ay, s1 * af + c1 * ay, c23 * az - s23 * ax
        position = (
            c1 * forwards - s1 * g.side + g.flange * r13,
            s1 * forwards + c1 * g.side + g.flange * r23,
            up + g.flange * r33,
        )
        r31, r32 = c23 * nz - s23 * nx, c23 * oz - s23 * ox
        return Pose(position, (c1 * nf - s1 * ny, c1 * of - s1 * oy, r13, s1 * nf + c1 * ny, s1 * of + c1 * oy, r23, r31, r32, r33))

    def configuration(self, q: Sequence[float]) -> Configuration:
        """The flags of these joints by the formulas of the manual."""
        _, t2, t3, _, t5, _ = q if self._plain else self._angles(q)
        lefty, up = self._bent(t2, t3)
        return FLAGS[lefty][up][wrapped(t5) >= 0.0]

    def _bent(self, t2: float, t3: float) -> tuple[bool, bool]:
        """Whether the arm is lefty, and epositive; rad."""
        g = self.geometry
        try:
            forwards = g.arm * math.sin(t2) + g.forearm * math.sin(t2 + t3) + g.elbow * math.cos(t2 + t3) + g.delta
        except ValueError:
            raise MotionError(f"joints with {t2} and {t3} hold a value that is not a finite number") from None
        bend = wrapped(t3 + self._fixed[6])
        return forwards >= -BORDER, not BORDER - math.pi < bend < -BORDER

    def jacobian(self, q: Sequence[float]) -> NDArray[np.float64]:
        """(6, 6): m and rad of the flange for each rad of a joint, in the base frame."""
        g = self.geometry
        t1, t2, t3, t4, _, _ = q if self._plain else self._angles(q)
        s1, c1, s23, c23 = math.sin(t1), math.cos(t1), math.sin(t2 + t3), math.cos(t2 + t3)
        s4, c4 = math.sin(t4), math.cos(t4)
        tip, rotation = self.forward(q)
        shoulder = (c1 * g.delta, s1 * g.delta, g.height)
        over = g.arm * math.sin(t2)
        elbow = (shoulder[0] + c1 * over, shoulder[1] + s1 * over, g.height + g.arm * math.cos(t2))
        wrist = tuple(tip[i] - g.flange * rotation[3 * i + 2] for i in range(3))
        across, along = (-s1, c1, 0.0), (c1 * s23, s1 * s23, c23)
        turned = (-s4 * c1 * c23 - c4 * s1, -s4 * s1 * c23 + c4 * c1, s4 * s23)  # axis of joint 5
        last = (rotation[2], rotation[5], rotation[8])
        lines = (((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)), (across, shoulder), (across, elbow), (along, wrist), (turned, wrist), (last, wrist))
        columns = np.empty((6, 6))
        for index, ((x, y, z), origin) in enumerate(lines):
            u, v, w = tip[0] - origin[0], tip[1] - origin[1], tip[2] - origin[2]
            sign = g.signs[index]
            columns[:, index] = (sign * (y * w - z * v), sign * (z * u - x * w), sign * (x * v - y * u), sign * x, sign * y, sign * z)
        return columns

    # ------------------------------------------------------------------------------------------------ pose -> joints

    def branches(self, pose: Pose) -> list[Branch]:
        """Up to eight (joints, flags); at the wrist pole j4 = 0, with the wrist centre on axis 1 j1 = 0."""
        return self._named(self._solve(pose, 0.0, 0.0, None))

    def inverse(self, pose: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """The nearest joints inside the limits; at the wrist pole j4 and j6 stay, as far as the orientation lets them."""
        t1, _, _, t4, _, t6 = near if self._plain else self._angles(near)
        found = self._solve(pose, t1, t4, t6)
        if not found:
            raise Unreachable(self._too_far(pose))
        return self._chooser.choose(self._named(found), near, configuration, self.configuration(near))

    def follow(self, pose: Pose, near: Sequence[float]) -> Joints:
        """The next joints of a path: shoulder and elbow as in `near`, the nearer of the two wrists."""
        t1, t2, t3, t4, t5, t6 = near if self._plain else self._angles(near)
        found = self._solve(pose, t1, t4, t6, self._bent(t2, t3))
        if not found:
            raise Unreachable(self._too_far(pose))
        joints = found[-1 if t5 < 0.0 else 0][0]  # the wrist as it was
        if not self._plain:
            joints = self._joints(joints)
        for k, lower, upper, beside in self._beside:
            if not (lower <= joints[k] <= upper and -beside < joints[k] - near[k] < beside):
                return self._chooser.choose(self._named(found), near, None, self.configuration(near))
        return joints  # a step of a path: the other wrist is further away for certain

    def _named(self, found: list[Branch]) -> list[Branch]:
        """Geometric angles -> joints of the robot."""
        return found if self._plain else [(self._joints(angles), flags) for angles, flags in found]

    def _solve(self, pose: Pose, hold1: float, hold4: float, hold6: float | None, only: tuple[bool, bool] | None = None) -> list[Branch]:
        """Branches as geometric angles (rad); `hold`: what j1, j4, j6 keep where the pose leaves them open.

        `only`: lefty and epositive, or not.
        """
        height, flange = self._fixed[0], self._fixed[4]
        x, y, z = pose.position
        r11, r12, r13, r21, r22, r23, r31, r32, r33 = pose.rotation
        found: list[Branch] = []
        atan2, sqrt, pi = math.atan2, math.sqrt, math.pi
        for t1, c1, s1, t2, t3, s23, c23, flags in self._arms(x - flange * r13, y - flange * r23, z - (flange * r33 + height), hold1, only):
            nf, of, af = c1 * r11 + s1 * r21, c1 * r12 + s1 * r22, c1 * r13 + s1 * r23
            ay = c1 * r23 - s1 * r13
            xc, zc = c23 * af - s23 * r33, s23 * af + c23 * r33
            h = sqrt(xc * xc + ay * ay)
            if h > POLE:
                t4, t5 = atan2(ay, xc), atan2(h, zc)
                if h > NEAR_POLE:
                    t6 = atan2(s23 * of + c23 * r32, -s23 * nf - c23 * r31)
                else:  # j4 has lost digits: j6 goes with it
                    row_n, row_o = c23 * nf - s23 * r31, c23 * of - s23 * r32
                    t6 = atan2(xc * (c1 * r21 - s1 * r11) - ay * row_n, xc * (c1 * r22 - s1 * r12) - ay * row_o)
                found.append(((t1, t2, t3, t4, t5, t6), flags[1]))
                t4 += pi if t4 < 0.0 else -pi
                t6 += pi if t6 < 0.0 else -pi
                found.append(((t1, t2, t3, t4, -t5, t6), flags[0]))
            else:
                turn = atan2(c1 * r21 - s1 * r11, c23 * nf - s23 * r31)
                found.append(((t1, t2, t3, *_at_the_pole(turn, zc, hold4, hold6)), flags[1]))
        return found

    def _arms(self, x: float, y: float, z: float, hold1: float, only: tuple[bool, bool] | None) -> list[_Arm]:
        """What the first three axes may be with the wrist centre there (m, z from axis 2 on)."""
        _, delta, side, arm, _, reach, psi, sin_psi, cos_psi, farthest, nearest, out, inn, total, excess = self._fixed
        away = x * x + y * y
        radius = away - side * side
        if not radius >= -SLACK:  # nearer to axis 1 than the arm's side offset; a NaN ends here too
            return []
        radius = math.sqrt(radius) if radius > 0.0 else 0.0
        arms: list[_Arm] = []
        atan2, sqrt, pi = math.atan2, math.sqrt, math.pi
        two = radius > 0.0 and away > LOST_SQUARE
        if only is None:
            shoulders: tuple[float, ...] = (radius, -radius) if two else (radius,)
            elbows: tuple[float, ...] = (1.0, -1.0)
        else:
            left, up = only
            shoulders, elbows = (radius if left or not two else -radius,), (1.0 if up else -1.0,)
        for forwards in shoulders:
            if away > LOST_SQUARE:
                c1, s1 = (forwards * x + side * y) / away, (forwards * y - side * x) / away
                t1 = atan2(s1, c1)
            else:
                t1, c1, s1 = hold1, math.cos(hold1), math.sin(hold1)
            over, lift = forwards - delta, z
            square = over * over + lift * lift
            beyond, within = farthest - square, square - nearest
            if beyond < 0.0 or within < 0.0:
                if beyond < out or within < inn:
                    continue
                border = farthest if beyond < 0.0 else nearest
                scale, square, bend = sqrt(border / square), border, 0.0
                over, lift = over * scale, lift * scale
            else:
                bend = sqrt(beyond * within)  # 2 arm reach sin(phi): keeps its digits at a stretched and at a folded elbow
            phi = atan2(bend, square - total)
            lefty = FLAGS[forwards >= -BORDER]
            along, aside = 0.5 * (square + excess) / arm, 0.5 * bend / arm
            for sign in elbows if bend > 0.0 else (1.0,):
                across = sign * aside
                if square > LOST_SQUARE:
                    s2, c2 = (along * over - across * lift) / square, (along * lift + across * over) / square
                else:
                    s2, c2 = 0.0, 1.0  # the wrist centre lies on axis 2: any j2 will do
                t3 = sign * phi - psi
                if not -pi <= t3 <= pi:
                    t3 += 2.0 * pi if t3 < 0.0 else -2.0 * pi
                u, w = (over - arm * s2) / reach, (lift - arm * c2) / reach
                s23, c23 = u * cos_psi - w * sin_psi, w * cos_psi + u * sin_psi
                arms.append((t1, c1, s1, atan2(s2, c2), t3, s23, c23, lefty[sign > 0.0]))
        return arms

    # ------------------------------------------------------------------------------------------------ small parts

    def _angles(self, q: Sequence[float]) -> tuple[float, ...]:
        return tuple(s * j + o for s, j, o in zip(self.geometry.signs, q, self.geometry.offsets, strict=True))

    def _joints(self, angles: Joints) -> Joints:
        (s1, s2, s3, s4, s5, s6), (o1, o2, o3, o4, o5, o6) = self.geometry.signs, self.geometry.offsets
        t1, t2, t3, t4, t5, t6 = angles
        joints = (s1 * (t1 - o1), s2 * (t2 - o2), s3 * (t3 - o3), s4 * (t4 - o4), s5 * (t5 - o5), s6 * (t6 - o6))
        if max(joints) <= math.pi and min(joints) >= -math.pi:
            return joints
        return tuple(map(wrapped, joints))

    def _too_far(self, pose: Pose) -> str:
        """Says how far the wrist centre is and how far it may be."""
        g, (x, y, z) = self.geometry, pose.position
        if not all(map(math.isfinite, (*pose.position, *pose.rotation))):
            return "the pose holds a value that is not a finite number"
        r13, r23, r33 = pose.rotation[2::3]
        x, y, z = x - g.flange * r13, y - g.flange * r23, z - g.flange * r33 - g.height
        sideways = x * x + y * y - g.side * g.side
        if sideways < 0.0:
            return f"the wrist centre is {math.hypot(x, y) * 1e3:.3f} mm from axis 1, nearer than {abs(g.side) * 1e3:.3f} mm"
        far = math.hypot(math.sqrt(sideways) - g.delta, z)
        least, most = abs(g.arm - self._fixed[5]) * 1e3, (g.arm + self._fixed[5]) * 1e3
        return f"the wrist centre is {beyond(far * 1e3, least, most)} mm from axis 2, possible are {least:.3f} .. {most:.3f} mm"


def _at_the_pole(turn: float, cosine: float, hold4: float, hold6: float | None) -> tuple[float, float, float]:
    """Return (j4, j5, j6) where only j4 + j6 (j5 = 0) or j6 - j4 (j5 = pi) matters: each axis makes half of the change."""
    t5 = 0.0 if cosine > 0.0 else math.pi
    if hold6 is None:
        return 0.0, t5, wrapped(turn if cosine > 0.0 else math.pi - turn)
    if cosine > 0.0:
        half = 0.5 * math.remainder(turn - hold4 - hold6, 2.0 * math.pi)
        return hold4 + half, t5, hold6 + half
    half = 0.5 * math.remainder(math.pi - turn + hold4 - hold6, 2.0 * math.pi)
    return hold4 - half, t5, hold6 + half
