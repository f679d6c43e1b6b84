"""Path parameters of the Reis ROBOTstar V: defaults, ranges, what is modal, and the faults of a path program.

Source: ROBOTstar V, part "Parameters of the path control": commands L1686-1788, system variables L1792-1956, machine data
L1962-2041, defaults L2043-2067, path errors L4753-4770; circle rules L308-338.  Values are the manual's (mm, mm/s, %, s, deg);
`Path.blocks` turns them into SI.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import Enum
from itertools import pairwise

from motion.errors import MotionError
from motion.geometry.orientation import angle_between
from motion.program.blocks import (
    Blend,
    Block,
    Curving,
    Frame,
    Interpolation,
    JointTarget,
    Pace,
    PoseTarget,
    Rounding,
    Target,
    Tool,
    Turning,
    changed,
)
from motion.program.errors import BlockError

SOURCE = "Reis path error"
MACHINE_DATA_RANGE = 650  # "machine data exceeds value range" (L4702)


class Mode(Enum):
    """BEWEG_ART; value: the number the default variable _IDEF_MOVMOD would hold, in the manual's order (0 = #PTP)."""

    PTP, LINEAR, SPLINE, ZIRK_MIN_ORI, ZIRK_BAHN_ORI = range(5)


CIRCLES = (Mode.ZIRK_MIN_ORI, Mode.ZIRK_BAHN_ORI)


@dataclass(frozen=True, slots=True)
class Parameters:
    """One set; its defaults are the pre-allocation at system start (L2043-2067)."""

    BEWEG_ART: Mode = Mode.PTP
    UEBERSCHL: bool = False
    BAHN_GESCHW: float = 10.0  # mm/s
    BAHN_BESCHL: float = 50  # % of _RACC_MAX
    PTP_GESCHW: float = 20  # % of RAXES_NOM_SPEED
    PTP_BESCHL: float = 50  # % of RAXES_NOM_ACCEL
    BAHN_RADIUS: float = 1.0  # mm
    BAHN_DISTANZ: float = 0.0  # mm; > 0 overrides the radius
    BAHN_ZEIT: float = 0.0  # s; not modal
    IV_FLYBY_S: float = 100
    IV_FLYBY_O: float = 0
    IV_CIRCHP_O: float = 100
    ISPL_TENS: float = 100
    IORI_TENS: float = 100
    IORI_WEIGHT: float = 100  # not modal
    IORI_CIRCHP: float = 100
    IACC_TIME: float = 25


DEFAULTS = Parameters()
NOT_MODAL = {"BAHN_ZEIT": 0.0, "IORI_WEIGHT": 100}  # value they fall back to after one position (L1752, L1908-1926)
PERCENT = ("IV_FLYBY_S", "IV_FLYBY_O", "IV_CIRCHP_O", "ISPL_TENS", "IORI_TENS", "IORI_WEIGHT", "IORI_CIRCHP")
RANGES: dict[str, tuple[float, float]] = dict.fromkeys(PERCENT, (0, 100))
RANGES |= {"IACC_TIME": (0, 50), "BAHN_RADIUS": (0, math.inf), "BAHN_DISTANZ": (0, math.inf), "BAHN_ZEIT": (0, math.inf)}
RANGES |= {"BAHN_GESCHW": (1e-6, math.inf), "BAHN_BESCHL": (1e-6, 100), "PTP_GESCHW": (1e-6, 100), "PTP_BESCHL": (1e-6, 100)}


@dataclass(frozen=True, slots=True)
class MachineData:
    """Constants of the spline mathematics and of zero steps (L1962-2041); a value outside its range raises number 650."""

    RSPOS_APPROX_QUAL: float = 1e-6  # mm
    RSORI_APPROX_QUAL: float = 1e-5  # deg
    RDELTA_OV_MAX: float = 0.1
    RAPPR_FACT_MAX: float = 0.4
    RSYNC_WEIGHT: float = 1.0
    RSMOOTH_WEIGHT: float = 0.5
    RSYNC_MIN_PHASE: float = 0.1
    RTIME_EPS: float = 0.001  # s
    RS_POS_EPS: float = 0.01  # mm
    RS_ORI_EPS: float = 0.1  # deg
    RS_AX_EPS: float = 0.001  # deg
    RACC_MAX: float = 2000.0  # mm/s2

    def __post_init__(self) -> None:
        for entry in fields(self):
            check_machine_data(entry.name, getattr(self, entry.name))


# name -> (lower, lower belongs to it, upper, upper belongs to it)
_OPEN = (0.0, False, math.inf, False)
_DATA_RANGES: Mapping[str, tuple[float, bool, float, bool]] = {
    "RDELTA_OV_MAX": (0.0, False, 1.0, True),
    "RAPPR_FACT_MAX": (0.0, False, 0.5, False),
    "RSYNC_WEIGHT": (0.0, True, 1.0, True),
    "RSMOOTH_WEIGHT": (0.0, True, 1.0, True),
    "RSYNC_MIN_PHASE": (0.0, True, 0.5, True),
}


