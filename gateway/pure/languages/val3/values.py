"""Values at run time.  An array is a list, a collection a dict, a 2-D or 3-D array a Grid; structures are changed in place, so that
frames, tools and references that point to them keep doing so."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Protocol, cast

from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.model import MOST_VALUES, UserType

MOST_AXES = 12
LONGEST = 128  # bytes of a string (L2041)


class Structure:
    """Fields by name."""

    FIELDS: tuple[str, ...] = ()
    __slots__ = ()

    def names(self) -> tuple[str, ...]:
        """Its fields in their order."""
        return self.FIELDS

    def set(self, other: object) -> None:
        """Takes the values of another; nested structures stay the same objects."""
        for name in self.names():
            mine, given = getattr(self, name), getattr(other, name)
            if isinstance(mine, Structure) and name != "father":  # its father is another variable
                mine.set(given)
            else:
                setattr(self, name, given)

    def copy(self) -> Structure:
        """One of its own with the same values."""
        made = type(self)()
        made.set(self)
        return made

    def same(self, other: object) -> bool:
        """The operator ==."""
        return all(equal(getattr(self, name), getattr(other, name)) for name in self.names())

    def __getitem__(self, name: str) -> object:
        return getattr(self, name)

    def __setitem__(self, name: str, value: object) -> None:
        setattr(self, name, value)


class TrsfV(Structure):
    """trsf: length unit and degrees."""

    FIELDS = ("x", "y", "z", "rx", "ry", "rz")
    __slots__ = FIELDS

    def __init__(self, x: float = 0.0, y: float = 0.0, z: float = 0.0, rx: float = 0.0, ry: float = 0.0, rz: float = 0.0) -> None:
        self.x, self.y, self.z, self.rx, self.ry, self.rz = x, y, z, rx, ry, rz

    def set(self, other: object) -> None:
        """All six of the other one."""
        if isinstance(other, TrsfV):
            self.x, self.y, self.z, self.rx, self.ry, self.rz = other.x, other.y, other.z, other.rx, other.ry, other.rz

    def numbers(self) -> tuple[float, float, float, float, float, float]:
        """All six."""
        return self.x, self.y, self.z, self.rx, self.ry, self.rz


class ConfigV(Structure):
    """config of an arm; a SCARA uses shoulder alone."""

    FIELDS = ("shoulder", "elbow", "wrist")
    __slots__ = FIELDS

    def __init__(self, shoulder: str = "ssame", elbow: str = "esame", wrist: str = "wsame") -> None:
        self.shoulder, self.elbow, self.wrist = shoulder, elbow, wrist


class MdescV(Structure):
    """mdesc (L5697-5712)."""

    FIELDS = ("accel", "vel", "decel", "tvel", "rvel", "blend", "leave", "reach")
    __slots__ = FIELDS

    def __init__(self) -> None:
        self.accel = self.vel = self.decel = 100.0
        self.tvel = self.rvel = 9999.0
        self.blend = "joint"
        self.leave = self.reach = 50.0


class JointV(Structure):
    """One number an axis; `count` of them are shown."""

    FIELDS = tuple(f"j{n}" for n in range(1, MOST_AXES + 1))
    __slots__ = (*FIELDS, "count", "family")

    def __init__(self, values: Iterable[float] = (), count: int = 6, family: str = "") -> None:
        self.count, self.family = count, family
        for name in JointV.FIELDS:
            setattr(self, name, 0.0)
        for name, value in zip(JointV.FIELDS, values, strict=False):
            setattr(self, name, value)

    def names(self) -> tuple[str, ...]:
        """j1 .. of the arm."""
        return JointV.FIELDS[: self.count]

    def set(self, other: object) -> None:
        """All axes of the other one."""
        super().set(other)
        self.family = getattr(other, "family", "")

    def copy(self) -> JointV:
        """With the same number of axes."""
        return JointV(self.numbers(), self.count, self.family)

    def numbers(self) -> tuple[float, ...]:
        """All of them."""
        return tuple(getattr(self, name) for name in self.names())

    def same(self, other: object) -> bool:
        """Within the accuracy of the robot (L4522): 0.001 deg or mm (AX-722)."""
        return all(abs(getattr(self, name) - getattr(other, name)) < 1e-3 for name in self.names())


class LinkV(Structure):
    """dio, aio, sio: the link to a system input or output, None: none."""

    FIELDS = ("link",)
    __slots__ = ("link",)

    def __init__(self, link: str | None = None) -> None:
        self.link = link


class DioV(LinkV):
    """A digital variable."""

    __slots__ = ()


class AioV(LinkV):
    """An analog variable."""

    __slots__ = ()


class SioV(LinkV):
    """A serial line or socket."""

    __slots__ = ("made",)

    def __init__(self, link: str | None = None) -> None:
        super().__init__(link)
        self.made: object = None  # what the sio core knows it as


class ScreenV(Structure):
    """A text page of s7."""

    __slots__ = ("text",)

    def __init__(self) -> None:
        self.text: list[str] = []


class FrameV(Structure):
    """frame: trsf and the frame it hangs on."""

    FIELDS = ("trsf", "father")
    __slots__ = (*FIELDS, "local", "lost", "root")

    def __init__(self, father: FrameV | None = None, root: bool = False) -> None:
        self.trsf, self.father, self.root = TrsfV(), self if root else father, root  # a copy of world hangs on world
        self.local = False  # it ends with its program
        self.lost: tuple[int, str] | None = None  # where its name leads nowhere: error code, and the name

    def same(self, other: object) -> bool:
        """The same reference and the same position."""
        return isinstance(other, FrameV) and self.father is other.father and self.trsf.same(other.trsf)


class ToolV(Structure):
    """tool: trsf, gripper and its times, and the tool it hangs on."""

    FIELDS = ("trsf", "gripper", "otime", "ctime", "father")
    __slots__ = (*FIELDS, "local", "lost", "root")

    def __init__(self, father: ToolV | None = None, root: bool = False) -> None:
        self.trsf, self.gripper, self.father, self.root = TrsfV(), DioV(None), self if root else father, root
        self.local = False  # as of a frame
        self.lost: tuple[int, str] | None = None  # as of a frame
        self.otime = self.ctime = 0.0

    def same(self, other: object) -> bool:
        """Base, position, output and both times."""
        return (
            isinstance(other, ToolV)
            and self.father is other.father
            and self.trsf.same(other.trsf)
            and self.gripper.link == other.gripper.link
            and (self.otime, self.ctime) == (other.otime, other.ctime)
        )


class PointV(Structure):
    """point: trsf, configuration and the frame it hangs on."""

    FIELDS = ("trsf", "config", "father")
    __slots__ = (*FIELDS, "family", "local")

    def __init__(self, father: FrameV | None = None) -> None:
        self.trsf, self.config, self.father, self.family = TrsfV(), ConfigV(), father, ""
        self.local = False  # as of a frame

    def same(self, other: object) -> bool:
        """Reference and position (L5060)."""
        return isinstance(other, PointV) and self.father is other.father and self.trsf.same(other.trsf)

    def set(self, other: object) -> None:
        """With its arm family."""
        super().set(other)
        self.family = getattr(other, "family", "")


class UserV(Structure):
    """A value of a user type: each field is a container."""

    __slots__ = ("__dict__", "local", "type")

    def __init__(self, kind: UserType) -> None:
        self.type = kind
        self.local = False  # as of a frame

    def names(self) -> tuple[str, ...]:
        """Attributes of its fields."""
        return tuple(f"u_{name}" for name in self.type.fields)

    def set(self, other: object) -> None:
        """Sizes and values, deep (L4153)."""
        for name in self.names():
            replace_container(getattr(self, name), getattr(other, name))

    def copy(self) -> UserV:
        """Deep."""
        made = UserV(self.type)
        for name in self.names():
            setattr(made, name, copy_container(getattr(self, name)))
        return made


class Collection(dict[str, object]):
    """Values by their keys; it may be empty, so it knows itself whether it ends with its program."""

    __slots__ = ("local",)

    def __init__(self, values: Mapping[str, object] | None = None) -> None:
        super().__init__(values or {})
        self.local = False


class Grid:
    """A 2-D or 3-D array; local: a variable of a program, which does not grow."""

    __slots__ = ("dims", "flat", "local")

    def __init__(self, dims: tuple[int, ...], flat: list[object]) -> None:
        self.dims, self.flat, self.local = dims, flat, False

    def at(self, *wanted: float) -> int:
        """The place of an element; 20 and 21."""
        place = 0
        for size, index in zip(self.dims, map(rounded, wanted), strict=True):
            if index >= size:
                raise Rte(20, f"index {index} of {size}")
            place = place * size + index
        return place

    def resize(self, dimension: int, size: int, new: Callable[[], object]) -> None:
        """Adds or drops values at the end of a dimension (0..)."""
        dims = (*self.dims[:dimension], size, *self.dims[dimension + 1 :])
        if math.prod(dims) > MOST_VALUES:
            raise Rte(40, f"{math.prod(dims)} values, {MOST_VALUES} at most")
        kept = []
        for place in range(math.prod(dims)):
            indices, rest = [], place
            for length in reversed(dims):
                rest, index = divmod(rest, length)
                indices.append(index)
            indices.reverse()
            inside = all(i < n for i, n in zip(indices, self.dims, strict=True))
            kept.append(self.flat[self.at(*indices)] if inside else new())
        self.dims = dims
        self.flat[:] = kept


class Places(Protocol):
    """Anything with values at places: an array, a collection, a structure."""

    def __getitem__(self, place: object, /) -> object:
        """The value at a place."""

    def __setitem__(self, place: object, value: object, /) -> None:
        """Puts one there."""


def places(what: object) -> Places:
    """A container or structure as one."""
    return cast(Places, what)


Container = list[object] | dict[str, object] | Grid


def rounded(index: float) -> int:
    """Return an index rounded to the nearest integer; 21 for a negative one."""
    place = math.floor(index + 0.5)
    if place < 0:
        raise Rte(21, f"index {index:g}")
    return place


def equal(first: object, second: object) -> bool:
    """The operator == of any type that has one."""
    return first.same(second) if isinstance(first, Structure) else first == second


def cut(text: str) -> str:
    """At most 128 bytes."""
    if len(text) * 4 <= LONGEST:
        return text
    data = text.encode("utf-8", "replace")
    return text if len(data) <= LONGEST else data[:LONGEST].decode("utf-8", "ignore")


def copied(value: object) -> object:
    """A value of its own."""
    return value.copy() if isinstance(value, Structure) else value


def passed(value: object) -> object:
    """A parameter by value: it ends with its program."""
    made = copied(value)
    mark_local(made)
    return made


def mark_local(what: object) -> None:
    """Frames, tools and points in a value or container end with their program."""
    if isinstance(what, FrameV | ToolV | PointV):
        what.local = True
    elif isinstance(what, UserV):
        what.local = True
        for name in what.names():
            mark_local(getattr(what, name))
    elif isinstance(what, list | dict | Grid):
        if isinstance(what, Collection):
            what.local = True
        for each in what.flat if isinstance(what, Grid) else what.values() if isinstance(what, dict) else what:
            mark_local(each)


def may_hang(what: FrameV | ToolV | PointV, father: FrameV | ToolV | None) -> None:
    """Checks a reference; 165: what lives longer than its program cannot hang on a local frame or tool."""
    if father is not None and father.local and not what.local:
        raise Rte(165, "linked to a local variable")


def is_local(container: object) -> bool:
    """Whether what a container holds ends with its program."""
    if isinstance(container, list | Grid):
        flat = container.flat if isinstance(container, Grid) else container
        return bool(flat) and bool(getattr(flat[0], "local", False))
    return isinstance(container, Collection) and container.local


def grown(container: object, make: Callable[[], object]) -> Callable[[], object]:
    """Makes values that live as long as those that are there."""
    return (lambda: passed(make())) if is_local(container) else make


def copy_container(container: object) -> Container:
    """Deep."""
    if isinstance(container, dict):
        return Collection({key: copied(value) for key, value in container.items()})
    if isinstance(container, Grid):
        return Grid(container.dims, [copied(value) for value in container.flat])
    assert isinstance(container, list)
    return [copied(value) for value in container]


def replace_container(mine: object, other: object) -> None:
    """The values of another container; structures that are there stay the same objects.  165: a reference to what ends before it."""
    if isinstance(mine, dict) and isinstance(other, dict):
        local = is_local(mine)
        taken = {key: _kept(mine.get(key), value, local) for key, value in other.items()}
        mine.clear()
        mine.update(taken)
    elif isinstance(mine, Grid) and isinstance(other, Grid):
        mine.dims = other.dims
        replace_container(mine.flat, other.flat)
    elif isinstance(mine, list) and isinstance(other, list):
        old, local = list(mine), is_local(mine)
        mine[:] = [_kept(old[at] if at < len(old) else None, value, local) for at, value in enumerate(other)]


def _kept(mine: object, value: object, local: bool) -> object:
    if not isinstance(value, Structure):
        return value
    if mine is value:
        return mine
    taken = mine if isinstance(mine, Structure) else passed(value) if local else copied(value)
    if isinstance(taken, FrameV | ToolV | PointV) and isinstance(value, FrameV | ToolV | PointV):
        may_hang(taken, value.father)
    if taken is mine and isinstance(mine, Structure):
        mine.set(value)
    elif isinstance(taken, UserV):
        _judge(taken)
    return taken


def _judge(value: UserV) -> None:
    """165 for a reference of a new value to what ends before it."""
    for name in value.names():
        container = getattr(value, name)
        for each in container.flat if isinstance(container, Grid) else container.values() if isinstance(container, dict) else container:
            if isinstance(each, UserV):
                _judge(each)
            elif isinstance(each, FrameV | ToolV | PointV):
                may_hang(each, each.father)
