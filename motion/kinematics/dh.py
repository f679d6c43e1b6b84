"""The chain of geometric parameters of a VAL 3 "absolute robot", and an arm that was measured.

Source: VAL 3 reference 13.3, L6523-6576:
    p = {0,0,0,0,0,j1+theta[0]} * {a[k],b[k],d[k],alpha[k],beta[k],j(k+2)+theta[k+1]} (k = 0..4) * {a[5],b[5],d[5],alpha[5],beta[5],0}
        * {0,0,d[6],0,0,0}, each {x,y,z,rx,ry,rz} = shift, then Rx Ry Rz; mm and degrees.
b may be left out (0, doubt D16); d[6] belongs to special wrists.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.geometry.conventions import DEGREE, VAL3
from motion.geometry.frames import NO_ROTATION, Pose, compose
from motion.geometry.orientation import between
from motion.kinematics.arm6 import Arm6, ArmGeometry
from motion.kinematics.base import Branch, Configuration, Joints, Unreachable
from motion.kinematics.choice import Chooser, wrapped

FARTHEST_MM = 10.0  # a measured length further from the default than this is refused (AX-355)
FARTHEST_DEG = 2.0
CLOSE = 1e-12  # m and rad: where the polishing of a measured arm ends
ROUNDS = 12


@dataclass(frozen=True, slots=True)
class DhParameters:
    """theta, alpha, beta: six angles, deg; a, b: six lengths, mm; d: six or seven lengths, mm."""

    theta: tuple[float, ...]
    d: tuple[float, ...]
    a: tuple[float, ...]
    alpha: tuple[float, ...]
    beta: tuple[float, ...] = (0.0,) * 6
    b: tuple[float, ...] = (0.0,) * 6

    def __post_init__(self) -> None:
        sizes = (len(self.theta), len(self.a), len(self.b), len(self.alpha), len(self.beta))
        if sizes != (6,) * 5 or len(self.d) not in (6, 7):
            raise MotionError("six values in each array are needed, in d six or seven")
        if not all(map(math.isfinite, (*self.theta, *self.d, *self.a, *self.b, *self.alpha, *self.beta))):
            raise MotionError("a geometric parameter is not a finite number")

    def links(self) -> tuple[Pose, ...]:
        """Elements between the turning axes: before joint 2, .., before joint 6, after joint 6."""
        rows = zip(self.a, self.b, self.d, self.alpha, self.beta, strict=False)
        links = [VAL3.pose((a, b, d, alpha, beta, 0.0)) for a, b, d, alpha, beta in rows]
        if len(self.d) == 7:
            links[5] = compose(links[5], VAL3.pose((0.0, 0.0, self.d[6], 0.0, 0.0, 0.0)))
        return tuple(links)


def default_dh(geometry: ArmGeometry) -> DhParameters:
    """The parameters of an arm as built (getDefaultDH); its signs must be 1 and its offsets 0, as on RX and TX arms."""
    if any(sign != 1 for sign in geometry.signs) or any(geometry.offsets):
        raise MotionError("the chain is VAL 3's: joints without signs and offsets")
    g = geometry
    d = tuple(1e3 * value for value in (g.height, g.side, 0.0, g.forearm, 0.0, g.flange))
    a = tuple(1e3 * value for value in (g.delta, g.arm, g.elbow, 0.0, 0.0, 0.0))
    return DhParameters((0.0, -90.0, 90.0, 0.0, 0.0, 0.0), d, a, (-90.0, 0.0, 90.0, -90.0, 90.0, 0.0))


def too_far(measured: DhParameters, default: DhParameters) -> bool:
    """True when setDH has to refuse: some length or angle differs too much, or d is shorter than the arm's own."""
    if len(measured.d) < len(default.d):
        return True
    d = (*default.d, *(0.0,) * (len(measured.d) - len(default.d)))
    lengths = zip((*measured.a, *measured.b, *measured.d), (*default.a, *default.b, *d), strict=True)
    angles = zip((*measured.theta, *measured.alpha, *measured.beta), (*default.theta, *default.alpha, *default.beta), strict=True)
    far = any(abs(one - two) > FARTHEST_MM for one, two in lengths)
    return far or any(abs(math.remainder(one - two, 360.0)) > FARTHEST_DEG for one, two in angles)


