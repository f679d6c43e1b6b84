"""The control of [controller] inside the services: stepped with them, its outputs merged with the cycle's for every command source
(AX-332).

A cell without [controller] loads and steps nothing: the RC outputs are the cycle's.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Protocol

from gateway.pure.controllers.control import Control
from gateway.pure.controllers.rho3.functions.system_variables import VariableError
from gateway.pure.controllers.rho3.pendant.catalogue import PREFIX
from gateway.pure.controllers.rho3.signals.coupling import Coupled
from gateway.pure.controllers.rho3.signals.errors import RESETS, RHO3, kind_of
from gateway.pure.image.error_list import ErrorList, Reset
from gateway.pure.image.records.cell import RC_BYTES, AxisFlag, InputImage, Quality
from gateway.registry import CONTROLLERS, language_in
from gateway.services.part import Part
from gateway.services.part_context import PartContext
from gateway.services.value_directory import Reader, as_number
from protocols.base.machine import Ns
from protocols.telegrams.fields import Value

STOPPED = InputImage(quality=bytearray([Quality.GOOD] * RC_BYTES))


def _source(code: int) -> str:
    """Whose number it is: parameters are refused with numbers of the Reis list."""
    return RHO3 if code in range(380, 382) else "reis"


class Panel(Protocol):
    """The hand-held unit of a control (`panel` of its row); loaded only where there is one."""

    def look(self, now: Ns) -> None:
        """Before a step of the control."""

    def judge_reset(self, now: Ns) -> str:
        """After it; why a reset at the panel is refused."""

    def answer(self, request: dict[str, object], source: int, now: Ns) -> dict[str, object]:
        """Keys, modes, the screen; the unit (gateway.pure.controllers.unit) with size and keys."""


class Parameters(Protocol):
    """What a rho 3 adds to the interface of a control (gateway.services.rho3_panel); loaded only for a rho 3."""

    @property
    def halted(self) -> bool:
        """The PIC has stopped."""

    @property
    def coupled(self) -> Coupled | None:
        """Its bit coupling."""

    def read(self, name: str) -> Value:
        """A variable of the PHG."""

    def number(self, name: str) -> float:
        """The same as a number."""

    def write(self, name: str, value: Value) -> None:
        """A variable of the PHG."""


class CellPrograms(Protocol):
    """Programs of the interpreter (gateway.services.program_host); loaded only where a cell has some."""

    def before(self, now: Ns) -> None:
        """Before a step of the control."""

    def after(self) -> list[str]:
        """After it: report to the operator."""

    def pass_on(self) -> None:
        """Pass orders to the interpreter, after those to the planner."""

    def ending(self) -> list[int]:
        """Jobs of an interpreter that has died."""

    def faults(self) -> list[str]:
        """Active errors of programs."""

    def answer(self, request: dict[str, object], source: int) -> dict[str, object]:
        """Answer a tool: list, start, stop, state."""


class PlcProcess(Protocol):
    """The integrated PLC of a Reis (gateway.services.plc_host); loaded only where there is one."""

    def before(self) -> None:
        """Before a step of the control."""

    def after(self, *, drives: bool) -> list[str]:
        """After it: report to the operator."""

    def order(self, request: dict[str, object]) -> dict[str, object]:
        """Status, start, stop, acknowledge."""


class ControllerHost(Part):
    """The error list of the run, and its control where there is one; provider of the control's values."""

    def __init__(
        self,
        context: PartContext,
        errors: ErrorList,
        last_heard: Callable[[], Ns],
        end_programs: Callable[[Sequence[int]], None],
        fds: Mapping[str, int],
        now: Ns,
    ) -> None:
        """`last_heard`: when a command source last received from its partner; `end_programs`: no blocks follow for these jobs."""
        run, image = context.run, context.image
        self._run, self._image, self.errors = run, image, errors
        self._last_heard, self._end_programs = last_heard, end_programs
        self._noted: list[tuple[int, str]] = []
        self._heard: Ns = 0
        self._seen = b""
        self.wired = False  # a route has changed an input of the control since its last cycle
        self.panel: Panel | None = None
        self.parameters: Parameters | None = None
        self.plc: PlcProcess | None = None
        self.programs: CellPrograms | None = None
        context.values.register(ControlValues(self))
        if run.cell.controller is None:
            return
        from gateway.assembly.controllers import make_control  # only cells that have one pay for it

        sources = {source.name: source.number for source in run.plan.sources}
        image.control, faults = make_control(run.cell, image.owners, sources, context.dispatcher, errors, now)
        kind = CONTROLLERS[run.cell.controller.kind]
        if kind.panel is not None and image.control is not None:
            self.panel = kind.panel(run.cell, image.control, context.dispatcher)
        if kind.parameters:
            from gateway.services.rho3_panel import Rho3Panel

            assert isinstance(self.panel, Rho3Panel)
            self.parameters = self.panel
            image.coupled = self.panel.coupled
        language = language_in(run.cell)
        if "interpreter" in fds and language is not None and image.control is not None:
            from gateway.services.program_host import ProgramHost

            self.programs = ProgramHost(language.host(run.cell, image.control, context.dispatcher), fds)
        if "plc" in fds:
            from gateway.pure.controllers.reis.control import ReisControl
            from gateway.services.plc_host import PlcHost

            assert isinstance(image.control, ReisControl) and run.cell.controller.plc is not None  # as `check` and the plan have it
            self.plc = PlcHost(image.control, fds, run.cell.controller.plc.watchdog)
        for fault in faults:
            run.journal.write("plc", fault)

    @property
    def control(self) -> Control | None:
        """The control of [controller]."""
        return self._image.control

    def step(self, now: Ns) -> None:
        """Once per cycle of the services."""
        control = self.control
        if control is None:
            return
        image, heard = self._image, self._last_heard()
        cycle = image.outputs.region.read() or bytes(RC_BYTES)
        self._seen, self.wired = bytes(image.inputs.values), False
        if self.panel is not None:
            self.panel.look(now)
        if self.programs is not None:
            self.programs.before(now)
        if self.plc is not None:
            self.plc.before()
        for line in control.step(image.for_cycle(), cycle, image.state, now, heard=heard > self._heard):
            self._run.journal.write("plc", line)
        if self.programs is not None:
            for line in self.programs.after():
                self._run.journal.write("plc", line)
            self._end_programs(self.programs.ending())
        if self.plc is not None:
            for line in self.plc.after(drives=any(axis.flags & AxisFlag.ENABLED for axis in image.state.axes)):
                self._run.journal.write("plc", line)
        self._heard = heard
        if self.panel is not None and self.panel.judge_reset(now):
            self._run.journal.write("plc", "reset at the panel: refused")

    def for_cycle(self, inputs: InputImage) -> InputImage:
        """RC inputs as the cycle is to have them: all 0 where the PIC has stopped (AX-478)."""
        return inputs if self.parameters is None or not self.parameters.halted else STOPPED

    def inputs_came(self, now: Ns) -> None:
        """A command source has written, or a wire has changed: an edge must not be lost because the next one comes before our next
        cycle."""
        if self.control is not None and (self.wired or self._image.inputs.values != self._seen):
            self.step(now)

    def pass_on(self) -> None:
        """Planner and cycle have their orders: now pass them to the interpreter."""
        if self.programs is not None:
            self.programs.pass_on()

    def note(self, errors: list[tuple[int, str]], now: Ns) -> None:
        """Errors of the cell with axisgate's own numbers go into the same list; gone with its cause."""
        if errors == self._noted:
            return
        for code, words in set(self._noted) - set(errors):
            self.errors.gone(code, words)
        for code, words in errors:
            if (code, words) not in self._noted:
                self.errors.report(code, words, now, reset=Reset.ITSELF)
        self._noted = list(errors)

    def came(self, code: int, where: str, now: Ns) -> None:
        """An error with a number of the rho 3, or of the Reis list (645, 650); 0 has none and is listed with axisgate's own."""
        if code:  # without a control nothing acknowledges it
            reset = Reset.ITSELF if self.control is None else RESETS[kind_of(code)]
            self.errors.report(code, where, now, source=_source(code), reset=reset)

    def gone(self, code: int, where: str) -> None:
        """Its cause is away; it stays until it is acknowledged."""
        if code:
            self.errors.gone(code, where, _source(code))

    def status(self) -> dict[str, object]:
        """For tools; empty without a control."""
        return {} if self.control is None else {"controller": self.control.status()}


class ControlValues:
    """Provider of the control's values and of the variables of the PHG; a cell without a control has none."""

    def __init__(self, host: ControllerHost) -> None:
        self._host = host

    def names(self) -> Iterable[str]:
        return self._host.control.names() if self._host.control is not None else ()

    def read(self, name: str, reader: Reader | None) -> Value:
        if name.startswith(PREFIX):
            try:
                return self.phg().number(name)
            except VariableError as fault:
                raise KeyError(str(fault)) from fault
        control = self._host.control
        if control is None or name not in control.names():
            raise KeyError(name)
        return control.value(name)

    def valid(self, name: str) -> bool:
        """A control knows no other state of its values."""
        return True

    def write(self, name: str, value: Value, now: Ns, by: str) -> None:
        control = self._host.control
        if control is None or name not in control.names():
            raise KeyError(name)
        control.put(name, as_number(value))
        self._host.wired = True

    def phg(self) -> Parameters:
        """Variables of the PHG 2000; KeyError: this cell has none."""
        if self._host.parameters is None:
            raise KeyError('phg: variables of the PHG need a cell with [controller] of kind "rho3"')
        return self._host.parameters
