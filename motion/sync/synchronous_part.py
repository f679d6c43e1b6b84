"""The synchronous part of a program on a belt of type 2 or 3: SYNCHRON ... SYNCHRON_END.

Source: rho 3 Releases part 1, TO04 sections 15.1, 15.3, 16.1 (L6107-6131, L6193-6249, L6319-6345).  The robot's coordinates follow
the belt from point to point, along lines or (type 2) circles: type 2 by a speed that brings both to the end of a block together,
type 3 by the cam.  Positions of the belt are those of its way, so a counter that is set meanwhile does no harm (AX-443).
"""

import math
from collections import deque
from dataclasses import dataclass, field
from enum import Enum

from motion.errors import MotionError
from motion.geometry.frames import NO_ROTATION, Pose
from motion.geometry.units import from_si
from motion.paths.arc import Arc, arc
from motion.program.blocks import Interpolation
from motion.sync.belts import Belt, Type
from motion.sync.cam import Cam, cam
from motion.sync.errors import DIRECTION, NO_DISTANCE, NO_PTP, NOT_POSSIBLE, TOLERANCE, BeltError
from motion.sync.pace import Pace

THERE = 1e-6  # of a block's way: arrived
ONWARD = math.cos(math.radians(1.0))  # blocks whose directions differ by less are run through without a stop


@dataclass(frozen=True, slots=True)
class BeltBlock:
    """One traverse block.  target: the robot's coordinates (any units, all blocks alike); belt: the belt's value at its end (m or
    rad of the counter), or with relative=True both as differences to the point before.  first, third: sections of the cam.
    via: of CIRCULAR: the first three coordinates run on the circle through it, the others in proportion (lengths in m then)."""

    target: tuple[float, ...]
    belt: float
    interpolation: Interpolation = Interpolation.LINEAR
    relative: bool = False
    pace: Pace = Pace()
    first: float = 0.0
    third: float = 0.0
    via: tuple[float, ...] = ()


class Phase(Enum):
    """Of the part."""

    WAITING, RUNNING, BETWEEN, FAILED = "waiting for the belt", "running", "without a block", "failed"


@dataclass(frozen=True, slots=True)
class _Leg:
    """A block as it is run.  begin, end: way of the belt."""

    start: tuple[float, ...]
    target: tuple[float, ...]
    begin: float
    end: float
    way: float  # of the robot: along the circle, else Euclidean in its coordinates
    pace: Pace
    curve: Cam
    circle: Arc | None = None

    def point(self, share: float) -> tuple[float, ...]:
        straight = tuple(a + share * (b - a) for a, b in zip(self.start, self.target, strict=True))
        if self.circle is None or share >= 1.0:
            return straight
        place = self.circle.at(share * self.way).position[: len(straight)]
        return (*place, *straight[len(place) :])

    def heading(self, share: float) -> tuple[float, ...]:
        """Change of the coordinates for each unit of the way."""
        straight = tuple((b - a) / self.way for a, b in zip(self.start, self.target, strict=True))
        if self.circle is None:
            return straight
        along = self.circle.derivatives(share * self.way).p1[: len(straight)]
        return (*along, *straight[len(along) :])

    def onward(self, other: "_Leg") -> bool:
        """Return whether the other continues in this one's direction."""
        if not (self.way > 0.0 and other.way > 0.0):
            return False
        here, there = self.heading(1.0), other.heading(0.0)
        return sum(a * b for a, b in zip(here, there, strict=True)) >= ONWARD * math.hypot(*here) * math.hypot(*there)


def _circle(start: tuple[float, ...], via: tuple[float, ...], target: tuple[float, ...]) -> Arc:
    """Through the first three coordinates; MotionError where there is none."""
    if len(via) != len(start) or len(start) < 2 or not all(map(math.isfinite, via)):
        raise MotionError(f"CIRCULAR through {via}: {len(start)} finite coordinates, two at least, are needed")
    first, middle, last = (Pose((p[0], p[1], p[2] if len(p) > 2 else 0.0), NO_ROTATION) for p in (start, via, target))
    return arc(first, middle, last)


