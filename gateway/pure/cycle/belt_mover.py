"""The mover of a cell with belts: synchronous parts of a program in addition to its paths.  Pure."""

from collections.abc import Callable, Sequence

from gateway.pure.cycle.belts import BeltFault, CoreBelts
from gateway.pure.cycle.mover import Mover
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.belts import belt_block_of, synchron_of
from gateway.pure.image.records.cell import InputImage
from gateway.pure.image.records.planner import Part, PieceRecord
from gateway.pure.planning.belt_statements import ActOrder, act_of
from motion.errors import MotionError
from motion.execution.pieces import Piece
from motion.execution.stepper import Sample, State
from motion.execution.timed import TimedPiece


class BeltMover(Mover):
    """Of one core.  `belts` and `off`, which switches all drives off, are given once, before the first cycle."""

    belts: CoreBelts
    off: Callable[[Reason], None]
    _awaiting = 0  # job whose SYNC waits

    @property
    def free(self) -> bool:
        """Return whether neither a path nor a synchronous part is running."""
        return self.stepper.state is State.IDLE and self.belts.free

    def set_override(self, value: float) -> None:
        if self.belts.set_override(value):
            self.override = value
        else:
            super().set_override(value)

    def abandon(self) -> None:
        if self.belts.free:
            super().abandon()
        else:
            self._leave_belt(Reason.ABANDONED)

    def stop(self, reason: Reason) -> None:
        if self.belts.free:
            super().stop(reason)
        else:
            self._leave_belt(reason)

    @property
    def bound(self) -> bool:
        """Return whether a synchronous part is running or SYNC waits."""
        return not self.belts.free or self.belts.awaits or super().bound

    def leave(self) -> bool:
        """A synchronous part needs all axes of its robot."""
        return (self.belts.free or self.all_wanted()) and super().leave()

    def drop(self, reason: Reason) -> None:
        super().drop(reason)
        self.belts.drop()

    def step(self, inputs: InputImage) -> Sample:
        """Counters, and the set values of the part under way."""
        belts, state, self._inputs = self.belts, self._state, inputs
        if self.start.on:
            self.hold()
        if self.program.backward:
            self._retrace()
        sample = belts.step(self.stepper, inputs)
        if self.gate.kept:
            sample = self._kept(sample)
        if belts.awaits:
            if self._awaiting != self.program.job:
                belts.forget()
            elif self.stepper.state is State.IDLE and belts.met(inputs):  # the blocks before it have been run
                state.parts += 1
        state.belt, state.belt_speed = belts.shown.counter, belts.shown.watch.speed
        if belts.engaged_now:
            state.engaged = belts.value
            state.parts += 1
        if belts.fault is not None:
            self._belt_fault(belts.fault)
        elif not belts.free and self._end_belt():
            self.stepper.place(sample.q)  # the part is over: from here on the axes are the stepper's again
        if self.program.job:
            self._attend(sample)
        return sample

    def _counters(self) -> Sequence[float]:
        return [belt.counter for belt in self.belts.all.all]

    def _load(self, piece: Piece | TimedPiece) -> None:
        if not self.belts.load(piece):
            super()._load(piece)

    def _take_belt(self, record: PieceRecord) -> None:
        """SYNCHRON, or a block of types 2 and 3; what does not fit ends the program before it moves."""
        program, belts = self.program, self.belts
        try:
            if record.part is Part.BELT_ACT:
                self._act(act_of(record))
                return
            if missing := self.gate.missing_of(program.mask):
                self._refuse(missing)
                return
            if self._homings.job or self._state.emergency or not self.all_enabled(self.program.mask):
                raise MotionError("the axes are not all enabled and free")
            if record.part is Part.BELT_BLOCK:
                belts.add(belt_block_of(record))
                return
            belts.synchron(synchron_of(record), [axis.set for axis in self._axes])
            belts.set_override(self.override)
        except MotionError:
            super()._take_belt(record)
            return
        self._begin(program.job)
        program.begun = True

    def _act(self, order: ActOrder) -> None:
        """Run a part without motion: it is over at once, or when the belt is there."""
        program = self.program
        self.belts.act(order)
        if not program.begun:
            self._begin(program.job)
            program.begun = True
        self._awaiting = program.job
        if not self.belts.awaits:
            self._state.parts += 1

    def _end_belt(self) -> bool:
        """Nothing more comes of the part: a robot of type 1 leaves its belt, one of types 2 and 3 stops at its last point.  True: over."""
        program, belts = self.program, self.belts
        if not (program.rests or program.complete or not program.job):
            return False
        if belts.carries:
            over = self.stepper.state is State.IDLE and belts.release()
        else:
            over = belts.done or (not belts.running and (program.complete or not program.job))
        if over:
            self._drop_part()
        return over

    def _drop_part(self) -> None:
        self.belts.drop()
        self.stepper.set_override(self.override)  # on the belt it was what the joints allow

    def _leave_belt(self, reason: Reason) -> None:
        """End a part that was stopped: the axes come to rest whatever the belt does."""
        belts, program = self.belts, self.program
        if program.job and not program.failed:
            self._end_program(reason)
            program.met = True  # its remaining records are dropped
            self._state.stop_cause = reason
        fault = belts.stop()
        if fault is not None:
            self._belt_fault(fault)
        elif not belts.carries:
            self._drop_part()
        elif self.stepper.state is not State.IDLE:
            self.stepper.abandon()

    def _belt_fault(self, fault: BeltFault) -> None:
        """End a part that cannot continue; with types 2 and 3 READY opens, so that the belt can be stopped (rho3 L6112)."""
        state, belts = self._state, self.belts
        belts.fault = None
        state.belt_code, state.belt_block, state.belt_axis = fault.code, belts.block, fault.axis
        if fault.opens_ready:
            state.emergency = True
            self.off(Reason.BELT_FAULT)
        else:
            self._leave_belt(Reason.BELT_FAULT)
