"""Motion parameters as they are at each position, displacement, and the faults of a path.  Source: robotstar 2.4, 3.2-3.9.

mm, mm/s, %, s, degrees: the manual's units.  Every value is taken step by step, so a program may change any of them in between.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from gateway.pure.languages.robotstar.faults import StepFault, path_fault
from motion.paths.arc import FLAT, NEAR_M
from motion.paths.base import cross, norm, sub

CARTESIAN = ("X", "Y", "Z", "A", "B", "C")
CIRCLES = ("ZIRK_MIN_ORI", "ZIRK_BAHN_ORI")
RS_POS_EPS, RS_ORI_EPS = 0.01, 0.1  # mm, degrees (L2019-2033)
NOMINAL_SPEED, NOMINAL_TURN = 1000.0, 100.0  # mm/s, degrees/s: 100 % of PTP in a virtual run (AX-757)
NOMINAL_ACCEL, NOMINAL_TURN_ACCEL = 2000.0, 200.0
ACC_MAX = 2000.0  # mm/s2: _RACC_MAX


@dataclass(frozen=True, slots=True)
class Target:
    """A position: X..C with a frame, or axes alone (then `pose` is empty).  `axes`: A1.. by name."""

    pose: tuple[float, ...] = ()
    frame: int = 0
    axes: Mapping[str, float] = field(default_factory=dict)

    def values(self) -> dict[str, float | int]:
        """As `run --json` prints it."""
        found: dict[str, float | int] = {name: _plain(value) for name, value in zip(CARTESIAN, self.pose, strict=False)}
        if self.frame:
            found["Frame"] = self.frame
        return found | {name: _plain(value) for name, value in self.axes.items()}

    def moved(self, shift: "Target") -> "Target":
        """With another's values added, number by number; only axes this position has."""
        pose = tuple(a + b for a, b in zip(self.pose, shift.pose or (0.0,) * 6, strict=True)) if self.pose else ()
        return Target(pose, self.frame, {name: value + shift.axes.get(name, 0.0) for name, value in self.axes.items()})


def _plain(value: float) -> float:
    return round(value, 6) + 0.0


@dataclass(frozen=True, slots=True)
class Defaults:
    """Pre-allocation at system start (L2043-2067), by the name of the parameter."""

    values: Mapping[str, float] = field(
        default_factory=lambda: {
            "MOVE_MODE": 0, "FLYBY": 0, "PATH_SPEED": 10.0, "PATH_ACCEL": 50, "PTP_SPEED": 20, "PTP_ACCEL": 50,
            "PATH_RADIUS": 1.0, "PATH_DISTANCE": 0.0, "PATH_TIME": 0.0, "_IV_FLYBY_S": 100, "_IV_FLYBY_O": 0, "_IV_CIRCHP_O": 100,
            "_ISPL_TENS": 100, "_IORI_TENS": 100, "_IORI_WEIGHT": 100, "_IORI_CIRCHP": 100, "_IACC_TIME": 25,
        }
    )  # fmt: skip


LEAST = 1e-6
RANGES: Mapping[str, tuple[float, float]] = {
    **dict.fromkeys(("_IV_FLYBY_S", "_IV_FLYBY_O", "_IV_CIRCHP_O", "_ISPL_TENS", "_IORI_TENS", "_IORI_WEIGHT", "_IORI_CIRCHP"), (0, 100)),
    "_IACC_TIME": (0, 50),
    **dict.fromkeys(("PTP_SPEED", "PTP_ACCEL", "PATH_ACCEL"), (LEAST, 100)),
    "PATH_SPEED": (LEAST, 1e6),
    **dict.fromkeys(("PATH_TIME", "PATH_RADIUS", "PATH_DISTANCE"), (0, 1e6)),
    "MOVE_MODE": (0, 4),
    "FLYBY": (0, 1),
}
MODES = ("PTP", "LINEAR", "SPLINE", "ZIRK_MIN_ORI", "ZIRK_BAHN_ORI")