@dataclass(slots=True)
class SynchronPart:
    """One SYNCHRON of one kinematic.  position and belt_value: of the last block before it: there the robot is, and there the
    first block waits for the belt.  step() once an interpolation cycle, after Belts.update.

    Every BeltError here opens READY and shows 528 as well; the robot then keeps the last position that step() returned.
    """

    belt: Belt
    kinematic: int  # from 1
    position: tuple[float, ...]
    belt_value: float  # m or rad, of the counter
    phase: Phase = field(init=False, default=Phase.WAITING)
    speed: float = field(init=False, default=0.0)  # along the present block, per s
    passed: int = field(init=False, default=0)  # blocks done
    kind: Type = field(init=False)
    _legs: deque[_Leg] = field(init=False, default_factory=deque)
    _end: tuple[float, ...] = field(init=False)  # of everything added
    _belt_end: float = field(init=False)
    _sign: float = field(init=False, default=0.0)  # +1, -1: direction programmed; 0: none yet
    _made: float = field(init=False, default=0.0)  # of the present block, by type 2
    _rebased: int = field(init=False)
    _first: bool = field(init=False, default=True)
    _fastest: float = field(init=False, default=0.0)  # of the belt since SYNCHRON

    def __post_init__(self) -> None:
        if self.belt.kind is Type.PARALLEL:
            raise MotionError(f"belt {self.belt.number} is of type 1: motion.sync.parallel")
        self.kind = self.belt.kind
        self._end, self._belt_end = tuple(self.position), self.belt.zero + self.belt_value
        self._rebased = self.belt.rebased

    # ---- blocks ------------------------------------------------------------------------------------------------------
    def add(self, block: BeltBlock) -> None:
        """The next block; known before it runs, so its errors come here: 20, 23, 89, 928 .. 937."""
        if block.interpolation is Interpolation.PTP:
            raise self._fault(NO_PTP)
        if block.interpolation is Interpolation.CIRCULAR and self.kind is Type.CAM:
            raise self._fault(NOT_POSSIBLE, "CIRCULAR")
        if block.interpolation is Interpolation.SPLINE:
            raise MotionError("a belt is followed along straight lines and circles, not along a spline")
        if len(block.target) != len(self._end) or not all(map(math.isfinite, (*block.target, block.belt))):
            raise MotionError(f"{block.target}, belt {block.belt}: {len(self._end)} finite coordinates and a finite belt value are needed")
        if not block.relative and self.belt.rebased != self._rebased:
            raise self._fault(NOT_POSSIBLE, "absolute belt value after the counter was set inside the part")
        if block.relative:
            target, end = tuple(a + b for a, b in zip(self._end, block.target, strict=True)), self._belt_end + block.belt
        else:
            target, end = tuple(block.target), self.belt.zero + block.belt
        length = end - self._belt_end
        if abs(length) <= 1e-12:
            raise self._fault(NO_DISTANCE)
        if self._sign * length < 0:
            raise self._fault(DIRECTION, "the belt values of the part do not all rise or all fall")
        curve = cam(abs(length), block.first, block.third)
        circle = None
        if block.interpolation is Interpolation.CIRCULAR:
            via = tuple(a + b for a, b in zip(self._end, block.via, strict=False)) if block.relative else block.via
            circle = _circle(self._end, via, target)
        way = circle.length if circle else math.dist(self._end, target)
        self._legs.append(_Leg(self._end, target, self._belt_end, end, way, block.pace, curve, circle))
        self._sign, self._end, self._belt_end = math.copysign(1.0, length), target, end

    def hindered(self, why: str = "feed hold") -> BeltError:
        """Feed hold, feed allow or a drive stopped the kinematic: the program is aborted; the error to raise (944 .. 953)."""
        return self._fault(TOLERANCE, why)

    # ---- time --------------------------------------------------------------------------------------------------------
    def step(self) -> tuple[float, ...]:
        """The robot's coordinates for this cycle; BeltError 928 .. 937, 944 .. 953."""
        if self.phase is Phase.FAILED:
            return self.position
        self._fastest = max(self._fastest, abs(self.belt.watch.speed))
        last = self.position
        try:
            self._step()
        except BeltError:
            self.position = last
            raise
        return self.position

    def _step(self) -> None:
        if self._legs:
            self._check_direction()
            if self.phase is not Phase.RUNNING:
                self._begin()
        if self.phase is Phase.RUNNING:
            self.position = self._cam_point() if self.kind is Type.CAM else self._paced_point()

    def _check_direction(self) -> None:
        """Before the first block always; with type 2 also later (15.3.1); the cam follows the belt back instead (16.1)."""
        if self.kind is Type.CAM and not (self._first and self.phase is Phase.WAITING):
            return
        if self.belt.watch.judges_direction and self.belt.watch.raw * self._sign < 0.0:
            raise self._fault(DIRECTION, "the belt moves against the programmed direction")

    def _ran(self, place: float) -> float:
        """How far the belt is beyond this place, in the programmed direction."""
        return (self.belt.way - place) * self._sign

    def _begin(self) -> None:
        """The first block when the belt comes by, the others at once: the belt must be where they start (L6117)."""
        beyond = self._ran(self._legs[0].begin)
        if self._first and beyond < 0.0:
            return
        self._check_tolerance(beyond)
        self._first, self.phase, self._made = False, Phase.RUNNING, 0.0

    def _check_tolerance(self, beyond: float) -> None:
        """While it is not judged a robot of type 2 catches up; the cam would jump, so it is held to the fastest the belt was."""
        room = self.belt.room
        if not self.belt.watch.judges_tolerance:
            if self.kind is Type.ALONE:
                return
            room = self.belt.tolerance * self._fastest * self.belt.watch.cycle_s
        if abs(beyond) > room + 1e-9:
            unit = self.belt.data.unit
            raise self._fault(TOLERANCE, f"the belt is {from_si(beyond, unit):.4g} {unit} off, {from_si(room, unit):.4g} are allowed")

    def _next(self) -> bool:
        """The present block is done; True: another one runs, and the belt was where it should be."""
        leg = self._legs.popleft()
        self.passed += 1
        self.position = leg.target
        if not self._legs:
            self.phase, self.speed = Phase.BETWEEN, 0.0
            return False
        self._check_tolerance(self._ran(leg.end))
        self._made = 0.0
        return True

    def _cam_point(self) -> tuple[float, ...]:
        while True:
            leg = self._legs[0]
            ran = self._ran(leg.begin)
            if ran < leg.curve.length:
                share, slope = leg.curve.at(ran)
                self.speed = slope * self.belt.watch.speed * leg.way * self._sign
                return leg.point(share)
            if not self._next():
                return self.position

    def _paced_point(self) -> tuple[float, ...]:
        """One cycle along the block at the speed that brings robot and belt to its end together."""
        belt = max(self.belt.watch.speed * self._sign, 0.0)
        leg = self._legs[0]
        made = self._advance(leg, belt)
        if made < leg.way * (1.0 - THERE):
            self._made = made
            if self._ran(leg.end) > 0.0:
                self._check_tolerance(self._ran(leg.end))  # the belt has passed the end, the robot has not: it will not get better
            return leg.point(made / leg.way)
        self._made = leg.way
        if self._onward(leg) is not None:
            if self._next():
                self._made = made - leg.way
            return self._legs[0].point(self._made / self._legs[0].way)
        self.speed = 0.0
        if self._ran(leg.end) >= -0.5 * belt * self.belt.watch.cycle_s:  # else: the robot is there, the belt not yet
            self._next()
        return leg.target

    def _onward(self, leg: _Leg) -> _Leg | None:
        """Return the next block if it continues in the same direction."""
        return self._legs[1] if len(self._legs) > 1 and leg.onward(self._legs[1]) else None

    def _advance(self, leg: _Leg, belt: float) -> float:
        """How much of the block is made one cycle later; the position before belonged to the belt's place one cycle ago."""
        cycle, before, rest = self.belt.watch.cycle_s, self.speed, leg.way - self._made
        if belt <= 0.0:
            self.speed = max(before - leg.pace.decel * cycle, 0.0)  # "belt stopped": braked to 0
        else:
            onward, left = self._onward(leg), -self._ran(leg.end)
            end = min(onward.way / abs(onward.end - onward.begin) * belt, leg.pace.top) if onward else 0.0
            self.speed = leg.pace.next_speed(rest, left / belt + cycle, before, end, cycle)
        mean = 0.5 * (before + self.speed) if leg.pace.accel < math.inf else self.speed
        return self._made + mean * cycle

    def _fault(self, code: int, detail: str = "") -> BeltError:
        self.phase, self.speed = Phase.FAILED, 0.0
        return BeltError(code, detail, kinematic=self.kinematic, synchronous=True)
