"""Types frame, tool, point, config and their instructions.  Source: VAL 3 reference 9.4-9.7, L4803-5349.

Frames hang on frames up to `world`, tools on tools up to `flange`; a point hangs on a frame.  Errors: 160 flange changed, 161
world changed, 162 point, 163 frame, 164 tool without what it hangs on.  Lengths mm, angles deg, as in the language.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from motion.geometry.frames import IDENTITY, Pose, compose
from motion.geometry.units import from_si, to_si
from motion.kinematics.base import FREE, Configuration, Kinematics, KinematicsError
from motion.paths.base import cross, norm, scale, sub
from motion.val3.errors import RuntimeFault
from motion.val3.trsf import Trsf, times, trsf_of
from motion.val3.trsf import distance as distance_of

CLOSE_MM = 0.01  # setFrame: nearer than that is too near (AX-358)
DEEPEST = 100  # links up to the root; more is a ring


@dataclass(slots=True, eq=False)
class Frame:
    """trsf in its reference frame; reference None: not linked."""

    trsf: Trsf = field(default_factory=Trsf)
    reference: "Frame | None" = None
    root: bool = False  # world

    def in_world(self) -> Pose:
        """Pose of the frame; 161 or 163."""
        pose, here = IDENTITY, self
        for _ in range(DEEPEST):
            if here.root:
                if here.trsf != Trsf():
                    raise RuntimeFault(161, "the coordinates of world were changed")
                return pose
            pose = compose(here.trsf.pose, pose)
            if here.reference is None:
                raise RuntimeFault(163)
            here = here.reference
        raise RuntimeFault(165, "frames linked in a ring")


@dataclass(slots=True, eq=False)
class Tool:
    """trsf relative to its mounting; reference None: not linked."""

    trsf: Trsf = field(default_factory=Trsf)
    reference: "Tool | None" = None
    root: bool = False  # flange

    def on_flange(self) -> Pose:
        """The tool centre point seen from the flange; 160 or 164."""
        pose, here = IDENTITY, self
        for _ in range(DEEPEST):
            if here.root:
                if here.trsf != Trsf():
                    raise RuntimeFault(160, "the coordinates of flange were changed")
                return pose
            pose = compose(here.trsf.pose, pose)
            if here.reference is None:
                raise RuntimeFault(164)
            here = here.reference
        raise RuntimeFault(165, "tools linked in a ring")


@dataclass(frozen=True, slots=True)
class Point:
    """trsf in its frame, and the configuration it demands."""

    trsf: Trsf = Trsf()
    config: Configuration = FREE
    frame: Frame | None = None

    def in_world(self) -> Pose:
        """Pose of the point; 162 when it has no frame."""
        return compose(self.linked().in_world(), self.trsf.pose)

    def linked(self) -> Frame:
        """Its frame; 162 when there is none."""
        if self.frame is None:
            raise RuntimeFault(162)
        return self.frame


def link_frame(frame: Frame, reference: Frame) -> None:
    """link(fFrame, fReference): the reference changes, the trsf stays, so the frame moves in the world."""
    frame.reference = reference


def link_tool(tool: Tool, reference: Tool) -> None:
    """link(tTool, tReference)."""
    tool.reference = reference


def link_point(point: Point, reference: Frame) -> Point:
    """link(pPoint, fReference)."""
    return replace(point, frame=reference)


def set_frame(origin: Point, on_x: Point, in_xy: Point, result: Frame) -> int:
    """setFrame: 0, and `result` has its origin in `origin`, its x axis through `on_x`, y on the side of `in_xy` (doubt D31).

    -1: on_x is too near the origin; -2: in_xy is too near the x axis; the result is then untouched.  162 for a point without
    frame.  A result that hangs on nothing is linked to the frame of `origin` (AX-358).
    """
    points = [point.in_world().position for point in (origin, on_x, in_xy)]
    x = sub(points[1], points[0])
    if not norm(x) * 1e3 > CLOSE_MM:
        return -1
    x = scale(x, 1.0 / norm(x))
    z = cross(x, sub(points[2], points[0]))
    if not norm(z) * 1e3 > CLOSE_MM:  # |z| is the distance of the third point from the x axis
        return -2
    z = scale(z, 1.0 / norm(z))
    y = cross(z, x)
    placed = Pose(points[0], (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]))
    reference = result.reference if result.reference is not None else origin.linked()
    result.trsf = trsf_of(compose(reference.in_world().inverse(), placed))
    result.reference = reference
    return 0


def position(what: Frame | Point, reference: Frame) -> Trsf:
    """position(fFrame or pPoint, fReference): the coordinates seen from `reference`; 161..163."""
    return trsf_of(compose(reference.in_world().inverse(), what.in_world()))


def tool_position(tool: Tool, reference: Tool) -> Trsf:
    """position(tTool, tReference); 160, 164."""
    return trsf_of(compose(reference.on_flange().inverse(), tool.on_flange()))


def distance(first: Point, second: Point) -> float:
    """distance(pPosition1, pPosition2), mm in the world; 162."""
    return distance_of(trsf_of(first.in_world()), trsf_of(second.in_world()))


def compose_point(point: Point, reference: Frame, trsf: Trsf) -> Point:
    """compose(pPosition, fReference, trTransformation): moved by `trsf` in the coordinates of `reference`.

    A rotation turns the point about the origin of `reference`; frame and configuration stay the point's.
    """
    own, other = point.linked().in_world(), reference.in_world()
    moved = compose(other, compose(trsf.pose, compose(other.inverse(), point.in_world())))
    return replace(point, trsf=trsf_of(compose(own.inverse(), moved)))


def appro(point: Point, trsf: Trsf) -> Point:
    """appro(pPosition, trTransformation): moved in the point's own axes; frame and configuration stay."""
    point.linked()
    return replace(point, trsf=times(point.trsf, trsf))