def check_machine_data(name: str, value: float) -> None:
    """Raises BlockError 650 for a machine datum outside its range."""
    low, with_low, high, with_high = _DATA_RANGES.get(name, _OPEN)
    if not ((low <= value if with_low else low < value) and (value <= high if with_high else value < high)):  # a NaN fails, too
        sides = f"{low:g} {'<=' if with_low else '<'} x {'<=' if with_high else '<'} {high:g}"
        raise BlockError(f"machine data exceeds value range: {name} = {value:g}, {sides}", code=MACHINE_DATA_RANGE, source="Reis")


class Path:
    """Commands of a Reis program in their order, blocks out.  Faults the text alone shows are raised where they are written;
    those that need the points are raised by blocks()."""

    def __init__(self, start: Target, data: MachineData = MachineData(), defaults: Parameters = DEFAULTS, tool: Tool | None = None) -> None:
        self._start, self._data, self._set, self._tool = start, data, defaults, tool or Tool()
        self._points: list[tuple[Target, Parameters]] = []
        self._auxiliary: Target | None = None  # first of two circle positions

    def standing(self) -> Parameters:
        """As they stand now."""
        return self._set

    def set(self, name: str, value: float | bool | Mode) -> None:
        """A command or KOPIERE into a system variable; raises MotionError for a value outside its range."""
        if name == "BEWEG_ART":
            self._mode_changes(value)
        elif name in RANGES:
            low, high = RANGES[name]
            if not low <= float(value if not isinstance(value, Mode) else math.nan) <= high:
                raise MotionError(f"{name} {value} is outside {low:g} .. {high:g}")
        self._set = changed(self._set, name, value)

    def position(self, target: Target) -> None:
        """POSITION: the next point with the parameters as they stand."""
        self._points.append((target, self._set))
        if self._set.BEWEG_ART in CIRCLES:
            self._auxiliary = target if self._auxiliary is None else None
        for name, fallen_back in NOT_MODAL.items():
            self._set = changed(self._set, name, fallen_back)

    def blocks(self) -> tuple[Block, ...]:
        """All blocks, or BlockError with the path error's number and the block."""
        self._even_circle(self._set.BEWEG_ART.name)
        made: list[Block] = []
        aux: tuple[Target, Parameters] | None = None
        for target, setting in self._points:
            if setting.BEWEG_ART in CIRCLES and aux is None:
                aux = (target, setting)
                continue
            made.append(self._block(target, setting, aux))
            aux = None
        settings = [setting for n, (_, setting) in enumerate(self._points) if not self._is_auxiliary(n)]
        self._check_orientation_weights()
        check_path(made, settings, self._start, self._data)
        return tuple(made)

    # ---- inside ------------------------------------------------------------------------------------------------------
    def _mode_changes(self, value: float | bool | Mode) -> None:
        if not isinstance(value, Mode):
            raise MotionError(f"BEWEG_ART {value}: one of {', '.join(mode.name for mode in Mode)}")
        if value is not self._set.BEWEG_ART:
            self._even_circle(value.name)

    def _even_circle(self, following: str) -> None:
        if self._auxiliary is not None:
            count = sum(1 for _, setting in self._points if setting.BEWEG_ART in CIRCLES)
            raise BlockError(
                f"{count} positions in circle mode before {following}: after an auxiliary point its end point is missing (L310)",
                block=len(self._points),
            )

    def _is_auxiliary(self, index: int) -> bool:
        first = index
        while first > 0 and self._points[first - 1][1].BEWEG_ART in CIRCLES:
            first -= 1
        return self._points[index][1].BEWEG_ART in CIRCLES and (index - first) % 2 == 0

    def _check_orientation_weights(self) -> None:
        """Weights other than 100 % at two successive points (path error 903); an auxiliary point's weight is _IORI_CIRCHP."""
        before = 100.0
        for n, (_, setting) in enumerate(self._points):
            weight = setting.IORI_CIRCHP if self._is_auxiliary(n) else setting.IORI_WEIGHT
            if before != 100 and weight != 100:
                raise BlockError("weighted orientation for two successive points", code=903, block=n + 1, source=SOURCE)
            before = weight

    def _block(self, target: Target, setting: Parameters, aux: tuple[Target, Parameters] | None) -> Block:
        mode = setting.BEWEG_ART
        via = aux[0] if aux is not None else None
        if via is not None and not isinstance(via, PoseTarget):
            raise MotionError("an auxiliary point of a circle is given as a position of the tool, not of the axes")
        kind = {Mode.PTP: Interpolation.PTP, Mode.LINEAR: Interpolation.LINEAR, Mode.SPLINE: Interpolation.SPLINE}.get(
            mode, Interpolation.CIRCULAR
        )
        turning = {Mode.ZIRK_MIN_ORI: Turning.LEAST, Mode.ZIRK_BAHN_ORI: Turning.PATH}.get(mode, Turning.VIA)
        weights = Curving(
            setting.ISPL_TENS / 100,
            setting.IORI_TENS / 100,
            setting.IORI_WEIGHT / 100,
            (aux[1].IORI_CIRCHP if aux is not None else setting.IORI_CIRCHP) / 100,
        )
        return Block(kind, target, via, self._pace(setting), self._blend(setting, kind), self._tool, Frame(), turning, curving=weights)

    def _pace(self, setting: Parameters) -> Pace:
        if setting.BEWEG_ART is Mode.PTP:
            accel = setting.PTP_BESCHL / 100
            return Pace(setting.PTP_GESCHW / 100, accel, accel, lead=True)
        accel = self._data.RACC_MAX / 1000 * setting.BAHN_BESCHL / 100
        return Pace(
            path_speed=None if setting.BAHN_ZEIT else setting.BAHN_GESCHW / 1000,
            path_accel=accel,
            path_decel=accel,
            time=setting.BAHN_ZEIT or None,
            ramp=setting.IACC_TIME / 100,
        )

    def _blend(self, setting: Parameters, kind: Interpolation) -> Blend:
        if not setting.UEBERSCHL or kind is Interpolation.SPLINE:
            return Blend()
        radius, distance = setting.BAHN_RADIUS / 1000, setting.BAHN_DISTANZ / 1000
        return Blend(
            Rounding.CARTESIAN, radius, radius, distance, share=self._data.RAPPR_FACT_MAX, flyby=setting.IV_FLYBY_S / 100, past_circles=True
        )


