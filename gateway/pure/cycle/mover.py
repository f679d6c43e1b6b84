"""What moves the axes of a core along paths: the stepper, the piece or program it runs, and whether the axes arrived.  Pure.

A cell with belts or a correction has one more: gateway.pure.cycle.belt_mover, gateway.pure.cycle.alter_mover.
"""

from collections.abc import Callable, Sequence

from gateway.pure.cycle.path_mover import PathMover
from gateway.pure.cycle.points import set_machine_position
from gateway.pure.cycle.program import Entry
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import InputImage, set_bit
from gateway.pure.image.records.inputs import flying_of, start_of
from gateway.pure.image.records.planner import FunctionAt, Part, PieceRecord, SwitchAt, function_number, function_of, switch_of, until_of
from gateway.pure.image.records.points import latch_of, machine_of, recall_of, tape_of
from motion.axes.errors import AxisError
from motion.errors import LatePieceError, MotionError, PieceError
from motion.execution.pieces import Piece
from motion.execution.stepper import Sample, State
from motion.execution.timed import TimedPiece, decode_any
from motion.outputs.function import Function

ENTRIES: dict[Part, Callable[[PieceRecord], Entry]] = {  # done at a place of a piece
    Part.OUTPUT: switch_of,
    Part.FUNCTION: function_of,
    Part.FLYING: flying_of,
    Part.TAPE: tape_of,
    Part.LATCH: latch_of,
}
STILL = 1e-9  # m or rad
ARRIVAL_S = 2.0  # after the set values: an axis that is not in its window by then has not arrived


def why_refused(error: MotionError) -> Reason:
    """Return the reason for refusing a piece; if the piece is valid, its axes are off or not free."""
    match error:
        case LatePieceError():
            return Reason.PATH_LATE
        case PieceError():
            return Reason.PATH_JOIN
        case _:
            return Reason.NOT_READY


