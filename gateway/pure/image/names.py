"""The names a data-block entry, a contact or a Modbus register may use, and the kind of value of each.

One row a name; AXIS is the name of an axis or `*` (all axes: a bit is 1 when it is 1 on every axis), LINE for a line,
ROBOT for a robot.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum, auto


class Kind(Enum):
    """What a name's value is."""

    BIT = auto()
    NUMBER = auto()  # a number without a unit of its own: counters, codes
    PERCENT = auto()
    WAY = auto()  # in the unit of the axis


@dataclass(frozen=True, slots=True)
class Name:
    """One name with its kind; `to`: a partner may write it; `from_`: a partner may read it."""

    pattern: str
    kind: Kind
    to: bool = False
    from_: bool = False


NAMES = (
    Name("drives.on", Kind.BIT, to=True),
    Name("cell.feed_allow", Kind.BIT, to=True),
    Name("cell.feed_hold_not", Kind.BIT, to=True),
    Name("cell.control_allow", Kind.BIT, to=True),
    Name("cell.travel_allow", Kind.BIT, to=True),
    Name("cell.emergency_stop_ok", Kind.BIT, to=True),
    Name("cell.safety_ok", Kind.BIT, to=True),
    Name("cell.reset", Kind.BIT, to=True),
    Name("cell.stop", Kind.BIT, to=True),
    Name("cell.resume", Kind.BIT, to=True),
    Name("cell.override", Kind.PERCENT, to=True, from_=True),
    Name("robot.ROBOT.override", Kind.PERCENT, to=True, from_=True),
    Name("axis.AXIS.reference", Kind.BIT, to=True),
    Name("move.start", Kind.BIT, to=True),
    Name("move.number", Kind.NUMBER, to=True),
    Name("move.parity", Kind.BIT, to=True),
    Name("move.AXIS.target", Kind.WAY, to=True),
    Name("move.speed", Kind.PERCENT, to=True),
    Name("line.LINE.life", Kind.NUMBER, to=True),
    Name("cell.ready", Kind.BIT, from_=True),
    Name("cell.drives_on", Kind.BIT, from_=True),
    Name("cell.control", Kind.BIT, from_=True),
    Name("cell.error", Kind.BIT, from_=True),
    Name("cell.emergency_stop", Kind.BIT, from_=True),
    Name("cell.life", Kind.NUMBER, from_=True),
    Name("axis.AXIS.referenced", Kind.BIT, from_=True),
    Name("axis.AXIS.in_position", Kind.BIT, from_=True),
    Name("axis.AXIS.enabled", Kind.BIT, from_=True),
    Name("axis.AXIS.fault", Kind.BIT, from_=True),
    Name("axis.AXIS.actual", Kind.WAY, from_=True),
    Name("axis.AXIS.lag", Kind.WAY, from_=True),
    Name("move.busy", Kind.BIT, from_=True),
    Name("move.done", Kind.BIT, from_=True),
    Name("move.refused", Kind.BIT, from_=True),
    Name("error.first.code", Kind.NUMBER, from_=True),
)
PLACES = {"AXIS": "axis", "LINE": "line", "ROBOT": "robot"}


@dataclass(frozen=True, slots=True)
class Found:
    """A name that fits: its row, and which axis, line or robot it speaks of ("" for none, "*" for all axes)."""

    name: Name
    which: str = ""

    @property
    def kind(self) -> str:
        """Tables of the cell file that `which` is one of: axis, line or robot."""
        return next((table for place, table in PLACES.items() if place in self.name.pattern), "axis")


def lookup(text: str) -> Found | None:
    """The row `text` fits; whether the axis, line or robot exists is the caller's question."""
    parts = text.split(".")
    for name in NAMES:
        pattern = name.pattern.split(".")
        if len(pattern) == len(parts) and all(want in (have, *PLACES) for want, have in zip(pattern, parts, strict=True)):
            which = "".join(have for want, have in zip(pattern, parts, strict=True) if want in PLACES)
            return Found(name, which)
    return None


def spelled(axes: Iterable[str], lines: Iterable[str], robots: Iterable[str] = ()) -> list[str]:
    """Every name with the axes, lines and robots of a cell put in: what a hint may suggest."""
    axis_names, line_names, robot_names = [*axes, "*"], list(lines), list(robots)
    names: list[str] = []
    for name in NAMES:
        if "AXIS" in name.pattern:
            names += [name.pattern.replace("AXIS", axis) for axis in axis_names]
        elif "LINE" in name.pattern:
            names += [name.pattern.replace("LINE", line) for line in line_names]
        elif "ROBOT" in name.pattern:
            names += [name.pattern.replace("ROBOT", robot) for robot in robot_names]
        else:
            names.append(name.pattern)
    return names
