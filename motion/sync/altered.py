"""Alterable moves of VAL 3 on an arm: alterMovej/l/c in addition to the standard moves, and the altered set values.

Source: VAL 3 reference 13.1 (L6245-6480).  An alterable path is a row of alterable moves between two standard ones.  The standard move
after it is computed only after alterEnd, from the position of the altered arm; here the arm is at rest there (AX-449). waitEndMove, open
and close wait for the theoretical path alone, which `place()` reports.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from motion.errors import MotionError
from motion.geometry.frames import IDENTITY, Pose, compose
from motion.kinematics.base import Kinematics, KinematicsError
from motion.kinematics.group import on_course
from motion.program.blocks import Block, Frame, PoseTarget, Target, Tool
from motion.sync.alter import DONE, WAITS, Alter, AlterFault, Mode, Reference, limits_of
from motion.val3.mdesc import Mdesc
from motion.val3.stack import MotionStack, Place


class Inner(Protocol):
    """Planner and follower of the theoretical path: motion.planner.arm.Arm."""

    joints: tuple[float, ...]

    def add(self, block: Block) -> int: ...
    def finish(self) -> None: ...
    def stop(self) -> None: ...
    def resume(self) -> None: ...
    def abandon(self) -> None: ...
    def place(self) -> Place: ...
    def step(self) -> tuple[float, ...]: ...
    @property
    def resting(self) -> bool: ...


@dataclass(frozen=True, slots=True)
class _Move:
    number: int
    block: Block
    alterable: bool


@dataclass
class AlteredArm:
    """A `Mover` for the motion stack: the arm with its alteration.  alterable: whether the next add() is alterable; step() once a period.

    kinematics: of the arm's own joints; additional axes after them are not altered.
    """

    inner: Inner
    kinematics: Kinematics
    alter: Alter
    alterable: bool = False
    joints: tuple[float, ...] = field(init=False)
    fault: MotionError | None = field(init=False, default=None)
    _moves: dict[int, _Move] = field(init=False, default_factory=dict)  # number of the inner block -> move
    _later: deque[_Move] = field(init=False, default_factory=deque)  # wait for alterEnd
    _count: int = field(init=False, default=0)
    _last: _Move | None = field(init=False, default=None)  # the last one the inner arm was given
    _held: bool = field(init=False, default=False)  # an error: the arm stays at rest
    _dropping: bool = field(init=False, default=False)
    _finish: bool = field(init=False, default=False)
    _tip: Pose | None = field(init=False, default=None)  # tool centre point of the last period

    def __post_init__(self) -> None:
        self.joints = tuple(self.inner.joints)

    # ---- Mover -------------------------------------------------------------------------------------------------------
    def add(self, block: Block) -> int:
        """Queue a block and return its number.  A standard move after an alterable path is kept until alterEnd.  Raise BlockError."""
        move = _Move(self._count + 1, block, self.alterable)
        if self._later or (self._last is not None and self._last.alterable and not move.alterable):
            if not self._later:
                self.inner.finish()
            self._later.append(move)
        else:
            self._give(move)
        self._count += 1
        return move.number

    def _give(self, move: _Move) -> None:
        self._moves[self.inner.add(move.block)] = move
        self._last = move

    def finish(self) -> None:
        """The last block is run to its target."""
        if self._later:
            self._finish = True
        else:
            self.inner.finish()

    def stop(self) -> None:
        """The theoretical path brakes; alter acts for alterStopTime yet."""
        self.inner.stop()
        self.alter.stopping()

    def resume(self) -> None:
        """Continue path and alteration."""
        if not self._held:
            self.inner.resume()
        self.alter.running()

    def abandon(self) -> None:
        """resetMotion: brakes, forgets everything, ends the mode and an error of it."""
        self._later.clear()
        self._finish, self.fault = False, None
        if self._held:
            self.alter.reset_motion()
        else:
            self.alter.end()  # the present alteration stays until the arm is at rest
        self._dropping = True
        self.inner.stop()
        self._drop_at_rest()

    def place(self) -> Place:
        """Of the theoretical path, with the joints of the altered arm."""
        place = self.inner.place()
        move = self._moves.get(place.block)
        number = move.number if move else 0
        return Place(number, place.share, place.resting and not self._dropping, place.waiting + len(self._later), self.joints)

    @property
    def apart(self) -> bool:
        """Return whether a standard move waits after the alterable path."""
        return any(not move.alterable for move in self._later)

    # ---- time --------------------------------------------------------------------------------------------------------
    def step(self) -> tuple[float, ...]:
        """The set values (axes,) of the next period; after an error the last valid ones."""
        q = self.inner.step()
        move = self._moves.get(self.inner.place().block)
        if move is not None and not self._dropping:
            self.alter.path(move.alterable)
        self.alter.step()
        if not self._held:
            try:
                self.joints = self._altered(q, move.block.tool.pose if move else IDENTITY)
            except (KinematicsError, AlterFault) as error:
                self.alter.failed()
                self.fault, self._held = error, True
                self.inner.stop()
        self._drop_at_rest()
        self._release()
        return self.joints

    def _altered(self, q: tuple[float, ...], tool: Pose) -> tuple[float, ...]:
        n = self.kinematics.axes
        if self.alter.mode in (Mode.OFF, Mode.PENDING):
            self._tip = None
            return q
        there = self.kinematics.forward(q[:n])
        flange = self.alter.altered(there)
        made = q if flange is there else (*self.kinematics.follow(flange, on_course(self.kinematics, self.joints, q)), *q[n:])
        tip = compose(flange, tool)
        if self._tip is not None:
            self.alter.judge(self._tip, tip, self.joints[:n], made[:n])
        self._tip = tip
        return made

    def _drop_at_rest(self) -> None:
        """After resetMotion: once the path is at rest, continue planning from the actual position of the arm."""
        if self._dropping and self.inner.resting:
            self.alter.reset_motion()
            self._dropping = self._held = False
            self._relocate()

    def _release(self) -> None:
        """Compute the waiting moves from here: the alterable path is done, and alterEnd was called (or no alterBegin)."""
        if not self._later or self._held or self.alter.mode in (Mode.PENDING, Mode.ACTIVE, Mode.ERROR):
            return
        if self.inner.place().waiting or not self.inner.resting:
            return
        self.alter.path(alterable=False)
        self._relocate()
        while self._later and not (self._last is not None and self._last.alterable and not self._later[0].alterable):
            self._give(self._later.popleft())
        if self._later or self._finish:
            self.inner.finish()
            self._finish = False

    def _relocate(self) -> None:
        """Place the inner arm at the position of the altered one."""
        self.inner.resume()
        self.inner.joints = self.joints
        self.inner.abandon()
        self._moves.clear()
        self._last, self._tip = None, None


@dataclass
class AlterMotion:
    """The option's instructions in addition to the motion stack.  nominal: joint speeds of the arm per s."""

    stack: MotionStack
    arm: AlteredArm
    nominal: Sequence[float]
    unit_m: float = 1e-3
    _asked: bool = field(init=False, default=False)  # alterBegin has answered 0, and no later one 1

    def alter_movej(self, target: Target, tool: Tool, mdesc: Mdesc, frame: Frame | None = None) -> int | None:
        """As movej, alterable (doubt D14); the configuration cannot change along the altered path."""
        self.arm.alterable = True
        try:
            return self.stack.movej(target, tool, mdesc, frame)
        finally:
            self.arm.alterable = False

    def alter_movel(self, target: PoseTarget, tool: Tool, mdesc: Mdesc, frame: Frame | None = None) -> int | None:
        """As movel, alterable."""
        self.arm.alterable = True
        try:
            return self.stack.movel(target, tool, mdesc, frame)
        finally:
            self.arm.alterable = False

    def alter_movec(self, via: PoseTarget, target: PoseTarget, tool: Tool, mdesc: Mdesc, frame: Frame | None = None) -> int | None:
        """As movec, alterable."""
        self.arm.alterable = True
        try:
            return self.stack.movec(via, target, tool, mdesc, frame)
        finally:
            self.arm.alterable = False

    def alter_begin(self, reference: Frame | Tool, mdesc: Mdesc) -> int:
        """alterBegin(frame or tool, mdesc): 0 waits for its path, 1 (once when asked again on it), -1, -2, -3; RuntimeFault 100..106."""
        kind = Reference.FRAME if isinstance(reference, Frame) else Reference.TOOL
        limits = limits_of(mdesc, self.nominal, self.unit_m)
        if self._asked and self.arm.alter.waits:
            return WAITS
        if self._asked and self.arm.alter.mode is Mode.ACTIVE:
            self._asked = False
            return DONE
        answer = self.arm.alter.begin(kind, reference.pose, limits, apart=self.arm.apart)
        self._asked = answer == WAITS
        return answer
