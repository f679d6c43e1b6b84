"""All functions of the interface behind one step per cycle: RC inputs in, RC output bits out.  Source: rho3 3.3."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from gateway.pure.controllers.rho3.functions.addresses import STROBE_TIME, Places
from gateway.pure.controllers.rho3.functions.coded_errors import CodedErrors
from gateway.pure.controllers.rho3.functions.coded_texts import CodedTexts
from gateway.pure.controllers.rho3.functions.dat_lines import Table
from gateway.pure.controllers.rho3.functions.display import Display
from gateway.pure.controllers.rho3.functions.external_programs import ExternalPrograms
from gateway.pure.controllers.rho3.functions.messages import Text
from gateway.pure.controllers.rho3.functions.phg_selection import PhgSelection
from gateway.pure.controllers.rho3.functions.processes import ProcessTable
from gateway.pure.controllers.rho3.functions.status_display import StatusDisplay
from gateway.pure.image.error_list import ErrorList
from gateway.pure.image.records.cell import InputImage
from protocols.base.machine import Ns

PHGCODE_ERROR = 1278  # ours, AX-534: the manual names the error and no number


@dataclass(slots=True)
class Settings:
    """Settings that differ between plants; a table is None where its file is missing."""

    strobe_time: Ns = STROBE_TIME  # P9
    language: str = "en"
    phg_option: bool = True  # option 41
    places: Places = field(default_factory=Places)
    msd: Table[str] | None = None
    texts: Table[str] | None = None
    programs: Table[str] | None = None
    modes: Table[str] | None = None


class Functions:
    """The functions with what they work on: error list, process table and panel, given by the one who owns them."""

    def __init__(self, settings: Settings, errors: ErrorList, processes: ProcessTable, display: Display | None = None) -> None:
        places, time = settings.places, settings.strobe_time
        self.errors, self.processes, self.display = errors, processes, display or Display()
        self.phg = PhgSelection(places, settings.modes, settings.language, option=settings.phg_option)
        self.statuses = StatusDisplay(places, settings.msd, settings.language)
        self.texts = CodedTexts(places, time, settings.texts)
        self.programs = ExternalPrograms(places, time, settings.programs)
        self.coded = CodedErrors(places, time)
        self._places = places
        self._pressed = False

    def press(self, key: str) -> None:
        """A key of the panel, for any reader; it also ends the strobe of a system error."""
        self._pressed = True
        self.display.press(key)

    def step(self, inputs: InputImage, outputs: bytearray, now: Ns, *, panel_ready: bool = True) -> Sequence[Text]:
        """One cycle; writes only the bits of the functions.  Returns what was refused, for the log."""
        self.display.disable(inputs.bit(self._places.display_off))
        refused = self.programs.step(inputs, outputs, self.processes, now)
        self.phg.step(inputs, outputs, self.display)
        self.statuses.step(inputs, outputs, self.display, self.phg.mode, now)
        refusal = self.texts.step(inputs, outputs, self.display, now, ready=panel_ready)
        if self.phg.file_error:
            self.phg.file_error = False
            self._report(PHGCODE_ERROR, "PHGCODE.DAT", now)
        for process in self.processes.step(now):
            self._report(process.error, process.place or process.name, now)
        self.coded.step(self.errors.records, outputs, now, key=self._pressed)
        self._pressed = False
        return [*refused, *([refusal] if refusal else [])]

    def _report(self, code: int, where: str, now: Ns) -> None:
        """An error that happened and is over: it stays in the list until it is acknowledged."""
        self.errors.report(code, where, now, source="rho3")
        self.errors.gone(code, where, source="rho3")
