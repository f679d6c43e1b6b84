"""The control of [controller] inside the services: stepped with them, its outputs merged with the cycle's for every command source
(AX-332).

A cell without [controller] has an empty host: nothing is loaded, nothing is stepped, the RC outputs are the cycle's.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.controllers.rho3.functions.processes import ProcessFault
from gateway.pure.controllers.rho3.pendant.modes import RESET
from gateway.pure.controllers.rho3.signals.codes import code_text
from gateway.pure.controllers.rho3.signals.errors import RESETS, RHO3, kind_of
from gateway.pure.image.error_list import ErrorList, Reset
from gateway.pure.image.reasons import CommandState, text
from gateway.pure.image.records.cell import RC_BYTES, InputImage, Quality
from gateway.pure.modbus.rho3_view import RhoView
from gateway.runtime.regions import RegionReader
from gateway.services.program_host import ProgramHost
from protocols.base.machine import Ns

if TYPE_CHECKING:
    from gateway.assembly.controllers import Control
    from gateway.pure.controllers.rho3.signals.control import RhoControl
    from gateway.pure.controllers.rho3.signals.hosted import HostedPrograms
    from gateway.services.loop import Services

NO_FDS: Mapping[str, int] = {}
STOPPED = InputImage(quality=bytearray([Quality.GOOD] * RC_BYTES))
PANEL_NS = 2_000_000_000  # the panel counts as used for so long after a key


def _source(code: int) -> str:
    """Whose number it is: parameters are refused with numbers of the Reis list."""
    return RHO3 if code in range(380, 382) else "reis"


def _outcome(hosted: "HostedPrograms", run: object) -> dict[str, object]:
    """How a run of a program is, or how it ended."""
    if not isinstance(run, int):
        return {"error": "state: run = a number that start has given"}
    if (over := hosted.results.get(run)) is not None:
        how, code, words, place = over
        return {"over": True, "how": how, "code": code, "text": words, "place": place}
    rows = [row for row in hosted.rows if row["run"] == run]
    return {"over": False, "rows": rows}


class RcOutputs:
    """RC outputs as command sources, routes and tools read them."""

    def __init__(self, region: RegionReader) -> None:
        self.region = region
        self.control: Control | None = None

    def read(self) -> bytes | None:
        """The cycle's, with those of the control; None: nothing has been published yet."""
        return self.region.read() if self.control is None else self.control.outputs


