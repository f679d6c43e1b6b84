"""The active errors of the cell, the first one first; and every tick's status words for the command sources."""

from collections.abc import Mapping, Sequence

from drivers.drives.servodyn_words import sentence as servodyn_fault
from gateway.assembly.axis_signals import rc_numbers
from gateway.assembly.drive_buses import LISTENS
from gateway.pure.image.reasons import Reason, text
from gateway.pure.image.records.cell import ALL_PERMITS, AxisFlag, CellState, Motion
from gateway.pure.image.records.planner import function_words
from gateway.services.alarm_file import AlarmFile
from gateway.services.canopen import CanopenServices
from gateway.services.cell_values import CellValues
from gateway.services.contacts import DigitalContacts
from gateway.services.controller_host import ControllerHost
from gateway.services.cycle_watch import CycleWatch
from gateway.services.io_error_log import IoComplaints
from gateway.services.part import Part
from gateway.services.part_context import PartContext
from gateway.services.sources.base import BaseSource
from protocols.base.machine import Ns, ms

ACKNOWLEDGE = 62  # RC input: error acknowledgement
REFUSALS_KEPT_NS: Ns = ms(60_000)
WRONG = int(AxisFlag.FAULT | AxisFlag.UNCONFIGURED | AxisFlag.LOST)  # of an axis, in the list of errors
Error = tuple[int, str]


class CellErrors(Part):
    """Into the value directory, the alarm file and the error list of the control."""

    def __init__(
        self,
        context: PartContext,
        cell_values: CellValues,
        sources: Sequence[BaseSource],
        cycle: CycleWatch,
        canopen: CanopenServices,
        contacts: DigitalContacts,
        host: ControllerHost,
        fds: Mapping[str, int],
    ) -> None:
        run = context.run
        self._run, self._image, self._values, self._dispatcher = run, context.image, context.values, context.dispatcher
        self._cell_values = cell_values
        self._sources, self._cycle, self._canopen, self._contacts, self._host = sources, cycle, canopen, contacts, host
        self._blind = {name: f"bus {name} {LISTENS}" for name in run.plan.listening}  # nothing is sent on them
        self._reset = rc_numbers(run.cell).reset
        self.alarms = AlarmFile(run.plan)
        self._complaints = IoComplaints(fds, run.journal, run.cell.cell.language)

    def step(self, now: Ns) -> None:
        """Errors first: the status words carry the first one."""
        state, facts = self._image.state, self._dispatcher.axes
        places = [(state.axes[n].actual / axis.si, state.axes[n].lag / axis.si) for n, axis in enumerate(facts)]
        self._collect(state, now)
        outputs = self._image.outputs.read()
        for source in self._sources:
            source.refresh(state, places, self._cell_values.life, now)
            source.show(outputs)

    async def close(self) -> None:
        self.alarms.close()

    def _late_words(self) -> str:
        return ", ".join(axis.name for n, axis in enumerate(self._dispatcher.axes) if n in self._cycle.late_machine.axes)

    def _cause_ended(self, state: CellState) -> bool:
        """The cause that stopped the axes is gone and no rest of a move waits: it is history, not an error (AX-642)."""
        if state.motion in (Motion.STOPPED, Motion.STOPPING):
            return False
        match state.stop_cause:
            case Reason.STOPPED_BY_SOURCE | Reason.SERVICES_LOST | Reason.ABANDONED | Reason.EMERGENCY_STOP:
                return True  # a latched emergency stop is a separate error
            case Reason.LINK_LOST:
                return all(source.watch.alive or not source.watch.losses for source in self._sources)
            case Reason.INPUT_LOST:
                return state.permits & int(ALL_PERMITS) == int(ALL_PERMITS)
            case Reason.DRIVE_LOST:
                return not any(axis.flags & AxisFlag.LOST for axis in state.axes[: len(self._dispatcher.axes)])
        return False

    def _collect(self, state: CellState, now: Ns) -> None:
        errors = self._active(state)
        io = self._complaints.look(self._host, now)
        refusals = self._cell_values.refusals
        for source, refusal in list(refusals.items()):
            if now - refusal[2] > REFUSALS_KEPT_NS:
                del refusals[source]
        self._values.errors[:] = errors + io
        self.alarms.look(self._values.errors)
        self.alarms.inputs({number: self._image.input_bit(number) for number in (self._reset, ACKNOWLEDGE)})
        self._host.note([*errors, *((code, words) for code, words in io if code == Reason.DRIVE_NOT_STARTED)], now)

    def _active(self, state: CellState) -> list[Error]:
        """Active errors of the cell, the first one first."""
        late, language = self._cycle.late_machine, self._run.cell.cell.language
        errors: list[Error] = [(Reason.NOT_READY, text(Reason.NOT_READY, detail=words)) for words in self._blind.values()]
        if state.emergency:
            errors.append((Reason.EMERGENCY_STOP, text(Reason.EMERGENCY_STOP)))
        if late.blamed:
            errors.append((Reason.MACHINE_LATE, text(Reason.MACHINE_LATE, detail=self._late_words())))
        errors += self._of_axes(state)
        strayed = self._dispatcher.strayed(language)
        if strayed:
            errors.append((Reason.FOLLOWING_ERROR, text(Reason.FOLLOWING_ERROR, detail=strayed)))
        ended = self._cause_ended(state)
        if state.stop_cause and not ended and state.stop_cause not in (e[0] for e in errors) and not late.blamed:
            errors.append((state.stop_cause, text(Reason(state.stop_cause))))
        if state.path_stop and Reason.OUTPUT_IN_USE not in (e[0] for e in errors):
            errors.append((Reason.OUTPUT_STOPPED, text(Reason.OUTPUT_STOPPED, detail=function_words(state.path_stop))))
        planner = self._dispatcher.planner
        for warning in (each.warning for each in (planner, *planner.others) if each.warning) if planner is not None else ():
            errors.append((Reason.INTERPOLATOR_STOP, text(Reason.INTERPOLATOR_STOP, detail=warning)))
        if self._host.programs is not None:
            errors += [(Reason.APPLICATION, text(Reason.APPLICATION, language, words)) for words in self._host.programs.faults()]
        return errors + [(Reason.COUPLER_FAULT, text(Reason.COUPLER_FAULT, language, words)) for words in self._contacts.faults()]

    def _of_axes(self, state: CellState) -> list[Error]:
        errors: list[Error] = []
        for n, axis in enumerate(self._dispatcher.axes):
            flags = int(state.axes[n].flags)
            if not flags & WRONG or (n in self._cycle.late_machine.axes and not flags & AxisFlag.UNCONFIGURED):
                continue
            if flags & AxisFlag.FAULT:
                code = state.axes[n].fault_code
                fault = self._canopen.fault(n, code) or servodyn_fault(code, self._run.cell.cell.language)
                errors.append((Reason.DRIVE_FAULT, text(Reason.DRIVE_FAULT, detail=f"{axis.name} {fault}")))
            why = self._canopen.why_not(n) if flags & AxisFlag.UNCONFIGURED else ""
            if why:
                errors.append((Reason.DRIVE_NOT_STARTED, text(Reason.DRIVE_NOT_STARTED, detail=f"{axis.name}: {why}")))
            elif flags & AxisFlag.LOST and self._run.cell.axis[n].drive.bus not in self._blind:
                errors.append((Reason.DRIVE_LOST, text(Reason.DRIVE_LOST, detail=axis.name)))
        return errors
