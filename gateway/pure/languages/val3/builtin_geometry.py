"""trsf, frame, tool, point, joint and config instructions, on the mathematics of motion.val3.  Source: VAL 3 reference 9, L4496-5349."""

from collections.abc import Callable, Iterable

from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.values import MOST_AXES, ConfigV, FrameV, JointV, PointV, ToolV, TrsfV, may_hang
from motion.geometry.conventions import DEGREE, angles_xyz, rotation_xyz
from motion.geometry.units import Kind, kind_of
from motion.kinematics.base import Configuration, Elbow, Shoulder, Wrist
from motion.val3 import cartesian, trsf
from motion.val3.trsf import Trsf

DEEPEST = 100
INCH = 25.4


def scale_of(own: Instance) -> float:
    """mm in a length unit of the application."""
    return 1.0 if own.loaded.app.millimetres else INCH


def trsf_in(own: Instance, value: TrsfV) -> Trsf:
    """In mm."""
    s = scale_of(own)
    return Trsf(value.x * s, value.y * s, value.z * s, value.rx, value.ry, value.rz)


def trsf_out(own: Instance, value: Trsf) -> TrsfV:
    """In the length unit of the application."""
    s = scale_of(own)
    return TrsfV(value.x / s, value.y / s, value.z / s, value.rx, value.ry, value.rz)


def frame_in(own: Instance, value: FrameV, depth: int = 0) -> cartesian.Frame:
    """With all it hangs on."""
    if depth > DEEPEST:
        raise Rte(165, "frames linked in a ring")
    if value.lost is not None:
        raise Rte(*value.lost)
    father = frame_in(own, value.father, depth + 1) if value.father is not None and not value.root else None
    return cartesian.Frame(trsf_in(own, value.trsf), father, value.root)


def tool_in(own: Instance, value: ToolV, depth: int = 0) -> cartesian.Tool:
    """With all it hangs on."""
    if depth > DEEPEST:
        raise Rte(165, "tools linked in a ring")
    if value.lost is not None:
        raise Rte(*value.lost)
    father = tool_in(own, value.father, depth + 1) if value.father is not None and not value.root else None
    return cartesian.Tool(trsf_in(own, value.trsf), father, value.root)


def config_in(value: ConfigV) -> Configuration:
    """Convert the words to the kinematics' configuration."""
    return Configuration(Shoulder(value.shoulder), Elbow(value.elbow), Wrist(value.wrist))


def config_out(value: Configuration) -> ConfigV:
    """As words."""
    return ConfigV(value.shoulder.value, value.elbow.value, value.wrist.value)


def point_in(own: Instance, value: PointV) -> cartesian.Point:
    """With its frame."""
    check_family(own, value.family)
    frame = frame_in(own, value.father) if value.father is not None else None
    return cartesian.Point(trsf_in(own, value.trsf), config_in(value.config), frame)


def check_family(own: Instance, family: str) -> None:
    """81 for values of another arm."""
    if family and own.machine.family and family != own.machine.family:
        raise Rte(81, f"a value of an {family.upper()} arm")


def joint_in(own: Instance, value: JointV) -> tuple[float, ...]:
    """Degrees and mm; 81."""
    check_family(own, value.family)
    return tuple(number * s for number, s in zip(value.numbers(), scales_of(own), strict=False))


def joint_out(own: Instance, values: Iterable[float]) -> JointV:
    """Degrees, and linear axes in the length unit of the application (L4511)."""
    return JointV([number / s for number, s in zip(values, scales_of(own), strict=False)], own.machine.axes)


def scales_of(own: Instance) -> tuple[float, ...]:
    """Return for each axis the mm in a length unit of the application; 1 for a rotary axis."""
    s, moves = scale_of(own), own.machine.moves_or_none
    if s == 1.0 or moves is None:
        return (1.0,) * MOST_AXES
    return tuple(1.0 if kind_of(unit) is Kind.ROTARY else s for unit in moves.units)