def check_path(blocks: list[Block], settings: list[Parameters], start: Target, data: MachineData) -> None:
    """Path errors 102 and 620 .. 624: approximation without anything to round, and orientation-only paths without a time.

    A path's own fault is reported before the one it causes in the path before it: a point twice is 620, not 623.
    """
    ways = [way(a.target if a else start, b.target, data) for a, b in pairwise([None, *blocks]) if b is not None]
    for n, setting in enumerate(settings):
        if setting.BEWEG_ART is not Mode.PTP:
            _check_alone(n + 1, setting, ways[n])
    for n, setting in enumerate(settings[:-1]):
        if _approximates(setting):
            _check_following(n + 1, ways[n + 1])


def _approximates(setting: Parameters) -> bool:
    return setting.UEBERSCHL and setting.BEWEG_ART not in (Mode.PTP, Mode.SPLINE)


def _check_alone(number: int, setting: Parameters, here: tuple[bool, bool]) -> None:
    """here: (the tool moves, it turns)."""
    if _approximates(setting):
        if here == (False, False):
            raise BlockError("approximation together with a path zero step", code=620, block=number, source=SOURCE)
        if here == (False, True):
            raise BlockError("approximation together with a path without distance", code=621, block=number, source=SOURCE)
        if setting.BAHN_RADIUS == 0 and setting.BAHN_DISTANZ == 0:
            raise BlockError(
                "BAHN_RADIUS and BAHN_DISTANZ are both 0 mm with activated approximation", code=102, block=number, source=SOURCE
            )
    if here == (False, True) and not setting.BAHN_ZEIT:
        raise BlockError("BAHN_ZEIT is missing: only the orientation moves", code=622, block=number, source=SOURCE)


def _check_following(number: int, following: tuple[bool, bool]) -> None:
    if following == (False, False):
        raise BlockError("approximation to a following path zero step", code=623, block=number, source=SOURCE)
    if following == (False, True):
        raise BlockError("approximation to a following path where only the orientation moves", code=624, block=number, source=SOURCE)


def way(start: Target, end: Target, data: MachineData) -> tuple[bool, bool]:
    """(the tool moves, it turns) beyond RS_POS_EPS and RS_ORI_EPS; axes count as both where they move beyond RS_AX_EPS."""
    if isinstance(start, PoseTarget) and isinstance(end, PoseTarget):
        distance = math.dist(start.pose.position, end.pose.position) * 1000
        angle = math.degrees(angle_between(start.pose.rotation, end.pose.rotation))
        return distance > data.RS_POS_EPS, angle > data.RS_ORI_EPS
    if isinstance(start, JointTarget) and isinstance(end, JointTarget):
        moves = any(math.degrees(abs(b - a)) > data.RS_AX_EPS for a, b in zip(start.q, end.q, strict=True))
        return moves, moves
    return True, True  # one of each: known only to the planner, which has the robot
