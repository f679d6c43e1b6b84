"""A movement of BAPS2 as a line of the text form for the planner: way, target, speeds, how its end is passed (rho 3 releases, part 1,
sections 6 and 14)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.frames import NO_FRAME, Frame
from gateway.pure.languages.baps2.robots import CellRobot
from motion.errors import MotionError
from motion.geometry.units import from_si, to_si
from motion.program.blocks import Interpolation
from motion.program.passing import Passing, Presets, Range
from motion.program.text.values import LONGEST_WITHIN_S

LEAST, MOST = 0.01, 500.0  # % of a speed, as the text form accepts it
LEG_S = 100.0  # longest block to a far place: the cycle begins it when it has all its pieces, and reads two of them (1 s) a turn
KINDS = (("V", "path", "V_PTP", "speed", 0), ("A", "pathaccel", "A_PTP", "accel", 1), ("D", "pathdecel", "D_PTP", "decel", 2))


@dataclass(frozen=True, slots=True)
class Wanted:
    """A movement requested by the program.  factors: V, A, D and the like in force, those after WITH for this block alone; presets: of
    R and R_PTP (P212 to P214), in mm and deg."""

    robot: CellRobot
    way: str
    via: bool
    joint: bool
    relative: bool
    target: tuple[float, ...]
    factors: Mapping[str, float]
    presets: Presets = Presets()
    frame: Frame = NO_FRAME
    until: str = ""
    on_belt: str = ""  # keys of a block in a synchronous part


def head(robot: CellRobot) -> list[str]:
    """Statements before the blocks of a stretch."""
    return ["angles rho3", f"axes {' '.join(robot.units)}"]


def system(frame: Frame) -> list[str]:
    """WC_SYSTEM as the planner keeps it."""
    if frame == NO_FRAME:
        return ["wc_system WC_UR"]
    return [f"wc_frame SYSTEM {' '.join(f'{value:.10g}' for value in frame)}", "wc_system SYSTEM"]


def within(limit: float | None) -> str:
    """Return MAX_TIME of MOVE UNTIL (s) as a key after until=; a negative one counts as 0."""
    return "" if limit is None else f" within={min(max(limit, 0.0), LONGEST_WITHIN_S):.10g}"


def line(wanted: Wanted, world: Sequence[float], shares: Sequence[float], through: Wanted | None = None) -> str:
    """Return the block.  world: joints from which the program's last point leads, for angles that a point omits; shares: global factors V,
    A, D; through: the first of the two points of a circle.
    """
    way = wanted.way
    if way == "circular":
        if through is None:
            raise fault(223)
        target = f"via {_point(through, world)} to {_point(wanted, world)}"
    else:
        target = _target(wanted, world)
    speeds = _speeds(way, wanted.factors, shares)
    return " ".join([way, target, *speeds, *_passed(wanted), *(each for each in (wanted.on_belt, wanted.until) if each)])


def check(way: str, via: bool, factors: Mapping[str, float], presets: Presets | None = None) -> None:
    """Speeds, accelerations and blending of a block that is prepared; a runtime error.  In a dry run as in a cell."""
    _speeds(way, factors, (1.0, 1.0, 1.0))
    if via:
        _passing(way, factors, presets or Presets())


def leg(wanted: Wanted, here: Sequence[float], shares: Sequence[float]) -> Wanted | None:
    """Return the part of a PTP block from `here` that lasts LEG_S; None: all of it can be planned at once.  A balancing machine goes to
    9999999.0 until its probe comes (L6763, 6844).
    """
    robot = wanted.robot
    if wanted.way != "ptp" or wanted.relative or not (wanted.joint or robot.plain):
        return None
    share = min(wanted.factors.get("V_PTP", 1.0) * wanted.factors.get("VFACTOR", 1.0) * shares[0], 1.0)
    ways = zip(here, wanted.target, robot.machine.limits, strict=True)
    full_s = max(abs(to_si(target - place, axis.unit)) / axis.speed for place, target, axis in ways)
    if share <= 0.0 or full_s <= LEG_S * share:
        return None
    part = LEG_S * share / full_s
    return replace(wanted, target=tuple(place + part * (target - place) for place, target in zip(here, wanted.target, strict=True)))


def left(wanted: Wanted, gone: Wanted) -> tuple[float, ...]:
    """The target once the axes are at rest at that of `gone`: endless ones count from 0 again there."""
    found = []
    for target, place, axis in zip(wanted.target, gone.target, wanted.robot.machine.limits, strict=True):
        turn = from_si(axis.modulo, axis.unit)
        found.append(target - place // turn * turn if turn else target)
    return tuple(found)


def _target(wanted: Wanted, near: Sequence[float]) -> str:
    if wanted.relative:
        return wanted.robot.shift(wanted.target, joint=wanted.joint)
    if wanted.joint:
        return wanted.robot.text("joints", wanted.target)
    return wanted.robot.target(wanted.target, near)


def _point(wanted: Wanted, near: Sequence[float]) -> str:
    """A point of a circle: always a pose."""
    robot = wanted.robot
    if wanted.relative:
        raise fault(222, "a circle through relative points")
    world = robot.world(wanted.target) if wanted.joint else wanted.target
    return robot.text("pose", robot.six(world) if robot.plain else robot.filled(world, near))


def _speeds(way: str, factors: Mapping[str, float], shares: Sequence[float]) -> list[str]:
    """V, A, D in mm/s and mm/s2 of lines and circles, V_PTP and its like as shares of what the axes can; times the factors."""
    found = []
    for name, path, ptp, share, place in KINDS:
        own = ptp if way == "ptp" else name
        factor = factors.get(f"{name}FACTOR", 1.0) * shares[place]
        value = factors.get(own, 1.0)
        if value * factor <= 0.0:  # nothing moves at 0
            raise fault(218, f"{own} = {value:g}" if value <= 0.0 else f"{name}FACTOR = {factor:g}")
        if way != "ptp" and name in factors:
            found.append(f"{path}={value * factor:.10g}")
        elif way == "ptp" or factor != 1.0:
            percent = 100.0 * factor * (value if way == "ptp" else 1.0)
            found.append(f"{share}={min(max(percent, LEAST), MOST):.10g}")
    return found


def _passed(wanted: Wanted) -> list[str]:
    """R of lines, R_PTP of PTP; TO stops."""
    if not wanted.via:
        return []
    found = _passing(wanted.way, wanted.factors, wanted.presets)
    if found.off:
        return []
    if not found.axes:
        return [f"radius={found.radius:.10g}"]
    size = wanted.robot.size
    return [f"zone={','.join(f'{each:.10g}' for each in (*found.axes, *[0.0] * size)[:size])}"]


def _passing(way: str, factors: Mapping[str, float], presets: Presets) -> Range:
    passing = Passing(presets)
    try:
        if "R" in factors:
            passing.set_radius(factors["R"])
        if "R_PTP" in factors:
            passing.set_factor(factors["R_PTP"])
        return passing.block(Interpolation(way))
    except MotionError as error:
        raise fault(218, str(error)) from error
