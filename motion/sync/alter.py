"""VAL 3 alter: a transformation in real time on top of a path.  Pure state machine; the moves are in motion.sync.altered.

Source: VAL 3 reference 13.1 (L6245-6480), doubts D15, D48.  The transformation is given in a frame (the whole path turns about its
origin, then shifts) or in a tool (the same about the tool centre point).  The system reads the last value every 4 ms; in between the
set values go straight from one to the next (AX-448).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from math import inf

from motion.errors import MotionError
from motion.geometry.frames import IDENTITY, Pose, compose
from motion.geometry.orientation import angle_between, interpolated
from motion.val3.mdesc import Mdesc
from motion.val3.trsf import Trsf

CYCLE_S = 4e-3
SYSTEM_STOP_S = 0.5  # an emergency stop leaves this long (L6472)
DONE, WAITS, IGNORED, NO_OPTION, IN_ERROR = 1, 0, -1, -2, -3
PATIENT = 1.0 + 1e-6  # of a speed limit: rounding


class Reference(Enum):
    """Of alterBegin."""

    FRAME, TOOL = "frame", "tool"


class Mode(Enum):
    """PENDING: alterBegin came, the alterable move has not begun; FROZEN: alterEnd came, the alteration stays for the rest."""

    OFF, PENDING, ACTIVE, FROZEN, ERROR = "off", "pending", "active", "frozen", "error"


@dataclass(frozen=True, slots=True)
class AlterLimits:
    """Limits of alterBegin's mdesc: joint speeds (rad/s or m/s), TCP m/s and rad/s; accel, decel: shares of the nominal ones."""

    joints: tuple[float, ...]
    tcp: float
    turn: float
    accel: float
    decel: float


def limits_of(mdesc: Mdesc, nominal: Sequence[float], unit_m: float = 1e-3) -> AlterLimits:
    """vel, tvel, rvel, accel, decel of a descriptor; nominal: joint speeds of the arm per s.  RuntimeFault 100..106."""
    mdesc.check()
    pace = mdesc.pace(unit_m)
    joints = tuple(pace.speed * speed for speed in nominal)
    return AlterLimits(joints, mdesc.tvel * unit_m, math.radians(mdesc.rvel), pace.accel, pace.decel)


class AlterFault(MotionError):
    """The alteration cannot be followed: the arm stays at the last valid position until resetMotion."""


