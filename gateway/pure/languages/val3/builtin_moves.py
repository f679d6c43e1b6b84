"""Move instructions.  Source: VAL 3 reference 10.6-10.7, L5724-6056."""

import math
from collections.abc import Generator

from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.builtin_geometry import frame_in, joint_in, joint_out, point_in, scale_of, tool_in, trsf_in
from gateway.pure.languages.val3.builtin_io import io_put
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.moves import Moves, refused
from gateway.pure.languages.val3.numbers import Place
from gateway.pure.languages.val3.values import FrameV, JointV, MdescV, PointV, ToolV, TrsfV
from motion.val3.errors import RuntimeFault
from motion.val3.mdesc import BlendKind, Mdesc

Waiting = Generator[Ns | None, None, object]
BLENDS = {"off": BlendKind.OFF, "joint": BlendKind.JOINT, "Cartesian": BlendKind.CARTESIAN}


def mdesc_in(value: MdescV) -> Mdesc:
    """Convert to the motion stack's form."""
    return Mdesc(value.accel, value.vel, value.decel, value.tvel, value.rvel, BLENDS[value.blend], value.leave, value.reach)


def moves_of(own: Instance) -> Moves:
    """153 without an arm."""
    if own.machine.arm is None:
        raise Rte(153, "there is no arm")
    return own.machine.moves


def _note(own: Instance, kind: str, target: object) -> dict[str, object]:
    task = own.machine.current
    return {
        "kind": kind,
        "at_s": round(own.machine.now / 1e9, 6),
        "task": task.name if task else "",
        "program": task.program if task else "",
        "line": task.line if task else 0,
        "target": target,
    }


def f_movej_joint(own: Instance, joint: JointV, tool: ToolV, mdesc: MdescV) -> Waiting:
    """To a joint position; its move id."""
    moves, hand, pace = moves_of(own), tool_in(own, tool), mdesc_in(mdesc)
    note = _note(own, "movej", {name: getattr(joint, name) for name in joint.names()})
    target = joint_in(own, joint)
    while True:
        try:
            number = moves.joint_move(target, hand, pace, scale_of(own) * 1e-3, note)
        except RuntimeFault as fault:
            raise refused(fault) from fault
        if number is not None:
            return float(number)
        yield None


def _to_points(own: Instance, kind: str, points: list[PointV], tool: ToolV, mdesc: MdescV) -> Waiting:
    moves, hand, pace = moves_of(own), tool_in(own, tool), mdesc_in(mdesc)
    targets = [point_in(own, point) for point in points]
    seen = points[-1].trsf
    note = _note(own, kind, {name: getattr(seen, name) for name in seen.names()})
    while True:
        try:
            number = moves.point_move(kind, targets, hand, pace, scale_of(own) * 1e-3, note)
        except RuntimeFault as fault:
            raise refused(fault) from fault
        if number is not None:
            return float(number)
        yield None


def f_movej_point(own: Instance, point: PointV, tool: ToolV, mdesc: MdescV) -> Waiting:
    """To a point, in joint space."""
    return _to_points(own, "movej", [point], tool, mdesc)


def f_movel(own: Instance, point: PointV, tool: ToolV, mdesc: MdescV) -> Waiting:
    """On the straight line."""
    return _to_points(own, "movel", [point], tool, mdesc)


def f_movec(own: Instance, through: PointV, point: PointV, tool: ToolV, mdesc: MdescV) -> Waiting:
    """On the arc."""
    return _to_points(own, "movec", [through, point], tool, mdesc)


def f_stop_move(own: Instance) -> None:
    """Stops on the path."""
    moves_of(own).stack.stop_move()


def f_restart_move(own: Instance) -> None:
    """Goes on."""
    moves_of(own).stack.restart_move()


def f_reset_motion(own: Instance) -> None:
    """Drop the queued moves."""
    moves_of(own).reset()


def f_reset_motion_at(own: Instance, joint: JointV) -> None:
    """The next move begins there."""
    moves_of(own).reset(joint_in(own, joint))


def f_wait_end_move(own: Instance) -> Waiting:
    """Until the command has reached its end."""
    stack = moves_of(own).stack
    if not own.machine.current_is_synchronous:
        yield own.machine.now
    while not stack.wait_end_move():
        yield None
    return None


def _gripper(own: Instance, tool: ToolV, value: bool, seconds: float) -> Waiting:
    yield from f_wait_end_move(own)
    io_put(own, tool.gripper, value)
    end = own.machine.now + max(round(seconds * 1e9), 0)
    while own.machine.now < end:
        yield end
    return None


def f_open(own: Instance, tool: ToolV) -> Waiting:
    """waitEndMove, gripper true, otime."""
    return _gripper(own, tool, True, tool.otime)


def f_close(own: Instance, tool: ToolV) -> Waiting:
    """waitEndMove, gripper false, ctime."""
    return _gripper(own, tool, False, tool.ctime)


def f_is_empty(own: Instance) -> bool:
    """No move pending."""
    return moves_of(own).stack.is_empty()