# ---- operators -------------------------------------------------------------------------------------------------------------


def _axes(first: JointV, second: JointV, rule: Callable[[float, float], float]) -> JointV:
    return JointV([rule(a, b) for a, b in zip(first.numbers(), second.numbers(), strict=False)], first.count, first.family)


def joint_sum(own: Instance, first: JointV, second: JointV) -> JointV:
    """+ by fields."""
    return _axes(first, second, lambda a, b: a + b)


def joint_difference(own: Instance, first: JointV, second: JointV) -> JointV:
    """- by fields."""
    return _axes(first, second, lambda a, b: a - b)


def joint_above(own: Instance, first: JointV, second: JointV) -> bool:
    """Every field is greater."""
    return all(a > b for a, b in zip(first.numbers(), second.numbers(), strict=False))


def joint_below(own: Instance, first: JointV, second: JointV) -> bool:
    """Every field is smaller."""
    return all(a < b for a, b in zip(first.numbers(), second.numbers(), strict=False))


def f_abs_joint(own: Instance, joint: JointV) -> JointV:
    """Magnitude by fields."""
    return JointV([abs(value) for value in joint.numbers()], joint.count, joint.family)


def trsf_product(own: Instance, first: TrsfV, second: TrsfV) -> TrsfV:
    """*: composition, in the length unit both have."""
    d = DEGREE
    a = rotation_xyz(first.rx * d, first.ry * d, first.rz * d)
    b = rotation_xyz(second.rx * d, second.ry * d, second.rz * d)
    x, y, z = second.x, second.y, second.z
    rows = ((a[0], a[1], a[2]), (a[3], a[4], a[5]), (a[6], a[7], a[8]))
    moved = [k * x + m * y + n * z for k, m, n in rows]
    turned = [k * b[c] + m * b[c + 3] + n * b[c + 6] for k, m, n in rows for c in (0, 1, 2)]
    rx, ry, rz = angles_xyz((turned[0], turned[1], turned[2], turned[3], turned[4], turned[5], turned[6], turned[7], turned[8]))
    return TrsfV(first.x + moved[0], first.y + moved[1], first.z + moved[2], rx / d, ry / d, rz / d)


def trsf_inverse(own: Instance, value: TrsfV) -> TrsfV:
    """!."""
    return TrsfV(*trsf.inverted(Trsf(*value.numbers())))


# ---- trsf ------------------------------------------------------------------------------------------------------------------


def f_distance_trsf(own: Instance, first: TrsfV, second: TrsfV) -> float:
    """Of the translations."""
    return trsf.distance(Trsf(*first.numbers()), Trsf(*second.numbers()))


def f_interpolate_l(own: Instance, start: TrsfV, end: TrsfV, position: float) -> TrsfV:
    """70 outside ]-1, 2[."""
    return TrsfV(*trsf.interpolate_l(Trsf(*start.numbers()), Trsf(*end.numbers()), position))


def f_interpolate_c(own: Instance, start: TrsfV, middle: TrsfV, end: TrsfV, position: float) -> TrsfV:
    """Interpolate on an arc.  Raise 550 .. 553 where there is none."""
    return TrsfV(*trsf.interpolate_c(Trsf(*start.numbers()), Trsf(*middle.numbers()), Trsf(*end.numbers()), position))


def f_align(own: Instance, value: TrsfV, reference: TrsfV) -> TrsfV:
    """z along the nearest axis of the reference."""
    return TrsfV(*trsf.align(Trsf(*value.numbers()), Trsf(*reference.numbers())))


# ---- frame, tool, point ----------------------------------------------------------------------------------------------------


def f_set_frame(own: Instance, origin: PointV, on_x: PointV, in_xy: PointV, result: FrameV) -> float:
    """0, -1, -2."""
    made = frame_in(own, result)
    had = made.reference is not None
    code = cartesian.set_frame(point_in(own, origin), point_in(own, on_x), point_in(own, in_xy), made)
    if code == 0:
        if not had:
            may_hang(result, origin.father)
            result.father = origin.father
        result.trsf.set(trsf_out(own, made.trsf))
    return float(code)