class Mover(PathMover):
    """Of one lane."""

    # ---- from the planner --------------------------------------------------------------------------------------------
    def feed(self, record: PieceRecord) -> None:
        """The next piece of the program, or the mark that nothing follows.  What belongs to another job is dropped."""
        program = self.program
        if record.generation != self._state.generation or record.job != program.job:
            return
        if record.part is Part.FAULT:
            self._end_program(Reason.PROGRAM_FAULT)
        elif record.part is Part.START:
            self.start.begin(start_of(record), self._inputs, self._state.sync_ns)
            self.stepper.set_override(0.0 if self.start.on else self.override)
        elif record.part is Part.UNTIL:
            self.measure.begin(until_of(record), self._inputs, self._state.sync_ns)
            if self.gate.kept and self.free:
                self.gate.accepting()
                self._begin_at_set_values()
        elif record.part in (Part.REST, Part.FLUSH):
            self._rest(flushed=record.part is Part.FLUSH)
        elif record.part in (Part.SYNCHRON, Part.BELT_BLOCK, Part.BELT_ACT):
            self._take_belt(record)
        elif record.part is Part.ALTER:
            self._take_alter(record)
        elif record.part in (Part.MACHINE, Part.RECALL):
            self._point(record)
        elif record.part in ENTRIES:
            program.switch(ENTRIES[record.part](record))
        elif record.part is Part.LAST:
            program.complete = True
            if not program.begun and (program.switches or self.start.on or program.met):
                # nothing has moved, and something is done or waited for here, or an input that ends the part has its value already
                self._begin(program.job)
                program.begun = True
            elif not program.begun:
                self._state.done_job = program.job
                self._clear()
        else:
            self._take_piece(record.piece)

    def _rest(self, *, flushed: bool) -> None:
        """End the part.  flushed: it is over where the axes come to rest, and later records belong to the next part."""
        program = self.program
        program.rests = True
        if not flushed:
            return
        self.stepper.abandon()
        self.measure.end()
        self._release()
        program.switches.clear()
        program.met = program.flushed = True
        self.program.held, self.program.backward = False, False

    def planner_lost(self) -> None:
        """What was committed runs to its end, which is at rest on the path; the program is over."""
        if self.program.waits:
            if self.start.on:  # what has not begun does not begin any more
                self.stepper.abandon()
            self._end_program(Reason.PLANNER_LOST)
            self._state.stop_cause = Reason.PLANNER_LOST

    def _take_piece(self, data: bytes) -> None:
        program = self.program
        if self.stepper.state is State.IDLE and not program.met and not self.start.on:
            self._needs_no_way()
        if program.met or program.failed:
            return
        try:
            piece = decode_any(data)
            if self._homings.job or self._state.emergency or self.running not in (0, program.job) or not self._may_run(piece):
                raise MotionError("the axes of the piece are not all enabled and free")
            self._load(piece)
        except AxisError as error:
            self._refuse(error.axis)
            return
        except MotionError as error:
            self._state.fail(program.job, why_refused(error))
            if program.begun:
                self.stepper.abandon()
                self.running = 0
            self._clear()
            return
        if not program.begun:
            self._begin(program.job)
            program.begun = True

    def _needs_no_way(self) -> bool:
        """At the beginning of a part: the input that ends it has its value already, or its time is 0; then nothing moves (rho3 4.3)."""
        has_value = self.measure.value_present(self._inputs)
        self.program.late = not has_value and self.measure.timeless()
        self.program.met = has_value or self.program.late
        return self.program.met

    def _may_run(self, piece: Piece | TimedPiece) -> bool:
        """Its axes follow; raises AxisError where some are out of the loop, and the piece moves them."""
        gate = self.gate
        if not gate.watches or not isinstance(piece, TimedPiece):
            return self.all_enabled(piece.mask)
        gate.check(piece, until=self.measure.on)
        if gate.kept and self.free and not self.stepper.ahead:
            self.stepper.place(gate.begin_of(piece))
        return True

    def _load(self, piece: Piece | TimedPiece) -> None:
        self.stepper.load(piece)
        if self.program.held:
            self.stepper.stop()

    def _point(self, record: PieceRecord) -> None:
        """Execute a part without motion, which is over at once; the axes rest."""
        if record.part is Part.RECALL:
            self.storing.tape.recall(*recall_of(record))
        else:
            set_machine_position(self._axes, self._state, machine_of(record))
            self._begin_at_set_values()
        if not self.program.begun:
            self._begin(self.program.job)
            self.program.begun = True
        self._state.parts += 1

    def _take_belt(self, record: PieceRecord) -> None:
        """The cell has no belts."""
        self._state.fail(record.job, Reason.NOT_READY)
        self._end_program(Reason.NOT_READY)

    def _take_alter(self, record: PieceRecord) -> None:
        """The cell has no correction."""
        self._state.fail(record.job, Reason.NOT_READY)
        self._end_program(Reason.NOT_READY)

    # ---- one cycle ---------------------------------------------------------------------------------------------------
    def step(self, inputs: InputImage) -> Sample:
        """Set values of all axes."""
        self._inputs = inputs
        if self.start.on:
            self.hold()
        if self.program.backward:
            self._retrace()
        sample = self.stepper.step()
        if self.gate.kept:
            sample = self._kept(sample)
        if self.program.job:
            self._attend(sample)
        return sample

    def _kept(self, sample: Sample) -> Sample:
        """Axes out of the loop stay where they are, until nothing of a program is left."""
        sample = self.gate.kept_in(sample)
        if not self.program.job and self.free:
            self.stepper.place(sample.q)
            self.gate.over()
        return sample

    def hold(self) -> None:
        """One cycle of a part that waits for its input."""
        if not self.program.job or self.start.step(self._inputs, self._state.sync_ns):
            self._release()
            if self.program.job and self.program.begun and self._needs_no_way():
                self.stepper.abandon()

    def store(self, actual: Sequence[float | None]) -> None:
        """actual: (axes,) as latched at this SYNC, None where the telegram did not come."""
        self.storing.store(actual, self._counters, program=self.program.job != 0)

    def _counters(self) -> Sequence[float]:
        """Values of the measuring systems other than axes."""
        return ()

    def _attend(self, sample: Sample) -> None:
        """Serve a program apart from its path: outputs, the input that ends its part, the end of a part."""
        program, stepper = self.program, self.stepper
        waits = self.start.on and self.free  # a part without way: its actions follow its input
        over = (program.rests or program.complete) and self.free and not program.met
        for switch in () if waits else program.passed(sample.piece_id, stepper.within, over=over):
            if isinstance(switch, FunctionAt):
                self._call(switch.function)
            elif isinstance(switch, SwitchAt):
                self._switch(switch)
            else:
                self.storing.call(switch, self._inputs, self._state.sync_ns, len(self._counters()))
        measure = self.measure
        self.storing.look(self._inputs, self._state.sync_ns)
        looks = measure.on and not (self.start.on or stepper.backward)
        if looks and measure.look(self._inputs, self._state.sync_ns, stepper.state) and not program.met:
            self._edge(sample)
        elif looks and not program.met and measure.late(stepper.state):
            stepper.abandon()
            program.met = program.late = True  # the rest of the part is dropped, as after an input
        if program.rests and self.free and not measure.waits and not waits:
            self._state.met = program.met and not (program.flushed or program.late)
            if measure.on and self.gate.watches:
                self.gate.accepted()
                stepper.place(sample.q)
            measure.end()
            program.part_over()
            self._state.parts += 1

    def _edge(self, sample: Sample) -> None:
        """The input of the part has come: the path is left."""
        if not self.measure.runs_on:
            self.stepper.abandon()
            self.program.met = True
            return
        course = self.measure.course(sample.q, sample.qd)
        if course is None:
            return
        self.program.met = True
        outside = next((n for n, place in enumerate(course.places) if not self._in_travel(n, place, sample.q[n])), None)
        if outside is not None:
            self._state.drive_axis = outside + 1
            self._end_program(Reason.TARGET_LIMIT)
        if outside is None and course.speed > 0.0:
            self.stepper.run_on(course.places, course.speed)
        else:
            self.stepper.abandon()

    def _in_travel(self, axis: int, place: float, now: float) -> bool:
        """An axis that does not move may be where it is."""
        low, high = self._axes[axis].plan.travel
        return low <= place <= high or abs(place - now) <= STILL

    def _switch(self, entry: SwitchAt) -> None:
        set_bit(self._outputs, entry.number, entry.value)

    def _call(self, call: Function) -> None:
        """IO logic or PPO; one that is still in use ends the program on the path."""
        if self.functions is None or not self.program.job:
            return
        try:
            self.functions.call(call, self._state, self._outputs)
        except MotionError:
            self._state.path_stop = function_number(call.ppo, abs(call.number))
            self._state.fail(self.program.job, Reason.OUTPUT_IN_USE)
            self.stepper.abandon()
            self.running = 0
            self._clear()

    def judge(self, sample: Sample) -> None:
        """A job runs: when its set values have arrived it is done as soon as the axes have, too."""
        program = self.program
        measured = program.failed or not (self.measure.waits or self.start.on)
        if not (program.complete and self.free and measured if program.begun else sample.done_id == self.running):
            return
        late = [axis for axis in self._own if abs(axis.set - axis.scaling.to_si(axis.drive.position_inc)) > axis.plan.window]
        self._arriving += 1
        if not late:
            if not self.program.failed:
                self._state.done_job = self.running
                if program.begun:
                    self._state.met = program.met and not (program.flushed or program.late)  # of its last part, after which nothing waits
            self._over()
        elif self._arriving * self.stepper.period > ARRIVAL_S:
            self._state.fail(self.running, Reason.FOLLOWING_ERROR)
            self._over()

    def _over(self) -> None:
        self.running, self._arriving = 0, 0
        if self.program.begun:
            self._clear()