def outside(name: str, value: float, low: float, high: float) -> str:
    """The fault of a value outside its range; a low end of 1e-6 means above 0."""
    if low == LEAST and not 0 < value < LEAST:
        return f"{name} {value:.10g} must be above 0 and at most {high:.10g}"
    return f"{name} {value:.10g} is outside {low:.10g} .. {high:.10g}"


@dataclass(slots=True)
class PathState:
    """Parameters in force, displacement, and the state after the last position."""

    defaults: Defaults = field(default_factory=Defaults)
    values: dict[str, float] = field(default_factory=dict)
    mode: str = "PTP"
    shift: Target = field(default_factory=Target)  # RELATIVE
    pallet: Target = field(default_factory=Target)  # PALLET #ON
    relation: object = None  # the vector of CALC_REL that waits for its position
    auxiliary: bool = False  # a circle's auxiliary point has been given, its end is missing
    arc: tuple[Target, Target] = (Target(), Target())  # start and auxiliary point of that circle
    weight: float = 100.0  # of the orientation at the last position
    rounded: bool = False  # the last position is approximated

    def __post_init__(self) -> None:
        self.values = dict(self.defaults.values)
        self.mode = MODES[int(self.values["MOVE_MODE"])]

    def set(self, name: str, value: float) -> None:
        """A parameter; StepFault outside its range."""
        low, high = RANGES[name]
        if not low <= value <= high:
            raise StepFault(outside(name, value, low, high))
        self.values[name] = value

    def set_mode(self, mode: str) -> None:
        """MOVE_MODE; a circle must be complete (L310)."""
        if mode != self.mode and self.auxiliary:
            raise StepFault(circle_open(mode), 0, "path")
        self.mode = mode

    def shifted(self, target: Target) -> Target:
        """With RELATIVE and the pallet's offset."""
        return target.moved(self.shift).moved(self.pallet)

    def accept(self, target: Target, actual: Target, approximates: bool) -> float:
        """Accept the next position; return its duration in seconds.  Raise StepFault with the number of a path error."""
        way, turn = _ways(actual, target)
        circle = self.mode in CIRCLES
        if self.mode == "PTP":
            seconds = self._ptp_seconds(actual, target)
        else:
            seconds = self._path_seconds(way, turn)
            self._check(way, turn, approximates)
        if circle:
            self._check_circle(target)
        self._check_weight(circle)
        self.auxiliary = circle and not self.auxiliary
        if self.auxiliary:
            self.arc = actual, target
        self.rounded = approximates and self.values["FLYBY"] == 1 and self.mode not in ("PTP", "SPLINE")
        self.values["PATH_TIME"], self.values["_IORI_WEIGHT"] = 0.0, 100
        return seconds

    def _ptp_seconds(self, actual: Target, target: Target) -> float:
        """The slowest of all ways, each with trapezoidal speed."""
        speed, accel = self.values["PTP_SPEED"] / 100, self.values["PTP_ACCEL"] / 100
        way, turn = _ways(actual, target)
        axes = max((abs(value - actual.axes.get(name, 0.0)) for name, value in target.axes.items()), default=0.0)
        return max(
            ramped(way, NOMINAL_SPEED * speed, NOMINAL_ACCEL * accel),
            ramped(max(turn, axes), NOMINAL_TURN * speed, NOMINAL_TURN_ACCEL * accel),
        )

    def _path_seconds(self, way: float, turn: float) -> float:
        if self.values["PATH_TIME"]:
            return self.values["PATH_TIME"]
        del turn
        return ramped(way, self.values["PATH_SPEED"], ACC_MAX * self.values["PATH_ACCEL"] / 100)

    def _check(self, way: float, turn: float, approximates: bool) -> None:
        moves, turns = way > RS_POS_EPS, turn > RS_ORI_EPS
        if approximates and self.values["FLYBY"] == 1 and self.mode != "SPLINE":
            if not moves and not turns:
                raise path_fault(620, "approximation together with a path zero step")
            if not moves:
                raise path_fault(621, "approximation together with a path without distance")
            if not self.values["PATH_RADIUS"] and not self.values["PATH_DISTANCE"]:
                raise path_fault(102, "BAHN_RADIUS and BAHN_DISTANZ are both 0 mm with activated approximation")
        if not moves and turns and not self.values["PATH_TIME"]:
            if self.rounded:
                raise path_fault(625, "BAHN_ZEIT of the following path is missing: only the orientation moves")
            raise path_fault(622, "BAHN_ZEIT is missing: only the orientation moves")
        if self.rounded and not moves:
            text = "only the orientation moves" if turns else "there is no distance"
            raise path_fault(624 if turns else 623, f"approximation to a following path where {text}")

    def _check_circle(self, target: Target) -> None:
        """A circle goes through three positions of the tool; a start whose axes alone are known is the planner's matter."""
        start, via = self.arc
        if not target.pose:
            raise StepFault(
                f"circle: {'the end' if self.auxiliary else 'an auxiliary'} point is a position of the tool, not of the axes", 0, "path"
            )
        if self.auxiliary and start.pose and via.pose and (wrong := no_circle(start.pose, via.pose, target.pose)):
            raise StepFault(wrong, 0, "path")

    def _check_weight(self, circle: bool) -> None:
        """Path error 903; the weight of an auxiliary point is _IORI_CIRCHP."""
        if self.mode == "PTP":
            self.weight = 100
            return
        weight = self.values["_IORI_CIRCHP" if circle and not self.auxiliary else "_IORI_WEIGHT"]
        if self.weight != 100 and weight != 100:
            raise path_fault(903, "weighted orientation for two successive points")
        self.weight = weight