class Arm:
    """The arm of an application: its kinematics, its place in the world, and joints in deg and mm as the language has them."""

    def __init__(self, kinematics: Kinematics, units: Sequence[str], base: Pose = IDENTITY) -> None:
        self.kinematics, self.units, self.base = kinematics, tuple(units), base

    def config(self, joint: Sequence[float]) -> Configuration:
        """config(jPosition)."""
        return self.kinematics.configuration(self._inside(joint))

    def joint_to_point(self, tool: Tool, reference: Frame, joint: Sequence[float]) -> Point:
        """jointToPoint(tTool, fReference, jPosition): the tool in `reference`, with the configuration of the joints."""
        q = self._inside(joint)
        world = compose(compose(self.base, self.kinematics.forward(q)), tool.on_flange())
        seen = compose(reference.in_world().inverse(), world)
        return Point(trsf_of(seen), self.kinematics.configuration(q), reference)

    def here(self, tool: Tool, reference: Frame, commanded: Sequence[float]) -> Point:
        """here(tTool, fReference); commanded: the joints commanded now."""
        return self.joint_to_point(tool, reference, commanded)

    def point_to_joint(self, tool: Tool, initial: Sequence[float], point: Point) -> tuple[float, ...] | None:
        """pointToJoint(tTool, jInitial, pPosition): the joints nearest to `initial`, None for false (no way there); 162."""
        flange = compose(compose(self.base.inverse(), point.in_world()), tool.on_flange().inverse())
        try:
            q = self.kinematics.inverse(flange, self._inside(initial), point.config)
        except KinematicsError:
            return None
        return tuple(from_si(value, unit) for value, unit in zip(q, self.units, strict=True))

    def _inside(self, joint: Sequence[float]) -> tuple[float, ...]:
        if len(joint) != len(self.units) or not all(map(math.isfinite, joint)):
            raise RuntimeFault(570, f"{len(self.units)} finite joint positions are needed")
        return tuple(to_si(value, unit) for value, unit in zip(joint, self.units, strict=True))


def new_world() -> Frame:
    """A world of its own, for one application."""
    return Frame(root=True)


def new_flange() -> Tool:
    """A flange of its own."""
    return Tool(root=True)
