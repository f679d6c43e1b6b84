"""The chain of joints of a URDF from its root to one link, read from the XML; nothing else of the URDF is read.

Branches such as grippers and cameras, masses, shapes and `<limit>` (set in the robot file) are ignored.  A joint with `<mimic>` is not an
axis: it follows another joint of the chain.  Source: ros.org, URDF XML specification, `joint` (AX-1776).
"""

import math
import xml.etree.ElementTree as Xml
from collections.abc import Sequence
from dataclasses import dataclass, replace

from motion.errors import MotionError

MOVING = ("revolute", "continuous", "prismatic")
XACRO = "it holds xacro: expand it first (xacro FILE.xacro > FILE.urdf)"
MARKS = ("${", "$(")  # of an expression of xacro
NOWHERE = (0.0, 0.0, 0.0)
ALONG_X = (1.0, 0.0, 0.0)  # of a joint that names no axis
SHORTEST = 1e-9  # an axis shorter than that has no direction


@dataclass(frozen=True, slots=True)
class ChainJoint:
    """One joint on the way; m and rad.  Its value is factor * (axis number `follows`) + offset."""

    name: str
    kind: str
    xyz: tuple[float, ...]
    rpy: tuple[float, ...]
    axis: tuple[float, ...]
    travel: tuple[float, float, float] | None  # lower, upper, speed
    follows: int | None = None
    factor: float = 1.0
    offset: float = 0.0
    leads: bool = False  # it is an axis itself

    @property
    def slides(self) -> bool:
        return self.kind == "prismatic"


@dataclass(frozen=True, slots=True)
class Chain:
    """Joints from the root to the flange, in their order."""

    joints: tuple[ChainJoint, ...]

    @property
    def moving(self) -> tuple[ChainJoint, ...]:
        return tuple(joint for joint in self.joints if joint.follows is not None)

    @property
    def axes(self) -> tuple[ChainJoint, ...]:
        return tuple(joint for joint in self.moving if joint.leads)


def chain_of(text: str, frame: str) -> Chain:
    """Return the chain from the root of a URDF to a link or joint.  Raise MotionError for an invalid one."""
    root = _root(text)
    joints = [element for element in root if element.tag == "joint"]
    links = [element.get("name", "") for element in root if element.tag == "link"]
    names = [joint.get("name", "") for joint in joints]
    above: dict[str, Xml.Element] = {}
    for joint in joints:
        if names.count(joint.get("name", "")) > 1:
            raise MotionError(f"the URDF has two joints named {joint.get('name', '')!r}")
        child = _link(joint, "child")
        if child in above:
            raise MotionError(f"the URDF has two joints that carry the link {child!r}")
        above[child] = joint
    end = next((_link(joint, "child") for joint in joints if frame not in links and joint.get("name") == frame), frame)
    if end not in links:
        known = ", ".join(links) or "no link at all"
        raise MotionError(f"the URDF has no link or joint {frame!r}; its links: {known}" + (f"; {XACRO}" if _holds_xacro(root) else ""))
    way: list[Xml.Element] = []
    here = end
    while here in above:
        if len(way) == len(joints):
            raise MotionError(f"the joints of the URDF below {frame!r} form a loop")
        way.insert(0, above[here])
        here = _link(above[here], "parent")
    if here not in links:
        raise MotionError(f"joint {way[0].get('name')!r} of the URDF is attached to the link {here!r}, which does not exist")
    return Chain(_followed([_joint(element) for element in way], way, frame))


def _root(text: str) -> Xml.Element:
    try:
        root = Xml.fromstring(text)
    except (Xml.ParseError, ValueError) as error:
        raise MotionError(f"the URDF is not XML: {error}" + (f"; {XACRO}" if "xacro:" in text else "")) from error
    for element in root.iter():
        if "xacro" not in element.tag:
            element.tag = element.tag.rpartition("}")[2]
    if root.tag != "robot":
        raise MotionError(f"no URDF: its first element is <{root.tag}>, not <robot>")
    return root


def _holds_xacro(root: Xml.Element) -> bool:
    return any("xacro" in element.tag for element in root.iter())


def _joint(element: Xml.Element) -> ChainJoint:
    name, kind = element.get("name", ""), element.get("type", "")
    if kind not in (*MOVING, "fixed"):
        raise MotionError(f"joint {name!r} of the URDF is {kind or 'of no type'}; {', '.join(MOVING)} and fixed are known on the way")
    axis = ALONG_X if kind == "fixed" else _numbers(element, "axis", "xyz", ALONG_X)
    length = math.hypot(*axis)
    if length < SHORTEST:
        raise MotionError(f"joint {name!r} of the URDF has the axis 0 0 0")
    place, turned = _numbers(element, "origin", "xyz", NOWHERE), _numbers(element, "origin", "rpy", NOWHERE)
    return ChainJoint(name, kind, place, turned, tuple(value / length for value in axis), _travel(element))


def _travel(joint: Xml.Element) -> tuple[float, float, float] | None:
    """Return the limits, or None where the URDF has no plausible ones; they are then required in the robot file."""
    limit = {} if (element := joint.find("limit")) is None else element.attrib
    try:
        lower, upper, speed = (float(limit.get(key, "0")) for key in ("lower", "upper", "velocity"))
    except ValueError:
        return None
    return (lower, upper, speed) if -math.inf < lower < upper < math.inf else None


def _followed(joints: Sequence[ChainJoint], way: Sequence[Xml.Element], frame: str) -> tuple[ChainJoint, ...]:
    """The joints, each with the axis that moves it."""
    moving = {joint.name: element for joint, element in zip(joints, way, strict=True) if joint.kind in MOVING}
    order = [name for name, element in moving.items() if element.find("mimic") is None]

    def moved_by(name: str, *behind: str) -> tuple[int, float, float]:
        if name not in moving:
            raise MotionError(f"joint {behind[0]!r} of the URDF follows {name!r}, which is not a moving joint on the way to {frame!r}")
        if name in behind:
            raise MotionError(f"joint {name!r} of the URDF follows itself")
        mimic = moving[name].find("mimic")
        if mimic is None:
            return order.index(name), 1.0, 0.0
        factor = _numbers(moving[name], "mimic", "multiplier", (1.0,))[0]
        offset = _numbers(moving[name], "mimic", "offset", (0.0,))[0]
        number, outer, shift = moved_by(mimic.get("joint", ""), name, *behind)
        return number, factor * outer, factor * shift + offset

    def placed(joint: ChainJoint) -> ChainJoint:
        number, factor, offset = moved_by(joint.name)
        return replace(joint, follows=number, factor=factor, offset=offset, leads=joint.name in order)

    return tuple(placed(joint) if joint.kind in MOVING else joint for joint in joints)


def _link(joint: Xml.Element, role: str) -> str:
    element = joint.find(role)
    name = "" if element is None else element.get("link", "")
    if not name:
        raise MotionError(f"joint {joint.get('name', '')!r} of the URDF names no {role} link")
    return name


def _numbers(joint: Xml.Element, tag: str, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
    """As many as the default has."""
    element = joint.find(tag)
    words = None if element is None else element.get(key)
    if words is None:
        return default
    try:
        found = tuple(float(word) for word in words.split())
    except ValueError:
        found = ()
    if len(found) != len(default) or not all(map(math.isfinite, found)):
        hint = f"; {XACRO}" if any(mark in words for mark in MARKS) else ""
        what = "a number" if len(default) == 1 else f"{len(default)} numbers"
        raise MotionError(f"joint {joint.get('name', '')!r} of the URDF: {tag} {key} is {words!r}, not {what}{hint}")
    return found
