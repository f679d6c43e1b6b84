"""The mover of a cell with a correction ([alter]): alterable parts of a program, alone or combined with belts.  Pure."""

from gateway.pure.cycle.alter import CoreAlter
from gateway.pure.cycle.belt_mover import BeltMover
from gateway.pure.cycle.homing import Homings
from gateway.pure.cycle.lane_parts import LaneParts
from gateway.pure.cycle.mover import Mover
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.alter import FREEZE, alter_of
from gateway.pure.image.records.cell import CellState, InputImage, OrderRecord
from gateway.pure.image.records.planner import PieceRecord, SwitchAt
from motion.errors import MotionError
from motion.execution.stepper import Sample, State


class AlterMover(Mover):
    """`alter` is given once, before the first cycle."""

    alter: CoreAlter

    @property
    def free(self) -> bool:
        """Return whether neither a path nor a part of another kind is running."""
        return super().free and not self.alter.on

    @property
    def moving(self) -> bool:
        return super().moving or self.alter.moves

    def order_program(self, record: OrderRecord) -> None:
        if not self.busy:
            self.alter.reset()
        super().order_program(record)

    def stop(self, reason: Reason) -> None:
        """Stop the mover.  At the end of an alterable path nothing is left to continue: the part is over."""
        if self.alter.on and self.stepper.state is State.IDLE:
            self._leave_part(reason)
        else:
            super().stop(reason)

    @property
    def bound(self) -> bool:
        """Return whether an alterable part is running."""
        return self.alter.on or super().bound

    def leave(self) -> bool:
        """An alterable part needs all axes of its robot."""
        return (not self.alter.on or self.all_wanted()) and super().leave()

    def drop(self, reason: Reason) -> None:
        super().drop(reason)
        self.alter.drop()

    def step(self, inputs: InputImage) -> Sample:
        """Set values, with the correction in an alterable part."""
        alter = self.alter
        alter.listen(inputs, self._state.sync_ns)
        sample = super().step(inputs)
        if alter.on:
            sample = self._corrected(sample, inputs)
        alter.publish(self._outputs)
        return sample

    def _corrected(self, path: Sample, inputs: InputImage) -> Sample:
        alter, program = self.alter, self.program
        if not program.job:  # abandoned: nothing is corrected any more
            alter.freeze()
        sample = alter.step(path, self.override)
        if alter.fault is not None:
            self._alter_fault(*alter.fault)
        failed = not program.job or program.failed
        if self.stepper.state is State.IDLE and (failed or ((program.rests or program.complete) and alter.may_end(inputs))):
            alter.drop()
            self.stepper.place(sample.q)  # from here on the axes are the stepper's again
        return sample

    def _alter_fault(self, code: int, axis: int) -> None:
        state, alter = self._state, self.alter
        alter.fault = None
        state.belt_code, state.belt_block, state.belt_axis = code, 0, axis
        self._leave_part(Reason.ALTER_FAULT)

    def _leave_part(self, reason: Reason) -> None:
        """The program is over; the path brakes with the correction as it is."""
        program = self.program
        if program.job and not program.failed:
            self._end_program(reason)
            program.met = True  # its remaining records are dropped
            self._state.stop_cause = reason
        self.alter.freeze()
        if self.stepper.state is not State.IDLE:
            self.stepper.abandon()

    def _take_alter(self, record: PieceRecord) -> None:
        """alterBegin; what does not fit ends the program before it moves."""
        if missing := self.gate.missing_of(self.program.mask):
            self._refuse(missing)
            return
        try:
            if self._homings.job or self._state.emergency or not self.all_enabled(self.program.mask):
                raise MotionError("the axes are not all enabled and free")
            self.alter.begin(alter_of(record), [axis.set for axis in self._axes])
        except MotionError:
            super()._take_alter(record)

    def _switch(self, entry: SwitchAt) -> None:
        if entry.number == FREEZE:
            self.alter.freeze()
        else:
            super()._switch(entry)


class AlterBeltMover(AlterMover, BeltMover):
    """Both kinds of part; a program has them in sequence."""


def make_mover(parts: LaneParts, state: CellState, homings: Homings) -> Mover:
    """The least that the cell needs."""
    kinds = (Mover, AlterMover), (BeltMover, AlterBeltMover)
    kind = kinds[parts.belts is not None][parts.alter is not None]
    mover = kind(parts.axes, state, parts.outputs, homings, parts.period_s, parts.foresight)
    if parts.belts is not None and isinstance(mover, BeltMover):
        mover.belts, mover.off = parts.belts, parts.off
    if parts.alter is not None and isinstance(mover, AlterMover):
        mover.alter = parts.alter
    return mover
