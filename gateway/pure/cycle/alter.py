"""VAL 3 alter in the cycle: a correction that a command source writes into RC inputs, on top of the path of an alterable part.  Pure.

The rules of the mode, its answers and its limits are those of motion.sync.alter; here it gets its correction from the input image, its
path from the stepper, and its end.  A correction that falls silent, is too fast, or leads out of reach ends the program at rest (AX-547).
"""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from gateway.pure.image.records.cell import NEVER, InputImage, Quality
from motion.errors import MotionError
from motion.execution.stepper import Sample, State
from motion.geometry.frames import Pose, compose
from motion.geometry.limits import TOUCH, AxisLimits
from motion.kinematics.base import KinematicsError, PathKinematics
from motion.kinematics.group import on_course
from motion.kinematics.placed import first_of
from motion.sync.alter import Alter, AlterFault, Mode
from motion.sync.alterable import AlterOrder
from motion.val3.trsf import Trsf
from protocols.base.machine import Ns

SILENT, REACH, FAST = 65004, 65005, 65006  # AX-547: the correction is silent; it leads out of reach; it is too fast
HELD = (State.STOPPING, State.STOPPED)
SHOWN = tuple(Mode)  # places: numbers of the modes in the status word
NUMBERS = 6
_STATUS = struct.Struct(">bBh")
MOST_MS = 32767


@dataclass(frozen=True, slots=True)
class AlterFacts:
    """[alter].  byte: first RC input byte of x, y, z, rx, ry, rz; real: six REAL (mm, deg), else six INT of `length` mm and `angle` deg;
    life: RC input byte that changes with every correction, -1: the stamp of the bytes counts; status: RC output byte, -1: none."""

    byte: int
    real: bool = False
    length: float = 0.01
    angle: float = 0.01
    life: int = -1
    silence_ns: Ns = 100_000_000
    every_s: float = 4e-3
    status: int = -1

    @property
    def size(self) -> int:
        """Bytes of the correction."""
        return NUMBERS * (4 if self.real else 2)


@dataclass(slots=True)
class Correction:
    """Correction of the command source, whether it is fresh, and what it was answered (as `alter` of VAL 3)."""

    facts: AlterFacts
    _codes: struct.Struct = field(init=False)
    _life: int = -1
    _since: Ns = NEVER  # the life byte changed, or the bytes were written
    fresh: bool = False
    answer: int = 0

    def __post_init__(self) -> None:
        self._codes = struct.Struct(
            f">{NUMBERS}{'f' if self.facts.real else 'h'}"
        )  # words high byte first, as at every command source (AX-010)

    def read(self, inputs: InputImage) -> Trsf:
        """As read from the image."""
        values = self._codes.unpack_from(inputs.values, self.facts.byte)
        if self.facts.real:
            return Trsf(*values)
        length, angle = self.facts.length, self.facts.angle
        x, y, z, a, b, c = values
        return Trsf(x * length, y * length, z * length, a * angle, b * angle, c * angle)

    def alive(self, inputs: InputImage, now: Ns) -> bool:
        """Once a cycle: good, and not older than it may be."""
        facts = self.facts
        if facts.life >= 0:
            if inputs.values[facts.life] != self._life:
                self._since = now if self._life >= 0 else NEVER  # the counter found at the start does not prove life
                self._life = inputs.values[facts.life]
        else:
            self._since = min(inputs.stamps[facts.byte : facts.byte + facts.size])
        good = min(inputs.quality[facts.byte : facts.byte + facts.size]) == Quality.GOOD
        return good and self._since != NEVER and now - self._since <= facts.silence_ns


