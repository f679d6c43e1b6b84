"""One kinematic of a rho 3: world points, joint points, frames, working range, software limits, mirror, tools.

Which points a workpiece system changes (L8943-9013): WC points, POS, LIMIT_MIN, LIMIT_MAX, JC(), WC(), mirroring.  Which not: joint
points, @POS, @MPOS, the software limits P204/P205.  Points are in mm and deg, in the machine's own components (P313).
"""

from collections.abc import Sequence

from motion.errors import LimitError, MotionError
from motion.geometry.frames import IDENTITY, Pose, compose
from motion.geometry.limits import AxisLimits, check_targets
from motion.geometry.units import from_si, to_si
from motion.kinematics.base import Kinematics
from motion.rho3.wc import WC_UR, Assignment, WcSystems

Point = tuple[float, ...]
PLANES = {"yz": 0, "xz": 1, "xy": 2}  # plane of the mirror -> direction that changes its sign
ROUNDING = 1e-9  # mm or deg: a point on the border of the working range is inside


class Rho3Kinematic:
    """kinematics: of the mechanics; limits: P204/P205 and more, of the machine's axes; origin: P310, zero of the world system."""

    def __init__(
        self,
        name: str,
        kinematics: Kinematics,
        limits: Sequence[AxisLimits],
        systems: WcSystems,
        *,
        assignment: Assignment | None = None,
        origin: Pose = IDENTITY,
        components: int = 6,
    ) -> None:
        self.name, self.kinematics, self.limits, self.systems = name, kinematics, tuple(limits), systems
        self.assignment, self.origin, self.components = assignment or Assignment(), origin, components
        self.tool = IDENTITY
        self._lower: Point | None = None
        self._upper: Point | None = None

    # ------------------------------------------------------------------------------------------- workpiece and original

    def original(self, point: Sequence[float]) -> Point:
        """A WC point (workpiece system) in the original system."""
        return self.assignment.moved(self._checked(point), self.systems.active(self.name).pose)

    def workpiece(self, point: Sequence[float]) -> Point:
        """A point of the original system in the workpiece system."""
        return self.assignment.moved(self._checked(point), self.systems.active(self.name).pose.inverse())

    # ------------------------------------------------------------------------------------------------- world and joints

    def jc(self, point: Sequence[float], near: Sequence[float]) -> Point:
        """JC(point): axes in mm and deg.  Depends on the active frame.  near: axes the arm comes from."""
        flange = compose(compose(self.origin, self.assignment.pose(self.original(point))), self.tool.inverse())
        return self._outside(self.kinematics.inverse(flange, self._inside(near)))

    def wc(self, joints: Sequence[float]) -> Point:
        """WC(@point), and POS of the axes where they are.  Depends on the active frame."""
        return self.workpiece(self.oc(joints))

    def oc(self, joints: Sequence[float]) -> Point:
        """Original coordinates, the level OC of mode 7.1; components that P313 does not name are 0."""
        tcp = compose(self.kinematics.forward(self._inside(joints)), self.tool)
        return self.assignment.put((0.0,) * self.components, compose(self.origin.inverse(), tcp))

    def joint_point(self, joints: Sequence[float]) -> Point:
        """@points, @POS, @MPOS: as they are, whatever frame is active (L8962-8976)."""
        return tuple(joints)

    def display(self, joints: Sequence[float]) -> dict[str, Point]:
        """Levels of PHG mode 7.1; OC only while a frame other than WC_UR is active (L9025-9037)."""
        levels = {"JC": self.joint_point(joints), "WC": self.wc(joints)}
        return levels if self.systems.active(self.name).values == WC_UR.values else {**levels, "OC": self.oc(joints)}

    # ------------------------------------------------------------------------------------------------------------ limits

    def check_software_limits(self, joints: Sequence[float]) -> None:
        """P204/P205, in machine coordinates, whatever frame is active (L9011-9013); LimitError names the axis."""
        check_targets(self.limits, self._inside(joints))

    def set_working_range(self, lower: Sequence[float] | None = None, upper: Sequence[float] | None = None) -> None:
        """LIMIT_MIN, LIMIT_MAX: WC points; they move with the active frame, like every WC point (L8976-8983)."""
        self._lower = self._lower if lower is None else self._checked(lower)
        self._upper = self._upper if upper is None else self._checked(upper)
        if self._lower is not None and self._upper is not None:
            for number, (low, high) in enumerate(zip(self._lower, self._upper, strict=True), 1):
                if not low <= high:
                    raise MotionError(f"{self.name}: component {number} of LIMIT_MIN is {low:g}, of LIMIT_MAX {high:g}")

    def check_working_range(self, point: Sequence[float]) -> None:
        """LimitError for the first component of a WC point outside LIMIT_MIN .. LIMIT_MAX."""
        point = self._checked(point)
        for number, value in enumerate(point):
            low = self._lower[number] if self._lower is not None else float("-inf")
            high = self._upper[number] if self._upper is not None else float("inf")
            if not low - ROUNDING <= value <= high + ROUNDING:
                raise LimitError(f"{self.name} component {number + 1}", "working range", value, low, high, "")

    def check_place(self, joints: Sequence[float]) -> None:
        """Both: software limits of the axes and the working range of where they are."""
        self.check_software_limits(joints)
        self.check_working_range(self.wc(joints))

    # ---------------------------------------------------------------------------------------------------- mirror and tool

    def mirror(self, point: Sequence[float], plane: str) -> Point:
        """SF 17: mirrored across a plane of the workpiece system, "xy", "yz" or "xz" (L9003-9005; the call is not described: AX-360)."""
        if plane not in PLANES:
            raise MotionError(f"mirror across {plane!r}: xy, yz or xz")
        return self.assignment.put(self._checked(point), mirrored(self.assignment.pose(point), PLANES[plane]))

    def change_tool(self, tool: Pose, *, at_rest: bool = True) -> None:
        """Another tool centre point on the flange: WC and POS change, the axes and @POS do not.  Refused on the way (AX-360)."""
        if not at_rest:
            raise MotionError(f"{self.name}: the tool changes at rest only")
        self.tool = tool

    # -------------------------------------------------------------------------------------------------------------- parts

    def _checked(self, point: Sequence[float]) -> Point:
        if len(point) != self.components:
            raise MotionError(f"{self.name}: a point has {self.components} components, not {len(point)}")
        return tuple(point)

    def _inside(self, joints: Sequence[float]) -> Point:
        if len(joints) != len(self.limits):
            raise MotionError(f"{self.name}: {len(self.limits)} axes, {len(joints)} positions")
        return tuple(to_si(value, axis.unit) for value, axis in zip(joints, self.limits, strict=True))

    def _outside(self, joints: Sequence[float]) -> Point:
        return tuple(from_si(value, axis.unit) for value, axis in zip(joints, self.limits, strict=True))


def mirrored(pose: Pose, direction: int) -> Pose:
    """Mirrored in x, y or z (0, 1, 2): the position changes sign there, the orientation turns the other way about the other two."""
    signs = [-1.0 if n == direction else 1.0 for n in range(3)]
    x, y, z = (sign * value for sign, value in zip(signs, pose.position, strict=True))
    r = [signs[n // 3] * signs[n % 3] * value for n, value in enumerate(pose.rotation)]
    return Pose((x, y, z), (r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]))