def f_position_frame(own: Instance, value: FrameV, reference: FrameV) -> TrsfV:
    """161, 163."""
    return trsf_out(own, cartesian.position(frame_in(own, value), frame_in(own, reference)))


def f_position_point(own: Instance, value: PointV, reference: FrameV) -> TrsfV:
    """162."""
    return trsf_out(own, cartesian.position(point_in(own, value), frame_in(own, reference)))


def f_position_tool(own: Instance, value: ToolV, reference: ToolV) -> TrsfV:
    """160, 164."""
    return trsf_out(own, cartesian.tool_position(tool_in(own, value), tool_in(own, reference)))


def f_link(own: Instance, what: FrameV | ToolV | PointV, reference: FrameV | ToolV) -> None:
    """The reference changes, the trsf stays; 165 for a ring."""
    may_hang(what, reference)
    here: FrameV | ToolV | None = reference
    for _ in range(DEEPEST):
        if here is None:
            break
        if here is what:
            raise Rte(165, "linked in a ring")
        here = None if here.root else here.father
    what.father = reference


def f_distance_point(own: Instance, first: PointV, second: PointV) -> float:
    """In the world; 162."""
    return cartesian.distance(point_in(own, first), point_in(own, second)) / scale_of(own)


def _moved(own: Instance, source: PointV, made: cartesian.Point) -> PointV:
    result = PointV()
    result.set(source)
    result.trsf.set(trsf_out(own, made.trsf))
    return result


def f_compose(own: Instance, point: PointV, reference: FrameV, change: TrsfV) -> PointV:
    """Moved in the coordinates of the reference."""
    return _moved(own, point, cartesian.compose_point(point_in(own, point), frame_in(own, reference), trsf_in(own, change)))


def f_appro(own: Instance, point: PointV, change: TrsfV) -> PointV:
    """Moved in its own axes."""
    return _moved(own, point, cartesian.appro(point_in(own, point), trsf_in(own, change)))


def _arm(own: Instance) -> cartesian.Arm:
    if own.machine.arm is None:
        raise Rte(153, "there is no arm")
    return own.machine.arm


def _point_out(own: Instance, made: cartesian.Point, reference: FrameV) -> PointV:
    result = PointV(reference)
    result.trsf.set(trsf_out(own, made.trsf))
    result.config.set(config_out(made.config))
    return result


def f_joint_to_point(own: Instance, tool: ToolV, reference: FrameV, joint: JointV) -> PointV:
    """Forward kinematics."""
    made = _arm(own).joint_to_point(tool_in(own, tool), frame_in(own, reference), joint_in(own, joint))
    return _point_out(own, made, reference)


def f_here(own: Instance, tool: ToolV, reference: FrameV) -> PointV:
    """Of the commanded position."""
    made = _arm(own).here(tool_in(own, tool), frame_in(own, reference), own.machine.moves.joints())
    return _point_out(own, made, reference)


def f_point_to_joint(own: Instance, tool: ToolV, initial: JointV, point: PointV, result: JointV) -> bool:
    """false: no way there."""
    found = _arm(own).point_to_joint(tool_in(own, tool), joint_in(own, initial), point_in(own, point))
    if found is not None:
        result.set(joint_out(own, found))
    return found is not None


def f_config(own: Instance, joint: JointV) -> ConfigV:
    """Of a joint position."""
    return config_out(_arm(own).config(joint_in(own, joint)))


def f_herej(own: Instance) -> JointV:
    """The commanded position."""
    return joint_out(own, own.machine.moves.joints())


def f_is_in_range(own: Instance, joint: JointV) -> bool:
    """Inside the software limits."""
    return own.machine.moves.in_range(joint_in(own, joint))
