"""Blocks of a synchronous part before they run: tried by the rules of their belt, and turned into what planner and cycle drive.

Type 1: blocks as seen from the belt, for the planner.  Types 2 and 3: coordinates of the tool (x, y, z, rotation vector from the
orientation at the start of the part, additional axes; m and rad) that follow the belt, for the cycle.  AX-543, AX-544.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf, isfinite, isnan, nan

from motion.errors import MotionError
from motion.geometry.frames import IDENTITY, Pose, Rotation, compose
from motion.planner.block_paths import base_pose, block_fault, check_numbers, extra_of
from motion.planner.relative import check_shift, moved, moved_extra, shown, unwound
from motion.planner.robot import Machine
from motion.program.blocks import Blend, Block, Frame, Interpolation, JointTarget, OnBelt, PoseTarget, Shift, Synchron
from motion.program.errors import BlockError
from motion.sync.belt_state import Watch
from motion.sync.belts import Belt, Type
from motion.sync.coordinates import coordinates
from motion.sync.endless_axis import bearing
from motion.sync.errors import NOT_POSSIBLE, TEXTS, BeltError
from motion.sync.facts import BeltFacts, SynchronOrder
from motion.sync.pace import Pace
from motion.sync.parallel import Carrier
from motion.sync.synchronous_part import BeltBlock, SynchronPart

PATH_ACCEL = 2.0  # m/s2: types 2 and 3 where neither block nor robot has an acceleration along the path (AX-544)
CYCLE_S = 0.01  # of the trial; no rule that is tried depends on it


def seen_from(block: Block, carrier: Carrier, reference: float) -> Block:
    """A block of a part of type 1 as the planner wants it; a block without a belt value is meant for the reference."""
    if block.on_belt is None:
        return block
    shift = carrier.frame(block.on_belt.value - reference).inverse()
    return replace(block, frame=Frame(block.frame.name, compose(shift, block.frame.pose)))


@dataclass
class BeltPlan:
    """One part.  start: (axes,) position of the robot before it; number: of its first block in the program; kinematic: the robot's number
    in its cell, one of those that follow the belt."""

    facts: BeltFacts
    belt: int  # place among the belts, from 0
    synchron: Synchron
    machine: Machine
    start: Sequence[float]
    number: int
    kinematic: int = 1
    blocks: list[BeltBlock] = field(default_factory=list)
    tool: Pose = IDENTITY
    reference: float = nan
    _trial: SynchronPart | None = None
    _rotation: Rotation | None = None
    _end: Pose = IDENTITY  # types 2 and 3: of the tool after the last block
    _count: int = 0

    @property
    def order(self) -> SynchronOrder:
        """For the cycle."""
        at = nan if self.synchron.at is None else self.synchron.at
        facts = self.facts
        return SynchronOrder(self.belt, facts.kind, at, self.reference, self.number, self.tool, facts.tolerance, self.kinematic)

    @property
    def carrier(self) -> Carrier:
        """How the belt carries this robot."""
        return self.facts.carriers[self.kinematic]

    def add(self, block: Block) -> Block:
        """The next block, checked; what a route may try: the block as the robot sees it.  Raises BlockError with the program's number."""
        number = self.number + self._count
        try:
            made = self._seen(block) if self.facts.kind is Type.PARALLEL else self._followed(block)
        except BeltError as error:
            words = str(error).partition(f" ({error.code}")[0]
            raise BlockError(f"{words}, belt {self.facts.name}", code=error.code, block=number, source="rho 3") from error
        except MotionError as error:
            raise block_fault(error, number, self.machine) from error
        self._count += 1
        return made

    def seen_at(self, engaged: float) -> tuple[float, ...]:
        """(axes,) of `start` as seen from a belt of type 1, got onto at this value; an axis parallel to it has no target value and keeps
        its position."""
        if isnan(self.reference):
            self.reference = engaged
        moved = bearing(self.carrier, self.machine.kinematics, self.machine.limits)
        own, others = tuple(self.start[: moved.axes]), self.start[moved.axes :]
        frame = self.carrier.frame(engaged - self.reference)
        return (*moved.follow(compose(frame.inverse(), moved.forward(own)), own), *others)

    def _seen(self, block: Block) -> Block:
        if self.carrier.joint is not None:
            self._check_beside(block, self.carrier.joint)
            return block
        self._check_place(block)
        if block.shift is not None and block.on_belt is not None:
            raise BlockError(
                f"belt= has no place in a relative block of type 1: its target lies on belt {self.facts.name} as the one before"
            )
        if isnan(self.reference) and self._count == 0:
            given = self.synchron.at if self.synchron.at is not None else block.on_belt.value if block.on_belt else None
            self.reference = nan if given is None else given
        if isnan(self.reference) and block.on_belt is not None:
            raise BlockError(f"belt= needs at= of its part, or belt= in the first block of it (belt {self.facts.name})")
        return seen_from(block, self.carrier, self.reference)

    def _check_beside(self, block: Block, joint: int) -> None:
        """An endless axis parallel to the belt has no places on it, only ways (L11609-11615)."""
        given = isinstance(block.target, JointTarget) or (joint >= self.machine.arm and bool(block.target.extra))
        if block.shift is not None:
            check_shift(block.shift)
        if block.on_belt is not None or (block.shift is None and given):
            what = "belt=" if block.on_belt is not None else f"an absolute place of {self.machine.name(joint)}"
            why = f"{what}: the axis parallel to belt {self.facts.name} is endless and moves by differences only, rel joints or rel pose"
            raise BlockError(f"{TEXTS[NOT_POSSIBLE]}: {why}", code=NOT_POSSIBLE, source="rho 3")

    def _check_place(self, block: Block) -> None:
        axes = isinstance(block.target, JointTarget) if block.shift is None else block.shift.angles is None
        if axes:
            raise BlockError(f"a place of the axes does not lie on belt {self.facts.name}: a pose is needed")

    def _followed(self, block: Block) -> Block:
        if block.on_belt is None or self.synchron.at is None:
            what = "belt=" if block.on_belt is None else "at= of the part, the belt value of the point before it"
            raise BlockError(f"{what} is needed with a belt of type {self.facts.kind.value} ({self.facts.name})")
        if block.angle is not None:
            raise BlockError(f"angle= has no place on a belt of type {self.facts.kind.value} ({self.facts.name}): its blocks end at points")
        check_numbers(block if block.shift is None else replace(block, shift=None, target=PoseTarget(IDENTITY)))
        if self._trial is None:
            self.tool = block.tool.pose
            pose = self.machine.kinematics.forward(tuple(self.start[: self.machine.arm])) @ self.tool
            self._rotation = pose.rotation
            position = (*coordinates(pose, pose.rotation), *self.start[self.machine.arm :])
            self._trial = SynchronPart(self._belt(), self.kinematic, position, self.synchron.at)
            self._end = pose
        if block.tool.pose != self.tool:
            raise BlockError("the tool cannot change in a synchronous part")
        if block.shift is not None and block.kind is not Interpolation.PTP:
            block = self._absolute(block, block.shift, block.on_belt)
        block = unwound(block, (*self.start[: self.machine.arm], *self._additional), self.machine)
        made = self._block(block)
        self._trial.add(made)
        self.blocks.append(made)
        self._end = base_pose(block, tuple(self.start), self.machine)
        return replace(block, blend=Blend())

    @property
    def _additional(self) -> tuple[float, ...]:
        """Additional axes after the last block."""
        return self.blocks[-1].target[6:] if self.blocks else tuple(self.start[self.machine.arm :])

    def _absolute(self, block: Block, shift: Shift, on_belt: OnBelt) -> Block:
        """A relative block with the place and belt value it leads to: belt= is a difference, too, as the belt is a coordinate of the
        point (L6249, AX-567)."""
        self._check_place(block)
        check_shift(shift)
        before = self.blocks[-1] if self.blocks else None
        extra = moved_extra(shift, shown(self._additional, self.machine.limits[self.machine.arm :]))
        pose = moved(shift, block.frame.pose.inverse() @ self._end)
        belt = on_belt.value + (before.belt if before else self.synchron.at or 0.0)
        return replace(block, target=PoseTarget(pose, extra=extra), on_belt=replace(on_belt, value=belt), shift=None)

    def _belt(self) -> Belt:
        """One that stays at 0: enough for the rules of blocks."""
        return Belt(self.belt + 1, self.facts.data, Watch(CYCLE_S), kind=self.facts.kind, tolerance=self.facts.tolerance)

    def _block(self, block: Block) -> BeltBlock:
        assert self._rotation is not None and block.on_belt is not None
        if block.kind is Interpolation.PTP:
            pose = IDENTITY  # it is refused whatever its target
        else:
            pose = base_pose(block, tuple(self.start), self.machine)
        via: tuple[float, ...] = ()
        extra = extra_of(block, (*self.start[: self.machine.arm], *self._additional), self.machine)
        if block.via is not None:
            via = (*coordinates(block.frame.pose @ block.via.pose, self._rotation), *extra)
        target = (*coordinates(pose, self._rotation), *extra)
        on, pace = block.on_belt, block.pace
        own = self.machine.path_accel if isfinite(self.machine.path_accel) else PATH_ACCEL
        law = Pace(inf, pace.path_accel or own * min(pace.accel, 1.0), pace.path_decel or own * min(pace.decel, 1.0))
        return BeltBlock(target, on.value, block.kind, pace=law, first=on.first, third=on.third, via=via)
