"""One block -> its complete, uncut path: a TCP curve in the base of the robot, or a straight line of the axes.

Every fault that can be found before the axes move is found here: NaN, targets out of reach or limits, a wrong configuration, degenerate
circles, zero blocks.
"""

import math
from dataclasses import dataclass

from motion.errors import LimitError, MotionError
from motion.geometry.frames import Pose
from motion.geometry.limits import AxisLimits, check_targets
from motion.geometry.units import Kind, from_si, kind_of
from motion.kinematics.base import FREE, Joints, KinematicsError, OutOfLimits, SingularPose
from motion.paths.arc import arc, around
from motion.paths.base import Curve, PathError
from motion.paths.joints import JointPath, joint_line
from motion.paths.line import fixed_tool, line
from motion.planner.adaptive_path import followed
from motion.planner.additional_axes import Course, straight
from motion.planner.relative import check_absolute, resolved, unwound
from motion.planner.robot import Machine
from motion.planner.tool_speed import limited
from motion.planner.untransformed import along_axes, axes_line
from motion.program.blocks import Block, Interpolation, JointTarget, PoseTarget, Turning
from motion.program.errors import BlockError

JOINT_LIMIT = 520  # VAL 3: joint position outside the software limits
MULTI_TURN = 544  # VAL 3: a Cartesian path drives a multi-turn joint out of its range
CONFIGURATION = 533  # VAL 3: unreachable in the given configuration
SAME_JOINT = 1e-5  # rad or m: nearer places count as equal
DUST = 1e-9  # of a slope
NEXT = 1.0  # rad or m: the continuing solution for the next place is nearer than this


@dataclass(frozen=True)
class Leg:
    """start, end: (axes,) positions; length: of curve or path, the same parameter s; course: of the additional axes along a
    curve; `resting`: only additional axes move, and the arm keeps the tool in place; axes: their motion along the curve."""

    number: int
    block: Block
    curve: Curve | None
    path: JointPath | None  # PTP only
    length: float
    start: Joints
    end: Joints
    course: Course = ()
    resting: bool = False
    axes: JointPath | None = None


def block_fault(error: MotionError, number: int, machine: Machine) -> BlockError:
    """Any error of the motion core as BlockError: number of the manual, block, axis."""
    if isinstance(error, BlockError):
        return error if error.block else BlockError(error.what, code=error.code, block=number, axis=error.axis, source=error.source)
    if isinstance(error, LimitError):
        what = str(error).partition(": ")[2]
        return BlockError(what, code=JOINT_LIMIT, block=number, axis=error.axis, source="VAL 3")
    if isinstance(error, KinematicsError):
        return BlockError(_words(error), code=error.number, block=number, axis=error.axis, source="VAL 3")
    if isinstance(error, PathError):
        source = "Reis path error" if error.number >= 600 or error.number == 102 else "VAL 3"
        return BlockError(str(error).partition(": ")[2] if error.number else str(error), code=error.number, block=number, source=source)
    return BlockError(str(error), block=number)


def make_leg(number: int, block: Block, position: Joints, machine: Machine) -> Leg | None:
    """The block's way from where the axes are; None: a block without way (the same point again), which is skipped as both VAL 3
    and the rho 3 do.  Raises what `block_fault` turns into a BlockError."""
    block = resolved(block, position, machine)
    check_numbers(block)
    block = unwound(block, position, machine)
    if block.kind is Interpolation.PTP:
        return _ptp(number, block, position, machine)
    check_joints(block, machine)
    if along_axes(block, position, machine):
        return _untransformed(number, block, position, machine)
    target = base_pose(block, position, machine)
    start = tcp(position, block, machine)
    if block.kind is Interpolation.CIRCULAR:
        curve: Curve | None = _arc(block, start, target)
    else:
        curve = _line(start, target)
    extra = extra_of(block, position, machine)
    resting = curve is None
    if curve is None:
        if extra == tuple(position[machine.arm :]) or not machine.carried:
            check_end(block, position, position, machine)
            return None if extra == tuple(position[machine.arm :]) else _only_extra(number, block, position, extra)
        curve = fixed_tool(start, max(abs(b - a) for a, b in zip(position[machine.arm :], extra, strict=True)))
    course = straight(position[machine.arm :], extra, curve.length)
    axes = _along(curve, course, block, position, machine)
    end = (*axes.q(axes.length)[: machine.arm], *extra)
    check_end(block, position, end, machine)
    return Leg(number, block, curve, None, curve.length, position, end, course, resting, axes)