def f_is_settled(own: Instance) -> bool:
    """Every joint within 1 % of its largest following error."""
    return moves_of(own).settled()


def f_is_settled_tool(own: Instance, tool: ToolV, accuracy: float) -> bool:
    """The tool within a distance of where it should be."""
    return moves_of(own).settled(tool_in(own, tool), accuracy * scale_of(own) * 1e-3)


def f_is_settled_time(own: Instance, tool: ToolV, accuracy: float, turn: float, seconds: float) -> bool:
    """Wait until the tool is within a distance and an angle for these seconds."""
    return moves_of(own).settled(tool_in(own, tool), accuracy * scale_of(own) * 1e-3, math.radians(turn), seconds)


def f_auto_connect_move(own: Instance, active: bool) -> None:
    """Set."""
    moves_of(own).stack.auto_connect_move(active)


def f_auto_connect(own: Instance) -> bool:
    """Asked."""
    return moves_of(own).stack.auto_connect_move()


def f_get_speed(own: Instance, tool: ToolV) -> float:
    """Of the tool centre point, by the commanded positions, in length units a second (L5964)."""
    return moves_of(own).speed_at(tool_in(own, tool)) * 1e3 / scale_of(own)


def f_get_position_err(own: Instance) -> JointV:
    """Set less actual positions."""
    return joint_out(own, moves_of(own).errors)


def f_get_joint_force(own: Instance, force: Place) -> None:
    """Of each axis, from the currents of the motors; 70 for too small an array."""
    if len(force[0]) - force[1] < own.machine.axes:
        raise Rte(70, f"{own.machine.axes} elements are needed")
    force[0][force[1] : force[1] + own.machine.axes] = moves_of(own).forces


def f_get_move_id(own: Instance) -> float:
    """Move under way and its progress."""
    return float(moves_of(own).stack.get_move_id())


def f_set_move_id(own: Instance, number: float) -> float:
    """Of the next move."""
    whole = math.floor(number + 0.5)
    moves_of(own).stack.set_move_id(whole)
    return float(whole)


def f_reset_turn(own: Instance, reference: JointV) -> JointV:
    """Shift the last axis by full turns next to the reference: AX-724."""
    moves = moves_of(own)
    moves.reset()
    values = list(moves.joints())
    last = len(values) - 1
    turns = math.floor((joint_in(own, reference)[last] - values[last]) / 360.0 + 0.5)
    values[last] += 360.0 * turns
    if turns:
        moves.restart(values)
    return joint_out(own, values)


# ---- alter (13.1) ----------------------------------------------------------------------------------------------------------


def _alterable(own: Instance, move: Waiting) -> Waiting:
    """The move is queued as an alterable one."""
    moves = moves_of(own)
    while True:
        moves.alterable(True)
        try:
            turn = next(move)
        except StopIteration as stop:
            return stop.value
        finally:
            moves.alterable(False)
        yield turn


def f_alter_movej_joint(own: Instance, joint: JointV, tool: ToolV, mdesc: MdescV) -> Waiting:
    """As movej, alterable."""
    return _alterable(own, f_movej_joint(own, joint, tool, mdesc))


def f_alter_movej_point(own: Instance, point: PointV, tool: ToolV, mdesc: MdescV) -> Waiting:
    """As movej, alterable."""
    return _alterable(own, _to_points(own, "alterMovej", [point], tool, mdesc))


def f_alter_movel(own: Instance, point: PointV, tool: ToolV, mdesc: MdescV) -> Waiting:
    """As movel, alterable."""
    return _alterable(own, _to_points(own, "alterMovel", [point], tool, mdesc))


def f_alter_movec(own: Instance, through: PointV, point: PointV, tool: ToolV, mdesc: MdescV) -> Waiting:
    """As movec, alterable."""
    return _alterable(own, _to_points(own, "alterMovec", [through, point], tool, mdesc))


def f_alter_begin_frame(own: Instance, reference: FrameV, mdesc: MdescV) -> float:
    """1, 0, -1, -2, -3; 100 .. 106."""
    return float(moves_of(own).alter_begin(frame_in(own, reference), mdesc_in(mdesc), scale_of(own) * 1e-3))


def f_alter_begin_tool(own: Instance, reference: ToolV, mdesc: MdescV) -> float:
    """As with a frame."""
    return float(moves_of(own).alter_begin(tool_in(own, reference), mdesc_in(mdesc), scale_of(own) * 1e-3))


def f_alter_end(own: Instance) -> float:
    """1, -1, -3."""
    return float(moves_of(own).alter_end())


def f_alter(own: Instance, change: TrsfV) -> float:
    """In force in the next system cycle: 1, 0, -1, -2, -3."""
    return float(moves_of(own).alter(trsf_in(own, change)))


def f_alter_stop_time(own: Instance) -> float:
    """Negative: no stop is pending; 0: locked, or alter mode is off."""
    return float(moves_of(own).alter_stop_time())
