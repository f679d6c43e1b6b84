"""The axes along a curve of the tool, for every robot: the way of its arm, and additional axes on their course."""

from motion.geometry.frames import Pose
from motion.kinematics.base import Joints, KinematicsError
from motion.paths.base import Curve
from motion.paths.joints import JointPath
from motion.planner.additional_axes import Course, with_course
from motion.planner.joint_path import joint_path_of
from motion.planner.portal_paths import exact_path
from motion.planner.robot import Machine


def followed(curve: Curve, near: Joints, tool: Pose, course: Course, machine: Machine) -> JointPath:
    """near: where the axes are at its start.  What checks a block, what draws it and what runs it ask here, so they agree.

    Raises KinematicsError, with the place where the path ends.
    """
    kinematics, own = machine.kinematics, near[: machine.arm]
    if machine.carried:
        return joint_path_of(curve, kinematics, near, tool=tool, course=course)
    return with_course(_exact(curve, near, tool, machine) or joint_path_of(curve, kinematics, own, tool=tool), course)


def _exact(curve: Curve, near: Joints, tool: Pose, machine: Machine) -> JointPath | None:
    try:
        return exact_path(curve, machine.kinematics, near[: machine.arm], tool)
    except KinematicsError:
        return None  # the general method names the place