class MeasuredArm:
    """An arm whose geometry was measured: the chain forward; inverse = the ideal arm's branches, polished on the chain.

    Flags are those of the ideal formulas, which the manual admits are then no longer exact (L6545).
    """

    axes = 6

    def __init__(self, ideal: Arm6, parameters: DhParameters) -> None:
        self.ideal, self.parameters, self.limits = ideal, parameters, ideal.limits
        self._links = parameters.links()
        self._theta = tuple(value * DEGREE for value in parameters.theta)
        self._chooser = Chooser(ideal.limits)

    def _places(self, q: Sequence[float]) -> list[Pose]:
        """Frames after joint 1 .. 6, then the flange."""
        if len(q) != 6:
            raise MotionError(f"{len(q)} joints, 6 are needed")
        pose = Pose((0.0, 0.0, 0.0), _about_z(q[0] + self._theta[0]))
        places = [pose]
        for n in range(5):
            turn = Pose((0.0, 0.0, 0.0), _about_z(q[n + 1] + self._theta[n + 1]))
            pose = compose(compose(pose, self._links[n]), turn)
            places.append(pose)
        return [*places, compose(pose, self._links[5])]

    def forward(self, q: Sequence[float]) -> Pose:
        """(6,) rad -> flange, by the manual's chain."""
        return self._places(q)[-1]

    def jacobian(self, q: Sequence[float]) -> NDArray[np.float64]:
        """(6, 6)."""
        places = self._places(q)
        tip = places[-1].position
        columns = np.empty((6, 6))
        for n, (origin, rotation) in enumerate(places[:6]):
            x, y, z = rotation[2::3]
            u, v, w = (a - b for a, b in zip(tip, origin, strict=True))
            columns[:, n] = (y * w - z * v, z * u - x * w, x * v - y * u, x, y, z)
        return columns

    def branches(self, pose: Pose) -> list[Branch]:
        """The ideal arm's ways as far as they converge on the measured one."""
        polished = [(self._polished(pose, joints), flags) for joints, flags in self.ideal.branches(pose)]
        return [(joints, flags) for joints, flags in polished if joints is not None]

    def inverse(self, pose: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """The nearest of them inside the limits, and what lies near `near`: an ideal arm cannot always reach as far."""
        found = self.branches(pose)
        local = self._polished(pose, tuple(near))
        if local is not None:
            found.append((tuple(map(wrapped, local)), self.configuration(local)))
        if not found:
            raise Unreachable("the measured arm does not get there")
        return self._chooser.choose(found, near, configuration, self.configuration(near))

    def follow(self, pose: Pose, near: Sequence[float]) -> Joints:
        """From `near`: the chain is smooth."""
        joints = self._polished(pose, tuple(near))
        if joints is None:
            raise Unreachable("the measured arm does not get there from the joints before")
        return self._chooser.choose([(joints, self.configuration(joints))], near, None, self.configuration(near))

    def configuration(self, q: Sequence[float]) -> Configuration:
        """The flags of the ideal formulas."""
        return self.ideal.configuration(q)

    def _polished(self, pose: Pose, joints: Joints) -> Joints | None:
        """Newton's steps on the chain."""
        for _ in range(ROUNDS):
            here = self.forward(joints)
            turn = between(here.rotation, pose.rotation)
            r = here.rotation
            world = tuple(r[3 * i] * turn[0] + r[3 * i + 1] * turn[1] + r[3 * i + 2] * turn[2] for i in range(3))
            miss = np.array([*(b - a for a, b in zip(here.position, pose.position, strict=True)), *world])
            if float(np.max(np.abs(miss))) < CLOSE:
                return joints
            step = np.linalg.lstsq(self.jacobian(joints), miss, rcond=1e-8)[0]
            joints = tuple(float(a + b) for a, b in zip(joints, step, strict=True))
        return joints if float(np.max(np.abs(miss))) < 1e3 * CLOSE else None


def _about_z(angle: float) -> tuple[float, float, float, float, float, float, float, float, float]:
    if angle == 0.0:
        return NO_ROTATION
    s, c = math.sin(angle), math.cos(angle)
    return c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0
