"""What leads the axes of a lane along a path: the stepper, what runs on it, and orders that stop, hold or end it.  Pure."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.cycle.drive_on import DriveOnGate
from gateway.pure.cycle.homing import Homings
from gateway.pure.cycle.inputs import CoreStart
from gateway.pure.cycle.program import ProgramRun
from gateway.pure.cycle.storing import Storing
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import CellState, InputImage, OrderRecord
from motion.axes.errors import AxisError
from motion.errors import MotionError
from motion.execution.pieces import decode
from motion.execution.stepper import State, Stepper
from motion.timing.foresight import Foresight

if TYPE_CHECKING:
    from gateway.pure.cycle.path_outputs import CoreOutputs


class PathMover:
    """`state`, which is the lane's, and `outputs` are written in place.  What comes from the planner: gateway.pure.cycle.mover."""

    def __init__(
        self,
        axes: Sequence[HeldAxis],
        state: CellState,
        outputs: bytearray,
        homings: Homings,
        period_s: float,
        foresight: type[Foresight] = Foresight,
    ) -> None:
        self.stepper = Stepper(len(axes), period_s, foresight=foresight)
        self.stepper.set_override(0.0)
        self.program = ProgramRun()  # done when nothing more comes and all is run
        self.storing = Storing(state, axes, round(period_s * 1e9))
        self.measure = self.storing.measure  # the edge that ends the part under way
        self.start = CoreStart(round(period_s * 1e9))
        self.functions: CoreOutputs | None = None  # of a cell with [[path_output]]
        self.gate = DriveOnGate(axes)  # drive-on of single axes
        self.override = 0.0  # as asked for: 0 while the feed is held
        self.running = 0  # job of the piece under way
        self._inputs = InputImage()  # of the last cycle
        self._arriving = 0  # cycles since the set values of the running job arrived
        self._axes, self._state, self._outputs, self._homings = axes, state, outputs, homings

    @property
    def _own(self) -> Iterator[HeldAxis]:
        """Those it moves, and no other does."""
        return (axis for n, axis in enumerate(self._axes) if self.gate.mask >> n & 1)

    @property
    def free(self) -> bool:
        """Return whether no path is under way: the set position then follows the axes."""
        return self.stepper.state is State.IDLE

    @property
    def moving(self) -> bool:
        return self.stepper.state in (State.RUNNING, State.STOPPING)

    @property
    def busy(self) -> bool:
        """Return whether a path or a program is not yet at its end."""
        return self.running != 0 or self.program.job != 0 or self.stepper.state is not State.IDLE

    @property
    def starved(self) -> bool:
        """Return whether a running program waits at rest for the planner or an input."""
        return (self.program.waits or self.start.on) and self.stepper.state is State.IDLE

    def all_enabled(self, mask: int) -> bool:
        return all(axis.drive.follows for n, axis in enumerate(self._axes) if mask >> n & 1)

    def set_override(self, value: float) -> None:
        self.override = value
        self.stepper.set_override(0.0 if self.start.on else value)

    def move(self, record: OrderRecord) -> None:
        """Start a single piece."""
        try:
            piece = decode(record.piece)
            if self._homings.job or self.program.job or self._state.emergency or not self.all_enabled(piece.mask):
                raise MotionError("the axes of the piece are not all enabled, or they are being referenced")
            if self.gate.kept and self.free:
                self._begin_at_set_values()
                self.gate.over()
            self.stepper.load(piece)
        except MotionError:
            self._state.fail(record.job, Reason.NOT_READY)
            return
        self._begin(record.job)
        self._state.stop_cause = 0

    def order_program(self, record: OrderRecord) -> None:
        if self._homings.job or self.busy or self._state.emergency or not self.gate.begin(record.mask):
            self._state.fail(record.job, Reason.NOT_READY)
            return
        self.program.order(record.job, record.mask)
        self.stepper.begin_anew()
        self._state.path_stop = 0
        self.storing.program_started()
        self._release()
        self._state.stop_cause = 0

    def abandon(self) -> None:
        """The rest of a stopped path is given up."""
        if self.stepper.state is not State.IDLE:
            self.stepper.abandon()
            self._state.fail(self.running, Reason.ABANDONED)
            self.running = 0
            self._clear()

    def stop(self, reason: Reason) -> None:
        """On the path."""
        if self.stepper.state is State.RUNNING:
            self.stepper.stop()
            self._state.stop_cause = reason
        elif self.starved:  # no path to stop on: it must not begin or continue on its own afterwards
            self._state.fail(self.program.job, reason)
            self.running, self._state.stop_cause = 0, reason
            self._clear()

    # ---- orders to a stream -------------------------------------------------------------------------------------------
    @property
    def bound(self) -> bool:
        """Return whether the running part follows more than its path: it can be ended but not held."""
        return False

    def hold_path(self, reason: Reason) -> None:
        """On the path; what still comes of the job waits."""
        if not self.program.job or self.bound:
            return
        self.program.held, self.program.backward = True, False
        if self.stepper.state is State.RUNNING:
            self.stepper.stop()
            self._state.stop_cause = reason

    def resume(self) -> None:
        """Continue the stopped or held motion."""
        self.program.held, self.program.backward = False, False
        self.stepper.resume()

    def retrace(self) -> None:
        """Back along the path, from rest."""
        if self.program.job and not self.bound and not self.start.on:
            self.hold_path(Reason.STOPPED_BY_SOURCE)
            self.program.backward = True

    def _retrace(self) -> None:
        """Without a path, the place where the axes rest is its beginning."""
        if self.stepper.state in (State.STOPPED, State.IDLE):
            self.program.backward = False
            if self.program.begun and self.stepper.has_path:
                self.stepper.retrace()

    def drop(self, reason: Reason) -> None:
        """The drives go off: nothing of the path is left."""
        self._state.fail(self.running or self.program.job, reason)
        self.running = 0
        self._clear()
        self.stepper = self.stepper.fresh([axis.set for axis in self._axes])
        self.stepper.set_override(self.override)

    # ---- drive-on of single axes --------------------------------------------------------------------------------------
    def all_wanted(self) -> bool:
        """No axis of the program was switched off."""
        return all(axis.wanted for n, axis in enumerate(self._axes) if self.program.mask >> n & 1)

    def leave(self) -> bool:
        """Release axes that are no longer commanded on; True where the running program continues without them or stops on its path."""
        if not self.program.job or not any(axis.wanted for axis in self._own):
            return False
        moves = self.gate.leave(self.stepper.ahead)
        if moves:
            self._held_up(Reason.DRIVE_ON_NOT_AVAILABLE, moves)
        return True

    def join(self, mask: int) -> bool:
        """These axes may be switched on; False: not while the program moves, and it is over (rho 3 L1516-1522)."""
        if not self.program.job:
            return True
        try:
            self.gate.join(mask)
        except AxisError as error:
            self._held_up(Reason.DRIVE_ON_NOT_ALLOWED, error.axis)
            return False
        return True

    def _held_up(self, reason: Reason, axis: int) -> None:
        """The program is over: what moves stops on the path."""
        self._state.drive_axis, self._state.stop_cause = axis, reason
        self._state.fail(self.program.job, reason)
        if self.stepper.state is not State.IDLE:
            self.stepper.abandon()
        self.running = 0
        self._clear()

    def _refuse(self, axis: int) -> None:
        """What comes next cannot be run without this axis: the program ends where what was committed ends."""
        self._state.drive_axis = axis
        self._end_program(Reason.DRIVE_ON_NOT_AVAILABLE)
        self.program.met = True  # its remaining records are dropped

    # ---- what all of them need ----------------------------------------------------------------------------------------
    def _begin(self, job: int) -> None:
        self.running, self._arriving = job, 0

    def _end_program(self, reason: Reason) -> None:
        """Fail the program; its committed part still runs."""
        self._state.fail(self.program.job, reason)
        self.program.failed = True
        self.program.switches.clear()
        if self.program.begun:
            self.program.complete = True
            self.stepper.uncommit()
        else:
            self._clear()

    def _clear(self) -> None:
        """End the program and drop a path whose end never arrived."""
        self.program.clear()
        self.stepper.uncommit()

    def accept(self) -> None:
        """Without a path, and none on its way, the next one begins where the axes rest."""
        if self.free and not self.stepper.ahead:
            self._begin_at_set_values()

    def _begin_at_set_values(self) -> None:
        """The path begins at the set values of the axes."""
        self.stepper.place([axis.set for axis in self._axes])

    def _release(self) -> None:
        self.start.end()
        self.stepper.set_override(self.override)
