"""Outcome of a command from what the cycle and the planner published: still open, done, or aborted with its reason in words."""

from collections.abc import Sequence

from drivers.drives.tracking import sentence
from gateway.pure.arbitration.axis_masks import axes_with, names_of
from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.jobs import AxisFacts, Job
from gateway.pure.image.belt_texts import belt_words
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import AxisFlag, CellState, Motion
from gateway.pure.image.records.planner import PlannerState, function_words


class Outcomes:
    """Outcomes of the jobs of one dispatcher."""

    def __init__(self, axes: Sequence[AxisFacts]) -> None:
        self._axes = tuple(axes)

    @staticmethod
    def ended(job: Job, outcome: Reason) -> CommandState:
        """State of a job that has ended; a program that failed before anything moved counts as refused."""
        if outcome is Reason.NONE:
            return CommandState.DONE
        untried = outcome in (Reason.PROGRAM_FAULT, Reason.DRIVE_ON_NOT_AVAILABLE)
        refused = job.code == Code.PROGRAM and job.state is CommandState.ACCEPTED and untried
        return CommandState.REFUSED if refused else CommandState.ABORTED

    def fault(self, job: Job, cell: CellState, planner: PlannerState | None, outcome: Reason) -> str:
        """The planner's words: line, block, axis and the manual's number; or which axis did not follow."""
        if outcome is Reason.FOLLOWING_ERROR:
            return self.strayed(cell)
        if outcome in (Reason.BELT_FAULT, Reason.ALTER_FAULT):
            axis = self._axes[cell.belt_axis - 1].name if 0 < cell.belt_axis <= len(self._axes) else ""
            return belt_words(cell.belt_code, cell.belt_block or (planner.of(job.watch).block if planner else 0), axis)
        if outcome is Reason.SERVO_ERROR:
            return self._axes[cell.belt_axis - 1].name if 0 < cell.belt_axis <= len(self._axes) else ""
        if outcome in (Reason.DRIVE_ON_NOT_AVAILABLE, Reason.DRIVE_ON_NOT_ALLOWED, Reason.TARGET_LIMIT):
            drive_axis = cell.lane_of(job.span).drive_axis
            return f"axis {self._axes[drive_axis - 1].name}" if 0 < drive_axis <= len(self._axes) else ""
        if outcome is Reason.NOT_READY:
            off = names_of(self._axes, job.mask & ~self._with(AxisFlag.ENABLED, cell))
            return f"drives off: {off}" if off else "its axes move or are being referenced"
        if outcome is Reason.OUTPUT_IN_USE:
            return function_words(cell.lane_of(job.span).path_stop)
        program = planner.of(job.watch) if planner is not None else None
        if outcome is not Reason.PROGRAM_FAULT or program is None or program.failed_job != job.watch:
            return ""
        return program.fault

    def strayed(self, cell: CellState | None, language: str = "en") -> str:
        """Describe the axes that did not follow or did not come to rest, with number and text of the old error list; empty: none."""
        found = cell.axes if cell is not None else []
        strayed = [(axis.name, found[n].finding) for n, axis in enumerate(self._axes[: len(found)]) if found[n].finding]
        return ", ".join(f"{name} {sentence(number, language)}" for name, number in strayed)

    def of(self, job: Job, cell: CellState) -> Reason | None:
        """NONE: done; a reason: aborted; None: still open."""
        if cell.taken < job.id:
            return None
        job.also = tuple(other for other in job.also if not cell.done(other))
        failed = cell.failure(job.watch or (job.id if job.code == Code.ENABLE else 0))
        if job.watch:
            done = cell.done(job.watch)
            if job.also and (done or not failed):
                if done:
                    job.watch, job.also = job.also[0], job.also[1:]
                return None
            return Reason.NONE if done else Reason(failed) if failed else None
        if failed:
            return Reason(failed)
        return Reason.NONE if self._reached(job, cell) else None

    def _reached(self, job: Job, cell: CellState) -> bool:
        """Whether the state that the command asks for is reached."""
        enabled = self._with(AxisFlag.ENABLED, cell) & job.mask
        match job.code:
            case Code.ENABLE:
                return enabled == job.mask
            case Code.DISABLE:
                return not enabled
            case Code.STOP:
                return cell.rests(job.id)
            case Code.ABANDON | Code.REQUEST_CONTROL:
                return cell.motion_of(job.span) is Motion.IDLE
            case Code.FAULT_RESET:
                return not cell.emergency and not self._with(AxisFlag.FAULT | AxisFlag.LOST, cell)
            case _:
                return True

    def why_not(self, job: Job, cell: CellState) -> tuple[Reason, str]:
        """Why a command did not reach its state in time."""
        if cell.emergency:
            return Reason.EMERGENCY_STOP, ""
        faults = [f"{a.name} fault {cell.axes[n].fault_code}" for n, a in enumerate(self._axes) if cell.axes[n].flags & AxisFlag.FAULT]
        if faults:
            return Reason.DRIVE_FAULT, ", ".join(faults)
        return Reason.TIME_OUT, Code(job.code).name.lower()

    def _with(self, flag: AxisFlag, cell: CellState) -> int:
        return axes_with(flag, cell, len(self._axes))
