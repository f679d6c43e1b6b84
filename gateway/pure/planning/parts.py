"""Parts of a program that begin only when the axes rest where the part before ended: blocks that end with an input, belts, alterable
paths.  Pure.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from gateway.pure.image.records.alter import FREEZE, alter_record
from gateway.pure.image.records.belts import belt_block_record, synchron_record
from gateway.pure.image.records.inputs import FlyingAt, StartOrder, flying_record, start_record
from gateway.pure.image.records.planner import (
    NO_LIMIT,
    FunctionAt,
    MeasuringFacts,
    Part,
    PieceRecord,
    SwitchAt,
    UntilInput,
    function_record,
    switch_record,
    until_record,
)
from gateway.pure.image.records.points import LatchAt, ReferencePathPoint, latch_record, machine_record, recall_record, tape_record
from gateway.pure.planning.belt_statements import act_order, act_record, belts_after
from motion.errors import LimitError, MotionError
from motion.geometry.limits import check_targets
from motion.measure.errors import BAD_MEASURING_SYSTEM, INADMISSABLE_INPUT, POINT_INVALID, POINT_NOT_DEFINED, ProgramFault
from motion.measure.inputs import InputKind, input_of
from motion.planner.marks import Mark
from motion.planner.relative import shown
from motion.planner.robot import Machine
from motion.planner.team import Team
from motion.program.blocks import (
    MEASURED,
    Act,
    Alteration,
    BeltAct,
    Block,
    Flying,
    JointTarget,
    Latching,
    MachinePoint,
    Output,
    Recording,
    StartWait,
    Synchron,
    Until,
)
from motion.program.errors import BlockError
from motion.program.team import Shared
from motion.sync.alterable import order_of
from motion.sync.belts import Type
from motion.sync.facts import BeltFacts
from motion.sync.planned import BeltPlan
from motion.sync.reserve import ACCEL, JERK, reserved


@dataclass
class Coming:
    """number: of its first block; tried: the part on a belt as it was looked at; engages: nothing but SYNCHRON of a type 1, the path
    of its blocks comes with the next part."""

    number: int
    blocks: list[Block] = field(default_factory=list)
    shared: list[Shared] = field(default_factory=list)  # of a program of several kinematics, which has no other blocks
    tried: BeltPlan | None = None
    engages: bool = False
    alteration: Alteration | None = None  # of an alterable part
    error: str = ""  # label at which to continue when the input of its block did not come
    otherwise: str = ""  # label at which to continue when its @MPOS or entry is missing
    label: str = ""  # before it
    act: BeltAct | None = None  # of a belt: nothing else happens in this part
    point: tuple[float, ...] = ()  # places the axes get (SF 3); nothing else happens in this part
    recall: int = 0  # entry of the reference path that is asked for (SF 31); nothing else happens in this part
    data: bytes = b""  # of the file its block runs (MOVE_FILE)
    inside: Synchron | None = None  # where the act is, on the belt
    kinematic: int = 1  # whose part that is, in the cell
    member: int = 0  # whose part that is, of several kinematics of the program, from 0
    open: bool = False  # it has begun, and other blocks may follow

    def holds(self, block: Block) -> bool:
        """Whether the block belongs to this part."""
        if (
            self.engages
            or self.act is not None
            or self.point != ()
            or self.recall != 0
            or block.recorded != 0
            or block.acts
            or block.label
            or block.until is not None
            or block.wait is not None
            or block.target == MEASURED
            or block.file is not None
            or (self.blocks and (self.blocks[-1].until is not None or self.blocks[-1].file is not None))
        ):
            return False
        if block.alteration != self.alteration:
            return False
        return block.synchron == (None if self.tried is None else self.tried.synchron)

    def takes(self, shared: Shared) -> bool:
        """The same for a block of several kinematics."""
        return self.shared != [] and not (shared.asks or shared.label or self.shared[-1].ends)

    @property
    def goes_on(self) -> bool:
        """It may have begun before all its blocks are known."""
        if self.shared:
            return not self.shared[-1].ends
        alone = self.engages or self.act is not None or self.point != () or self.recall != 0 or self.follows
        return not alone and self.blocks != [] and self.blocks[-1].until is None and self.blocks[-1].file is None

    @property
    def alone(self) -> bool:
        """On a belt or corrected: of several kinematics one moves."""
        return self.tried is not None or self.alteration is not None

    @property
    def asks_met(self) -> bool:
        """Its block ends with an input."""
        return any(row.until is not None for row in self.blocks) or any(
            block is not None and block.until is not None for row in self.shared for block in row.moves
        )

    @property
    def follows(self) -> bool:
        """Run by the cycle itself, from block to block with the belt."""
        return self.tried is not None and self.tried.facts.kind is not Type.PARALLEL

    def begins(self, job: int, generation: int, kinematic: int) -> list[PieceRecord]:
        """alterBegin of an alterable part.  kinematic: number of the robot in its cell."""
        if self.alteration is None:
            return []
        return [alter_record(job, generation, order_of(self.alteration, self.blocks[0].tool, self.number, kinematic))]

    @staticmethod
    def marked(block: Block) -> Block:
        """alterEnd at its end, where it has one."""
        return replace(block, outputs=(*block.outputs, Output(FREEZE, 1.0))) if block.freeze else block

    def own(self, mask: int, job: int, generation: int) -> PieceRecord | None:
        """What the cycle does at rest, and nothing else in this part."""
        if self.point:
            return machine_record(job, generation, mask, self.point)
        return recall_record(job, generation, self.recall, self.kinematic) if self.recall else None

    def again(self, machine: Machine, start: Sequence[float]) -> BeltPlan:
        """The same part from the actual position of the robot."""
        assert self.tried is not None
        return replace(self.tried, machine=machine, start=start, blocks=[], _trial=None, _rotation=None, _count=0)

    def followed(self, machine: Machine, start: Sequence[float], job: int, generation: int) -> list[PieceRecord]:
        """Everything of a part of type 2 or 3; raises BlockError."""
        plan = self.again(machine, start)
        for block in self.blocks:
            plan.add(block)
        records = [synchron_record(job, generation, plan.order)]
        records += [belt_block_record(job, generation, block) for block in plan.blocks]
        return [*records, PieceRecord(Part.REST, job, generation)]

    def engagement(self, job: int, generation: int) -> PieceRecord:
        """SYNCHRON of a type 1."""
        assert self.tried is not None
        return synchron_record(job, generation, self.tried.order)

    def carried(self, plan: BeltPlan, engaged: float) -> tuple[Machine, Sequence[float], list[Block]]:
        """Machine, start and blocks of a type 1 as the planner plans them: seen from the belt, which began at `engaged`.  plan: again()."""
        places = plan.seen_at(engaged)
        planned = replace(plan.machine, limits=tuple(reserved(plan.machine.limits)), shares=(ACCEL, JERK))
        return planned, places, [plan.add(block) for block in self.blocks]


def begun(
    block: Block,
    number: int,
    belts: Sequence[BeltFacts],
    machine: Machine,
    start: Sequence[float],
    kinematic: int,
    before: Coming | None = None,
) -> list[Coming]:
    """Return the parts that begin with this block, after the previous one.  Raise BlockError for a belt that the robot does not follow or
    that has no room for the block.  kinematic: number of the robot in its cell.
    """
    synchron: Synchron | None = block.synchron
    label = "" if outside(block) else block.label
    if synchron is None:
        error = block.until.error if block.until is not None else ""
        return [Coming(number, alteration=block.alteration, error=error, otherwise=block.otherwise, label=label)]
    if block.until is not None:
        raise BlockError("until= has no place in a synchronous part", block=number)
    if block.wait is not None or block.target == MEASURED:
        raise BlockError("wait= and mpos have no place in a synchronous part", block=number)
    own = {each.name: n for n, each in enumerate(belts) if kinematic in each.carriers}
    place = own.get(synchron.belt)
    if place is None:
        whose = "this robot follows" if any(each.name == synchron.belt for each in belts) else "this cell has"
        known = ", ".join(own) or "none"
        raise BlockError(f"belt {synchron.belt}: Inadmiss. Belt-No; {whose} {known}", code=93, block=number, source="rho 3")
    plan = BeltPlan(belts[place], place, synchron, machine, start, number, kinematic)
    for act in inside(block):
        act_order(act, belts, number, synchron, kinematic)
    if belts[place].kind is not Type.PARALLEL:
        return [Coming(number, tried=plan, label=label)]
    on = before is not None and before.tried is not None and before.tried.synchron == synchron and not block.label
    found = [] if on else [Coming(number, tried=plan, engages=True, label=label), Coming(number, tried=plan)]
    for act in inside(block):
        found += [Coming(number, act=act, inside=synchron, kinematic=kinematic), Coming(number, tried=plan)]
    return found


def outside(block: Block) -> tuple[Act, ...]:
    """Return the belt statements before the block's part; those in it follow them."""
    return tuple(act for act in block.acts if act not in inside(block))


