"""The robot moved by hand in a cell: movement keys, Position Control, 6D mouse.  Pure.  Source: robotstar 8.2, 8.4; AX-1050.

It is a user of the path in addition to the program.  A key causes a straight movement up to the limit of reach, which the control stops
when the key is released: short pieces first, so that it begins at once.  The wheel and the mouse cause short single movements.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from gateway.pure.languages.base.path import Path, Stretch
from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.robotstar.arm import REIS, Arm, tool_values
from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.lines import tool_line
from gateway.pure.languages.robotstar.mouse import Mouse
from gateway.pure.languages.robotstar.path import ACC_MAX, Target
from gateway.pure.languages.robotstar.values import Structure
from motion.geometry.units import from_si

NAME, ROBOT = "HAND", 1
AXIS_SHARE = 10.0  # % of an axis' speed at an override of 100 %
LONGEST, STEP = 3000.0, 20.0  # mm a key may lead, and how finely it is looked whether the robot gets there
TURN, TURN_STEP = 180.0, 3.0  # degrees likewise
SLICE_S, AHEAD = 0.1, 4  # of the mouse: how long a movement lasts, how many are handed on
STILL_NS: Ns = 60_000_000  # the wheel has come to rest
WHEEL = 1.0  # least mm or degrees of the wheel while it is turned
LEAST = 1e-3  # mm or degrees
ROOM = 0.5  # mm or degrees a key keeps from the travel of an axis
SMALLEST = 0.01  # share of a way that is tried
ALIGNED = 5  # mm: pieces of one straight way need no more to follow each other at full speed
FIRST_S, LONGEST_S, PIECES = 0.2, 1.6, 3  # of a straight way: duration of its first and its longest piece, number of pieces handed on


@dataclass(frozen=True, slots=True)
class Push:
    """kind: keys, wheel, mouse, or "" (nothing is wanted); frame: AXIS, AXIS7, XYZ or UVW; ways: of six keys -1, 0 or 1; turned: mm or
    degrees the wheel has given since the key was pressed; moves, turns: ways of the mouse that are chosen."""

    kind: str = ""
    frame: str = "AXIS"
    ways: tuple[float, ...] = (0.0,) * 6
    turned: float = 0.0
    moves: bool = False
    turns: bool = False


@dataclass(slots=True)
class Hand:
    """Call `look` once a turn.  speeds: _RVEL_KART mm/s and _RVEL_ORI degrees/s; tool: in force; mouse_in_hand: bit 1 of _VERFAHR[3]."""

    path: Path
    arm: Arm
    speeds: Callable[[], tuple[float, float]]
    tool: Callable[[], Structure | None]
    mouse_in_hand: Callable[[], bool]
    say: Callable[[str], None]
    mouse: Mouse = field(default_factory=Mouse)
    wanted: Push = field(default_factory=Push)
    _run: Push = field(default_factory=Push)  # purpose of the stretch
    _stretch: Stretch | None = None
    _at: Target = field(default_factory=Target)  # where what was handed on leads
    _given: float = 0.0  # of the wheel
    _added: Ns = 0  # when the wheel gave something last
    _share: float = 1.0  # of the way of a key, where the planner has refused the full way
    _led: float = 0.0  # mm or degrees of the straight way that are handed on
    _piece_s: float = FIRST_S  # duration of its next piece at the highest speed
    _refused: bool = False

    def hear(self, push: Push) -> None:
        """What keys, wheel and mouse want now."""
        if replace(push, turned=0.0) != replace(self.wanted, turned=0.0):
            self._share, self._refused = 1.0, False
        self.wanted = push

    def look(self, places: Sequence[float], now: Ns) -> None:
        """Hand on the requested movement."""
        held = self.path.held_by(self)
        same = replace(self.wanted, turned=0.0) == replace(self._run, turned=0.0)
        if not self.wanted.kind or self._refused or (self._stretch is not None and not same):
            if held is not None:
                self.path.release(self)
            return
        stretch = self.path.wanted(self, NAME, ROBOT)
        if stretch is None:
            return
        try:
            if stretch is not self._stretch:
                self._begin(stretch, places)
            self._go_on(stretch, places, now)
        except StepFault as fault:
            self._refuse(fault.text)

    def over(self, stretch: Stretch, words: str, *, planned: bool) -> None:
        """The path is over; words: because of an error, planned: of the planner, which has refused the way."""
        ours, self._stretch, self._run = stretch is self._stretch, None, Push()
        if ours and planned and self.wanted.kind == "keys" and self._share > SMALLEST:
            self._share /= 2  # the way is straight, but an axis cannot follow all of it
        elif words and self.wanted.kind:
            self._refuse(words)

    def forget(self) -> None:
        """The keys are not known any more: nothing is wanted."""
        self.wanted, self._run, self._stretch = Push(), Push(), None

    def _refuse(self, words: str) -> None:
        self._refused = True
        self.say(f"the robot cannot be moved by hand: {words}")

    def _begin(self, stretch: Stretch, places: Sequence[float]) -> None:
        self._stretch, self._run, self._given, self._led, self._piece_s = stretch, self.wanted, 0.0, 0.0, FIRST_S
        self._at = self.arm.actual(self.arm.own(places), self.tool())
        if self.wanted.frame in ("XYZ", "UVW"):
            if self.arm.plain:
                raise StepFault("Cartesian movements need the geometry of the robot")
            self.path.hand_on(stretch, tool_line("T1", tool_values(self.tool())), block=False)
        if self.wanted.kind == "keys" and self.wanted.frame.startswith("AXIS"):
            text = self._axes_way(places)
            if text:
                self.path.hand_on(stretch, text)
            self.path.finish(stretch)

    def _go_on(self, stretch: Stretch, places: Sequence[float], now: Ns) -> None:
        match self.wanted.kind:
            case "keys" if self.wanted.frame in ("XYZ", "UVW"):
                if self._led < math.inf and stretch.count - stretch.passed < PIECES:
                    self._lead(stretch, places)
            case "wheel":
                due = self.wanted.turned - self._given
                if abs(due) > WHEEL or (abs(due) > LEAST and now - self._added > STILL_NS):
                    self._given, self._added = self.wanted.turned, now
                    self._add(stretch, self._moved(self._at, self.wanted.ways, due), places)
                elif now - self._added > STILL_NS:
                    self.path.finish(stretch)
            case "mouse":
                push = self.mouse.push(moves=self.wanted.moves, turns=self.wanted.turns, hand=self.mouse_in_hand())
                if any(push) and stretch.count - stretch.passed < AHEAD:
                    self._slice(stretch, push, places)

    # ---- ways ------------------------------------------------------------------------------------------------------------
    def _axes_way(self, places: Sequence[float]) -> str:
        """All axes whose keys are held, at their own speeds, until the first reaches its limit; "": none can."""
        first = 6 if self.wanted.frame == "AXIS7" else 0
        here = list(self.arm.own(places))
        rates, longest = {}, math.inf
        for number, way in enumerate(self.wanted.ways, first):
            if way and number >= len(here):
                raise StepFault(f"this robot has {len(here)} axes")
            if way:
                limits = self.arm.machine.limits[number]
                end = from_si(limits.upper if way > 0 else limits.lower, limits.unit)
                rates[number] = way * from_si(limits.speed, limits.unit) * AXIS_SHARE / 100
                longest = min(longest, (end - math.copysign(ROOM, way) - here[number]) / rates[number])
        if not rates or longest <= 0:
            return ""
        for number, rate in rates.items():
            here[number] += rate * longest
        joints = " ".join(f"{value:.10g}" for value in here)
        return f"ptp joints {joints} speed={AXIS_SHARE:g} accel=50 decel=50"

    def _lead(self, stretch: Stretch, places: Sequence[float]) -> None:
        """The next piece of the straight way along the keys, twice as long as the one before; the last one ends where the reach ends."""
        ways, tool, axes = self.wanted.ways, self.tool(), self.arm.own(places)
        along = any(ways[:3])
        step, most = (STEP, LONGEST) if along else (TURN_STEP, TURN)
        end = min(self._led + self.speeds()[0 if along else 1] * self._piece_s * self._share, most)
        start, reached = self._at, 0.0
        while reached < end - self._led:
            further = min(step, end - self._led - reached)
            if not self.arm.unreachable(self._moved(start, ways, reached + further), start, tool, axes):
                reached += further
            elif step < LEAST:
                break
            else:
                step /= 2  # remainder of the last step
        self._led = self._led + reached if reached >= end - self._led and end < most else math.inf
        self._piece_s = min(2 * self._piece_s, LONGEST_S)
        if reached > LEAST:
            self._add(stretch, self._moved(start, ways, reached), places, radius=ALIGNED)
        if self._led == math.inf:
            self.path.finish(stretch)

    def _slice(self, stretch: Stretch, push: Sequence[float], places: Sequence[float]) -> None:
        speed, turning = self.speeds()
        ways = [value * speed * SLICE_S for value in push[:3]] + [value * turning * SLICE_S for value in push[3:]]
        frame = "UVW" if self.mouse_in_hand() else "XYZ about the hand"
        pace = math.hypot(*push[:3]) * speed, math.hypot(*push[3:]) * turning
        self._add(stretch, moved(self._at, frame, ways), places, *pace)

    def _moved(self, start: Target, ways: Sequence[float], amount: float) -> Target:
        length = math.hypot(*ways[:3]) or 1.0  # two keys together are not faster than one
        return moved(start, self.wanted.frame, [way * amount / length for way in ways])

    def _add(
        self, stretch: Stretch, target: Target, places: Sequence[float], path: float = 0.0, turn: float = 0.0, *, radius: int = 10000
    ) -> None:
        wrong = self.arm.unreachable(target, self._at, self.tool(), self.arm.own(places))
        if wrong:
            raise StepFault(wrong)
        text = self._line(target, path, turn)
        self._at = target
        self.path.hand_on(stretch, f"{text} radius={radius} share=40 flyby=100 arcs=yes")

    def _line(self, target: Target, path: float = 0.0, turn: float = 0.0) -> str:
        speed, turning = self.speeds()
        place, _, extra = self.arm.text(target, self._at).partition(" extra=")
        words = [f"linear {place}", "tool=T1", *([f"extra={extra}"] if extra else []), f"path={max(path or speed, 0.1):.10g}"]
        words += [f"turn={max(turn or turning, 0.1):.10g}", f"pathaccel={ACC_MAX / 2:g}", f"pathdecel={ACC_MAX / 2:g}"]
        return " ".join(words)


def moved(start: Target, frame: str, ways: Sequence[float]) -> Target:
    """mm and degrees from a position on.  XYZ: along the axes of the basic system, A, B, C by number (L1310-1318); UVW: along and about the
    axes of the hand; `XYZ about the hand`: the mouse at the pendant."""
    if frame == "XYZ":
        return Target(tuple(value + way for value, way in zip(start.pose, ways, strict=True)), start.frame, start.axes)
    pose = REIS.pose(start.pose)
    if frame == "UVW":
        pose = pose @ REIS.pose((*ways[:3], 0, 0, 0))
    turned = pose
    for place, way in enumerate(ways[3:]):
        if way:
            turned = turned @ REIS.pose((0, 0, 0, *(way if n == place else 0.0 for n in range(3))))
    values = list(REIS.values(turned))
    if frame != "UVW":
        values[:3] = [value + way for value, way in zip(start.pose[:3], ways[:3], strict=True)]
    return Target(tuple(values), start.frame, start.axes)
