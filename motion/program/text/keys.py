"""The keys of the text form: name, unit, range, where its value goes.  One table for reading, writing and the guide."""

import math
from dataclasses import dataclass
from enum import Enum

from motion.program.blocks import Blend, Block, Curving, Pace, Rounding, Shape, Slope, Turning


@dataclass(frozen=True, slots=True)
class Key:
    """A number: outside unit, range outside (both ends legal), factor to SI, part of the block and its field."""

    name: str
    unit: str
    low: float
    high: float
    si: float
    part: str
    field: str
    says: str


@dataclass(frozen=True, slots=True)
class Choice:
    """One of some words."""

    name: str
    words: type[Enum]
    part: str
    field: str
    says: str


DEG = math.pi / 180
BIG = 1e6
_PERCENT = (0.01, 500.0, 0.01)
KEYS = (
    Key("speed", "%", *_PERCENT, "pace", "speed", "axis speeds, share of each limit"),
    Key("accel", "%", *_PERCENT, "pace", "accel", "axis accelerations, speeding up"),
    Key("decel", "%", *_PERCENT, "pace", "decel", "axis accelerations, slowing down"),
    Key("path", "mm/s", 1e-3, BIG, 1e-3, "pace", "path_speed", "speed of the tool centre point; ptp: at most"),
    Key("turn", "deg/s", 1e-3, BIG, DEG, "pace", "turn_speed", "speed of turning of the tool; ptp: at most"),
    Key("pathaccel", "mm/s2", 1e-3, 1e9, 1e-3, "pace", "path_accel", "acceleration along the path; not of ptp"),
    Key("pathdecel", "mm/s2", 1e-3, 1e9, 1e-3, "pace", "path_decel", "deceleration along the path; not of ptp"),
    Key("time", "s", 1e-3, BIG, 1.0, "pace", "time", "time of the complete block, takes precedence over speeds"),
    Key("ramp", "%", 0.0, 50.0, 0.01, "pace", "ramp", "share of `time` for each ramp"),
    Key("leave", "mm", 0.0, BIG, 1e-3, "blend", "leave", "distance before the end point at which the corner begins"),
    Key("reach", "mm", 0.0, BIG, 1e-3, "blend", "reach", "distance after the end point at which the corner ends"),
    Key(
        "distance",
        "mm",
        0.0,
        BIG,
        1e-3,
        "blend",
        "distance",
        "the corner misses the end point by this distance; takes precedence over leave and reach",
    ),
    Key(
        "share",
        "%",
        1.0,
        99.9,
        0.01,
        "blend",
        "share",
        "the largest part of a block that a corner may take; above 50 if its other end has none",
    ),
    Key("flyby", "%", 0.0, 100.0, 0.01, "blend", "flyby", "speed in the middle of the corner, share of the mean of both"),
    Key("angle", "deg", 0.01, BIG, DEG, "", "angle", "circular: angle to travel on the circle through both points; 360 is a full circle"),
    Key("rise", "mm", -BIG, BIG, 1e-3, "", "rise", "with angle: along the axis of the circle over the whole angle, a helix"),
    Key("tension", "%", 0.0, 100.0, 0.01, "curving", "tension", "spline: 0 straight with corners, 100 full swing"),
    Key("tube", "mm", 0.0, BIG, 1e-3, "curving", "tube", "spline: largest deviation from the straight line to the point; 0: no limit"),
    Key("oritension", "%", 0.0, 100.0, 0.01, "curving", "orientation_tension", "the same for the orientation"),
    Key("weight", "%", 0.0, 100.0, 0.01, "curving", "weight", "how far the orientation of the target counts"),
    Key("viaweight", "%", 0.0, 100.0, 0.01, "curving", "via_weight", "how far the orientation of `via` counts"),
)
CHOICES = (
    Choice("blend", Rounding, "blend", "rounding", "how the end point is blended"),
    Choice("turning", Turning, "", "turning", "orientation along an arc"),
    Choice("slope", Slope, "", "slope", "one speed over all blocks, or ramps of each block added"),
    Choice("shape", Shape, "", "shape", "ramps: as set for the robot, jerk-limited, or a sine square"),
)
OTHERS = {
    "radius": "mm: leave and reach together",
    "arcs": "yes or no: points next to an arc are rounded, too",
    "lead": "yes or no: speed is that of the axis with the longest way",
    "zone": "one distance for each axis: passing of a PTP point by the axis criterion",
    "tool": "name of a `tool` line, or - for none",
    "frame": "name of a `frame` line, or - for none",
    "mirror": "xy, yz or xz: poses are mirrored across this plane of the block's frame, SF 17; - for none",
    "limitmin": "x,y,z mm: working range of the tool in the block's frame, LIMIT_MIN; - for none",
    "limitmax": "x,y,z mm: its other end, LIMIT_MAX; - for none",
    "config": "righty,epositive,wnegative ..: demanded configuration",
    "extra": "values of additional axes with their unit: 100mm,30deg",
    "out": "NUMBER:VALUE or NUMBER:VALUE@MM, with commas: outputs at the end or so far before it",
    "belt": "in a synchronous part: value of the belt at the end of the block, with its unit: 150mm",
    "camin": "type 3: first section, the belt path A with its unit: 30mm",
    "camout": "type 3: last section, the belt path D with its unit: 70mm",
    "freeze": "yes, in an alterable part: from the end of this block on the correction stays as it is",
    "until": "NUMBER or !NUMBER: the block ends when this input is 1 (0); ch610, !ch611: a measuring input; ch710: runs on after it",
    "within": "s: the block of until= ends after this time of movement, even without the input",
    "error": "label where the program continues when the input of until= never occurred, "
    "or nothing was measured (mpos) or stored (recorded)",
    "wait": "NUMBER, !NUMBER, ch611: the block begins when this input is 1 (0): fast start-off",
    "delay": "s: time from the input of wait= to the begin of the block",
}
NUMBERS = {key.name: key for key in KEYS}
WORDS = {choice.name: choice for choice in CHOICES}
NAMES = (*NUMBERS, *WORDS, *OTHERS)
DEFAULT: dict[str, Pace | Blend | Curving] = {"pace": Pace(), "blend": Blend(), "curving": Curving()}


def part_of(block: Block, part: str) -> object:
    """The block itself or one of its parts."""
    return getattr(block, part) if part else block