def _ptp(number: int, block: Block, position: Joints, machine: Machine) -> Leg | None:
    if isinstance(block.target, JointTarget):
        check_values(block.target, machine)
        end = block.target.q
    else:
        flange = base_pose(block, position, machine) @ block.tool.pose.inverse()
        configuration = block.target.configuration
        near = (*position[: machine.arm], *extra_of(block, position, machine))
        end = machine.inverse(flange, near, None if configuration == FREE else configuration)
    check_targets(machine.limits, end)
    if max(abs(b - a) for a, b in zip(position, end, strict=True)) < 1e-12:
        return None
    path = limited(joint_line(position, end), machine, block)
    return Leg(number, block, None, path, path.length, position, end)


def _untransformed(number: int, block: Block, position: Joints, machine: Machine) -> Leg:
    assert isinstance(block.target, JointTarget)
    check_values(block.target, machine)
    path = axes_line(position, block.target.q, machine)
    return Leg(number, block, None, path, path.length, position, block.target.q)


def _only_extra(number: int, block: Block, position: Joints, extra: Joints) -> Leg:
    """Return the leg of a block in which the tool is at rest and only additional axes move."""
    end = (*position[: len(position) - len(extra)], *extra)
    path = joint_line(position, end)
    return Leg(number, block, None, path, path.length, position, end)


def _line(start: Pose, target: Pose) -> Curve | None:
    try:
        return line(start, target)
    except PathError as error:
        if "same pose" in str(error):
            return None
        raise


def _arc(block: Block, start: Pose, target: Pose) -> Curve:
    if block.via is None:
        raise BlockError("a circle needs a point on the way")
    via = block.frame.pose @ block.via.pose
    if block.angle is not None:
        if isinstance(block.target, JointTarget):
            raise BlockError("angle= needs a pose as target: it is a point of the circle, not its end")
        return around(start, via, target, block.angle, block.rise, moving=block.turning is Turning.PATH)
    least = block.turning is Turning.LEAST
    weight = block.curving.via_weight
    return arc(
        start, via, target, moving=block.turning is Turning.PATH, via_weight=weight, halves=not least and block.turning is Turning.VIA
    )


def tcp(position: Joints, block: Block, machine: Machine) -> Pose:
    """Where the block's tool is in the frame that counts."""
    return machine.forward(position) @ block.tool.pose


def base_pose(block: Block, position: Joints, machine: Machine) -> Pose:
    """The target as a pose of the tool in the frame that counts; joints of a straight block are turned into one."""
    if isinstance(block.target, PoseTarget):
        return block.frame.pose @ block.target.pose
    check_values(block.target, machine)
    return tcp(block.target.q, block, machine)


def extra_of(block: Block, position: Joints, machine: Machine) -> Joints:
    """Additional axes at the end of the block; checked against their limits."""
    count = machine.axes - machine.arm
    if isinstance(block.target, JointTarget):
        wanted = block.target.q[machine.arm :]
    else:
        wanted = block.target.extra or tuple(position[machine.arm :])
    if len(wanted) != count:
        raise BlockError(f"{len(wanted)} values of additional axes, the robot has {count}", code=154, source="VAL 3")
    check_targets(machine.limits[machine.arm :], wanted)
    return tuple(wanted)


def _along(curve: Curve, course: Course, block: Block, position: Joints, machine: Machine) -> JointPath:
    """Return the path of the axes along the curve on their present branch.  Report an obstacle with its place."""
    try:
        return followed(curve, position, block.tool.pose, course, machine)
    except KinematicsError as error:
        if error.at is None:
            raise
        where, flange, q = _where(curve, error.at), curve.at(error.at) @ block.tool.pose.inverse(), error.joints[: machine.arm]
        jumps = isinstance(error, SingularPose)
        blamed = _run_out_of(machine, flange, q) if jumps or isinstance(error, OutOfLimits) else None
        if blamed is not None and (jumps or turns_more(blamed)):
            raise run_out(blamed, where) from error
        if jumps:
            what = f"the joints would have to jump {where} along the path: there is a singularity or another configuration"
            raise SingularPose(what, _farthest(machine, flange, error.joints)) from error
        raise BlockError(f"{_words(error)}, {where} along the path", code=error.number, axis=error.axis, source="VAL 3") from error


def _farthest(machine: Machine, flange: Pose, q: Joints) -> str:
    """Name of the axis that would jump; empty: none is known."""
    try:
        found = machine.inverse(flange, q)
    except KinematicsError:
        return ""
    return machine.name(max(range(machine.arm), key=lambda n: abs(found[n] - q[n])))


def turns_more(axis: AxisLimits) -> bool:
    """More than once around."""
    return kind_of(axis.unit) is Kind.ROTARY and axis.upper - axis.lower > math.tau


