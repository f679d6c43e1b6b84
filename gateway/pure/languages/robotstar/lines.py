"""A position of ROBOTstar as a line of the text form for the planner, with its parameters as they are at its step.  Source: robotstar 3."""

import math
from collections.abc import Mapping, Sequence

from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.machine import Go
from gateway.pure.languages.robotstar.path import ACC_MAX, CIRCLES
from motion.program.reis import MachineData

WORDS = {"PTP": "ptp", "LINEAR": "linear", "SPLINE": "spline"}
TURNING = {"ZIRK_MIN_ORI": "least", "ZIRK_BAHN_ORI": "path"}
SHARE = MachineData().RAPPR_FACT_MAX * 100
LEAST, MOST = 0.01, 500.0  # % of a speed, as the text form accepts it
Point = Sequence[float]


def head(units: Sequence[str]) -> list[str]:
    """Statements before the positions."""
    return ["angles reis", f"axes {' '.join(units)}"]


def tool_line(name: str, values: Sequence[float]) -> str:
    """A tool by name."""
    return f"tool {name} {' '.join(f'{value:.10g}' for value in values)}"


def line(go: Go, target: str, tool: str, through: str = "", weight: float = 100.0) -> str:
    """The block.  target, through: positions in the text form, `through` of a circle's auxiliary point with the weight of its
    orientation."""
    settings = go.settings
    place, _, extra = target.partition(" extra=")
    if go.mode in CIRCLES:
        where = f"circular via {through.partition(' extra=')[0]} to {place}"
    else:
        where = f"{WORDS[go.mode]} {place}"
    words = [where, f"tool={tool}", *([f"extra={extra}"] if extra else []), *_speeds(go.mode, settings), *_passed(go)]
    if go.mode in CIRCLES:
        words += [f"turning={TURNING[go.mode]}", f"viaweight={weight:g}"]
    if go.mode == "SPLINE":
        words.append(f"tension={settings['_ISPL_TENS']:g}")
    if go.mode != "PTP":
        words += [f"oritension={settings['_IORI_TENS']:g}", f"weight={settings['_IORI_WEIGHT']:g}"]
    return " ".join(words)


def _speeds(mode: str, settings: Mapping[str, float]) -> list[str]:
    """PTP in shares of what the axes can, led by the one with the longest way; paths in mm/s or by their time."""
    if mode == "PTP":
        share = f"{min(max(settings['PTP_ACCEL'], LEAST), MOST):.10g}"
        return [f"speed={min(max(settings['PTP_SPEED'], LEAST), MOST):.10g}", f"accel={share}", f"decel={share}", "lead=yes"]
    accel = ACC_MAX * settings["PATH_ACCEL"] / 100
    found = [f"pathaccel={accel:.10g}", f"pathdecel={accel:.10g}"]
    if settings["PATH_TIME"]:
        return [*found, f"time={max(settings['PATH_TIME'], 1e-3):.10g}", f"ramp={settings['_IACC_TIME']:g}"]
    return [*found, f"path={max(settings['PATH_SPEED'], 1e-3):.10g}"]


def _passed(go: Go) -> list[str]:
    """The sphere around a point that is approximated, or the distance that wins over it."""
    radius, distance = go.settings["PATH_RADIUS"], go.settings["PATH_DISTANCE"]
    if not go.approximates or not (radius or distance):
        return []
    return [f"radius={radius:.10g}", f"distance={distance:.10g}", f"share={SHARE:g}", f"flyby={go.settings['_IV_FLYBY_S']:g}", "arcs=yes"]


def rest_of_circle(start: Point, via: Point, end: Point, here: Point) -> tuple[float, ...]:
    """Return the via point of the remainder of an arc left at `here`: the auxiliary point if that is still ahead, else the middle of the
    remainder.  X Y Z in mm; StepFault where the points make no circle.
    """
    start, via, end, here = (tuple(point[:3]) for point in (start, via, end, here))
    centre, normal = _centre(start, via, end)
    at, middle, last = _angles(start, via, end, here)
    if at > 2 * math.pi - 1e-3:
        at = 0.0
    if at < middle:
        return tuple(via)
    half = (at + last) / 2 if last > at else at
    out = _minus(start, centre)
    side = _cross(normal, out)
    return tuple(c + math.cos(half) * a + math.sin(half) * b for c, a, b in zip(centre, out, side, strict=True))


def past_via(start: Point, via: Point, end: Point, here: Point) -> bool:
    """Return whether `here` is past the auxiliary point of an arc.  X Y Z in mm; StepFault where the points make no circle."""
    at, middle, last = _angles(*(tuple(point[:3]) for point in (start, via, end, here)))
    return middle <= at < last + (2 * math.pi - last) / 2  # a point nearer to the start has not left it yet


def arc_length(start: Point, via: Point, end: Point) -> float:
    """mm of an arc.  X Y Z in mm; StepFault where the points make no circle."""
    start, via, end = (tuple(point[:3]) for point in (start, via, end))
    return math.dist(start, _centre(start, via, end)[0]) * _angles(start, via, end, end)[2]


def _angles(start: Point, via: Point, end: Point, here: Point) -> tuple[float, float, float]:
    """How far `here`, via and end are turned from the start, 0 .. 2 pi."""
    centre, normal = _centre(start, via, end)
    one = _minus(start, centre)

    def angle(point: Point) -> float:
        other = _minus(point, centre)
        return math.atan2(_dot(_cross(one, other), normal), _dot(one, other)) % (2 * math.pi)

    return angle(here), angle(via), angle(end)


def _minus(one: Point, other: Point) -> tuple[float, float, float]:
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]


def _dot(one: Point, other: Point) -> float:
    return sum(a * b for a, b in zip(one, other, strict=True))


def _cross(one: Point, other: Point) -> tuple[float, float, float]:
    return one[1] * other[2] - one[2] * other[1], one[2] * other[0] - one[0] * other[2], one[0] * other[1] - one[1] * other[0]


def _centre(start: Point, via: Point, end: Point) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Centre and normal; the arc runs round the normal in the positive sense."""
    one, other = _minus(via, start), _minus(end, start)
    across = _cross(one, other)
    square = _dot(across, across)
    if square < 1e-9:
        raise StepFault("circle: start, auxiliary and end point lie on a straight line", 0, "path")
    first, second = _cross(across, one), _cross(other, across)
    centre = tuple(s + (_dot(other, other) * a + _dot(one, one) * b) / (2 * square) for s, a, b in zip(start, first, second, strict=True))
    length = math.sqrt(square)
    return (centre[0], centre[1], centre[2]), (across[0] / length, across[1] / length, across[2] / length)