def inside(block: Block) -> tuple[BeltAct, ...]:
    """Those in the synchronous part of the block."""
    return tuple(act for act in block.acts if isinstance(act, BeltAct) and act.inside and block.synchron is not None)


def ending(part: Coming, belts: Sequence[BeltFacts], job: int, generation: int) -> PieceRecord:
    """What ends the path before this part: the axes rest, or SYNC waits on the belt."""
    order = (
        act_order(part.act, belts, part.number, part.inside, part.kinematic) if part.act is not None and part.inside is not None else None
    )
    return PieceRecord(Part.REST, job, generation) if order is None else act_record(job, generation, order)


def acting(
    acts: Sequence[Act], number: int, belts: Sequence[BeltFacts], label: str, robots: Machine | Team
) -> tuple[list[Coming], Sequence[BeltFacts]]:
    """Return their parts, before the block `number`, and the belts after them.  Raise BlockError."""
    found: list[Coming] = []
    for act in acts:
        if isinstance(act, MachinePoint):
            point = _placed(act, number, robots)
            found.append(Coming(number, point=point, label="" if found else label, member=act.member))
            continue
        act_order(act, belts, number)
        belts = belts_after(act, belts)
        found.append(Coming(number, act=act, label="" if found else label))
    return found, belts


def _placed(act: MachinePoint, number: int, robots: Machine | Team) -> tuple[float, ...]:
    """SF 3: inside the travel, which belongs to the new places."""
    if isinstance(robots, Team):
        try:
            return _placed(act, number, robots.machines[act.member])
        except BlockError as error:
            raise robots.with_kinematic(error, act.member) from error
    try:
        if act.inside:
            raise MotionError("mach_pos is not allowed in synchronous and alter sections")
        check_targets(robots.limits, act.q)
    except LimitError as error:
        what = f"mach_pos: {str(error).partition(': ')[2]}"
        raise BlockError(what, block=number, axis=error.axis) from error
    except MotionError as error:
        raise BlockError(f"mach_pos: {error}", block=number) from error
    return act.q