@dataclass(slots=True)
class Alter:
    """One arm.  period_s: of the set values, an integer fraction of every_s; stop_time_s: of the arm at nominal deceleration, from full
    speed.

    The owner reports events with path(), stopping(), running() and reads the altered poses with step().
    """

    period_s: float
    enabled: bool = True  # the option
    stop_time_s: float = 0.2
    every_s: float = CYCLE_S  # period at which the last value is read
    mode: Mode = field(init=False, default=Mode.OFF)
    _reference: Reference = field(init=False, default=Reference.FRAME)
    _frame: Pose = field(init=False, default=IDENTITY)
    _limits: AlterLimits | None = field(init=False, default=None)
    _on_path: bool = field(init=False, default=False)  # an alterable move is under way, or the arm is at the end of the path
    _used: bool = field(init=False, default=False)  # this path has had its alterBegin
    _next: "tuple[Reference, Pose, AlterLimits] | None" = field(init=False, default=None)  # alterBegin of the path to come
    _value: Pose = field(init=False, default=IDENTITY)  # last of alter()
    _from: Pose = field(init=False, default=IDENTITY)  # taken 4 ms ago
    _to: Pose = field(init=False, default=IDENTITY)  # taken last
    _ticks: int = field(init=False, default=0)
    _left: float | None = field(init=False, default=None)  # s in which alter is still accepted; None: no stop is pending

    def __post_init__(self) -> None:
        ratio = self.every_s / self.period_s if self.period_s > 0 else 0.0
        if ratio < 1.0 or abs(ratio - round(ratio)) > 1e-6:
            raise MotionError(f"period {self.period_s:g} s does not divide evenly into {self.every_s * 1e3:g} ms")

    # ---- instructions --------------------------------------------------------------------------------------------------
    def begin(self, reference: Reference, frame: Pose, limits: AlterLimits, *, apart: bool = False) -> int:
        """alterBegin; frame: the reference in the world, or the tool on the flange.  1, 0 (waits for the alterable move), -1..-3.

        apart: a standard move is queued after the alterable path: after alterEnd the order is for the next one (L6294).
        """
        if not self.enabled:
            return NO_OPTION
        if self.mode is Mode.ERROR:
            return IN_ERROR
        if apart and self.mode is Mode.FROZEN and self._next is None:
            self._next = (reference, frame, limits)
            return WAITS
        if self.mode in (Mode.PENDING, Mode.ACTIVE) or self._used:
            return IGNORED
        return self._begun(reference, frame, limits)

    def _begun(self, reference: Reference, frame: Pose, limits: AlterLimits) -> int:
        self._reference, self._frame, self._limits = reference, frame, limits
        self._value = self._from = self._to = IDENTITY
        self._used, self._ticks = True, 0
        self.mode = Mode.ACTIVE if self._on_path else Mode.PENDING
        return DONE if self._on_path else WAITS

    def alter(self, trsf: Trsf) -> int:
        """The alteration from the next 4 ms on; the last one within 4 ms wins.  1, 0 (locked by a stop), -1, -2, -3."""
        if not self.enabled:
            return NO_OPTION
        if self.mode is Mode.ERROR:
            return IN_ERROR
        if self.mode is not Mode.ACTIVE:
            return IGNORED
        if self._left is not None and self._left <= 0.0:
            return WAITS
        if not all(map(math.isfinite, trsf)):
            self._fail()
            return IN_ERROR
        self._value = trsf.pose
        return DONE

    def end(self) -> int:
        """alterEnd: the present alteration stays for the rest of the path.  1, -1, -3."""
        if self.mode is Mode.ERROR:
            return IN_ERROR
        if self._next is not None:
            self._next = None
            return DONE
        if self.mode not in (Mode.ACTIVE, Mode.PENDING):
            return IGNORED
        self._value = self._from = self._to = self.alteration
        self.mode = Mode.FROZEN
        return DONE

    @property
    def waits(self) -> bool:
        """alterBegin waits for its alterable path."""
        return self.mode is Mode.PENDING or self._next is not None

    def stop_time(self) -> float:
        """alterStopTime: negative: no stop is pending; 0: alter is locked, or its mode is off (D15)."""
        if self.mode is not Mode.ACTIVE:
            return 0.0
        return -1.0 if self._left is None else max(self._left, 0.0)

    def reset_motion(self) -> None:
        """resetMotion ends the mode, an error too."""
        self.mode, self._on_path, self._used, self._left, self._next = Mode.OFF, False, False, None, None
        self._value = self._from = self._to = IDENTITY

    # ---- what the path does ----------------------------------------------------------------------------------------------
    def path(self, alterable: bool) -> None:
        """The move under way (or, at rest, the last one) is alterable or not."""
        if alterable and not self._on_path and self.mode is Mode.PENDING:
            self.mode = Mode.ACTIVE
        if not alterable and self._on_path and self.mode is Mode.FROZEN:
            self.mode, self._value = Mode.OFF, IDENTITY
            self._from = self._to = IDENTITY
        if not alterable and self.mode in (Mode.OFF, Mode.FROZEN):
            self._used = False  # a standard move came between: the next path may begin anew
        self._on_path = alterable
        if not alterable and self._next is not None:
            coming, self._next = self._next, None
            self._begun(*coming)

    def stopping(self, system_s: float = SYSTEM_STOP_S) -> None:
        """stopMove, hold or emergency stop: alter() still acts for the shorter of the arm's own and the system's time."""
        if self.mode is Mode.ACTIVE and self._left is None and self._limits is not None:
            own = self.stop_time_s / min(self._limits.accel, self._limits.decel)
            self._left = min(own, system_s)

    def running(self) -> None:
        """No stop is pending any more: alter acts again."""
        self._left = None

    # ---- time --------------------------------------------------------------------------------------------------------------
    @property
    def alteration(self) -> Pose:
        """What acts now."""
        every = round(self.every_s / self.period_s)
        share = min(self._ticks / every, 1.0)
        if self._from == self._to or share >= 1.0:
            return self._to
        return interpolated(self._from, self._to, share)

    def step(self) -> None:
        """One period further: every 4 ms the last value is taken."""
        if self.mode is not Mode.ACTIVE:
            return
        if self._left is not None:
            self._left -= self.period_s
        every = round(self.every_s / self.period_s)
        if self._ticks % every == 0:
            locked = self._left is not None and self._left <= 0.0
            self._from, self._to, self._ticks = self._to, self._to if locked else self._value, 0
        self._ticks += 1

    def altered(self, flange: Pose, tool: Pose = IDENTITY) -> Pose:
        """The flange with the alteration; flange and frame in the same world; tool: the tool centre point on the flange.

        Both references carry the tool along: the frame moves the whole path, the tool is shifted in its own coordinates.
        """
        if self.mode in (Mode.OFF, Mode.PENDING):
            return flange
        by = self.alteration
        if by == IDENTITY:
            return flange
        if self._reference is Reference.FRAME:
            return compose(compose(compose(self._frame, by), self._frame.inverse()), flange)
        return compose(flange, compose(compose(self._frame, by), self._frame.inverse()))

    def judge(self, before: Pose, now: Pose, q_before: Sequence[float], q_now: Sequence[float]) -> None:
        """Speeds of the altered path against alterBegin's mdesc; poses: of the tool centre point; one period apart.

        AlterFault beyond: the mode is locked, nothing of `now` may be sent.
        """
        if self._limits is None or self.mode is not Mode.ACTIVE:
            return
        h, limits = self.period_s, self._limits
        way = math.dist(before.position, now.position) / h
        turn = angle_between(before.rotation, now.rotation) / h
        for what, value, top, unit in (("tvel", way, limits.tcp, "m/s"), ("rvel", turn, limits.turn, "rad/s")):
            if not value <= top * PATIENT:
                self._fail()
                raise AlterFault(f"alter: {value:.4g} {unit} are beyond {what} = {top:.4g} {unit}")
        for axis, (a, b, top) in enumerate(zip(q_before, q_now, limits.joints or (inf,) * len(q_now), strict=True), 1):
            if not abs(b - a) / h <= top * PATIENT:
                self._fail()
                raise AlterFault(f"alter: joint {axis} would do {abs(b - a) / h:.4g} per s, vel allows {top:.4g}")

    def failed(self) -> None:
        """The altered position cannot be reached: the mode is locked."""
        if self.mode is Mode.ACTIVE:
            self._fail()

    def _fail(self) -> None:
        self.mode, self._left = Mode.ERROR, None