def circle_open(mode: str) -> str:
    """Return the fault of another mode before a circle's end (L310)."""
    return f"circle without its end point before #{mode}: an even number of positions is needed"


def no_circle(start: Sequence[float], via: Sequence[float], end: Sequence[float]) -> str:
    """Why three points make no circle, "" where they do.  X Y Z in mm."""
    points = {"start": start[:3], "auxiliary": via[:3], "end": end[:3]}
    for one, other in (("start", "auxiliary"), ("auxiliary", "end"), ("start", "end")):
        if not math.dist(points[one], points[other]) >= NEAR_M * 1000:
            return f"circle: {one} and {other} point are the same"
    begin, middle, last = ((point[0], point[1], point[2]) for point in points.values())
    first, second = sub(middle, begin), sub(last, begin)
    flat = norm(cross(first, second)) < FLAT * norm(first) * norm(second)
    return "circle: start, auxiliary and end point lie on a straight line" if flat else ""


def ramped(way: float, speed: float, accel: float) -> float:
    """Seconds of a way with trapezoidal speed from rest to rest."""
    if way <= 0:
        return 0.0
    if way * accel < speed * speed:
        return 2 * math.sqrt(way / accel)
    return way / speed + speed / accel


def _ways(start: Target, end: Target) -> tuple[float, float]:
    """Distance of the tool, and its largest change of an angle; between axes and pose all counts as turning."""
    if start.pose and end.pose:
        turn = max(abs((b - a + 180) % 360 - 180) for a, b in zip(start.pose[3:], end.pose[3:], strict=True))
        return math.dist(start.pose[:3], end.pose[:3]), turn
    if not start.pose and not end.pose:
        changes = [abs(value - start.axes.get(name, 0.0)) for name, value in end.axes.items()]
        return 0.0, max(changes, default=0.0)
    return 100.0, 0.0


def between(start: Target, end: Target, part: float) -> Target:
    """A point on the way."""
    if start.pose and end.pose:
        return replace(end, pose=tuple(a + part * (b - a) for a, b in zip(start.pose, end.pose, strict=True)))
    return start if part < 1 else end