def later_fault(error: BlockError, blocks: int) -> BlockError:
    """Return a block's fault with its block number shifted by `blocks`."""
    return BlockError(error.what, code=error.code, block=error.block + blocks, axis=error.axis, source=error.source)


def apart(block: Block) -> bool:
    """Whether a block always begins a part of its own."""
    asks = block.until is not None or block.wait is not None or block.target == MEASURED or block.recorded != 0 or block.file is not None
    return asks or bool(block.synchron or block.alteration or block.acts)


def measured_at(found: Sequence[float | None], mask: int) -> list[float | None]:
    """@MPOS of a robot's axes; found: of all axes of the cell."""
    return [found[n] if n < len(found) else None for n in range(mask.bit_length()) if mask >> n & 1]


@dataclass
class Measuring:
    """@MPOS for a program of a cell: the input of a block, and the positions of the axes of `mask` at its edge.  channels: of the cell."""

    channels: Mapping[int, MeasuringFacts]
    systems: int = 0  # measuring systems of the cell: its axes, then its belts
    last: int = 0  # axes that will have been measured, of each kinematic by its own last measurement

    def wanted(self, until: Until, mask: int) -> UntilInput:
        """Raises ProgramFault inadmissable input for a channel the robot does not have."""
        within = NO_LIMIT if until.within is None else until.within
        if not until.channel:
            return UntilInput(until.number, until.value, mask, within=within)
        asked, own = input_of(until.channel), self._own(mask)
        facts, runs_on = own.get(asked.wire), asked.kind is InputKind.MODIFIED
        if facts is None or asked.kind is InputKind.NORMAL:
            known = ", ".join(f"ch{channel}" for channel in sorted(own)) or "none"
            raise ProgramFault(INADMISSABLE_INPUT, f"channel {until.channel}; the robot has {known} ([[measuring]])")
        return UntilInput(facts.input, until.value, facts.mask & mask, asked.by_edge, facts.drives & mask, within, runs_on)

    def start(self, wait: StartWait, mask: int) -> StartOrder:
        """Raise ProgramFault inadmissable input for anything but a high-speed input of the robot."""
        if not wait.channel:
            return StartOrder(wait.number, wait.value, wait.delay)
        return StartOrder(self._wire(wait.channel, InputKind.HIGH_SPEED, mask).input, wait.value, wait.delay)

    def flying(self, piece: int, after: float, call: Flying, mask: int) -> FlyingAt:
        """Raise ProgramFault inadmissable input for anything but a probe of the robot."""
        wire = self._wire(call.channel, InputKind.PROBE, mask)
        return FlyingAt(piece, after, call.channel, wire.input, wire.mask & mask, call.edge, wire.drives & mask)

    def latch(self, mark: Mark, call: Latching, mask: int, job: int, generation: int) -> PieceRecord:
        """setLatch.  Raise ProgramFault for a fast input that is not wired to the robot."""
        channel = self._latching(call, mask)
        wire = self.channels[channel]
        if wire.drives:
            at = FlyingAt(mark.piece, mark.after, channel, wire.input, wire.mask & mask, True, wire.drives & mask)
            return flying_record(job, generation, at)
        return latch_record(job, generation, LatchAt(mark.piece, mark.after, wire.input, wire.mask & mask, call.name))

    def _latching(self, call: Latching, mask: int) -> int:
        own = self._own(mask)
        channel = next((each for each, facts in own.items() if facts.latch == call.name), None)
        if channel is None:
            known = ", ".join(facts.latch for facts in own.values() if facts.latch) or "none"
            raise ProgramFault(INADMISSABLE_INPUT, f"set_latch {call.name}; the robot has {known} ([[measuring]] latch)")
        return channel

    def inputs(self, block: Block, mask: int, job: int, generation: int) -> list[PieceRecord]:
        """What the block that begins a part ends with and waits for."""
        found = []
        if block.until is not None:
            found.append(until_record(job, generation, self.wanted(block.until, mask)))
        if block.wait is not None:
            found.append(start_record(job, generation, self.start(block.wait, mask)))
        return found

    def marked(self, mark: Mark, mask: int, kinematic: int, job: int, generation: int) -> PieceRecord:
        """An output, a function or a measurement on a piece; mask, kinematic: of the robot it is about."""
        if isinstance(mark.function, Flying):
            return flying_record(job, generation, self.flying(mark.piece, mark.after, mark.function, mask))
        if isinstance(mark.function, Latching):
            return self.latch(mark, mark.function, mask, job, generation)
        if isinstance(mark.function, Recording):
            call = mark.function
            at = ReferencePathPoint(mark.piece, mark.after, call.system, call.distance, call.unit == "cycles", kinematic)
            return tape_record(job, generation, at)
        if mark.function is not None:
            return function_record(job, generation, FunctionAt(mark.piece, mark.after, mark.function))
        return switch_record(job, generation, SwitchAt(mark.piece, mark.after, mark.number, mark.value != 0.0))

    def _own(self, mask: int) -> dict[int, MeasuringFacts]:
        """Channels on whose boards the robot has axes."""
        return {channel: facts for channel, facts in self.channels.items() if facts.mask & mask}

    def _wire(self, channel: int, kind: InputKind, mask: int) -> MeasuringFacts:
        own = self._own(mask)
        facts = own.get(channel)
        if facts is None or input_of(channel).kind is not kind:
            known = ", ".join(f"ch{each}" for each in sorted(own) if input_of(each).kind is kind) or "none"
            word = "high-speed inputs" if kind is InputKind.HIGH_SPEED else "probes"
            raise ProgramFault(INADMISSABLE_INPUT, f"channel {channel}; {word} of the robot: {known} ([[measuring]])")
        return facts

    def check(self, block: Block, mask: int, machine: Machine) -> None:
        """Check before any motion that the block's measuring inputs exist and that the position it reads will have been measured."""
        if block.target == MEASURED and mask & ~self.last:
            own = (n for n in range(mask.bit_length()) if mask >> n & 1)
            missing = next(k for k, n in enumerate(own) if not self.last >> n & 1)
            raise BlockError(f"{POINT_NOT_DEFINED}: @MPOS is measured by until= or measure_on before it", axis=machine.name(missing))
        if block.wait is not None:
            self.start(block.wait, mask)
        for call in block.functions:
            if isinstance(call, Flying):
                stored = self.flying(0, 0.0, call, mask).mask
                self._measured(mask, 0 if call.edge is None else stored)
            elif isinstance(call, Latching):
                self._measured(mask, self.channels[self._latching(call, mask)].mask & mask)
            elif isinstance(call, Recording) and call.system > self.systems:
                raise BlockError(f"{BAD_MEASURING_SYSTEM} {call.system}: 1 .. {self.systems} exist", code=91, source="rho 3")
        if block.recorded:
            self.last &= ~mask  # the entry replaces @MPOS
        if block.until is not None:
            self._measured(mask, self.wanted(block.until, mask).mask)

    def _measured(self, mask: int, stored: int) -> None:
        """Of a kinematic's axes these, and no longer others; none: it is as it was."""
        self.last = self.last & ~mask | stored if stored else self.last

    @staticmethod
    def resolved(block: Block, places: Sequence[float | None], machine: Machine, number: int) -> Block:
        """@MPOS as it was measured; places: (axes,) None where nothing was."""
        if block.target != MEASURED:
            return block
        for n, place in enumerate(places):
            if place is None and block.recorded:
                raise BlockError(f"{POINT_INVALID}: no entry {block.recorded} is stored", code=90, block=number, source="rho 3")
            if place is None:
                raise BlockError(f"{POINT_NOT_DEFINED}: @MPOS was not measured", block=number, axis=machine.name(n))
        measured = [place for place in places if place is not None]
        return replace(block, target=JointTarget(shown(measured, machine.limits)), recorded=0)