class CoreAlter:
    """The alterable part that may be under way.  robots: kinematics by number, as motion.planner.robot.Machine has them, each on the axes
    of the cell; limits: of those."""

    def __init__(self, facts: AlterFacts, robots: Mapping[int, PathKinematics], limits: Sequence[AxisLimits], period_s: float) -> None:
        self.facts, self.on = facts, False
        self.fault: tuple[int, int] | None = None  # code, axis from 1 or 0
        self.block = 0
        self._source = Correction(facts)
        self._robots, self._limits, self._period = robots, tuple(limits), period_s
        every = max(round(facts.every_s / period_s), 1) * period_s
        self._alters = {number: Alter(period_s, stop_time_s=self._slowest(robot), every_s=every) for number, robot in robots.items()}
        self._kinematics, self.alter = next(iter(robots.values())), next(iter(self._alters.values()))  # of the robot of the part
        self._order: AlterOrder | None = None
        self._q: tuple[float, ...] = ()
        self._tip: Pose | None = None  # tool centre point of the cycle before
        self._held = False  # after an error: the axes stay at rest

    def _slowest(self, robot: PathKinematics) -> float:
        """Return the time that its slowest axis needs to stop."""
        own = self._limits[first_of(robot) : robot.axes]
        return max(axis.speed / axis.accel + axis.accel / axis.jerk for axis in own)

    # ---- a part --------------------------------------------------------------------------------------------------------
    def begin(self, order: AlterOrder, q: Sequence[float]) -> None:
        """alterBegin: the axes (all of the cell) rest at q."""
        if self.on or order.kinematic not in self._robots:
            raise MotionError("an alterable part is under way, or the robot has no correction")
        self.alter.reset_motion()
        self._kinematics, self.alter = self._robots[order.kinematic], self._alters[order.kinematic]
        self.reset()
        self._order, self._q, self._tip, self.block = order, tuple(q), None, order.block
        self.alter.begin(order.reference, order.frame, order.limits(self._limits[: self._kinematics.axes]))
        self.on = True
        if not self._source.fresh:
            self.fault = (SILENT, 0)

    def freeze(self) -> None:
        """alterEnd: what acts now stays to the end of the part."""
        self.alter.end()

    def reset(self) -> None:
        """resetMotion: an error is forgotten."""
        self.alter.reset_motion()
        self.fault, self._held = None, False

    def drop(self) -> None:
        """The part is over, or forgotten; the axes are released.  An error stays shown until the next program."""
        self.on, self._order = False, None
        if self.alter.mode is not Mode.ERROR:
            self.alter.reset_motion()

    @property
    def moves(self) -> bool:
        """A correction may move the axes while the path is at rest."""
        return self.on and self.alter.mode is Mode.ACTIVE and self.alter.stop_time() != 0.0

    def may_end(self, inputs: InputImage) -> bool:
        """At the end of the path: the input of alterEnd is not awaited."""
        until = self._order.until if self._order is not None else None
        if until is None or self.alter.mode is not Mode.ACTIVE:
            return True
        return inputs.quality[until.number >> 3] == Quality.GOOD and inputs.bit(until.number) is until.value

    # ---- one cycle -----------------------------------------------------------------------------------------------------
    def listen(self, inputs: InputImage, now: Ns) -> None:
        """The correction of this cycle, also where no part is under way: a command source that speaks has its answer."""
        self._source.fresh = self._source.alive(inputs, now)
        self._source.answer = self.alter.alter(self._source.read(inputs))

    def step(self, sample: Sample, override: float) -> Sample:
        """Set values of all axes for the path's; `fault` is the cause that ended the part."""
        alter = self.alter
        if sample.state is State.RUNNING and alter.mode is Mode.PENDING:
            alter.path(alterable=True)
        if sample.state in HELD or override <= 0.0:
            alter.stopping()
        else:
            alter.running()
        if not self._source.fresh and alter.mode in (Mode.PENDING, Mode.ACTIVE):
            self.fault = (SILENT, 0)
            alter.end()
        alter.step()
        if alter.mode is Mode.ERROR and not self._held:  # a correction that is NaN
            self._halted(REACH, 0)
        q = self._q if self._held else self._altered(sample.q)
        speeds = tuple((b - a) / self._period for a, b in zip(self._q, q, strict=True))
        self._q = q
        return sample._replace(q=q, qd=speeds)

    def _altered(self, path: tuple[float, ...]) -> tuple[float, ...]:
        """Joints of the altered path; after a fault those of the cycle before."""
        assert self._order is not None
        n = self._kinematics.axes
        there = self._kinematics.forward(path[:n])
        flange = self.alter.altered(there, self._order.tool)
        try:
            made = path if flange is there else (*self._kinematics.follow(flange, on_course(self._kinematics, self._q, path)), *path[n:])
            self._inside(made)
            tip = compose(flange, self._order.tool)
            if self._tip is not None:
                self.alter.judge(self._tip, tip, self._q[:n], made[:n])
        except AlterFault:
            return self._halted(FAST, 0)
        except KinematicsError as error:
            return self._halted(REACH, next((k for k, axis in enumerate(self._limits, 1) if axis.name == error.axis), 0))
        self._tip = tip
        return made

    def _inside(self, q: Sequence[float]) -> None:
        for axis, value in zip(self._limits, q, strict=True):
            if not axis.lower - TOUCH <= value <= axis.upper + TOUCH:
                raise KinematicsError("outside of its travel", axis=axis.name, number=531)

    def _halted(self, code: int, axis: int) -> tuple[float, ...]:
        """The arm halts at its last valid position, and the mode is locked (L6284, L6446)."""
        self.alter.failed()
        self.fault, self._held = (code, axis), True
        return self._q

    def publish(self, outputs: bytearray) -> None:
        """The answer to alter(), the mode, and alterStopTime in ms (-1: no stop is pending) for the command source that corrects."""
        if self.facts.status < 0:
            return
        left = self.alter.stop_time()
        shown = -1 if left < 0.0 else min(round(left * 1e3), MOST_MS)
        _STATUS.pack_into(outputs, self.facts.status, self._source.answer, SHOWN.index(self.alter.mode), shown)