def run_out(axis: AxisLimits, where: str) -> BlockError:
    """A path that drives it beyond its travel."""
    low, high = (from_si(each, axis.unit) for each in (axis.lower, axis.upper))
    what = f"the path drives the axis out of its range {low:.6g} .. {high:.6g} {axis.unit}, {where} along the path"
    if turns_more(axis):
        return BlockError(f"{what}: let it begin a turn further back", code=MULTI_TURN, axis=axis.name, source="VAL 3")
    return BlockError(what, code=OutOfLimits.number, axis=axis.name, source="VAL 3")


def _run_out_of(machine: Machine, flange: Pose, q: Joints) -> AxisLimits | None:
    """Return the axis whose travel ends where the arm would continue from q, or None if it could not continue at all."""
    if machine.carried:
        return None  # the position of the arm depends on its carrier
    for joints, _ in machine.kinematics.branches(flange):
        near = [
            value + math.tau * round((here - value) / math.tau) if kind_of(axis.unit) is Kind.ROTARY else value
            for value, here, axis in zip(joints, q, machine.limits, strict=False)
        ]
        if max(abs(there - here) for there, here in zip(near, q, strict=True)) <= NEXT:
            return next((axis for axis, there in zip(machine.limits, near, strict=False) if not axis.lower <= there <= axis.upper), None)
    return None


def _words(error: KinematicsError) -> str:
    return str(error).partition(" (VAL 3")[0]


def _where(curve: Curve, at: float) -> str:
    by_s = curve.derivatives(0.0)
    if max(map(abs, by_s.p1)) > DUST:
        return f"{at * 1e3:.1f} mm"
    return f"{math.degrees(at):.1f} deg" if any(by_s.w) else f"{100 * at / curve.length:.0f} %"  # the tool is at rest, its carrier moves


def check_values(target: JointTarget, machine: Machine) -> None:
    """As many as there are axes."""
    if len(target.q) != machine.axes:
        raise BlockError(f"{len(target.q)} joint values, the robot has {machine.axes} axes", code=154, source="VAL 3")


def check_joints(block: Block, machine: Machine) -> None:
    """A place of the axes as the target of a path: within their travel as that of a PTP block."""
    if isinstance(block.target, JointTarget) and len(block.target.q) == machine.axes:
        check_targets(machine.limits, block.target.q)


def check_end(block: Block, position: Joints, end: Joints, machine: Machine) -> None:
    """A path keeps the configuration and the turn of its axes: what the target demands beyond that cannot be forced (VAL 3 L5547-5554;
    rho 3: "not reachable with actual interpolation type")."""
    arm = machine.arm
    if isinstance(block.target, JointTarget):
        for n, (wanted, there) in enumerate(zip(block.target.q[:arm], end, strict=False)):
            if abs(wanted - there) > SAME_JOINT:
                unit = machine.limits[n].unit
                what = (
                    f"a straight or circular path leads the axis to {from_si(there, unit):.6g} {unit}, not to {from_si(wanted, unit):.6g}"
                )
                raise BlockError(what, code=CONFIGURATION, axis=machine.name(n), source="VAL 3")
    elif block.target.configuration != FREE:
        count, configuration = machine.kinematics.axes, machine.kinematics.configuration
        found, before = configuration(end[:count]), configuration(position[:count])
        if not block.target.configuration.admits(found, before):
            raise BlockError(
                "a straight or circular path cannot change the configuration to the one demanded", code=CONFIGURATION, source="VAL 3"
            )


def check_numbers(block: Block) -> None:
    """Every number of a block is finite, every speed above 0."""
    check_absolute(block)
    poses = [place.pose for place in (block.target, block.via) if isinstance(place, PoseTarget)]
    values = [value for pose in (*poses, block.tool.pose, block.frame.pose) for part in pose for value in part]
    values += block.target.q if isinstance(block.target, JointTarget) else block.target.extra
    values += (block.angle or 0.0, block.rise, block.blend.leave, block.blend.reach, block.blend.distance, *block.blend.axes)
    if not all(map(math.isfinite, values)):
        raise BlockError("a value is not a finite number", code=154, source="VAL 3")
    pace = block.pace
    for name, wanted in (("speed", pace.speed), ("acceleration", pace.accel), ("deceleration", pace.decel)):
        if not 0.0 < wanted < math.inf:
            raise BlockError(f"{name} {wanted:g} is not above 0")
    for name, given in (("path speed", pace.path_speed), ("turning speed", pace.turn_speed), ("time", pace.time)):
        if given is not None and not 0.0 < given < math.inf:
            raise BlockError(f"{name} {given:g} is not above 0")
    if min(block.blend.leave, block.blend.reach, block.blend.distance, *(block.blend.axes or (0.0,))) < 0.0:
        raise BlockError("a negative distance of blending")