class ControllerHost:
    """The error list of the run, and its control where there is one."""

    def __init__(self, services: "Services", now: Ns, fds: Mapping[str, int] = NO_FDS) -> None:
        self._services = services
        self.errors = ErrorList()
        self.control: Control | None = None
        self._noted: list[tuple[int, str]] = []
        self._heard: Ns = 0
        self._panel: Ns = 0
        self._panel_door = 0  # who pressed last
        self._seen = b""
        self.programs: ProgramHost | None = None
        self.wired = False  # a route has changed an input of the control since its last cycle
        if services.cell.controller is None:
            return
        from gateway.assembly.controllers import make_control  # only cells that have one pay for it

        doors = {door.name: door.number for door in services.plan.doors}
        self.control, faults = make_control(services.cell, services.owned, doors, services.office, self.errors, now)
        services.retain.restore(self.control)
        if self.rho3 is not None and "interpreter" in fds:
            self.programs = ProgramHost(self.rho3, fds, services.cell.cell.language)
        services.rc_out.control = self.control
        for door in services.doors:
            view = getattr(door, "view", None)
            if isinstance(view, RhoView):
                view.flags = self.control
            for shown in getattr(door, "pictures", ()):
                from gateway.assembly.modbus_views import join

                if self.control is not None:
                    join(shown, self.control)
        for fault in faults:
            services.journal.write("plc", fault)

    def step(self, now: Ns) -> None:
        """Once per cycle of the services."""
        control = self.control
        if control is None:
            return
        services = self._services
        heard = max((door.watch.last_ns for door in services.doors), default=0)
        cycle = services.rc_out.region.read() or bytes(RC_BYTES)
        self._seen, self.wired = bytes(services.inputs.values), False
        rho = self.rho3
        if rho is not None:
            rho.panel_used = bool(self._panel) and now - self._panel < PANEL_NS
        if self.programs is not None:
            self.programs.before(now)
        for line in control.step(services.forces.over(services.inputs), cycle, services.values.state, now, heard=heard > self._heard):
            services.journal.write("plc", line)
        if self.programs is not None:
            for line in self.programs.after():
                services.journal.write("plc", line)
            services.programs.end(self.programs.ending())
        self._heard = heard
        if rho is not None and self._judge_reset(rho, now):
            services.journal.write("plc", "reset at the panel: refused")

    def for_cycle(self, inputs: InputImage) -> InputImage:
        """RC inputs as the cycle is to have them: all 0 where the PIC has stopped (AX-478)."""
        rho = self.rho3
        return inputs if rho is None or not rho.halted else STOPPED

    def inputs_came(self, now: Ns) -> None:
        """A command source has written, or a wire has changed: an edge must not be lost because the next one comes before our next
        cycle."""
        if self.control is not None and (self.wired or self._services.inputs.values != self._seen):
            self.step(now)

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
        if code:  # without a control nobody acknowledges
            reset = Reset.ITSELF if self.control is None else RESETS[kind_of(code)]
            self.errors.report(code, where, now, source=_source(code), reset=reset)

    def gone(self, code: int, where: str) -> None:
        """Its cause is away; it stays until it is acknowledged."""
        if code:
            self.errors.gone(code, where, _source(code))

    @property
    def rho3(self) -> "RhoControl | None":
        """The control, where it is a rho 3."""
        if self.control is None:
            return None
        from gateway.pure.controllers.rho3.signals.control import RhoControl  # loaded long ago: there is a control

        return self.control if isinstance(self.control, RhoControl) else None

    def status(self) -> dict[str, object]:
        """For tools; nothing where there is no control."""
        return {} if self.control is None else {"controller": self.control.status()}

    def _judge_reset(self, rho: "RhoControl", now: Ns) -> str:
        """Mode 11.1 was chosen at the panel: a fault reset as any command source gives it; why it is refused."""
        if not rho.panel.reset_wanted:
            return ""
        rho.panel.reset_wanted = False
        job = self._services.office.command(self._panel_door, Command(Code.FAULT_RESET), now)
        if job.state is CommandState.REFUSED:
            why = text(job.reason, "en", job.detail)
            rho.panel.refuse(why)
            return why
        rho.panel.enter(RESET)
        return ""

    # ---- programs of the interpreter -------------------------------------------------------------------------------------
    def process(self, request: dict[str, object], door: int) -> dict[str, object]:
        """`do`: list, start and stop (`name`), state (`run`).  door: command source a program that is started moves as, 0: the PLC's."""
        rho = self.rho3
        if rho is None or rho.hosted is None:
            return {"error": 'no programs: this cell has no [controller] with memory = "FOLDER"'}
        hosted, name = rho.hosted, str(request.get("name", "")).upper()
        match request.get("do"):
            case "list":
                return {"programs": hosted.programs, "processes": hosted.rows, "id": hosted.language_id}
            case "start":
                return self._start_program(rho, hosted, name, door)
            case "stop":
                process = rho.processes.named(name)
                if process is None or not rho.processes.stop(process.number):
                    return {"error": f"{name}: no such process"}
                return {"ok": True}
            case "state":
                return _outcome(hosted, request.get("run"))
        return {"error": f"do {request.get('do')!r}; list, start, stop, state are known"}

    @staticmethod
    def _start_program(rho: "RhoControl", hosted: "HostedPrograms", name: str, door: int) -> dict[str, object]:
        row = next((row for row in hosted.programs if row["name"] == name), None)
        if row is None:
            known = ", ".join(str(each["name"]) for each in hosted.programs) or "none"
            why = f"the memory has {known}" if hosted.language_id else "the interpreter does not run"
            return {"error": f"{name}: no such program; {why}"}
        if row["fault"]:
            return {"error": f"{name} has {row['errors']} errors and does not run; the first: {row['fault']}"}
        hosted.starter = door
        try:
            return {"run": hosted.run_of(rho.start(name))}
        except ProcessFault as fault:
            return {"error": f"{name}: {code_text(fault.code) or 'error'} ({fault.code})"}
        finally:
            hosted.starter = 0

    # ---- the panel -------------------------------------------------------------------------------------------------------
    def panel(self, request: dict[str, object], door: int, now: Ns) -> dict[str, object]:
        """Its screen; with `key` after a key, with `mode` in another mode.  Mode 11.1 resets, and needs control for it."""
        rho = self.rho3
        if rho is None:
            return {"error": 'no panel: this cell has no [controller] of kind "rho3"'}
        functions = rho.functions
        if "key" in request:
            self._panel, self._panel_door = now, door
            functions.press(str(request["key"]))
        if "mode" in request:
            self._panel, self._panel_door = now, door
            rho.panel.go(f"0.{request['mode']}".removesuffix(".0"))
            refused = self._judge_reset(rho, now)
            if refused:
                return {"error": f"mode {request['mode']}: {refused}"}
        display = functions.display
        return {"screen": list(display.screen()), "mode": functions.phg.mode, "lost_keys": display.lost_keys}
