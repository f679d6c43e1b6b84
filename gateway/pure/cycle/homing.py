"""Reference runs in the core: which axes reference, by the gateway or by their drive, and the outcome of the job.  Pure."""

from collections.abc import Sequence

from drivers.drives.family import Actual, DriveHoming, Homing
from drivers.drives.referencing import Referencing, RunState
from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import EVERY_AXIS, CellState


class Homings:
    """Of one lane."""

    def __init__(self, axes: Sequence[HeldAxis], state: CellState, period_s: float) -> None:
        self.job = 0
        self.under_way = False  # a job runs, or an axis is still coming to rest from one
        self._axes, self._state, self._period = axes, state, period_s
        self.mask = EVERY_AXIS  # axes (bit n-1 = axis n) it may reference

    @property
    def _own(self) -> list[HeldAxis]:
        return [axis for n, axis in enumerate(self._axes) if self.mask >> n & 1]

    def begin(self, job: int, mask: int) -> None:
        """The axes of the mask rest and follow."""
        for n, axis in enumerate(self._axes):
            plan = axis.plan.reference
            if mask >> n & 1 and plan is not None:
                axis.referenced = False
                if isinstance(plan, DriveHoming):
                    axis.by_drive = True
                else:
                    axis.run = Referencing(plan, axis.drive.position_inc)
        self.job, self.under_way = job, True
        self._ended()  # axes that know where they are have nothing to do

    def end(self, reason: Reason) -> None:
        """Fail the job and bring its runs to rest."""
        self._state.fail(self.job, reason)
        self.job = 0
        for axis in self._own:
            axis.by_drive = False
            if axis.run is not None:
                axis.run.abort()

    def step(self, actuals: Sequence[Actual | None]) -> None:
        """Before the set values of a cycle."""
        for n, (axis, actual) in enumerate(zip(self._axes, actuals, strict=True)):
            if axis.run is not None and self.mask >> n & 1:
                axis.led = True
                self._step_run(axis, actual)

    def judge(self) -> None:
        """After the set values of a cycle."""
        for axis in self._own:
            if axis.by_drive:
                self._judge_drive(axis)

    def look(self) -> None:
        """Update once a cycle whether a reference run is still under way."""
        self.under_way = self.job != 0 or any(axis.run is not None or axis.by_drive for axis in self._own)

    def _step_run(self, axis: HeldAxis, actual: Actual | None) -> None:
        run = axis.run
        assert run is not None
        step = run.step(axis.drive.position_inc, actual is not None and actual.reference_switch, self._period)
        axis.set = axis.scaling.to_si(step.set_inc)
        axis.speed = axis.scaling.speed_from_inc(step.speed_inc_s)
        if step.state is RunState.RUNNING:
            return
        axis.run = None
        if step.state is RunState.DONE:
            assert run.zero_inc is not None
            axis.scaling = axis.plan.scaling.with_zero(run.zero_inc)
            axis.set = axis.scaling.to_si(step.set_inc)
            axis.referenced = True
        elif self.job:
            self._state.stop_cause = Reason.REFERENCE_FAILED
            self.end(Reason.REFERENCE_FAILED)
        self._ended()

    def _judge_drive(self, axis: HeldAxis) -> None:
        """Assign the planned meaning to the increments of a drive in its home position (AX-306)."""
        plan, state = axis.plan.reference, axis.drive.homing
        if state is Homing.DONE and isinstance(plan, DriveHoming):
            axis.by_drive, axis.referenced = False, True
            axis.scaling = axis.plan.scaling.with_zero(-plan.position * axis.plan.scaling.inc_per_unit)
            axis.set = axis.scaling.to_si(axis.drive.set_inc)
        elif state is Homing.FAILED:
            self._state.stop_cause = Reason.REFERENCE_FAILED
            self.end(Reason.REFERENCE_FAILED)
        self._ended()

    def _ended(self) -> None:
        if self.job and not any(axis.run is not None or axis.by_drive for axis in self._own):
            self._state.done_job, self.job = self.job, 0
